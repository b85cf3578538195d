//! Rod on rod: a loose joint of a drill string, the faces and the thread each one-sided.
//!
//! | mode | force on the lower rod, N | stored energy, J |
//! |---|---|---|
//! | open | 0 | 0 |
//! | shoulder: the faces press | `-kj (x + beta x')` | `kj x^2 / 2` |
//! | ring: the thread pulls | `-kj (x - slack + beta x')` | `kj (x - slack)^2 / 2` |
//!
//! `x` is the displacement of the lower rod's upper face relative to the upper rod's lower face, m,
//! and `beta` the damping time of the rods' material. The guards are those of the chuck, which is the
//! same tie; without slack there are none, and the joint holds both ways. In the engine all that is
//! above a joint is displaced by `slack` while its thread pulls, so that both closed modes are one
//! linear system.

use crate::laws::event::{Displacement, Event, Guard};
use crate::laws::mode::{Joints, Mode};
use crate::quantities::parameters::{ChuckLaw, Parameters};

impl Parameters {
    /// The law of every loose joint.
    pub(crate) fn joint(&self) -> ChuckLaw {
        let joint = self.drill.joint;
        ChuckLaw {
            stiffness: joint.stiffness,
            viscosity: self.material.damping_time * joint.stiffness,
            travel: joint.slack,
            idle_travel: 0.0,
        }
    }

    /// Guards of the loose joints in a mode.
    pub(crate) fn joint_guards(&self, mode: &Mode) -> impl Iterator<Item = Guard> {
        let count = if self.drill.joint.slack > 0.0 { self.drill.joints() } else { 0 };
        let guards = (count > 0).then(|| {
            let (law, Joints(ties)) = (self.joint(), mode.joints);
            ties.into_iter().zip(0..).take(count).flat_map(move |(tie, joint)| {
                law.changes(tie, Displacement::Joint(joint), move |to| Event::Joint { joint, to })
            })
        });
        guards.into_iter().flatten()
    }
}
