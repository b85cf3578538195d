//! The driving force on the piston, distributed like its mass.
//!
//! | source | force `F_A`, N |
//! |---|---|
//! | relay | `alpha F0` |
//! | force | the input `drive_force` |
//! | pressure | `p_drive A_drive - p_return A_return`, both pressures inputs |
//! | air | the force of the air in the chambers, over the exhaust's pressure ([`air`](super::air)) |
//!
//! All but air may have a transmission line at the piston: the force is then that of the line's wave, to which
//! `-Zd vr'` is added (`motion/line.rs`).
//!
//! The return chamber also presses on the bit, with `(p_return - p_exhaust) anvil_area`, distributed like the bit's
//! mass (a slow pressure excites no waves). The body that is fed carries the rest of the drive's reaction, unless it
//! is the bit itself, so that all forces add up to zero.
//!
//! The relay is the paper's pressure law, with memory `alpha`. Its position `vr = up_mean - ub_mean - g0` is the
//! piston's mean displacement relative to that of the body that is fed:
//!
//! | mode | guard | direction | next |
//! |---|---|---|---|
//! | `alpha = +1` | Q9: `vr` through 0 | rising | `alpha = -1` |
//! | `alpha = -1` | Q10: `vr` through `-D1` | falling | `alpha = +1` |

use crate::laws::event::{Direction, Displacement, Event, Guard};
use crate::laws::mode::Relay;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{Drive, Source};

impl Drive {
    /// `F_A` as a polynomial of time, N.
    pub(crate) fn force(&self, inputs: &Inputs, relay: Relay) -> Poly {
        match self.source {
            Source::Relay => Poly::constant(relay.sign() * self.amplitude),
            Source::Force => *inputs.of(Input::DriveForce),
            Source::Pressure => {
                self.balance(inputs.of(Input::DrivePressure), inputs.of(Input::ReturnPressure))
            }
            Source::Air => Poly::default(), // Of its window.
        }
    }

    /// Derivative of `F_A` by an input, N per its unit.
    pub(crate) fn force_per(&self, input: Input) -> f64 {
        match (self.source, input) {
            (Source::Force, Input::DriveForce) => 1.0,
            (Source::Pressure, Input::DrivePressure) => self.area_drive,
            (Source::Pressure, Input::ReturnPressure) => -self.area_return,
            (Source::Air, Input::ExhaustPressure) => self.area_return - self.area_drive,
            _ => 0.0,
        }
    }

    /// `p_drive A_drive - p_return A_return`.
    fn balance(&self, drive: &Poly, back: &Poly) -> Poly {
        Poly::default().plus(self.area_drive, drive).plus(-self.area_return, back)
    }

    /// The force of the return chamber on the bit, N; that of air follows from its window. The body that is fed
    /// carries the opposite force, unless it is the bit.
    pub(crate) fn on_bit(&self, inputs: &Inputs) -> Poly {
        match self.source {
            Source::Relay | Source::Force | Source::Air => Poly::default(),
            Source::Pressure => {
                Poly::default().plus(self.anvil_area, inputs.of(Input::ReturnPressure))
            }
        }
    }

    /// Least and largest force on the piston, and largest force on the bit, N, while the piston is at rest: air
    /// pressures may be anything between exhaust and supply.
    pub(crate) fn reach(&self, inputs: &Inputs) -> [f64; 3] {
        if self.source != Source::Air {
            let force = |relay| self.force(inputs, relay).at(0.0);
            return [force(Relay::Return), force(Relay::Drive), self.on_bit(inputs).at(0.0)];
        }
        let pressure = |input| *inputs.of(input);
        let [low, high] = [Input::ExhaustPressure, Input::SupplyPressure].map(pressure);
        let on_bit = self.area_return * (high.at(0.0) - low.at(0.0));
        [self.balance(&low, &high).at(0.0), self.balance(&high, &low).at(0.0), on_bit]
    }

    /// Q9 or Q10 of the position `vr`; none for a source without a relay.
    pub(crate) fn guard(&self, relay: Relay, vr: Displacement) -> Option<Guard> {
        let (direction, level) = match relay {
            Relay::Drive => (Direction::Rising, 0.0),
            Relay::Return => (Direction::Falling, -self.stroke),
        };
        (self.source == Source::Relay).then(|| Guard {
            displacement: vr,
            order: 0,
            direction,
            level,
            event: Event::Relay(relay.turned()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::parameters::{InputValues, Parameters};

    /// By a difference over 2^20 Pa or N, which is exact but for the rounding of a product.
    #[test]
    fn each_input_moves_the_force_by_its_own_slope() {
        let step = 2.0_f64.powi(20);
        for (source, input) in [Source::Force, Source::Pressure]
            .into_iter()
            .flat_map(|source| Input::ALL.map(|input| (source, input)))
        {
            let drive = Drive { source, ..Parameters::default().drive };
            let force = |value: f64| {
                let mut inputs = Inputs::constant(&InputValues::default());
                inputs.0[input as usize] = Poly::constant(value);
                drive.force(&inputs, Relay::Drive).at(0.0)
            };
            assert_eq!((force(step) - force(0.0)) / step, drive.force_per(input), "{input:?}");
        }
    }
}
