//! The tracks of an interval, and the loads on them.

use crate::laws::event::Bodies;
use crate::modal::system::System;
use crate::modal::system::driven::Driven;
use crate::modal::track::Track;
use crate::motion::Motion;
use crate::motion::state::MotionState;
use crate::numerics::poly::Poly;
use crate::numerics::series::LOW;
use crate::scene::graph::{CHANNELS, Group};
use std::array::from_fn;
use std::sync::Arc;

/// A force `k u + c u'` on one of an interval's tracks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Force {
    /// Index of the track on which it acts, among the tracks other than the tip's; `None` means the tip's.
    pub other: Option<usize>,
    /// Functional of the displacement `u`.
    pub functional: usize,
    /// Polynomial part of the force.
    pub poly: Poly,
    /// `k`, N/m.
    pub stiffness: f64,
    /// `c`, N s/m.
    pub viscosity: f64,
}

/// The tracks of an interval.
#[derive(Debug)]
pub(crate) struct Modes {
    pub(super) group: Group,
    pub(super) system: Arc<System>,
    /// State of the tip's track at the start, followed by that at the end.
    pub(super) ends: Vec<f64>,
    pub(super) loading: Loading,
    /// System of the piston, if it flies alone.
    pub(super) piston: Option<Arc<System>>,
    pub(super) others: Vec<Other>,
}

/// A track other than the tip's. Its interval begins at the event that last changed the track.
#[derive(Debug)]
pub(super) struct Other {
    pub(super) group: Group,
    pub(super) system: Arc<System>,
    /// State at the start, followed by that at the end.
    pub(super) ends: Vec<f64>,
    /// Length of the track's own interval, s.
    pub(super) span: f64,
    /// The polynomial part of its motion, in time from the start of its own interval.
    pub(super) driven: Driven,
}

/// Loads over an interval, and the polynomial part of the motion.
#[derive(Debug)]
pub(super) enum Loading {
    /// Constant loads, with the parabolas of the tip's track and of a free piston. Nearly all intervals are of this
    /// kind, and it takes much less memory than general polynomials.
    Constant {
        loads: [f64; CHANNELS],
        translations: [[f64; 3]; 2],
    },
    Varying(Box<Varying>),
}

/// Loads of [`LOW`] coefficients, with the polynomial parts of the same motions.
#[derive(Debug)]
pub(super) struct Varying {
    loads: [[f64; LOW]; CHANNELS],
    driven: [Driven; 2],
}

/// Polynomials in time from the start of the interval.
pub(super) struct Polynomials {
    pub(super) loads: [Poly; CHANNELS],
    /// Polynomial part of the motion of the tip's track, and of a free piston.
    pub(super) driven: [Driven; 2],
}

impl Loading {
    fn new(motion: &Motion) -> Self {
        let MotionState { loads, anchors, .. } = &motion.state;
        let tracks = [Some(0), motion.flying()];
        if !motion.is_steady() {
            let driven =
                |i: Option<usize>| i.map(|i| anchors[i].driven.clone()).unwrap_or_default();
            let driven = tracks.map(driven);
            let loads = from_fn(|c| from_fn(|k| loads[c].0[k]));
            return Self::Varying(Box::new(Varying { loads, driven }));
        }
        let translation = |i: Option<usize>| {
            let c = i.map(|i| &anchors[i].driven.translation.0);
            c.map_or([0.0; 3], |c| [c[0], c[1], c[2]])
        };
        let loads = loads.each_ref().map(|load| load.0[0]);
        Self::Constant { loads, translations: tracks.map(translation) }
    }

    pub(super) fn polynomials(&self) -> Polynomials {
        match self {
            Self::Varying(varying) => {
                let Varying { loads, driven } = &**varying;
                let load = |c: &[f64; LOW]| Poly::of_part(c, 1.0);
                Polynomials { loads: loads.each_ref().map(load), driven: driven.clone() }
            }
            Self::Constant { loads, translations } => {
                let driven = translations.map(|c| Driven::translating(Poly::parabola(c)));
                Polynomials { loads: loads.map(Poly::constant), driven }
            }
        }
    }
}

impl Modes {
    pub(super) fn new(motion: &Motion, tracks: &[Track], touched: Bodies, span: f64) -> Self {
        let state = &motion.state;
        let system = |index: usize| motion.tracks[index].system.clone();
        let ends = |index: usize| [state.anchors[index].start().1, &tracks[index].z].concat();
        let other = |index: usize| {
            let anchor = &state.anchors[index];
            let (start, mut driven) = (anchor.start().0, anchor.driven.clone());
            driven.translation.shift(start);
            let (group, system, ends) = (anchor.group, system(index), ends(index));
            Other { group, system, ends, span: span - start, driven }
        };
        Self {
            group: state.anchors[0].group,
            system: system(0),
            ends: ends(0),
            loading: Loading::new(motion),
            piston: motion.flying().map(system),
            others: motion.others(touched).map(other).collect(),
        }
    }

    pub(super) fn start(&self) -> &[f64] {
        &self.ends[..self.ends.len() / 2]
    }

    /// The track on which a force acts, at the start of the interval.
    pub fn track(&self, force: &Force) -> Track {
        let (system, ends) = match force.other {
            None => (&self.system, &self.ends),
            Some(other) => (&self.others[other].system, &self.others[other].ends),
        };
        Track { system: system.clone(), z: ends[..ends.len() / 2].to_vec(), at: 0.0 }
    }

    /// Number of stored numbers beside the fixed ones.
    pub(super) fn size(&self) -> usize {
        let slow = |driven: &Driven| numbers(size_of_val(&driven.slow[..]));
        let other = |other: &Other| other.ends.len() + slow(&other.driven);
        let loading = if let Loading::Varying(varying) = &self.loading {
            numbers(size_of::<Varying>()) + varying.driven.iter().map(slow).sum::<usize>()
        } else {
            0
        };
        let others = numbers(size_of_val(&self.others[..]));
        self.ends.len() + self.others.iter().map(other).sum::<usize>() + loading + others
    }
}

/// Number of numbers in so many bytes.
pub(super) fn numbers(bytes: usize) -> usize {
    bytes / size_of::<f64>()
}
