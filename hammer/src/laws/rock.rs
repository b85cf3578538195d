//! Bit on rock: five modes, and a memory of the depth drilled.
//!
//! `p = w1.u` is the displacement of the bit/rock interface, m; `F_R >= 0` acts upward on it.
//!
//! | mode | force `F_R`, N | stored energy, J | guard | direction | next |
//! |---|---|---|---|---|---|
//! | FF | 0 | 0 | Q1: `p - ul` through 0 | rising | DFC |
//! | DFC | `KR (p - ul) + CR p'` | `KR (p - ul)^2 / (2 gamma)` | Q2: `p'` through 0 | falling | BC |
//! | | | | Q3: `psi` through `WR` | rising | FC |
//! | FC | `KR (p - ul)` | `KR (p - ul)^2 / (2 gamma)` | Q4: `p'` through 0 | falling | BC |
//! | BC | `gamma KR (p - uu)` | `gamma KR (p - uu)^2 / 2` | Q5: `p - uu` through 0 | falling | FF |
//! | | | | Q6: `p'` through 0 | rising | SS if `dp < dps`, else DFC |
//! | SS | `gamma KR (p - uu)` | `gamma KR (p - uu)^2 / 2` | `p - uu` through 0 | falling | FF |
//! | | | | Q7: `p'` through `vs` | rising | DFC |
//! | | | | Q8: `p'` through `-vs` | falling | BC |
//!
//! The elastic power lost on loading, in DFC and FC, is `(1 - 1/gamma) KR (p - ul) p'`.
//! The viscous power in DFC is `psi' = CR p'^2`.
//! Transitions also set:
//!
//! * Q1: `psi = 0`;
//! * Q2, Q4: `uu := p - (p - ul)/gamma`, `dp := uu - (previous uu)`;
//! * Q5 and lift-off: `ul := uu`;
//! * Q6, Q7 to DFC: `ul := p - gamma (p - uu)`, `psi = 0`.
//!
//! If `rock.reloading` is `Unloading`, a bit that turns downward again before it has left the rock goes back along the
//! unloading line (Hustrulid and Fairhurst, Lundberg).
//! Q6 then always leads to SS, which has two guards: lift-off and, in place of Q7 and Q8, `gamma KR (p - uu)` rising
//! through the force at which the tip had turned upward.
//! At that force DFC begins as at Q7.
//!
//! The engine measures displacements from the *origin*, the zero of the present loading or unloading line (`ul` or
//! `uu`), so that a force is a stiffness times a small number however deep the hole is.
//! A transition to another line moves the origin. In free flight the origin is the bottom of the hole.
//!
//! Source: the paper, equations (2) to (5). Lift-off from standstill is not in the paper; without it a slowly lifted
//! bit would stick to the rock.

use crate::laws::event::{Direction, Displacement, Event, Guard, RockEvent};
use crate::laws::mode::RockMode;
use crate::quantities::parameters::{Reloading, Rock};
use serde::{Deserialize, Serialize};

/// A spring and a dashpot at the tip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficients {
    /// Stiffness of the spring, N/m.
    pub stiffness: f64,
    /// Viscosity of the dashpot, N s/m.
    pub viscosity: f64,
}

impl Coefficients {
    /// Force at a displacement and a velocity, N. Given the rates of both, it is the rate of the force.
    pub(crate) fn force(self, p: f64, v: f64) -> f64 {
        self.stiffness * p + self.viscosity * v
    }

    /// Energy stored in the spring at a displacement, J.
    pub(crate) fn stored_energy(self, x: f64) -> f64 {
        0.5 * self.stiffness * x * x
    }

    /// Rate of the energy stored in the spring at a displacement and a velocity, W.
    pub(crate) fn stored_power(self, x: f64, v: f64) -> f64 {
        self.stiffness * x * v
    }

    /// Power dissipated by the dashpot at a velocity, W.
    pub(crate) fn lost_power(self, v: f64) -> f64 {
        self.viscosity * v * v
    }
}

