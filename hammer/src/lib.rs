//! Down-the-hole percussive drilling: physics and exact event-driven integration.
//!
//! A piston strikes a bit, a stress wave runs down, the rock breaks. Both bodies are elastic
//! bars (or rigid), on one axis that points **down, into the rock**; SI units throughout:
//!
//! ```text
//! M v' + C v + K u = f_drive + f_contact + f_rock + dead loads,      u' = v,      C = beta K
//! ```
//!
//! | force | law | file |
//! |---|---|---|
//! | drive `F_A`, N | `alpha F0` by a relay with hysteresis, chambers with ports, or an input | `laws/drive.rs`, `laws/chambers.rs` |
//! | contact `F_C`, N | `-KC g` while the gap `g <= 0` | `laws/contact.rs` |
//! | rock `F_R`, N | five modes: loading `KR`, dashpot `CR`, unloading `gamma KR` | `laws/rock.rs` |
//!
//! The law is piecewise linear with memory. Between events the hammer is linear with constant
//! coefficients, so nothing is stepped: the state is carried by modal exponentials and
//! polynomials, and the search for the next event is a proof. The answer depends neither on
//! how time is sliced nor on the processor. The model is that of Depouhon, Denoël and
//! Detournay, *Multiscale aspects in modeling percussive drilling*.
//!
//! # Use
//! A [`Machine`] is a scene in motion: it takes [`Parameters`] (the default is a 3-inch hammer
//! in soft rock) and [`InputValues`], [advances](Machine::advance) in steps of any size, and is
//! read between them.
//!
//! ```
//! use hammer::{Event, InputValues, Machine, Parameters, Relay};
//!
//! let mut hammer = Machine::new(&Parameters::default(), &InputValues::default(), 0.0)?;
//! hammer.keep_journal(true);
//! hammer.advance(1.0)?;
//! let journal = hammer.take_journal();
//! let blow = hammer.blow().expect("blows within a second");
//! println!("{:.0} J per blow, {:.1} mm/s", blow.energy, 1e3 * blow.rop);
//! let turns = journal.iter().filter(|r| r.event == Event::Relay(Relay::Return)).count();
//! println!("{turns} strokes, {} collisions", hammer.counters().contacts);
//! # assert_eq!(format!("{:.0} J per blow, {:.1} mm/s", blow.energy, 1e3 * blow.rop),
//! #     "223 J per blow, 34.0 mm/s");
//! # assert_eq!((turns, hammer.counters().contacts), (22, 44));
//! # Ok::<(), hammer::Error>(())
//! ```
//!
//! It prints:
//!
//! ```text
//! 223 J per blow, 34.0 mm/s
//! 22 strokes, 44 collisions
//! ```
//!
//! `examples/` has a stationary table and a hammer coupled with a chamber of one's own.
//!
//! # Features
//! `internals` opens the engine's parts to its own evidence; nothing in them is promised.

/// Highest derivative of an input that is taken.
pub const MAX_INPUT_ORDER: usize = 4;

pub mod diagnostics;
mod error;
mod machine;
pub mod periodic;
pub mod presets;
pub mod sensitivity;
pub mod variables;

/// Parts that the engine's own evidence may look into.
macro_rules! internals {
    ($($name:ident)*) => {$(
        #[cfg(not(feature = "internals"))]
        mod $name;
        #[cfg(feature = "internals")]
        #[doc(hidden)]
        pub mod $name;
    )*};
}
internals! { bodies laws modal motion numerics quantities search }

pub use bodies::resolution::MeshAdvice;
pub use error::{
    CorruptState, DisplayNumber, Error, InputError, ParameterError, SpectrumError, WorkLimit,
};
pub use laws::event::{Event, RockEvent};
pub use laws::mode::{Chamber, Mode, Port, Relay, RockMode};
pub use machine::Machine;
pub use machine::blows::{Blow, MAX_STEP_BLOWS};
pub use machine::journal::{Counters, Record};
pub use machine::ledger::{Energies, Impulses};
pub use machine::outputs::{Kinematics, Profile};
pub use machine::peaks::Peaks;
pub use machine::state::State;
pub use machine::zeno::{MAX_BURST, MAX_SIMULTANEOUS, SHORTEST_SPACING};
pub use modal::shared::forget as forget_shared_systems;
pub use num_complex::Complex64;
pub use numerics::vectors::Vectors;
pub use quantities::domain::Domain;
pub use quantities::inputs::Input;
pub use quantities::parameters;
pub use quantities::parameters::{
    Fidelity, InputValues, MAX_DEGREE, MAX_ELEMENTS, Parameters, Source,
};
pub use quantities::quantity;
pub use quantities::scales::Timescales;
pub use quantities::sections::{Body, MAX_SEGMENTS, Sections, Segment};
pub use quantities::warnings::Suspect;
pub use search::TIME_RESOLUTION;
pub use search::work::Interrupt;
