//! The graph of a hammer: bodies are its nodes, ties its edges.
//!
//! ```text
//!            casing         the frame, if there is one: the feed force and the drive's reaction act on it
//!              |
//!   piston - shank - rod - ... - bit      without rods there is only the bit; the rock's spring is at its tip
//! ```
//!
//! A *group* is a set of bodies that are joined by ties that hold. A group and the spring at its tip have one linear
//! system. The graph is a tree, so each tie separates some bodies, those *beyond* it, from the bit. While the tie is
//! pulled, the engine displaces these bodies.

use crate::bodies::bar::Bar;
use crate::error::Error;
use crate::laws::event::{Bodies, Displacement};
use crate::laws::mode::{Mode, Tie, TieState, Ties};
use crate::laws::rock::{Coefficients, Spring};
use crate::laws::tie::TieLaw;
use crate::quantities::parameters::{Parameters, Source};
use crate::quantities::sections::Body;
use serde::{Deserialize, Serialize};

/// Number of loads.
pub const CHANNELS: usize = 4;

/// Loads, in the order of a system's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// `F_A`, distributed over the piston like its mass, and its reaction on a frame, N.
    Drive,
    /// Feed force at the top of the frame or, without a frame, at the top of the body that the piston strikes, N.
    Feed,
    /// Gravity on all bodies; the channel's value is `G`, m/s2.
    Gravity,
    /// The return chamber's pressure on the body that the piston strikes, distributed like its mass, and its reaction
    /// on a frame, N.
    Anvil,
}

/// Indices, in two groups, of the free modes of bodies that the groups share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overlap {
    /// Index of the first of these modes in the old group.
    pub from: usize,
    /// Index of the first of these modes in the new group.
    pub to: usize,
    /// Number of these modes.
    pub count: usize,
}

/// Bodies that are joined by ties that hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Group {
    /// The bodies.
    pub bodies: Bodies,
    /// The spring at the tip, if the bit is one of the bodies.
    pub spring: Option<Spring>,
}

impl Group {
    /// The piston in flight.
    pub const PISTON: Self = Self { bodies: Bodies::PISTON, spring: None };
}

/// A tie of two bodies, or of one body and the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub tie: Tie,
    pub law: TieLaw,
    /// The body above; `None` means the ground.
    pub upper: Option<usize>,
    /// The body below.
    pub lower: usize,
    pub ends: Bodies,
    /// All bodies that the tie separates from the bit.
    pub beyond: Bodies,
}

/// Bodies and their ties.
#[derive(Debug)]
pub struct Graph {
    /// The bodies from the piston down to the bit, then the casing, if there is one.
    pub bodies: Vec<Bar>,
    pub(crate) ties: Vec<Edge>,
    /// The body on which the feed force and the drive's reaction act: the casing, or without one the body that the
    /// piston strikes.
    pub frame: usize,
    /// True if air drives the piston.
    aired: bool,
    /// The body that ends at the rock: the bit, or the last rod with the bit.
    pub(crate) bit: usize,
    /// The displacements that are evaluated, each with the bodies that contribute to it.
    listed: Vec<(Displacement, Bodies)>,
    /// The displacements on which loads do work, each with its bodies and the share of each channel's load.
    pub(crate) loaded: Vec<(Displacement, Bodies, [f64; CHANNELS])>,
}

