//! Which bodies stand on each other, and how far the engine displaces those that a tie holds back.

use super::Motion;
use crate::laws::event::Displacement;
use crate::laws::rock::Coefficients;
use crate::modal::span::Span;
use std::mem::discriminant;
use std::ops::Range;

impl Motion {
    /// The displacement that switches the drive, `vr`.
    pub(crate) fn relative(&self) -> Displacement {
        let cased = self.model.casing.is_some();
        if cased { Displacement::InCasing } else { Displacement::Relative }
    }

    /// What a displacement lacks in the engine, m: the casing is displaced while the ring holds the
    /// bit, and what is above a joint while its thread pulls.
    pub(crate) fn ahead(&self, displacement: Displacement) -> f64 {
        match displacement {
            Displacement::InCasing => self.parameters().chuck.offset(self.state.mode.chuck),
            Displacement::PistonMean => -self.lifted(0),
            Displacement::BitMean if self.model.chain.joints > 0 => {
                let bodies = self.model.string.iter().enumerate();
                let moments: f64 = bodies.map(|(body, bar)| bar.mass * self.lifted(body)).sum();
                -moments / self.model.string_mass()
            }
            _ => 0.0,
        }
    }

    /// Displacement and law of each tie that holds: of the bodies in contact, in the chuck and in the
    /// joints, and of a casing by the string above it.
    pub(crate) fn ties(&self) -> impl Iterator<Item = (Displacement, Coefficients)> + use<> {
        let (laws, mode) = (self.parameters(), self.state.mode);
        let contact = (Displacement::Gap, self.contact().line());
        let chuck = (Displacement::Chuck, laws.chuck.line(mode.chuck));
        let string = Coefficients { stiffness: 0.0, viscosity: laws.casing.impedance };
        let cased = [chuck, (Displacement::CasingTop, string)].into_iter();
        let cased = cased.filter({
            let is_cased = self.model.chain.cased;
            move |_| is_cased
        });
        let law = laws.joint();
        let joints = mode.joints.0.into_iter().zip(0..).take(self.model.chain.joints);
        let joints = joints.map(move |(tie, joint)| (Displacement::Joint(joint), law.line(tie)));
        let all = std::iter::once(contact).chain(cased).chain(joints);
        all.filter(|(_, line)| *line != Coefficients::default())
    }

    /// How far a body of the drill string, counted from the shank, is displaced in the engine, m: by
    /// all joints below it whose threads pull.
    pub(crate) fn lifted(&self, body: usize) -> f64 {
        let (law, ties) = (self.parameters().joint(), &self.state.mode.joints.0);
        let below = ties.iter().take(self.model.chain.joints).skip(body);
        below.fold(0.0, |sum, tie| sum + law.offset(*tie))
    }

    /// The track of a body that flies alone.
    pub(crate) fn flying(&self, span: Span) -> Option<usize> {
        self.state
            .anchors
            .iter()
            .position(|anchor| discriminant(&anchor.span) == discriminant(&span))
    }

    /// The tracks that have neither the tip nor the piston alone: a free casing, parted rods.
    pub(crate) fn others(&self) -> Range<usize> {
        let end = self.state.anchors.len();
        match self.flying(Span::Piston) {
            None => 1..end,
            // Before a casing, after all rods.
            Some(_) if self.model.chain.cased => 2..end,
            Some(piston) => 1..piston,
        }
    }
}
