//! Which bodies stand on each other, and how far the engine displaces those that a tie holds back.

use super::Motion;
use crate::laws::event::Displacement;
use crate::laws::mode::Chuck;
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

    /// The displacement and the line of each joint that is closed.
    pub(crate) fn ties(&self) -> impl Iterator<Item = (Displacement, Coefficients)> + use<> {
        let (law, ties) = (self.parameters().joint(), self.state.mode.joints.0);
        let ties = ties.into_iter().zip(0..).take(self.model.chain.joints);
        let closed = ties.filter(|(tie, _)| *tie != Chuck::Open);
        closed.map(move |(tie, joint)| (Displacement::Joint(joint), law.line(tie)))
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
