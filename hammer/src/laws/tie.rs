//! Ties: one-sided springs with a dashpot, each between an upper and a lower body.
//!
//! | state | force on the lower body, N | stored energy, J | guard | direction | next |
//! |---|---|---|---|---|---|
//! | open | 0 | 0 | `x` through 0 | falling | pressed |
//! | | | | `x` through `travel` | rising | pulled |
//! | pressed | `-(k x + c x')` | `k x^2 / 2` | `x` through 0 | rising | open |
//! | pulled | `-(k (x - travel) + c x')` | `k (x - travel)^2 / 2` | `x` through `travel` | falling | open |
//!
//! `x` is the displacement of the lower body's upper face relative to the upper body's lower face, m. The opposite
//! force acts on the upper body. The dashpot acts while the tie holds, even where a pressed tie then pulls. While a tie
//! is pulled, the engine displaces the bodies on its far side from the bit by `travel`, so that pressed and pulled ties
//! have the same linear system. If `chuck.idle_travel` is given, the drive is vented (`F_A = 0`) while the bit hangs
//! out further than that, and acts again at half of it.

use crate::laws::event::{Direction, Displacement, Event, Guard};
use crate::laws::mode::{Mode, Tie, TieState};
use crate::laws::rock::Coefficients;
use crate::quantities::parameters::Parameters;
use crate::quantities::sections::{Body, Segment};
use crate::quantities::table::name_of;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TieLaw {
    /// Stiffness and viscosity while the tie holds.
    pub line: Coefficients,
    /// Distance between the pressed and the pulled position, m.
    pub travel: f64,
}

impl TieLaw {
    /// Displacement, in the engine, of the bodies on the tie's far side from the bit, m.
    pub fn offset(&self, state: TieState) -> f64 {
        if state == TieState::Pulled { self.travel } else { 0.0 }
    }

    /// Stiffness and viscosity that act in a state.
    pub fn acting(&self, state: TieState) -> Coefficients {
        if state == TieState::Open { Coefficients::default() } else { self.line }
    }

    /// Guards of a tie in a state; none if it always holds because its travel is 0.
    pub fn guards(&self, tie: Tie, state: TieState) -> impl Iterator<Item = Guard> + use<> {
        use Direction::{Falling, Rising};
        let guard = |direction, level, to| {
            let (displacement, event) = (Displacement::Tie(tie), Event::Tie(tie, to));
            Some(Guard { displacement, order: 0, direction, level, event })
        };
        let pulls = guard(Rising, self.travel, TieState::Pulled);
        let guards = match state {
            _ if self.travel == 0.0 => [None, None],
            TieState::Open => [
                guard(Falling, 0.0, TieState::Pressed),
                pulls.filter(|_| self.travel < f64::INFINITY),
            ],
            TieState::Pressed => [guard(Rising, 0.0, TieState::Open), None],
            TieState::Pulled => [guard(Falling, 0.0, TieState::Open), None],
        };
        guards.into_iter().flatten()
    }
}

impl Tie {
    /// Name of the parameter that gives the tie's travel; empty if there is none.
    pub(crate) fn travel_name(self) -> &'static str {
        match self {
            Self::Chuck => name_of(|p| &mut p.chuck.travel),
            Self::Joint(_) => name_of(|p| &mut p.drill.joint.slack),
            Self::Contact | Self::String => "",
        }
    }
}

/// Advice in case the piston runs out of its cylinder.
pub(crate) const VENTING: &str = "a bit that hangs out vents the drive if chuck.idle_travel is less than that, \
    and more feed_force holds the casing down";

/// The share of the idle travel at which a vented drive acts again. At the idle travel itself, its first thrust would
/// lift the casing beyond it at once.
const DRIVEN_AGAIN: f64 = 0.5;

impl Parameters {
    /// The guard that vents the drive or ends venting; there is one only while the chuck is open.
    pub(crate) fn vent_guard(&self, mode: &Mode) -> Option<Guard> {
        let (chuck, vented) = (Tie::Chuck, mode.vented);
        let vents = self.chuck.idle_travel > 0.0 && !mode.ties.hold(chuck) && self.has_casing();
        vents.then_some(Guard {
            displacement: Displacement::Tie(chuck),
            order: 0,
            direction: if vented { Direction::Falling } else { Direction::Rising },
            level: self.chuck.idle_travel * if vented { DRIVEN_AGAIN } else { 1.0 },
            event: Event::Vent(!vented),
        })
    }

    /// Length of the wave front that an impact at the casing's chuck sends, m; infinite without a casing.
    pub(crate) fn frame_front(&self) -> f64 {
        if !self.has_casing() {
            return f64::INFINITY;
        }
        let mobility = |section: &Segment| 1.0 / self.impedance_of(section.area);
        let lower = mobility(&self.sections(Body::Bit).as_slice()[0]);
        let upper = self.own(Body::Casing).2.last().map_or(0.0, mobility);
        self.wave_speed() / ((lower + upper) * self.chuck.stiffness)
    }

    /// The ties of a scene, in the order of their events at one instant.
    pub(crate) fn ties(&self) -> Vec<(Tie, TieLaw)> {
        let law = |stiffness, viscosity, travel| {
            let line = Coefficients { stiffness, viscosity };
            TieLaw { line, travel }
        };
        let mut ties = vec![(Tie::Contact, law(self.meeting_stiffness(), 0.0, f64::INFINITY))];
        if self.has_casing() {
            let chuck = &self.chuck;
            ties.push((Tie::Chuck, law(chuck.stiffness, chuck.viscosity, chuck.travel)));
            ties.push((Tie::String, law(0.0, self.casing.impedance, 0.0)));
        }
        let joint = self.drill.joint;
        let damped = self.material.damping_time * joint.stiffness;
        let joints = (0..).map(Tie::Joint).take(self.drill.loose());
        ties.extend(joints.map(|tie| (tie, law(joint.stiffness, damped, joint.slack))));
        ties.retain(|(_, law)| law.line != Coefficients::default());
        ties
    }
}