impl Graph {
    /// The graph of a scene.
    ///
    /// # Errors
    /// [`Error::Modes`] for a body whose modes cannot be found; [`Error::Cancelled`].
    pub(crate) fn new(parameters: &Parameters) -> Result<Self, Error> {
        let missing = |body: Body| {
            Error::if_interrupted().err().unwrap_or(Error::Modes { body: body.name() })
        };
        let mut bodies = Vec::new();
        for body in parameters.bodies() {
            let bars = match body {
                Body::Bit => Bar::string(parameters),
                _ => Bar::of(parameters, body).map(|bar| vec![bar]),
            };
            bodies.extend(bars.ok_or_else(|| missing(body))?);
        }
        let (bit, last) = (1 + parameters.drill.loose(), bodies.len() - 1);
        let edge = |(tie, law): (Tie, TieLaw)| {
            let (upper, lower) = tie.ends(last);
            let ends = upper
                .map_or(Bodies::one(lower), |upper| Bodies::one(upper).and(Bodies::one(lower)));
            Edge { tie, law, upper, lower, ends, beyond: Bodies::default() }
        };
        let ties = parameters.ties().into_iter().map(edge).collect();
        let frame = if last > bit { last } else { 1 };
        let aired = parameters.drive.source == Source::Air;
        let mut graph =
            Self { bodies, ties, frame, aired, bit, listed: Vec::new(), loaded: Vec::new() };
        let all = Bodies::first(last + 1);
        for place in 0..graph.ties.len() {
            let tie = graph.ties[place].tie;
            graph.ties[place].beyond = all.without(graph.joined_to(bit, |other| other != tie));
        }
        graph.load();
        graph.list();
        Ok(graph)
    }

    /// Lists the displacements on which loads do work.
    fn load(&mut self) {
        let (piston, string, frame) = (Bodies::PISTON, self.string(), Bodies::one(self.frame));
        let feed = (Displacement::Top(self.frame), frame, [0.0, 1.0, 0.0, 0.0]);
        let mass = |bodies| self.mass(bodies);
        let anvil = |mass| (Displacement::STRUCK, Bodies::STRUCK, [0.0, 0.0, mass, 1.0]);
        let mut loaded = vec![(Displacement::PISTON, piston, [1.0, 0.0, mass(piston), 0.0])];
        if string == Bodies::STRUCK {
            loaded.push(anvil(mass(string)));
        } else {
            loaded.push((Displacement::Mean(string), string, [0.0, 0.0, mass(string), 0.0]));
            loaded.push(anvil(0.0));
        }
        if self.is_framed() {
            loaded.push((Displacement::Mean(frame), frame, [-1.0, 0.0, mass(frame), -1.0]));
        }
        loaded.push(feed);
        self.loaded = loaded;
    }

    /// Lists the displacements that are evaluated.
    fn list(&mut self) {
        let frame = Bodies::one(self.frame);
        let ties = self.ties.iter().map(|edge| (Displacement::Tie(edge.tie), edge.ends));
        let loaded = self.loaded.iter().map(|(displacement, bodies, _)| (*displacement, *bodies));
        self.listed = vec![
            (Displacement::Tip, Bodies::one(self.bit)),
            (Displacement::Relative, Bodies::PISTON.and(frame)),
        ];
        let over_struck = (Displacement::OverStruck, Bodies::PISTON.and(Bodies::STRUCK));
        self.listed.extend(ties.chain(loaded));
        self.listed.extend((self.aired && self.is_framed()).then_some(over_struck));
    }

    /// The displacement that sets the volume of the return chamber.
    pub(crate) fn over_struck(&self) -> Displacement {
        if self.is_framed() { Displacement::OverStruck } else { Displacement::Relative }
    }

    /// Adds the work of all loads on one of the [loaded](Self::loaded) displacements, each to its channel. Without a
    /// frame, the cylinder of an air hammer is held from outside the model, and follows the body that the piston
    /// strikes. The work of this support is counted with that of the feed, so that the drive's work is that of the air
    /// minus the drag's loss.
    pub(crate) fn add_works(
        &self,
        displacement: Displacement,
        parts: &[f64; CHANNELS],
        work: impl Fn(usize) -> f64,
        sums: &mut [f64; CHANNELS],
    ) {
        for i in (0..CHANNELS).filter(|i| parts[*i] != 0.0) {
            sums[i] += parts[i] * work(i);
        }
        if self.aired && !self.is_framed() && displacement == Displacement::STRUCK {
            let held = work(Channel::Drive as usize) + work(Channel::Anvil as usize);
            sums[Channel::Drive as usize] -= held;
            sums[Channel::Feed as usize] += held;
        }
    }

