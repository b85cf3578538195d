//! FMI 2.0 face of the hammer.
