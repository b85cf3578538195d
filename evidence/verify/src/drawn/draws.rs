//! Numbers drawn over many orders of magnitude.

use proptest::prelude::*;

/// Log-uniform.
pub(crate) fn log(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

/// Log-uniform, or zero one time in six.
pub(crate) fn or_zero(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![1 => Just(0.0), 5 => log(low, high)]
}

/// With either sign.
pub(crate) fn signed(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    (or_zero(low, high), any::<bool>()).prop_map(|(x, s)| if s { -x } else { x })
}