    /// True if there are two bodies, both rigid: then the piston strikes the bit, and no other body is held.
    pub(crate) fn is_rigid_pair(&self) -> bool {
        self.bodies.len() == 2 && self.bodies.iter().all(|bar| bar.len() == 1)
    }

    /// Shares of a rigid piston and a rigid bit in a displacement, if there is no other body.
    pub(crate) fn shares_of_pair(&self, displacement: Displacement) -> [f64; 2] {
        let of = |bodies: Bodies| [0, 1].map(|body| f64::from(u8::from(bodies.have(body))));
        match displacement {
            Displacement::Tip => [0.0, 1.0],
            Displacement::Tie(_) => [-1.0, 1.0],
            Displacement::Relative | Displacement::OverStruck => [1.0, -1.0],
            Displacement::Top(body) => of(Bodies::one(body)),
            Displacement::Mean(bodies) => of(bodies),
        }
    }

    /// The drill string with the bit: all bodies between piston and rock.
    pub(crate) fn string(&self) -> Bodies {
        Bodies::first(self.bit + 1).without(Bodies::PISTON)
    }

    /// True if there is a frame: a casing, on which the feed force and the drive's reaction act.
    pub(crate) fn is_framed(&self) -> bool {
        self.frame > 1
    }

    /// The tie between the frame and the body that the piston strikes.
    pub(crate) fn carrier(&self) -> Option<&Edge> {
        self.ties.iter().find(|edge| self.is_framed() && edge.upper == Some(self.frame))
    }

    /// True if there is a frame and it contributes to this displacement.
    pub(crate) fn is_of_frame(&self, displacement: Displacement) -> bool {
        let frame = Bodies::one(self.frame);
        let includes_frame =
            |(other, bodies): &(_, Bodies)| *other == displacement && bodies.meet(frame);
        self.is_framed() && self.listed.iter().any(includes_frame)
    }

    /// True if there are loose joints. They allow so many groups that nothing is stored for pairs of groups.
    pub(crate) fn is_loose(&self) -> bool {
        self.bit > 1
    }

    pub(crate) fn edge(&self, tie: Tie) -> Option<&Edge> {
        self.ties.iter().find(|edge| edge.tie == tie)
    }

    /// A body with all bodies that are joined to it, directly or through others, by ties for which `holds` is true.
    fn joined_to(&self, body: usize, holds: impl Fn(Tie) -> bool) -> Bodies {
        let mut joined = Bodies::one(body);
        loop {
            let adjacent = |edge: &&Edge| edge.ends.meet(joined) && holds(edge.tie);
            let adjacent = self.ties.iter().filter(adjacent);
            let extended = adjacent.fold(joined, |bodies, edge| bodies.and(edge.ends));
            if extended == joined {
                return joined;
            }
            joined = extended;
        }
    }

    fn group_of(&self, body: usize, mode: &Mode) -> Group {
        let bodies = self.joined_to(body, |tie| mode.ties.hold(tie));
        let spring = bodies.have(self.bit).then(|| Spring::of(mode.rock));
        Group { bodies, spring }
    }

    /// The group that ends at the rock.
    pub(crate) fn at_tip(&self, mode: &Mode) -> Group {
        self.group_of(self.bit, mode)
    }

