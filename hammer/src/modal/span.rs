//! The bodies that a linear system contains, and which displacements it has a share of.

use crate::laws::event::Displacement;
use crate::laws::mode::{Chuck, Mode};
use crate::laws::rock::Spring;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Bodies that a linear system contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Span {
    /// The piston alone.
    Piston,
    /// The bit alone.
    Bit(Spring),
    /// Both, in contact.
    Both(Spring),
    /// The casing alone.
    Casing,
    /// Bit and casing, tied by the chuck.
    Lower(Spring),
    /// All three.
    All(Spring),
    /// Some of a loose drill string, perhaps with the piston.
    Run(Run),
}

/// Neighbours in a loose drill string that are closed on each other: 0 is the piston, 1 the shank,
/// then rods; the last rod carries the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Run {
    first: u8,
    last: u8,
    /// What acts on the tip, if the bit belongs to them.
    spring: Option<Spring>,
}

impl Run {
    /// The bodies.
    pub(crate) fn bodies(self) -> RangeInclusive<usize> {
        usize::from(self.first)..=usize::from(self.last)
    }

    /// The joints inside.
    pub(crate) fn joints(self) -> std::ops::Range<u8> {
        self.first.max(1) - 1..self.last - 1
    }

    /// The joints inside, and those that end it.
    fn ends(self) -> std::ops::Range<u8> {
        self.first.max(2) - 2..if self.spring.is_some() { self.last - 1 } else { self.last }
    }

    fn displacements(self) -> &'static [Displacement] {
        use Displacement::{BitMean, BitTop, Gap, PistonMean, Relative, Tip};
        match (self.first, self.spring.is_some()) {
            (0, false) => &[Gap, Relative, BitTop, BitMean, PistonMean],
            (0, true) => &[Tip, Gap, Relative, BitTop, BitMean, PistonMean],
            (1, false) => &[Gap, Relative, BitTop, BitMean],
            (1, true) => &[Tip, Gap, Relative, BitTop, BitMean],
            (_, false) => &[BitMean],
            (_, true) => &[Tip, BitMean],
        }
    }
}

impl Span {
    /// The displacements of which it has a share of its own, in the order of its system's
    /// functionals; after them come a run's joints.
    fn listed(self) -> &'static [Displacement] {
        use Displacement::{
            BitMean, BitTop, Casing, CasingTop, Chuck, Gap, InCasing, PistonMean, Relative, Tip,
        };
        match self {
            Self::Piston => &[Gap, PistonMean],
            Self::Bit(_) => &[Tip, Gap, Relative, BitTop, BitMean],
            Self::Both(_) => &[Tip, Gap, Relative, BitTop, BitMean, PistonMean],
            Self::Casing => &[Chuck, Casing, CasingTop, InCasing],
            Self::Lower(_) => {
                &[Tip, Gap, Relative, BitTop, BitMean, Chuck, Casing, CasingTop, InCasing]
            }
            Self::All(_) => &[
                Tip, Gap, Relative, BitTop, BitMean, PistonMean, Chuck, Casing, CasingTop, InCasing,
            ],
            Self::Run(run) => run.displacements(),
        }
    }

    fn joints(self) -> std::ops::Range<u8> {
        if let Self::Run(run) = self { run.ends() } else { 0..0 }
    }

    /// All of them.
    pub(crate) fn displacements(self) -> impl Iterator<Item = Displacement> {
        self.listed().iter().copied().chain(self.joints().map(Displacement::Joint))
    }

    /// Index of this span's share of a displacement among its system's functionals; none if it has
    /// none. The shares of all spans add up to the displacement.
    pub fn share(self, displacement: Displacement) -> Option<usize> {
        use Displacement::{BitTop, Chuck, InCasing, PistonMean, Relative};
        // One functional may be its share of several.
        let own = match (self, displacement) {
            (Self::Piston, Relative | InCasing) | (Self::Both(_), InCasing) => PistonMean,
            (Self::Bit(_) | Self::Both(_), Chuck) => BitTop,
            _ => displacement,
        };
        let listed = self.listed();
        if let Displacement::Joint(joint) = own {
            let mut joints = self.joints();
            return joints.position(|other| other == joint).map(|place| listed.len() + place);
        }
        listed.iter().position(|&d| d == own)
    }

    /// The spring at the tip, if the span has one.
    pub(crate) fn spring(self) -> Option<Spring> {
        match self {
            Self::Piston | Self::Casing => None,
            Self::Bit(spring) | Self::Both(spring) | Self::Lower(spring) | Self::All(spring) => {
                Some(spring)
            }
            Self::Run(run) => run.spring,
        }
    }

    /// True if it contains the piston and what it strikes.
    pub(crate) fn is_in_contact(self) -> bool {
        matches!(self, Self::Both(_) | Self::All(_) | Self::Run(Run { first: 0, .. }))
    }

    /// True if it contains bit and casing.
    pub(crate) fn is_in_chuck(self) -> bool {
        matches!(self, Self::Lower(_) | Self::All(_))
    }
}

