//! The inputs: their rows of the table, and their values as polynomials of time.

use crate::MAX_INPUT_ORDER;
use crate::numerics::display::DisplayNumber;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::quantities::parameters::{InputValues, Source};
use crate::quantities::quantity::{FORCE, PRESSURE, Quantity};
use crate::quantities::table::Reader;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Largest allowed value, as a multiple of the nominal one.
const LARGEST: f64 = 1e9;
/// Largest allowed first derivative, over the largest allowed value, 1/s. For the derivative of order `n` it is the
/// power `n` of this number.
const FASTEST: f64 = 1e6;
/// Names of an input's value and derivatives.
const DERIVATIVES: [&str; MAX_INPUT_ORDER + 1] =
    ["a value", "a rate", "a second derivative", "a third derivative", "a fourth derivative"];

/// The reason why an input is refused.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum InputError {
    /// The input has no value.
    #[error("it has no value")]
    NoValue,
    /// More derivatives are given than [`crate::MAX_INPUT_ORDER`].
    #[error("its derivatives may have orders up to {}", crate::MAX_INPUT_ORDER)]
    OrderTooHigh,
    /// A value or a derivative is not a number, or infinite.
    #[error("a value or derivative is not a finite number")]
    NotFinite,
    /// A value or a derivative is larger than that of any hammer.
    #[error("{what} of {} is not allowed: it must be from -{most:e} to {most:e}", DisplayNumber(*.value))]
    TooLarge {
        /// Name of the value or the derivative.
        what: &'static str,
        /// The given value.
        value: f64,
        /// The largest allowed magnitude.
        most: f64,
    },
    /// The pressure of air must be positive.
    #[error("{} Pa is not allowed: it is absolute and must be above 0 when drive.source is Air", DisplayNumber(*.value))]
    NoPressure {
        /// The given value, Pa.
        value: f64,
    },
}

/// An input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Input {
    /// Feed force on the bit's shoulder, N.
    FeedForce,
    /// Force on the piston, N.
    DriveForce,
    /// Pressure driving the piston down, Pa.
    DrivePressure,
    /// Pressure returning the piston, Pa.
    ReturnPressure,
    /// Pressure of the supply's air, Pa.
    SupplyPressure,
    /// Pressure at the exhaust, Pa.
    ExhaustPressure,
}

impl Input {
    /// All inputs.
    pub const ALL: [Self; 6] = [
        Self::FeedForce,
        Self::DriveForce,
        Self::DrivePressure,
        Self::ReturnPressure,
        Self::SupplyPressure,
        Self::ExhaustPressure,
    ];

    /// True for the inputs of the sources `Force` and `Pressure`.
    pub(crate) fn drives(self) -> bool {
        matches!(self, Self::DriveForce | Self::DrivePressure | Self::ReturnPressure)
    }

    /// The input's row of the table.
    pub fn row(self) -> &'static InputRow {
        &INPUTS[self as usize]
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Checks a value (order 0) or a derivative (order 1 to [`MAX_INPUT_ORDER`]). The largest allowed value is 1e9
    /// times the nominal one. The largest allowed derivative changes the input by the largest value within 1 us.
    ///
    /// # Errors
    ///
    /// [`InputError::NotFinite`], [`InputError::TooLarge`], [`InputError::OrderTooHigh`].
    pub fn check(self, order: usize, value: f64) -> Result<(), InputError> {
        let what = *DERIVATIVES.get(order).ok_or(InputError::OrderTooHigh)?;
        let most = LARGEST * self.row().nominal * math::powi(FASTEST, order);
        match value.is_finite() {
            false => Err(InputError::NotFinite),
            true if value.abs() > most => Err(InputError::TooLarge { what, value, most }),
            true => Ok(()),
        }
    }

    /// The polynomial of time whose value and derivatives at present are `values`, for a drive with this source.
    ///
    /// # Errors
    ///
    /// No value is given, [`Self::check`] refuses a value, or air drives the piston and its pressure is not positive.
    pub(crate) fn polynomial(self, values: &[f64], source: Source) -> Result<Poly, InputError> {
        let value = *values.first().ok_or(InputError::NoValue)?;
        values.iter().enumerate().try_for_each(|(order, value)| self.check(order, *value))?;
        let is_air = self.row().reader == Reader::Drive(&[Source::Air]);
        if source == Source::Air && is_air && value <= 0.0 {
            return Err(InputError::NoPressure { value });
        }
        Ok(Poly::taylor(values))
    }
}

/// A row of the table.
#[derive(Debug)]
pub struct InputRow {
    /// Name, unique.
    pub name: &'static str,
    /// Meaning.
    pub description: &'static str,
    /// Type.
    pub quantity: Quantity,
    /// Order of magnitude.
    pub nominal: f64,
    /// Which input.
    pub input: Input,
    /// Accessor of the input's start value.
    pub start: fn(&mut InputValues) -> &mut f64,
    /// Which sources read the input.
    pub reader: Reader,
}

/// The inputs, in the order of [`Input::ALL`].
#[rustfmt::skip]
pub static INPUTS: [InputRow; 6] = [
    InputRow { name: "feed_force", description: "Feed force on the bit's shoulder, or on the casing, positive downward", quantity: FORCE, nominal: 5e3,
        input: Input::FeedForce, start: |i| &mut i.feed_force, reader: Reader::Every },
    InputRow { name: "drive_force", description: "Force on the piston, positive downward, when drive.source is Force", quantity: FORCE, nominal: 1e3,
        input: Input::DriveForce, start: |i| &mut i.drive_force, reader: Reader::Drive(&[Source::Force]) },
    InputRow { name: "drive_pressure", description: "Pressure that drives the piston down, gauge, when drive.source is Pressure", quantity: PRESSURE, nominal: 1e6,
        input: Input::DrivePressure, start: |i| &mut i.drive_pressure, reader: Reader::Drive(&[Source::Pressure]) },
    InputRow { name: "return_pressure", description: "Pressure that returns the piston, gauge, when drive.source is Pressure", quantity: PRESSURE, nominal: 1e6,
        input: Input::ReturnPressure, start: |i| &mut i.return_pressure, reader: Reader::Drive(&[Source::Pressure]) },
    InputRow { name: "supply_pressure", description: "Absolute pressure of the air that the hammer is fed with, when drive.source is Air", quantity: PRESSURE, nominal: 1e6,
        input: Input::SupplyPressure, start: |i| &mut i.supply_pressure, reader: Reader::Drive(&[Source::Air]) },
    InputRow { name: "exhaust_pressure", description: "Absolute pressure at the exhaust, when drive.source is Air: that of the hole's bottom", quantity: PRESSURE, nominal: 1e5,
        input: Input::ExhaustPressure, start: |i| &mut i.exhaust_pressure, reader: Reader::Drive(&[Source::Air]) },
];

/// Every input as a polynomial of time, in the order of [`Input::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inputs(pub [Poly; Input::ALL.len()]);

impl Inputs {
    /// Inputs that stay at these values.
    pub fn constant(values: &InputValues) -> Self {
        let mut values = *values;
        Self(Input::ALL.map(|input| Poly::constant(*(input.row().start)(&mut values))))
    }

    /// The polynomial of an input.
    pub fn of(&self, input: Input) -> &Poly {
        &self.0[input as usize]
    }

    /// True if no input varies.
    pub fn are_constant(&self) -> bool {
        self.0.iter().all(Poly::is_constant)
    }

    /// Moves the time origin to `t` later.
    pub fn shift(&mut self, t: f64) {
        self.0.iter_mut().for_each(|p| p.shift(t));
    }
}
