//! What a tangent needs of the motion: stretches, and the events that end them.

use crate::laws::event::RockEvent;
use crate::laws::event::{Displacement, Event};
use crate::laws::mode::Mode;
use crate::laws::mode::Relay;
use crate::laws::mode::RockMode;
use crate::laws::rock::Spring;
use crate::machine::Machine;
use crate::machine::blows::Blow;
use crate::modal::model::{Channel, Span};
use crate::modal::system::{CHANNELS, Functional, System};
use crate::modal::track::Track;
use crate::motion::Motion;
use crate::numerics::kernel;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::Inputs;
use crate::tangent::statics::Statics;
use std::sync::Arc;

/// One track over a leg.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub span: Span,
    pub system: Arc<System>,
    /// Oscillation at the start and at the end.
    pub start: Vec<f64>,
    pub end: Vec<f64>,
    /// Translation, from the start on.
    pub translation: Poly,
    /// The oscillation at the end as the engine has it, where that is something else.
    seen: Option<Vec<f64>>,
}

/// Where points of the bodies are, from the origin, m.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Place {
    /// Means of the bodies.
    pub piston: f64,
    pub bit: f64,
    /// The bit's upper end.
    pub top: f64,
    pub tip: f64,
}

/// A stretch between two looks at the motion, within one mode.
#[derive(Clone, Debug)]
pub(crate) struct Leg {
    pub runs: Vec<Run>,
    /// Duration, s.
    pub span: f64,
    /// Loads and inputs from its start on.
    pub loads: [Poly; CHANNELS],
    pub inputs: Inputs,
    pub mode: Mode,
    /// Where it leads from and to, if somebody wants to know.
    pub ends: Option<[Place; 2]>,
}

impl Leg {
    /// From `from` to `to` after the epoch; with its `places` or without.
    pub(crate) fn of(motion: &Motion, from: f64, to: f64, places: bool) -> Self {
        let state = motion.state();
        let mut tracks: Vec<Track> =
            (0..state.anchors.len()).map(|index| motion.at_anchor(index)).collect();
        let mut at = |t: f64| {
            tracks.iter_mut().for_each(|track| {
                track.rotate_to(t);
            });
            let there = places.then(|| place(motion, &tracks, t));
            (there, tracks.iter().map(|track| track.z.clone()).collect::<Vec<_>>())
        };
        let ((first, begun), (last, done)) = (at(from), at(to));
        let pairs = begun.into_iter().zip(done).zip(tracks).enumerate();
        let runs = pairs.map(|(index, ((mut start, mut end), Track { system, .. }))| {
            let anchor = &state.anchors[index];
            let mut seen = None;
            if !anchor.driven.slow.is_empty() {
                seen = Some(end.clone());
                let statics = Statics::new(motion.model(), anchor.span, &system);
                for (z, t) in [(&mut start, from), (&mut end, to)] {
                    system.add_driven(&state.loads, &anchor.driven, t, z);
                    statics.add(&state.loads, t, -1.0, z);
                    if system.rigid {
                        (z[0], z[system.blocks()]) = (0.0, 0.0);
                    }
                }
            }
            let translation = anchor.driven.translation.shifted(from);
            Run { span: anchor.span, system, start, end, translation, seen }
        });
        let mut inputs = state.inputs;
        inputs.shift(from);
        Self {
            runs: runs.collect(),
            span: to - from,
            loads: state.loads.map(|p| p.shifted(from)),
            inputs,
            mode: state.mode,
            ends: first.zip(last).map(|(first, last)| [first, last]),
        }
    }

    /// True if the engine divides the motion otherwise: digits are lost here.
    pub(crate) fn is_rough(&self) -> bool {
        self.runs.iter().any(|run| run.seen.is_some())
    }

    pub(crate) fn is_viscous(&self) -> bool {
        self.mode.rock == RockMode::DissipativeForward
    }
}

/// Where `tracks` stand, at `t` after the epoch.
fn place(motion: &Motion, tracks: &[Track], t: f64) -> Place {
    let of = |displacement| motion.point(tracks, displacement, t).displacement;
    Place {
        piston: of(Displacement::PistonMean),
        bit: of(Displacement::BitMean),
        top: of(Displacement::BitTop),
        tip: of(Displacement::Tip),
    }
}

/// An event, with all that the tangents need of the motion there.
#[derive(Clone, Debug)]
pub(crate) struct Moment {
    pub event: Event,
    pub time: f64,
    /// Time since the event before, s.
    pub spacing: f64,
    pub mode: Mode,
    /// Tip from the origin, and its rates: of an event of the rock.
    pub tip: [f64; 3],
    /// `vr` and its rates: of any other.
    pub relative: [f64; 3],
    /// The piston's mean, and its rates: of any other.
    pub piston: [f64; 3],
    /// Slope of the guard, with the sum of its terms' sizes.
    pub slope: [f64; 2],
    /// What the guard does not resolve.
    pub resolution: f64,
    pub viscosity: f64,
    pub gain: f64,
    /// Of the drive, before and after.
    pub drive: [f64; 2],
    counts: [u64; 2],
    /// What it led to.
    pub entered: Mode,
    pub collides: bool,
    pub strikes: bool,
    pub blow: Blow,
    /// From the first blow to the last, s.
    pub drilled: f64,
}

