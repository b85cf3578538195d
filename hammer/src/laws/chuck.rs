//! Bit in casing: the chuck's shoulder and its retaining ring, each one-sided. A loose joint of two
//! rods (`joint.rs`) is the same tie.
//!
//! | mode | force on the bit's top, N | stored energy, J | guard | direction | next |
//! |---|---|---|---|---|---|
//! | open | 0 | 0 | `x` through 0 | falling | shoulder |
//! | | | | `x` through `travel` | rising | ring |
//! | shoulder | `-(ks x + cs x')` | `ks x^2 / 2` | `x` through 0 | rising | open |
//! | ring | `-(ks (x - travel) + cs x')` | `ks (x - travel)^2 / 2` | `x` through `travel` | falling | open |
//!
//! `x` is the displacement of the bit's upper face relative to the casing, m; the opposite force
//! acts on the casing. The dashpot acts while the tie is closed, also where it pulls. In the engine
//! the casing is displaced by `travel` while the ring holds the bit, so that both closed modes are
//! one linear system. Where `idle_travel` is given, the drive is vented from there on: `F_A = 0`.

use crate::laws::event::{Direction, Displacement, Event, Guard, Quantity};
use crate::laws::mode::Chuck;
use crate::laws::rock::Coefficients;
use crate::quantities::parameters::ChuckLaw;

impl ChuckLaw {
    /// What is added to the casing's displacement in a mode, m.
    pub(crate) fn offset(&self, chuck: Chuck) -> f64 {
        if chuck == Chuck::Ring { self.travel } else { 0.0 }
    }

    /// Stiffness and viscosity that act in a mode: of the force on the casing, with the opposite
    /// sign, where `x` is measured from where the tie closes.
    pub(crate) fn line(&self, chuck: Chuck) -> Coefficients {
        let Self { stiffness, viscosity, .. } = *self;
        if chuck == Chuck::Open {
            Coefficients::default()
        } else {
            Coefficients { stiffness, viscosity }
        }
    }

    /// Guards of the present mode.
    pub(crate) fn guards(&self, chuck: Chuck, vented: bool) -> impl Iterator<Item = Guard> {
        let venting = if vented { Direction::Falling } else { Direction::Rising };
        let vent = Guard {
            quantity: Quantity::Displacement(Displacement::Chuck),
            direction: venting,
            level: self.idle_travel,
            event: Event::Vent(!vented),
        };
        let vents = chuck == Chuck::Open && self.idle_travel > 0.0;
        self.changes(chuck, Displacement::Chuck, Event::Chuck).chain(vents.then_some(vent))
    }

    /// Guards of a tie in a mode, by its displacement `x`.
    pub(crate) fn changes<E: Fn(Chuck) -> Event>(
        &self,
        tie: Chuck,
        x: Displacement,
        event: E,
    ) -> impl Iterator<Item = Guard> + use<E> {
        use Direction::{Falling, Rising};
        let guard = |direction, level, to| {
            let quantity = Quantity::Displacement(x);
            Some(Guard { quantity, direction, level, event: event(to) })
        };
        let guards = match tie {
            Chuck::Open => {
                [guard(Falling, 0.0, Chuck::Shoulder), guard(Rising, self.travel, Chuck::Ring)]
            }
            Chuck::Shoulder => [guard(Rising, 0.0, Chuck::Open), None],
            Chuck::Ring => [guard(Falling, 0.0, Chuck::Open), None],
        };
        guards.into_iter().flatten()
    }
}