impl Rock {
    /// Stiffness `gamma KR` of the unloading line, N/m.
    pub(crate) fn unloading_stiffness(&self) -> f64 {
        self.unloading_ratio * self.stiffness
    }
}

/// The spring, if any, between the tip and the rock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Spring {
    /// No spring: the tip is off the rock.
    Free,
    /// A spring of stiffness `KR`.
    Loading,
    /// A spring of stiffness `KR` and a dashpot of viscosity `CR`.
    Viscous,
    /// A spring of stiffness `gamma KR`.
    Unloading,
}

impl Spring {
    /// All four springs.
    pub const ALL: [Self; 4] = [Self::Free, Self::Loading, Self::Viscous, Self::Unloading];

    /// The spring of a mode.
    pub fn of(mode: RockMode) -> Self {
        match mode {
            RockMode::FreeFlight => Self::Free,
            RockMode::DissipativeForward => Self::Viscous,
            RockMode::Forward => Self::Loading,
            RockMode::Backward | RockMode::Standstill => Self::Unloading,
        }
    }

    /// Stiffness and viscosity of the spring in this rock.
    pub fn coefficients(self, rock: &Rock) -> Coefficients {
        let (stiffness, viscosity) = match self {
            Self::Free => (0.0, 0.0),
            Self::Loading => (rock.stiffness, 0.0),
            Self::Viscous => (rock.stiffness, rock.viscosity),
            Self::Unloading => (rock.unloading_stiffness(), 0.0),
        };
        Coefficients { stiffness, viscosity }
    }

    /// True on the loading line, where the rock dissipates part of the elastic work.
    pub(crate) fn is_loading(self) -> bool {
        matches!(self, Self::Loading | Self::Viscous)
    }

    /// The part of `work`, the elastic work done on the rock, that is returned on unloading.
    fn returned(self, rock: &Rock, work: f64) -> f64 {
        if self.is_loading() { work / rock.unloading_ratio } else { work }
    }

    /// `1 - 1/gamma`, the part of the elastic work that is not returned on unloading; 0 while the rock is not loaded.
    /// The formula does not cancel if `gamma` is near 1.
    fn lost_part(self, rock: &Rock) -> f64 {
        let gamma = rock.unloading_ratio;
        if self.is_loading() { (gamma - 1.0) / gamma } else { 0.0 }
    }

    fn stiffness(self, rock: &Rock) -> f64 {
        self.coefficients(rock).stiffness
    }

    /// Recoverable energy at the tip's displacement `p`, J.
    pub(crate) fn stored_energy(self, rock: &Rock, p: f64) -> f64 {
        self.returned(rock, 0.5 * self.stiffness(rock) * p * p)
    }

    /// Rate of the recoverable energy at the tip's displacement `p` and velocity `v`, W.
    pub(crate) fn stored_power(self, rock: &Rock, p: f64, v: f64) -> f64 {
        self.returned(rock, self.stiffness(rock) * p * v)
    }

    /// Rate of the elastic work dissipated in the rock, W.
    pub(crate) fn lost_power(self, rock: &Rock, p: f64, v: f64) -> f64 {
        self.lost_part(rock) * self.stiffness(rock) * p * v
    }

    /// Elastic work dissipated in the rock from `start` to `end`, J.
    pub(crate) fn lost_on_loading(self, rock: &Rock, start: f64, end: f64) -> f64 {
        0.5 * self.lost_part(rock) * self.stiffness(rock) * (end - start) * (end + start)
    }
}

