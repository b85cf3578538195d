//! The interval between two events. Its works, losses and forces follow from the states at both its ends.

use crate::error::Error;
use crate::laws::event::{Bodies, Displacement};
use crate::laws::mode::{Tie, Ties};
use crate::laws::rock::{Coefficients, Spring};
use crate::modal::stretch::Stretch;
use crate::modal::system::System;
use crate::modal::system::driven::Driven;
use crate::modal::track::Track;
use crate::motion::Motion;
use crate::motion::state::MotionState;
use crate::numerics::kernel;
use crate::numerics::poly::Poly;
use crate::numerics::series::LOW;
use crate::quantities::parameters::Rock;
use crate::scene::graph::CHANNELS;
use crate::scene::graph::{Graph, Group};
use serde::{Deserialize, Serialize};
use std::array::from_fn;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How many numbers the intervals of all hammers of the process store.
static STORED: AtomicUsize = AtomicUsize::new(0);
/// If more numbers than this (32 MB) are stored in the process, each hammer may store only [`CROWDED`].
const PROCESS: usize = 1 << 22;
/// Most numbers that the intervals of one hammer may store: 8 MB, or some 120 blows of the reference hammer. Within
/// this limit, a run of one second integrates only what is read.
const MAX_STORED: usize = 1 << 20;
/// The limit if many hammers store numbers: 256 kB each, which fits in the processor's caches.
pub(crate) const CROWDED: usize = 1 << 15;

/// How many numbers a hammer may store now, in intervals whose integrals or peaks are not yet computed. The limit does
/// not affect their values.
pub(crate) fn storable() -> usize {
    if STORED.load(Ordering::Relaxed) > PROCESS { CROWDED } else { MAX_STORED }
}

/// Works, losses and impulses, summed over time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    /// Work of the load of each channel, J.
    pub work: [f64; CHANNELS],
    /// Work dissipated in the bars, J.
    pub damping: f64,
    /// Work of the dashpot at the tip, J.
    pub viscous: f64,
    /// Work dissipated in the rock on loading, J.
    pub rock: f64,
    /// Energy added by changes of parameters, J.
    pub retuned: f64,
    /// Impulse of `F_C`, N s.
    pub contact_impulse: f64,
    /// Impulse of `F_R`, N s.
    pub rock_impulse: f64,
}

impl Sums {
    pub fn add(&mut self, other: &Self) {
        for (a, b) in self.work.iter_mut().zip(other.work) {
            *a += b;
        }
        self.damping += other.damping;
        self.viscous += other.viscous;
        self.rock += other.rock;
        self.retuned += other.retuned;
        self.contact_impulse += other.contact_impulse;
        self.rock_impulse += other.rock_impulse;
    }
}

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

/// A system, its state at the end of an interval, and the value of its damping form there.
type End<'a> = (&'a Arc<System>, &'a [f64], f64);

/// Values of the damping forms at the ends of this interval and of the previous one. A group that the event between
/// them did not change has the same value on both sides.
#[derive(Default)]
pub(crate) struct Forms<'a> {
    before: Vec<End<'a>>,
    now: Vec<End<'a>>,
}

impl<'a> Forms<'a> {
    fn begin(&mut self) {
        std::mem::swap(&mut self.before, &mut self.now);
        self.now.clear();
    }

    /// Values of a system's damping form at the start and the end of an interval.
    fn of(&mut self, system: &'a Arc<System>, [start, end]: [&'a [f64]; 2]) -> [f64; 2] {
        let is_same = |known: &&End| Arc::ptr_eq(known.0, system) && known.1 == start;
        let form = system.damping_form();
        let known = self.before.iter().find(is_same);
        let first = known.map_or_else(|| form.of(start), |known| known.2);
        let last = form.of(end);
        self.now.push((system, end, last));
        [first, last]
    }
}