    /// All groups: from the bit's upward to the piston's, then the casing's if it belongs to neither.
    pub(crate) fn groups(&self, mode: &Mode) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::with_capacity(self.bodies.len());
        let bit_to_piston = (0..=self.bit).rev();
        for body in bit_to_piston.chain(self.bit + 1..self.bodies.len()) {
            if !groups.iter().any(|group| group.bodies.have(body)) {
                groups.push(self.group_of(body, mode));
            }
        }
        groups
    }

    /// True if a scene with this graph can be in a mode.
    pub(crate) fn admits(&self, mode: &Mode) -> bool {
        let possible = |tie: Tie| match (self.edge(tie), mode.ties.of(tie)) {
            (None, state) => state == Ties::START.of(tie),
            (Some(_), TieState::Pressed) => true,
            (Some(edge), TieState::Open) => edge.law.travel > 0.0,
            (Some(edge), TieState::Pulled) => edge.law.travel > 0.0 && edge.law.travel.is_finite(),
        };
        Tie::all().all(possible) && (self.is_framed() || !mode.vented)
    }

    /// Each tie that holds, with its stiffness and viscosity.
    pub(crate) fn holding(&self, ties: Ties) -> impl Iterator<Item = (&Edge, Coefficients)> {
        let holding = self.ties.iter().filter(move |edge| ties.hold(edge.tie));
        holding.map(|edge| (edge, edge.law.line))
    }

    /// The ties inside a group.
    pub(crate) fn inside(&self, group: Group) -> impl Iterator<Item = &Edge> {
        let others = Bodies::first(self.bodies.len()).without(group.bodies);
        self.ties.iter().filter(move |edge| !edge.ends.meet(others))
    }

    /// The bodies of a group in their order, each with its number and the index of its first mode in the group.
    pub(crate) fn bodies_of(
        &self,
        bodies: Bodies,
    ) -> impl Iterator<Item = (usize, usize, &Bar)> + Clone {
        let mut first = 0;
        let members = self.bodies.iter().enumerate().filter(move |(body, _)| bodies.have(*body));
        members.map(move |(body, bar)| {
            first += bar.len();
            (body, first - bar.len(), bar)
        })
    }

    /// All bodies.
    pub fn all(&self) -> Bodies {
        Bodies::first(self.bodies.len())
    }

    /// Number of modes of a set of bodies.
    pub(crate) fn modes(&self, bodies: Bodies) -> usize {
        self.bodies_of(bodies).map(|(_, _, bar)| bar.len()).sum()
    }

    /// Total mass of a set of bodies, kg.
    pub(crate) fn mass(&self, bodies: Bodies) -> f64 {
        self.bodies_of(bodies).fold(0.0, |sum, (_, _, bar)| sum + bar.mass)
    }

    /// Squared frequencies of the modes of a set of bodies, rad2/s2.
    pub(crate) fn omega2(&self, bodies: Bodies) -> impl Iterator<Item = &f64> {
        self.bodies_of(bodies).flat_map(|(_, _, bar)| &bar.omega2)
    }

    /// The runs of free modes that two groups share.
    pub(crate) fn overlaps(&self, from: Group, to: Group) -> Vec<Overlap> {
        let mut list: Vec<Overlap> = Vec::new();
        for (body, start, bar) in self.bodies_of(to.bodies) {
            let old = self.bodies_of(from.bodies).find(|(other, ..)| *other == body);
            let Some((_, old, _)) = old else { continue };
            match list.last_mut() {
                Some(last) if last.from + last.count == old && last.to + last.count == start => {
                    last.count += bar.len();
                }
                _ => list.push(Overlap { from: old, to: start, count: bar.len() }),
            }
        }
        list
    }

    /// Index of a group's share of a displacement among the functionals of the group's system; `None` if the group does
    /// not contribute. The shares of all groups add up to the displacement.
    pub(crate) fn share(&self, group: Group, displacement: Displacement) -> Option<usize> {
        self.share_of_listed(group, self.place(displacement)?)
    }

    /// Index of a displacement among the listed ones.
    pub(crate) fn place(&self, displacement: Displacement) -> Option<usize> {
        if displacement == Displacement::Tip {
            return Some(0); // It is first, because it is needed most often.
        }
        self.listed.iter().position(|(other, _)| *other == displacement)
    }

    /// As [`Self::share`], for the listed displacement at an index.
    pub(crate) fn share_of_listed(&self, group: Group, place: usize) -> Option<usize> {
        let has = |(_, bodies): &&(Displacement, Bodies)| bodies.meet(group.bodies);
        let (before, rest) = self.listed.split_at(place);
        rest.first().filter(has).map(|_| before.iter().filter(has).count())
    }

    /// The displacements to which a group contributes, in the order of its system's functionals.
    pub(crate) fn shares(&self, group: Group) -> impl Iterator<Item = Displacement> {
        let has = move |(_, bodies): &&(Displacement, Bodies)| bodies.meet(group.bodies);
        self.listed.iter().filter(has).map(|(displacement, _)| *displacement)
    }

    /// Amplitudes of a displacement in the modes of a group.
    pub(crate) fn shape(&self, group: Group, displacement: Displacement) -> Vec<f64> {
        let mut shape = Vec::with_capacity(self.modes(group.bodies));
        for (body, _, bar) in self.bodies_of(group.bodies) {
            self.add_shape(displacement, body, bar, &mut shape);
        }
        shape
    }

    /// Appends one body's part of [`Self::shape`].
    fn add_shape(&self, displacement: Displacement, body: usize, bar: &Bar, to: &mut Vec<f64>) {
        // The first mode is the body's translation, whose amplitude gives the mean displacement.
        let (points, sign, mean) = match displacement {
            Displacement::Tip if body == self.bit => (Some(&bar.bottom), 1.0, 0.0),
            Displacement::Top(place) if body == place => (Some(&bar.top), 1.0, 0.0),
            Displacement::Tie(tie) => match self.edge(tie) {
                Some(edge) if edge.upper == Some(body) => (Some(&bar.bottom), -1.0, 0.0),
                Some(edge) if edge.lower == body => (Some(&bar.top), 1.0, 0.0),
                _ => (None, 1.0, 0.0),
            },
            Displacement::Relative if body == 0 => (None, 1.0, 1.0),
            Displacement::Relative if body == self.frame => (None, -1.0, 1.0),
            Displacement::OverStruck if body == 0 => (None, 1.0, 1.0),
            Displacement::OverStruck if body == 1 => (None, -1.0, 1.0),
            Displacement::Mean(bodies) if bodies.have(body) => {
                (None, 1.0, bar.mass / self.mass(bodies))
            }
            _ => (None, 1.0, 0.0),
        };
        match points {
            Some(points) => to.extend(points.iter().map(|x| sign * x)),
            None => {
                to.push(sign * (mean / bar.mass.sqrt()));
                to.resize(to.len() + bar.len() - 1, 0.0 * sign);
            }
        }
    }

    /// How far the engine displaces a body because of the pulled ties that separate it from the bit, m.
    pub(crate) fn lifted(&self, body: usize, ties: &Ties) -> f64 {
        let beyond = self.ties.iter().filter(|edge| edge.beyond.have(body));
        beyond.fold(0.0, |sum, edge| sum + edge.law.offset(ties.of(edge.tie)))
    }

    /// The constant to add to a displacement of the engine to obtain the true one, m.
    pub(crate) fn ahead(&self, displacement: Displacement, ties: &Ties) -> f64 {
        match displacement {
            Displacement::Relative => self.lifted(self.frame, ties) - self.lifted(0, ties),
            Displacement::OverStruck => self.lifted(1, ties) - self.lifted(0, ties),
            Displacement::Mean(Bodies::PISTON) => -self.lifted(0, ties),
            Displacement::Mean(bodies) => {
                let moment =
                    |(body, _, bar): (usize, usize, &Bar)| bar.mass * self.lifted(body, ties);
                -self.bodies_of(bodies).map(moment).sum::<f64>() / self.mass(bodies)
            }
            // The positions of ties are stored relative to the position at which they close.
            Displacement::Tip | Displacement::Tie(_) | Displacement::Top(_) => 0.0,
        }
    }
}