impl RockMode {
    /// The guards of this mode, except the energy barrier (Q3), which is not a function of the motion at one instant.
    pub(crate) fn guards(self, rock: &Rock, memory: &Memory) -> impl Iterator<Item = Guard> {
        use Direction::{Falling, Rising};
        let (p, v) = (0, 1);
        let guard = |order, direction, level, event| {
            let (displacement, event) = (Displacement::Tip, Event::Rock(event));
            Some(Guard { displacement, order, direction, level, event })
        };
        let (vs, unloading) = (rock.standstill_speed, Spring::Unloading.stiffness(rock));
        let guards: [Option<Guard>; 3] = match self {
            Self::FreeFlight => [guard(p, Rising, 0.0, RockEvent::Touch), None, None],
            Self::DissipativeForward => {
                [guard(v, Falling, 0.0, RockEvent::DissipativeTurn), None, None]
            }
            Self::Forward => [guard(v, Falling, 0.0, RockEvent::Turn), None, None],
            Self::Backward => [
                guard(p, Falling, 0.0, RockEvent::LiftOff),
                guard(v, Rising, 0.0, RockEvent::Return),
                None,
            ],
            Self::Standstill if rock.reloading == Reloading::Unloading => [
                guard(p, Falling, 0.0, RockEvent::StandstillLiftOff),
                // The position at which the tip last turned upward, measured from the foot of the unloading line.
                guard(p, Rising, memory.turned / unloading, RockEvent::Restart),
                None,
            ],
            Self::Standstill => [
                guard(p, Falling, 0.0, RockEvent::StandstillLiftOff),
                guard(v, Rising, vs, RockEvent::Restart),
                guard(v, Falling, -vs, RockEvent::Retreat),
            ],
        };
        guards.into_iter().flatten()
    }

    /// True while the work of the tip's dashpot counts towards the energy barrier.
    pub(crate) fn is_viscous(self) -> bool {
        self == Self::DissipativeForward
    }

    /// The mode that `event` leads to.
    pub(crate) fn next(self, event: RockEvent, memory: &Memory, rock: &Rock) -> Self {
        use RockEvent::{
            Barrier, DissipativeTurn, LiftOff, Restart, Retreat, Return, StandstillLiftOff, Touch,
            Turn,
        };
        match event {
            Barrier => Self::Forward,
            DissipativeTurn | Turn | Retreat => Self::Backward,
            LiftOff | StandstillLiftOff => Self::FreeFlight,
            Return
                if rock.reloading == Reloading::Unloading
                    || memory.gain < rock.standstill_penetration =>
            {
                Self::Standstill
            }
            Touch | Return | Restart => Self::DissipativeForward,
        }
    }
}

/// The memory of the law. Positions are relative to the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// `uu` at the last unloading, m.
    pub unloaded: f64,
    /// Permanent penetration `dp` that the last cycle gained, m.
    pub gain: f64,
    /// Force at which the tip last turned upward, N.
    pub turned: f64,
}

/// The effect of a transition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// The new mode.
    pub mode: RockMode,
    /// How far the origin moves, m.
    pub shift: f64,
    /// The tip's position relative to the new origin, m. It is computed separately, because the difference of the old
    /// position and the shift cancels if `gamma` is large.
    pub tip: f64,
}

/// The gain is a difference of two positions. This is the number of roundings in each of them.
const ROUNDED: f64 = 4.0;

