//! The five-mode bit/rock law: forces, memory, transitions.
//!
//! Displacements are measured from the *origin*, the zero of the present loading or
//! unloading line, so that a force is a stiffness times a small number for ever, however
//! deep the hole. In free flight the origin is the hole bottom.

use crate::physics::mode::RockMode;
use crate::physics::parameters::Rock;
use serde::{Deserialize, Serialize};

/// What acts at the tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Spring {
    /// Nothing.
    Free,
    /// `KR`.
    Loading,
    /// `KR` and `CR`.
    Viscous,
    /// `gamma KR`.
    Unloading,
}

impl Spring {
    /// All four.
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

    /// Stiffness (N/m) and viscosity (N s/m).
    pub fn coefficients(self, rock: &Rock) -> (f64, f64) {
        match self {
            Self::Free => (0.0, 0.0),
            Self::Loading => (rock.stiffness, 0.0),
            Self::Viscous => (rock.stiffness, rock.viscosity),
            Self::Unloading => (rock.unloading_ratio * rock.stiffness, 0.0),
        }
    }
}

/// What the tip's motion can do to the mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RockEvent {
    /// Q1: the bit reaches the rock.
    Touch,
    /// Q2, Q4: the tip's velocity falls through 0.
    Turn,
    /// Q3: the viscous work reaches the barrier.
    Barrier,
    /// Q5, and lift-off from standstill: the tip leaves the rock.
    Lift,
    /// Q6: the tip's velocity rises through 0.
    Return,
    /// Q7: the tip's velocity rises through `vs`.
    Restart,
    /// Q8: the tip's velocity falls through `-vs`.
    Retreat,
}

impl RockEvent {
    /// Name of the event function in the paper; `lift` where it has none.
    pub fn name(self, mode: RockMode) -> &'static str {
        match self {
            Self::Touch => "Q1",
            Self::Turn if mode == RockMode::Forward => "Q4",
            Self::Turn => "Q2",
            Self::Barrier => "Q3",
            Self::Lift if mode == RockMode::Standstill => "lift",
            Self::Lift => "Q5",
            Self::Return => "Q6",
            Self::Restart => "Q7",
            Self::Retreat => "Q8",
        }
    }
}

/// Memory of the law, relative to the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// `uu` at the last unloading, m.
    pub unloaded: f64,
    /// Permanent gain of the last cycle `dp`, m.
    pub gain: f64,
}

/// What a transition does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// The new mode.
    pub mode: RockMode,
    /// How far the origin moves, m.
    pub shift: f64,
}

impl Memory {
    /// The transition of `event` with the tip at `p`; the memory is then relative to the
    /// new origin.
    pub fn transit(&mut self, event: RockEvent, p: f64, rock: &Rock) -> Transition {
        use RockEvent::{Barrier, Lift, Restart, Retreat, Return, Touch, Turn};
        let gamma = rock.unloading_ratio;
        let (mode, shift) = match event {
            Touch => (RockMode::DissipativeForward, 0.0),
            Barrier => (RockMode::Forward, 0.0),
            Retreat => (RockMode::Backward, 0.0),
            Lift => (RockMode::FreeFlight, 0.0),
            Turn => {
                let unloaded = p - p / gamma;
                self.gain = unloaded - self.unloaded;
                self.unloaded = unloaded;
                (RockMode::Backward, unloaded)
            }
            Return if self.gain < rock.standstill_penetration => (RockMode::Standstill, 0.0),
            Return | Restart => (RockMode::DissipativeForward, p - gamma * p),
        };
        self.unloaded -= shift;
        Transition { mode, shift }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::parameters::Parameters;

    /// Force is continuous through Q2 and Q6: `KR p` before is `gamma KR p'` after, and
    /// back, to a rounding of each.
    #[test]
    fn the_elastic_force_is_continuous_where_lines_meet() {
        let rock = Parameters::default().rock;
        let mut memory = Memory::default();
        let p = 3.1e-4;
        let t = memory.transit(RockEvent::Turn, p, &rock);
        let q = p - t.shift;
        assert!((rock.stiffness * p - rock.unloading_ratio * rock.stiffness * q).abs() < 1e-11);
        let t = memory.transit(RockEvent::Restart, q, &rock);
        assert!((rock.unloading_ratio * q - (q - t.shift)).abs() < 1e-18);
    }

    #[test]
    fn a_cycle_without_permanent_gain_ends_in_standstill() {
        let rock = Parameters::default().rock;
        let mut memory = Memory::default();
        memory.transit(RockEvent::Turn, 1e-7, &rock);
        assert!(memory.gain < rock.standstill_penetration);
        assert_eq!(memory.transit(RockEvent::Return, 1e-8, &rock).mode, RockMode::Standstill);
        memory.transit(RockEvent::Restart, 1e-8, &rock);
        memory.transit(RockEvent::Turn, 1e-4, &rock);
        assert_eq!(
            memory.transit(RockEvent::Return, 1e-5, &rock).mode,
            RockMode::DissipativeForward
        );
    }
}
