//! The interval between two events. Its works, losses and forces follow from the states at both its ends.

use super::modes::{Force, Modes, Other, Polynomials, numbers};
use super::rigid::RigidInterval;
use crate::error::Error;
use crate::laws::event::{Bodies, Displacement};
use crate::laws::mode::{Tie, Ties};
use crate::laws::rock::{Coefficients, Spring};
use crate::modal::stretch::Stretch;
use crate::modal::system::{System, TAYLOR};
use crate::modal::track::Track;
use crate::motion::{Course, Motion};
use crate::numerics::kernel;
use crate::quantities::parameters::Rock;
use crate::scene::graph::CHANNELS;
use crate::scene::graph::{Graph, Group};
use serde::{Deserialize, Serialize};
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
    /// Length of the interval, s.
    pub span: f64,
    steel: Steel,
    ties: Ties,
    spring: Spring,
    rock: Rock,
    damped: bool,
    /// Work done on the rock, J: the part dissipated on loading, and that of the dashpot at the tip.
    pub given: [f64; 2],
}

/// The motion over an interval.
#[derive(Debug)]
enum Steel {
    Modes(Modes),
    Rigid(RigidInterval),
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
        let steel = match &state.course {
            Some(course) => Steel::Rigid(RigidInterval::new(course, &state.loads)),
            None => Steel::Modes(Modes::new(motion, tracks, touched, span)),
        };
        let mut interval = Self {
            graph: model.graph.clone(),
            span,
            steel,
            ties: state.mode.ties,
            spring: motion.spring(),
            rock: motion.parameters().rock,
            damped: model.is_damped(),
            given: [0.0; 2],
        };
        if interval.spring.is_loading() {
            interval.given = interval.rock_work(motion, tracks, known);
        }
        STORED.fetch_add(interval.size(), Ordering::Relaxed);
        interval
    }

    /// True if a force acts whose peak is an output.
    pub fn is_pressed(&self) -> bool {
        let rock = self.spring.coefficients(&self.rock).stiffness;
        rock > 0.0 || Tie::REPORTED.into_iter().any(|tie| self.ties.hold(tie))
    }

    /// The tracks, unless the bodies are expanded with the air.
    pub fn modes(&self) -> Option<&Modes> {
        if let Steel::Modes(modes) = &self.steel { Some(modes) } else { None }
    }

    /// `F_R`, then the forces of [`Tie::REPORTED`] on tracks; `None` for a force that does not act.
    pub fn forces(&self, modes: &Modes) -> [Option<Force>; 1 + Tie::REPORTED.len()] {
        let Polynomials { loads, driven: [driven, ..] } = &modes.loading.polynomials();
        self.acting(|displacement, line: Coefficients, sign: f64| {
            let others = modes.others.iter().enumerate();
            let others = others.map(|(i, o)| (Some(i), o.group, &o.system, &o.driven));
            let mut tracks =
                std::iter::once((None, modes.group, &modes.system, driven)).chain(others);
            tracks.find_map(|(other, group, system, driven)| {
                let functional = self.graph.share(group, displacement)?;
                let poly = system.poly(functional, loads, driven);
                let [stiffness, viscosity] = [sign * line.stiffness, sign * line.viscosity];
                Some(Force { other, functional, poly, stiffness, viscosity })
            })
        })
    }

    /// The same forces over `[0, 1]`, the time over the interval from `start` on (s), if the bodies are expanded with the
    /// air.
    pub fn whole_forces(&self, start: f64) -> [Option<[f64; TAYLOR]>; 1 + Tie::REPORTED.len()] {
        let Steel::Rigid(rigid) = &self.steel else { return Default::default() };
        self.acting(|displacement, line, sign| {
            let shares = self.graph.shares_of_pair(displacement);
            Some(rigid.force(shares, line, [start, self.span]).map(|c| sign * c))
        })
    }

    /// What `force` makes of `F_R`, then of the forces of [`Tie::REPORTED`]; `None` for a force that does not act.
    fn acting<T: Copy>(
        &self,
        force: impl Fn(Displacement, Coefficients, f64) -> Option<T>,
    ) -> [Option<T>; 1 + Tie::REPORTED.len()] {
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

    fn stretch<'a>(&'a self, modes: &'a Modes, polynomials: &'a Polynomials) -> Stretch<'a> {
        let (start, end) = modes.ends.split_at(modes.ends.len() / 2);
        Stretch {
            system: &modes.system,
            start,
            end,
            span: self.span,
            loads: &polynomials.loads,
            driven: &polynomials.driven[0],
        }
    }

    fn tip_of(&self, modes: &Modes) -> usize {
        self.graph.share(modes.group, Displacement::Tip).unwrap_or_default()
    }

    /// Computes the damping form, once per system. It takes most of the time of the integrals.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn prepare(&self) -> Result<(), Error> {
        let damped = self.modes().filter(|_| self.damped);
        damped.map_or(Ok(()), |modes| modes.system.prepare_damping_form())
    }

    /// The integrals over the interval. `forms` are those at the end of the previous interval, and become those at the
    /// end of this one. The damping of a flying piston is integrated when its flight ends.
    pub fn sums<'a>(&'a self, forms: &mut Forms<'a>) -> Sums {
        match &self.steel {
            Steel::Modes(modes) => self.sums_of_modes(modes, forms),
            Steel::Rigid(rigid) => {
                forms.begin();
                self.sums_of_rigid(rigid)
            }
        }
    }

    fn sums_of_modes<'a>(&'a self, modes: &'a Modes, forms: &mut Forms<'a>) -> Sums {
        let polynomials = &modes.loading.polynomials();
        let main = self.stretch(modes, polynomials);
        let mut sums = Sums::default();
        forms.begin();
        let mut damping = |system, track: &Stretch, ends: &'a [f64]| {
            let (start, end) = ends.split_at(ends.len() / 2);
            if self.damped { track.damping(|| forms.of(system, [start, end])) } else { 0.0 }
        };
        sums.damping += damping(&modes.system, &main, &modes.ends);
        self.add_group(modes.group, &main, &mut sums);
        if let Some(system) = &modes.piston {
            // Loads on a free body do work on its translation only, so its oscillation can be left out.
            let rest = vec![0.0; 2 * system.blocks()];
            let (start, end, driven) = (&rest[..], &rest[..], &polynomials.driven[1]);
            let piston = Stretch { system, start, end, driven, ..main };
            self.add_works(Group::PISTON, &piston, &mut sums);
        }
        for other in &modes.others {
            let Other { group, system, ends, span, driven } = other;
            let (start, end) = ends.split_at(ends.len() / 2);
            let track = Stretch { system, start, end, span: *span, driven, ..main };
            sums.damping += damping(system, &track, ends);
            self.add_group(*group, &track, &mut sums);
        }
        let impulse = |line| impulse(line, &main, self.tip_of(modes));
        self.add_rock(impulse, &mut sums);
        sums
    }

    fn sums_of_rigid(&self, rigid: &RigidInterval) -> Sums {
        let (mut sums, part) = (Sums::default(), rigid.part(self.span));
        let works = rigid.works(&part);
        for (displacement, _, parts) in &self.graph.loaded {
            let shares = self.graph.shares_of_pair(*displacement);
            let along = |channel: usize| {
                let [piston, bit] = works[channel];
                shares[0] * piston + shares[1] * bit
            };
            self.graph.add_works(*displacement, parts, along, &mut sums.work);
        }
        let impulse = |displacement, line: Coefficients| {
            let shares = self.graph.shares_of_pair(displacement);
            let [start, end] = part.ends().map(|[p, q]| shares[0] * p + shares[1] * q);
            line.force(part.integral(shares), end - start)
        };
        let contact = Tie::Contact;
        let mut holding = self.graph.holding(self.ties).filter(|(edge, _)| edge.tie == contact);
        let pressed = holding.next().map(|(_, line)| impulse(Displacement::Tie(contact), line));
        sums.contact_impulse = pressed.map_or(0.0, |impulse| -impulse);
        self.add_rock(|line| impulse(Displacement::Tip, line), &mut sums);
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

    fn add_rock(&self, impulse: impl Fn(Coefficients) -> f64, sums: &mut Sums) {
        let line = self.spring.coefficients(&self.rock);
        if line.stiffness <= 0.0 {
            return;
        }
        sums.rock_impulse = impulse(line);
        [sums.rock, sums.viscous] = self.given;
    }

    /// Work done on the rock, J: the part dissipated on loading, and that of the dashpot at the tip. It is integrated
    /// immediately, because each blow reports it and it costs little.
    fn rock_work(&self, motion: &Motion, tracks: &[Track], known: [Option<f64>; 2]) -> [f64; 2] {
        let viscosity = self.spring.coefficients(&self.rock).viscosity;
        let lost = |[start, end]: [f64; 2]| self.spring.lost_on_loading(&self.rock, start, end);
        let modes = match &self.steel {
            Steel::Modes(modes) => modes,
            Steel::Rigid(rigid) => {
                let viscous = viscosity * rigid.bit_square(self.span);
                return [lost(rigid.tip(self.span)), viscous];
            }
        };
        let (main, tip) = (motion.stretch(0, &tracks[0], self.span), self.tip_of(modes));
        let poly = motion.poly(0, tip);
        let row = &modes.system.functionals[tip].rows[0];
        let [start, end] = [main.start, main.end].map(|z| kernel::dot(row, z));
        let drift = poly.at(self.span);
        let change = drift - poly.0[0] + (end - start);
        let end = drift + end;
        let lost = lost([end - change, end]);
        if viscosity <= 0.0 {
            return [lost, 0.0];
        }
        let [form, work] = known;
        let form = || form.unwrap_or_else(|| modes.system.viscous_form().of(modes.start()));
        let integrate = || viscosity * main.tip_square(tip, &poly.derivative(), form());
        [lost, work.unwrap_or_else(integrate)]
    }

    /// The viscous work, computed in the same way as in the search for the energy barrier: by a series, whose rounding
    /// is relative to the work itself, or by quadratic forms.
    /// Also returns the number of the series' panels.
    pub fn viscous_of_barrier(&self, by_series: bool) -> (f64, u64) {
        let Some(modes) = self.modes().filter(|_| by_series) else { return (self.given[1], 0) };
        let viscosity = self.spring.coefficients(&self.rock).viscosity;
        let tip = self.tip_of(modes);
        let polynomials = &modes.loading.polynomials();
        let stretch = self.stretch(modes, polynomials);
        if modes.system.varies(&polynomials.loads) {
            let form = modes.system.viscous_form().of(modes.start());
            if let Some(closed) =
                stretch.tip_square_uncancelled(tip, &stretch.drift_rate(tip), form)
            {
                return (viscosity * closed, 0);
            }
        }
        let rate = stretch.drift_rate(tip);
        let square = stretch.tip_square_by_series(tip, &rate, 0.0, modes.start());
        (viscosity * square, Stretch::panels(&modes.system, self.span))
    }

    /// Approximate number of stored numbers.
    pub fn size(&self) -> usize {
        let fixed = numbers(size_of::<Self>());
        fixed + self.modes().map_or(numbers(size_of::<Course>()), Modes::size)
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