impl Memory {
    /// Makes the transition that `event` causes. `p` is the tip's position, which is accurate to `error`. Afterwards
    /// the memory is relative to the new origin.
    pub fn transit(
        &mut self,
        from: RockMode,
        event: RockEvent,
        p: f64,
        error: f64,
        rock: &Rock,
    ) -> Transition {
        use RockEvent::{DissipativeTurn, Restart, Return, Turn};
        let gamma = rock.unloading_ratio;
        let mode = from.next(event, self, rock);
        let (shift, tip) = match event {
            DissipativeTurn | Turn => {
                // The form p - p/gamma would cancel for `gamma` near 1.
                let unloaded = p * (gamma - 1.0) / gamma;
                let gain = unloaded - self.unloaded;
                // The gain is compared with `dps`, which may be zero. So a gain that is no larger than its own error
                // counts as zero. The error includes that of the previous unloading, which is as large as this one's.
                let rounding = ROUNDED * f64::EPSILON * (unloaded.abs() + self.unloaded.abs());
                let gain_error = rounding + 2.0 * error * (gamma - 1.0) / gamma;
                self.gain = if gain.abs() <= gain_error { 0.0 } else { gain };
                (self.unloaded, self.turned) = (unloaded, Spring::of(from).stiffness(rock) * p);
                (unloaded, p / gamma)
            }
            Return | Restart if mode == RockMode::DissipativeForward => {
                (-(gamma - 1.0) * p, gamma * p)
            }
            _ => (0.0, p),
        };
        self.unloaded -= shift;
        Transition { mode, shift, tip }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::parameters::Parameters;

    /// The stored power is compared with a difference of energies, and the dashpot's loss with its force times speed.
    #[test]
    fn powers_of_a_tie_are_the_rate_of_its_energy_and_the_power_of_its_dashpot() {
        let tie = Coefficients { stiffness: 3e8, viscosity: 4e3 };
        let (x, v, h) = (-2e-4, 1.7, 1e-6);
        let stored = (tie.stored_energy(x + v * h) - tie.stored_energy(x - v * h)) / (2.0 * h);
        let rounding = 8.0 * f64::EPSILON * (stored.abs() + tie.stored_energy(x) / h);
        assert!((tie.stored_power(x, v) - stored).abs() <= rounding);
        let dashpot = tie.force(x, v) - tie.force(x, 0.0);
        // The difference of two rounded forces.
        let rounding = 4.0 * f64::EPSILON * tie.force(x, v).abs() * v;
        assert!((tie.lost_power(v) - dashpot * v).abs() <= rounding);
        assert!(tie.lost_power(v) > 0.0);
    }

    /// At `gamma = 1 + d`, where `d` is a power of two, the gain of a cycle is `p d / (1 + d)` and the shift on the way
    /// back is `-d p`, each to two roundings. With `p - p/gamma` only about `log2(d / 2^-53)` binary digits would be
    /// right.
    #[test]
    fn the_gain_of_a_cycle_keeps_its_digits_where_gamma_is_near_one() {
        let d = 2f64.powi(-40);
        let rock = crate::quantities::parameters::Rock {
            unloading_ratio: 1.0 + d,
            ..Parameters::default().rock
        };
        let (p, mut memory) = (3.1e-4, Memory::default());
        let close = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs();
        let down = memory.transit(RockMode::Forward, RockEvent::Turn, p, 0.0, &rock);
        assert!(close(down.shift, p * d / (1.0 + d)), "{:e}", down.shift);
        let reload = memory.transit(RockMode::Standstill, RockEvent::Restart, p, 0.0, &rock);
        assert!(close(reload.shift, -d * p), "{:e}", reload.shift);
        let lost = Spring::Loading.lost_on_loading(&rock, 0.0, p);
        assert!(close(lost, 0.5 * rock.stiffness * p * p * d / (1.0 + d)), "{lost:e}");
    }

    /// `F_R` after the turn to unloading equals `KR p` before it, whatever the depth of the hole. With `gamma` = 1e4
    /// the shift brings the tip from 0.7 m to 70 um; a difference of positions would have an error of 1e-16 m.
    #[test]
    fn the_force_after_a_turn_does_not_feel_the_depth_of_the_hole() {
        let rock = crate::quantities::parameters::Rock {
            unloading_ratio: 1e4,
            ..Parameters::default().rock
        };
        let turn = Memory::default().transit(RockMode::Forward, RockEvent::Turn, 0.7, 0.0, &rock);
        let after = rock.unloading_ratio * turn.tip;
        assert!((after - 0.7).abs() <= 2.0 * f64::EPSILON * 0.7, "{after:e}");
        assert!((turn.tip - (0.7 - turn.shift)).abs() <= f64::EPSILON);
    }

    /// A tip that turns upward at the point where it had started downward gains nothing, however `p - (p - ul)/gamma`
    /// is rounded.
    #[test]
    fn no_gain_is_none_however_it_is_rounded() {
        let mut rock = Parameters::default().rock;
        rock.standstill_penetration = 0.0;
        for i in 1..2000 {
            rock.unloading_ratio = 1.0 + f64::from(i) * 3.7e-6;
            let (mut memory, p) = (Memory::default(), 3.1e-5 * f64::from(i).sqrt());
            let turn = memory.transit(RockMode::Forward, RockEvent::Turn, p, 0.0, &rock);
            let forth = memory.transit(RockMode::Backward, RockEvent::Return, turn.tip, 0.0, &rock);
            memory.transit(RockMode::Forward, RockEvent::Turn, forth.tip, 0.0, &rock);
            assert_eq!(memory.gain, 0.0);
            assert_eq!(
                memory.transit(RockMode::Backward, RockEvent::Return, 1e-9, 0.0, &rock).mode,
                RockMode::DissipativeForward
            );
        }
    }

    /// A cycle ends `1e-17` m short of the previous one. If both positions are uncertain by `6e-18` m, its gain counts
    /// as zero; if they are uncertain by `4e-18` m, it is negative.
    #[test]
    fn a_gain_that_the_places_errors_hide_is_none() {
        let mut rock = Parameters::default().rock;
        rock.standstill_penetration = 0.0;
        for (error, mode) in [(6e-18, RockMode::DissipativeForward), (4e-18, RockMode::Standstill)]
        {
            let (mut memory, p) = (Memory::default(), 1e-9);
            let turn = memory.transit(RockMode::Forward, RockEvent::Turn, p, error, &rock);
            let forth = memory.transit(RockMode::Backward, RockEvent::Return, turn.tip, 0.0, &rock);
            memory.transit(RockMode::Forward, RockEvent::Turn, forth.tip - 1e-17, error, &rock);
            assert_eq!(
                memory.transit(RockMode::Backward, RockEvent::Return, 1e-10, 0.0, &rock).mode,
                mode
            );
        }
    }

    /// The tip turns at `p`, goes back to `q` on the unloading line, and turns at `r` on the new loading line. The hole
    /// deepens by `p (1 - 1/gamma)`, and then by `r (1 - 1/gamma) - (gamma - 1) q`. This must not depend on where the
    /// zero of each line is, except for the rounding of the terms.
    #[test]
    fn a_gain_is_between_two_unloadings_wherever_their_lines_begin() {
        let rock = Parameters::default().rock;
        let (gamma, mut memory) = (rock.unloading_ratio, Memory::default());
        let [p, q, r] = [1e-3, 1e-4, 9e-4];
        memory.transit(RockMode::Forward, RockEvent::Turn, p, 0.0, &rock);
        let first = p * (1.0 - 1.0 / gamma);
        assert!((memory.gain - first).abs() <= 4.0 * f64::EPSILON * first);
        memory.transit(RockMode::Backward, RockEvent::Return, q, 0.0, &rock);
        memory.transit(RockMode::Forward, RockEvent::Turn, r, 0.0, &rock);
        let second = r * (1.0 - 1.0 / gamma) - (gamma - 1.0) * q;
        assert!((memory.gain - second).abs() <= 8.0 * f64::EPSILON * r, "{:e}", memory.gain);
    }

    #[test]
    fn standstill_is_left_at_its_speed_down_and_up() {
        let rock = Rock { standstill_speed: 2e-3, ..Parameters::default().rock };
        let memory = Memory::default();
        let guards = RockMode::Standstill.guards(&rock, &memory);
        let speed_guards = guards.filter(|guard| guard.order == 1);
        let exits: Vec<_> =
            speed_guards.map(|guard| (guard.direction, guard.level, guard.event)).collect();
        let [restart, retreat] = [RockEvent::Restart, RockEvent::Retreat].map(Event::Rock);
        assert_eq!(
            exits,
            [(Direction::Rising, 2e-3, restart), (Direction::Falling, -2e-3, retreat)]
        );
    }
}
