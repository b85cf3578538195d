//! The driving force on the piston, distributed like its mass.
//!
//! | source | force `F_A`, N |
//! |---|---|
//! | relay | `alpha F0` |
//! | force | the input `drive_force` |
//! | pressure | `p_drive A_drive - p_return A_return`, where both pressures are inputs |
//! | air | the force of the air in the chambers, with pressures counted from the exhaust's ([`air`](super::air)) |
//!
//! Every source except air may act through a transmission line at the piston: the force is then that of the line's
//! wave, to which `-Zd vr'` is added (`motion/line.rs`).
//!
//! The return chamber also presses on the bit with `(p_return - p_exhaust) anvil_area`. This force is distributed like
//! the bit's mass, since a slow pressure excites no waves. The body on which the feed force acts carries the rest of
//! the drive's reaction, so that all forces add up to zero. If that body is the bit itself, nothing else is applied to
//! it.
//!
//! The relay is the paper's pressure law, with the memory `alpha`.
//! It is switched by `vr = up_mean - ub_mean - g0`, the piston's mean displacement relative to that of the body on
//! which the feed force acts:
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
            Source::Air => Poly::default(), // `motion/air.rs` adds the force of the present window.
        }
    }

    /// Derivative of `F_A` by an input, N per unit of the input.
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

    /// The force of the return chamber on the bit, N. It is zero for air, whose force follows from its window.
    /// The body on which the feed force acts carries the opposite force, unless that body is the bit.
    pub(crate) fn on_bit(&self, inputs: &Inputs) -> Poly {
        match self.source {
            Source::Relay | Source::Force | Source::Air => Poly::default(),
            Source::Pressure => {
                Poly::default().plus(self.anvil_area, inputs.of(Input::ReturnPressure))
            }
        }
    }

    /// Least and largest force on the piston, and largest force on the bit, that are possible while the piston is at
    /// rest, N. The pressure of air may then have any value between those of exhaust and supply.
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

    /// The guard Q9 or Q10 on the displacement `vr`; none for a source without a relay.
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

    /// The slope is measured as a difference over 2^20 Pa or N, which is exact except for the rounding of a product.
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