/// Which bodies a scene has beside piston and bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chain {
    /// True with a casing.
    pub cased: bool,
    /// Loose joints of the drill string: as many bodies more.
    pub joints: usize,
}

impl Chain {
    /// The span of the tip under the rock's spring, by the ties of a mode.
    pub(crate) fn at_tip(self, mode: Mode) -> Span {
        let spring = Spring::of(mode.rock);
        match (mode.closed, mode.chuck == Chuck::Open) {
            _ if self.joints > 0 => {
                let last = self.joints + 1;
                let parted = (0..last).rev().find(|&upper| !is_tied(mode, upper));
                run(parted.map_or(0, |upper| upper + 1), last, Some(spring))
            }
            (false, true) => Span::Bit(spring),
            (true, true) => Span::Both(spring),
            (false, false) => Span::Lower(spring),
            (true, false) => Span::All(spring),
        }
    }

    /// The spans of a mode, that of the tip first.
    pub(crate) fn spans(self, mode: Mode) -> Vec<Span> {
        let tip = self.at_tip(mode);
        if let Span::Run(Run { first, .. }) = tip {
            let (mut list, mut end) = (vec![tip], usize::from(first));
            for upper in (0..end).rev().filter(|&upper| !is_tied(mode, upper)) {
                if upper + 1 < end {
                    list.push(run(upper + 1, end - 1, None));
                }
                end = upper + 1;
            }
            if end > 0 {
                list.push(run(0, end - 1, None));
            }
            return list;
        }
        let flying = (!mode.closed).then_some(Span::Piston);
        let hanging = (self.cased && mode.chuck == Chuck::Open).then_some(Span::Casing);
        [Some(tip), flying, hanging].into_iter().flatten().collect()
    }

    /// True for ties that such a scene can have.
    pub(crate) fn admits(self, mode: Mode, slack: f64) -> bool {
        let joints = if slack > 0.0 { self.joints } else { 0 };
        let others = mode.joints.0.iter().skip(joints);
        (self.cased || mode.chuck == Chuck::Open && !mode.vented)
            && others.into_iter().all(|tie| *tie == Chuck::Shoulder)
    }
}

/// True if a body of a loose string is closed on the one below it.
fn is_tied(mode: Mode, upper: usize) -> bool {
    match upper.checked_sub(1) {
        None => mode.closed,
        Some(joint) => mode.joints.0[joint] != Chuck::Open,
    }
}

/// At most nine bodies, and the piston.
fn run(first: usize, last: usize, spring: Option<Spring>) -> Span {
    let at = |body: usize| u8::try_from(body).unwrap_or(u8::MAX);
    if last == 0 {
        Span::Piston
    } else {
        Span::Run(Run { first: at(first), last: at(last), spring })
    }
}