/// An interval between two events, with all data for its integrals.
#[derive(Debug)]
pub(crate) struct Interval {
    graph: Arc<Graph>,
    group: Group,
    system: Arc<System>,
    /// State of the tip's track at the start, followed by that at the end.
    ends: Vec<f64>,
    /// Length of the interval, s.
    pub span: f64,
    loading: Loading,
    /// System of the piston, if it flies alone.
    piston: Option<Arc<System>>,
    others: Vec<Other>,
    ties: Ties,
    spring: Spring,
    rock: Rock,
    damped: bool,
    /// Work done on the rock, J: the part dissipated on loading, and that of the dashpot at the tip.
    pub given: [f64; 2],
}

/// A track other than the tip's. Its interval begins at the event that last changed the track.
#[derive(Debug)]
struct Other {
    group: Group,
    system: Arc<System>,
    /// State at the start, followed by that at the end.
    ends: Vec<f64>,
    /// Length of the track's own interval, s.
    span: f64,
    /// The polynomial part of its motion, in time from the start of its own interval.
    driven: Driven,
}

/// Loads over an interval, and the polynomial part of the motion.
#[derive(Debug)]
enum Loading {
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
struct Varying {
    loads: [[f64; LOW]; CHANNELS],
    driven: [Driven; 2],
}

/// Polynomials in time from the start of the interval.
struct Polynomials {
    loads: [Poly; CHANNELS],
    /// Polynomial part of the motion of the tip's track, and of a free piston.
    driven: [Driven; 2],
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

    fn polynomials(&self) -> Polynomials {
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

impl Interval {
    /// The interval of all tracks, from the epoch to `span` after it. `tracks` are rotated to its end.
    pub fn whole(motion: &Motion, tracks: &[Track], span: f64) -> Self {
        Self::new(motion, tracks, motion.graph().all(), span, [None; 2])
    }

    /// The interval of the tracks that contain one of the `touched` bodies and of the tip's track, from the epoch to
    /// `span` after it. `tracks` are rotated to its end. `known` are the viscous form at the start and the viscous
    /// work, if they are known.
    pub fn new(
        motion: &Motion,
        tracks: &[Track],
        touched: Bodies,
        span: f64,
        known: [Option<f64>; 2],
    ) -> Self {
        let (state, model) = (&motion.state, &motion.model);
        let anchor = &state.anchors[0];
        let system = |index: usize| motion.tracks[index].system.clone();
        let ends = |index: usize| [state.anchors[index].start().1, &tracks[index].z].concat();
        let other = |index: usize| {
            let anchor = &state.anchors[index];
            let (start, mut driven) = (anchor.start().0, anchor.driven.clone());
            driven.translation.shift(start);
            let (group, system, ends) = (anchor.group, system(index), ends(index));
            Other { group, system, ends, span: span - start, driven }
        };
        let mut interval = Self {
            graph: model.graph.clone(),
            group: anchor.group,
            system: system(0),
            ends: ends(0),
            span,
            loading: Loading::new(motion),
            piston: motion.flying().map(system),
            others: motion.others(touched).map(other).collect(),
            ties: state.mode.ties,
            spring: motion.spring(),
            rock: motion.parameters().rock,
            damped: model.is_damped(),
            given: [0.0; 2],
        };
        interval.given = interval.rock_work(motion, &tracks[0], known);
        STORED.fetch_add(interval.size(), Ordering::Relaxed);
        interval
    }

    fn start(&self) -> &[f64] {
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

    /// True if a force acts whose peak is an output.
    pub fn is_pressed(&self) -> bool {
        let rock = self.spring.coefficients(&self.rock).stiffness;
        rock > 0.0 || Tie::REPORTED.into_iter().any(|tie| self.ties.hold(tie))
    }

    /// `F_R`, then the forces of [`Tie::REPORTED`]; `None` for a force that does not act.
    pub fn forces(&self) -> [Option<Force>; 1 + Tie::REPORTED.len()] {
        let Polynomials { loads, driven: [driven, ..] } = &self.loading.polynomials();
        let force = |displacement, line: Coefficients, sign: f64| {
            let others = self.others.iter().enumerate();
            let others = others.map(|(i, o)| (Some(i), o.group, &o.system, &o.driven));
            let mut tracks =
                std::iter::once((None, self.group, &self.system, driven)).chain(others);
            tracks.find_map(|(other, group, system, driven)| {
                let functional = self.graph.share(group, displacement)?;
                let poly = system.poly(functional, loads, driven);
                let [stiffness, viscosity] = [sign * line.stiffness, sign * line.viscosity];
                Some(Force { other, functional, poly, stiffness, viscosity })
            })
        };
        let mut forces = [None; 1 + Tie::REPORTED.len()];
        let line = self.spring.coefficients(&self.rock);
        if line.stiffness > 0.0 {
            forces[0] = force(Displacement::Tip, line, 1.0);
        }
        for (slot, tie) in forces.iter_mut().skip(1).zip(Tie::REPORTED) {
            let mut holding = self.graph.holding(self.ties);
            if let Some((_, line)) = holding.find(|(edge, _)| edge.tie == tie) {
                *slot = force(Displacement::Tie(tie), line, -1.0);
            }
        }
        forces
    }

    fn stretch<'a>(&'a self, polynomials: &'a Polynomials) -> Stretch<'a> {
        let (start, end) = self.ends.split_at(self.ends.len() / 2);
        Stretch {
            system: &self.system,
            start,
            end,
            span: self.span,
            loads: &polynomials.loads,
            driven: &polynomials.driven[0],
        }
    }

    fn beside<'a>(&'a self, other: &'a Other, polynomials: &'a Polynomials) -> Stretch<'a> {
        let Other { system, ends, span, driven, .. } = other;
        let (start, end) = ends.split_at(ends.len() / 2);
        Stretch { system, start, end, span: *span, driven, ..self.stretch(polynomials) }
    }

    fn share(&self, displacement: Displacement) -> usize {
        self.graph.share(self.group, displacement).unwrap_or_default()
    }

    /// Computes the damping form, once per system. It takes most of the time of the integrals.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn prepare(&self) -> Result<(), Error> {
        if self.damped { self.system.prepare_damping_form() } else { Ok(()) }
    }