impl Moment {
    /// Of an event that is about to happen at `at`, where `leg` ends.
    pub(crate) fn before(
        machine: &Machine,
        leg: &Leg,
        at: f64,
        spacing: f64,
        event: Event,
    ) -> Self {
        let motion = machine.motion();
        let state = motion.state();
        // A run's share of a displacement: functional and polynomial.
        let shares = |displacement: Displacement| {
            leg.runs.iter().enumerate().filter_map(move |(index, run)| {
                let functional = motion.share(index, displacement)?;
                let end = run.seen.as_ref().unwrap_or(&run.end);
                let f = &run.system.functionals[functional];
                Some((f, end, motion.poly(index, functional)))
            })
        };
        let rates = |displacement: Displacement| -> [f64; 3] {
            let mut sum = [0.0; 3];
            for (f, end, mut poly) in shares(displacement) {
                for (k, value) in sum.iter_mut().enumerate() {
                    *value += poly.at(at) + kernel::dot(&f.rows[k], end);
                    poly = poly.derivative();
                }
            }
            sum
        };
        let sizes = |displacement: Displacement, order: usize| -> f64 {
            let size = |(f, end, poly): (&Functional, &Vec<f64>, Poly)| {
                let still = (0..order).fold(poly, |poly, _| poly.derivative()).at(at);
                still.abs() + kernel::bound(&f.weights[order], end)
            };
            shares(displacement).map(size).sum()
        };
        let [near, slow] = motion.parameters().resolutions();
        let (guard, order, resolution) = match event {
            Event::Contact => (Displacement::Gap, 1, near),
            Event::Relay(_) | Event::Port { .. } | Event::Level(_) => {
                (Displacement::Relative, 1, near)
            }
            Event::Rock(RockEvent::Touch | RockEvent::LiftOff | RockEvent::StandstillLiftOff) => {
                (Displacement::Tip, 1, near)
            }
            Event::Rock(RockEvent::Barrier) => (Displacement::Tip, 1, slow),
            Event::Rock(_) => (Displacement::Tip, 2, slow),
        };
        let none = [0.0; 3];
        let (tip, relative, piston) = match event {
            Event::Rock(_) => (rates(Displacement::Tip), none, none),
            _ => (none, rates(Displacement::Relative), rates(Displacement::PistonMean)),
        };
        let slope = match guard {
            Displacement::Gap => rates(Displacement::Gap)[order],
            Displacement::Relative => relative[order],
            _ => tip[order],
        };
        let counters = machine.counters();
        let rock = &motion.parameters().rock;
        Self {
            event,
            time: 0.0,
            spacing,
            mode: state.mode,
            tip,
            relative,
            piston,
            slope: [slope, sizes(guard, order)],
            resolution,
            viscosity: Spring::of(state.mode.rock).coefficients(rock).viscosity,
            gain: state.memory.gain,
            drive: [state.loads[Channel::Drive as usize].at(at); 2],
            counts: [counters.contacts, counters.blows],
            entered: state.mode,
            collides: false,
            strikes: false,
            blow: Blow::default(),
            drilled: 0.0,
        }
    }

    /// The event has happened.
    pub(crate) fn after(&mut self, machine: &Machine) {
        let state = machine.motion().state();
        let (counters, blows) = (machine.counters(), machine.blows());
        self.time = state.epoch.value();
        self.entered = state.mode;
        self.drive[1] = state.loads[Channel::Drive as usize].0[0];
        self.collides = counters.contacts > self.counts[0];
        self.strikes = counters.blows > self.counts[1];
        self.blow = blows.last;
        if let [Some(first), Some(last)] = blows.milestones {
            self.drilled = last.time.since(first.time);
        }
    }

    /// How surely the guard is crossed, 0 to 1.
    pub(crate) fn transversality(&self) -> f64 {
        if self.slope[1] > 0.0 { self.slope[0].abs() / self.slope[1] } else { 0.0 }
    }

    /// Time within which the guard does not know its zero, s.
    pub(crate) fn blur(&self) -> f64 {
        (self.resolution / self.slope[0]).abs()
    }

    /// The direction that the relay turns from, if it does.
    pub(crate) fn turned_from(&self) -> Option<Relay> {
        matches!(self.event, Event::Relay(_)).then_some(self.mode.relay)
    }
}