    /// The integrals over the interval. `forms` are those at the end of the previous interval, and become those at the
    /// end of this one. The damping of a flying piston is integrated when its flight ends.
    pub fn sums<'a>(&'a self, forms: &mut Forms<'a>) -> Sums {
        let polynomials = &self.loading.polynomials();
        let main = self.stretch(polynomials);
        let mut sums = Sums::default();
        forms.begin();
        let mut damping = |system, track: &Stretch, ends: &'a [f64]| {
            let (start, end) = ends.split_at(ends.len() / 2);
            if self.damped { track.damping(|| forms.of(system, [start, end])) } else { 0.0 }
        };
        sums.damping += damping(&self.system, &main, &self.ends);
        self.add_group(self.group, &main, &mut sums);
        if let Some(system) = &self.piston {
            // Loads on a free body do work on its translation only, so its oscillation can be left out.
            let rest = vec![0.0; 2 * system.blocks()];
            let (start, end, driven) = (&rest[..], &rest[..], &polynomials.driven[1]);
            let piston = Stretch { system, start, end, driven, ..self.stretch(polynomials) };
            self.add_works(Group::PISTON, &piston, &mut sums);
        }
        for other in &self.others {
            let track = self.beside(other, polynomials);
            sums.damping += damping(&other.system, &track, &other.ends);
            self.add_group(other.group, &track, &mut sums);
        }
        self.add_rock(&main, &mut sums);
        sums
    }

    fn add_group(&self, group: Group, track: &Stretch, sums: &mut Sums) {
        self.add_works(group, track, sums);
        let contact = self.graph.inside(group).find(|edge| edge.tie == Tie::Contact);
        let share = self.graph.share(group, Displacement::Tie(Tie::Contact));
        if let Some((edge, gap)) = contact.zip(share) {
            sums.contact_impulse = -impulse(edge.law.line, track, gap);
        }
    }

    fn add_works(&self, group: Group, track: &Stretch, sums: &mut Sums) {
        for (displacement, _, parts) in &self.graph.loaded {
            let Some(share) = self.graph.share(group, *displacement) else { continue };
            self.graph.add_works(*displacement, parts, track.works(share), &mut sums.work);
        }
    }

    fn add_rock(&self, main: &Stretch, sums: &mut Sums) {
        let line = self.spring.coefficients(&self.rock);
        if line.stiffness <= 0.0 {
            return;
        }
        sums.rock_impulse = impulse(line, main, self.share(Displacement::Tip));
        [sums.rock, sums.viscous] = self.given;
    }

    /// Work done on the rock, J: the part dissipated on loading, and that of the dashpot at the tip. It is integrated
    /// immediately, because each blow reports it and it costs little.
    fn rock_work(&self, motion: &Motion, track: &Track, known: [Option<f64>; 2]) -> [f64; 2] {
        if !self.spring.is_loading() {
            return [0.0; 2];
        }
        let (main, tip) = (motion.stretch(0, track, self.span), self.share(Displacement::Tip));
        let poly = motion.poly(0, tip);
        let row = &self.system.functionals[tip].rows[0];
        let [start, end] = [main.start, main.end].map(|z| kernel::dot(row, z));
        let drift = poly.at(self.span);
        let change = drift - poly.0[0] + (end - start);
        let end = drift + end;
        let lost = self.spring.lost_on_loading(&self.rock, end - change, end);
        let viscosity = self.spring.coefficients(&self.rock).viscosity;
        if viscosity <= 0.0 {
            return [lost, 0.0];
        }
        let [form, work] = known;
        let form = || form.unwrap_or_else(|| self.system.viscous_form().of(self.start()));
        let integrate = || viscosity * main.tip_square(tip, &poly.derivative(), form());
        [lost, work.unwrap_or_else(integrate)]
    }

    /// The viscous work, computed in the same way as in the search for the energy barrier: by a series, whose rounding
    /// is relative to the work itself, or by quadratic forms.
    pub fn viscous_of_barrier(&self, by_series: bool) -> f64 {
        if !by_series {
            return self.given[1];
        }
        let viscosity = self.spring.coefficients(&self.rock).viscosity;
        let tip = self.share(Displacement::Tip);
        let polynomials = &self.loading.polynomials();
        let stretch = self.stretch(polynomials);
        if self.system.varies(&polynomials.loads) {
            let form = self.system.viscous_form().of(self.start());
            if let Some(closed) =
                stretch.tip_square_uncancelled(tip, &stretch.drift_rate(tip), form)
            {
                return viscosity * closed;
            }
        }
        viscosity * stretch.tip_square_by_series(tip, &stretch.drift_rate(tip), 0.0, self.start())
    }

    /// Approximate number of stored numbers.
    pub fn size(&self) -> usize {
        let numbers = |bytes: usize| bytes / size_of::<f64>();
        let slow = |driven: &Driven| numbers(size_of_val(&driven.slow[..]));
        let other = |other: &Other| other.ends.len() + slow(&other.driven);
        let loading = if let Loading::Varying(varying) = &self.loading {
            numbers(size_of::<Varying>()) + varying.driven.iter().map(slow).sum::<usize>()
        } else {
            0
        };
        let fixed = numbers(size_of::<Self>() + size_of_val(&self.others[..]));
        self.ends.len() + self.others.iter().map(other).sum::<usize>() + loading + fixed
    }
}

/// Impulse of a spring with a dashpot whose displacement is this functional of a track.
fn impulse(line: Coefficients, track: &Stretch, functional: usize) -> f64 {
    let change = if line.viscosity > 0.0 { track.change(functional) } else { 0.0 };
    line.force(track.integral(functional), change)
}

impl Drop for Interval {
    fn drop(&mut self) {
        STORED.fetch_sub(self.size(), Ordering::Relaxed);
    }
}
