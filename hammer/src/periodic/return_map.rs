//! The return (Poincaré) map.

use crate::energy::ledger::Energies;
use crate::energy::peaks::Peaks;
use crate::error::Error;
use crate::laws::event::{Displacement, Event};
use crate::laws::mode::{Chamber, Port, Relay};
use crate::machine::journal::Record;
use crate::machine::{Machine, Observer};
use crate::numerics::kernel::{inner_product, norm};
use crate::periodic::error::CycleError;
use crate::periodic::point::{Point, weights};
use crate::periodic::response::{Response, Strike};
use crate::quantities::inputs::Input;
use crate::quantities::parameters::{Parameters, Source};
use crate::sensitivity::{Argument, Sample};

/// An input from an instant of the period on: that value and those derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// From the start of the period, s.
    pub at: f64,
    /// Which.
    pub input: Input,
    /// Value and derivatives there.
    pub derivatives: Vec<f64>,
}

/// Inputs over one period, piece by piece: what a drive without a section of its own repeats.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schedule {
    /// s.
    pub period: f64,
    /// In order of time.
    pub pieces: Vec<Piece>,
}

/// Where the map leads.
#[derive(Clone, Debug)]
pub(crate) struct Image {
    pub end: Point,
    pub response: Response,
    /// Events on the way, their times from its start.
    sample: Sample,
}

/// How sections follow each other.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    pub schedule: Option<Schedule>,
    /// Returns that the map is made of.
    pub returns: usize,
    /// What takes longer does not come back, s.
    pub limit: f64,
}

impl Image {
    /// Events on the way, in their order.
    pub fn sequence(&self) -> Vec<Event> {
        self.sample.events.iter().map(|record| record.event).collect()
    }

    /// The same with their instants.
    pub fn events(&self) -> &[Record] {
        &self.sample.events
    }

    /// The weighted end, the response, and the instants of the events; and the events.
    pub fn sample(&self, weights: &[f64]) -> Sample {
        let mut sample = self.sample.clone();
        sample.values = self.end.weighted(weights);
        sample.values.extend(self.response.numbers());
        sample.values.extend(sample.events.iter().map(|record| record.time));
        sample
    }
}

/// Tells the blows on the way, and stops at the section.
struct ReturnObserver {
    stop: Option<Event>,
    stopped: bool,
    start: f64,
    strikes: Vec<Strike>,
}

impl Observer for ReturnObserver {
    fn after(&mut self, machine: &Machine, event: Event) -> bool {
        let motion = machine.motion();
        if event == Event::CLOSING {
            let now = motion.milestone().time.value();
            if let Some(blow) = machine.blow().filter(|blow| blow.time == now) {
                let (time, speed, energy) = (now - self.start, blow.speed, blow.energy);
                self.strikes.push(Strike { time, speed, energy, rebound: 0.0 });
            }
        } else if event == Event::OPENING
            && let Some(last) = self.strikes.last_mut()
        {
            last.rebound = -motion.velocity(motion.tracks(), Displacement::PISTON, 0.0);
        }
        self.stopped = Some(event) == self.stop;
        self.stopped
    }
}

impl Section {
    /// The event at which a drive's cycle is cut.
    fn event(source: Source) -> Option<Event> {
        match source {
            Source::Relay => Some(Event::Relay(Relay::Drive)),
            Source::Air => {
                Some(Event::Port { chamber: Chamber::Drive, port: Port::Supply, opens: true })
            }
            Source::Force | Source::Pressure => None,
        }
    }

    pub fn check(&self, parameters: &Parameters) -> Result<(), CycleError> {
        let has_event = Self::event(parameters.drive.source).is_some();
        match &self.schedule {
            None if has_event => Ok(()),
            None => Err(CycleError::NoSchedule),
            Some(_) if has_event => Err(CycleError::NotScheduled),
            Some(schedule) => {
                let (mut last, end) = (0.0, schedule.period);
                let ordered = schedule.pieces.iter().all(|piece| {
                    let fits = piece.at >= last && piece.at < end;
                    last = piece.at;
                    fits
                });
                let sound = end.is_finite() && end > 0.0 && ordered;
                if sound { Ok(()) } else { Err(CycleError::Disordered { period: end }) }
            }
        }
    }

    /// The same with a constant added to an input, if the argument is one.
    pub fn shifted(&self, argument: Argument, by: f64) -> Self {
        let mut section = self.clone();
        let pieces = section.schedule.iter_mut().flat_map(|schedule| &mut schedule.pieces);
        for piece in pieces.filter(|piece| Some(piece.input) == argument.input()) {
            piece.derivatives.iter_mut().take(1).for_each(|value| *value += by);
        }
        section
    }

    /// To the next section, from where the machine stands; energies and peaks if `measured`.
    pub fn run(&self, machine: &mut Machine, measured: bool) -> Result<Image, CycleError> {
        machine.settle()?;
        let start = machine.motion().milestone();
        let begun = measured.then(|| machine.energies());
        let drilled = machine.drilled_length();
        machine.keep_journal(true);
        let mut observer = ReturnObserver {
            stop: Self::event(machine.parameters().drive.source),
            stopped: false,
            start: start.time.value(),
            strikes: Vec::new(),
        };
        let mut peaks = Peaks::default();
        for _ in 0..self.returns {
            self.once(machine, &mut observer, measured.then_some(&mut peaks))?;
        }
        machine.settle()?;
        let end = machine.motion().milestone();
        let mut events = machine.take_journal();
        machine.keep_journal(false);
        for record in &mut events {
            record.time = (record.time - start.time.value()) + record.time_rest;
            record.time_rest = 0.0;
        }
        let (period, advance) = (end.time.since(start.time), end.hole.since(start.hole));
        let spent = |begun| difference(&begun, &machine.energies());
        Ok(Image {
            response: Response {
                period,
                advance,
                tip_rate: advance / period,
                rop: (machine.drilled_length() - drilled) / period,
                energies: begun.map(spent).unwrap_or_default(),
                peaks,
                strikes: observer.strikes,
            },
            end: Point::of(machine),
            sample: Sample { events, ..Sample::default() },
        })
    }

    fn once(
        &self,
        machine: &mut Machine,
        observer: &mut ReturnObserver,
        mut peaks: Option<&mut Peaks>,
    ) -> Result<(), CycleError> {
        let start = machine.time();
        observer.stopped = false;
        let mut advance = |machine: &mut Machine, to: f64| {
            machine.advance_observed(to, observer)?;
            if let Some(peaks) = &mut peaks {
                machine.prepare_peaks()?;
                peaks.raise(machine.peaks());
            }
            Ok::<bool, Error>(observer.stopped)
        };
        let Some(schedule) = &self.schedule else {
            return if advance(machine, start + self.limit)? {
                Ok(())
            } else {
                Err(CycleError::NoReturn { after: self.limit, stalled: machine.stalled() })
            };
        };
        for piece in &schedule.pieces {
            let at = (start + piece.at).max(machine.time());
            advance(machine, at)?;
            machine.set_input(piece.input, &piece.derivatives)?;
        }
        advance(machine, start + schedule.period)?;
        Ok(())
    }
}

fn difference(start: &Energies, end: &Energies) -> Energies {
    let (start, end) = (start.values(), end.values());
    std::array::from_fn(|k| end[k] - start[k]).into()
}

/// Steps of the map's differences by the state, over its size, and the least one. Standstill speaks
/// of 1e-4 of it, so that curvature leaves 1e-6 of the first step's square; rounding leaves as much.
const STEP: f64 = 3e-7;
const FINER: f64 = 0.125;
const LEAST: f64 = 1e-9;

/// The map, of points whose vectors are measured by weights.
pub(crate) struct ReturnMap<'a> {
    pub machine: Machine,
    pub section: &'a Section,
    pub weights: Vec<f64>,
    /// Energies and peaks are asked for.
    pub measured: bool,
}

impl<'a> ReturnMap<'a> {
    /// The map of the scene that a machine is in.
    pub fn new(machine: Machine, section: &'a Section) -> Self {
        Self { machine, section, weights: Vec::new(), measured: false }
    }

    /// Where the map leads from a point.
    pub fn image(&mut self, point: &Point) -> Result<Image, CycleError> {
        point.place(&mut self.machine)?;
        let image = self.section.run(&mut self.machine, self.measured)?;
        if self.weights.is_empty() {
            let model = self.machine.motion().model();
            self.weights = weights(model, point, image.response.period);
        }
        Ok(image)
    }

    /// How far the map moves a point, weighted, and that over the point's size: infinite where it
    /// leads to another discrete state.
    pub fn defect(&self, point: &Point, image: &Image) -> (Vec<f64>, f64) {
        let [a, b] = [point, &image.end].map(|point| point.weighted(&self.weights));
        let defect: Vec<f64> = b.iter().zip(&a).map(|(b, a)| b - a).collect();
        let distance = (inner_product(&defect, &defect) / inner_product(&a, &a)).sqrt();
        let near = point.shares_mode(&image.end) && !distance.is_nan();
        (defect, if near { distance } else { f64::INFINITY })
    }

    /// The derivative along `u` of the image's [sample](Image::sample): its first part is `P_x u`.
    /// A side on which other events happen is left out; where both are, all is NaN.
    pub fn times(&mut self, point: &Point, image: &Image, u: &[f64]) -> Vec<f64> {
        let here = point.weighted(&self.weights);
        let base = image.sample(&self.weights);
        let size = norm(&here) / norm(u);
        let mut part = STEP;
        loop {
            let mut side = |h: f64| -> Option<Sample> {
                let moved: Vec<f64> = here.iter().zip(u).map(|(x, u)| x + h * u).collect();
                let image = self.image(&point.with(&moved, &self.weights)).ok()?;
                Some(image.sample(&self.weights)).filter(|sample| sample.agrees(&base))
            };
            let h = part * size;
            let quotient = |low: &Sample, high: &Sample, h: f64| -> Vec<f64> {
                high.values.iter().zip(&low.values).map(|(b, a)| (b - a) / h).collect()
            };
            match (side(-h), side(h)) {
                (Some(low), Some(high)) => return quotient(&low, &high, 2.0 * h),
                _ if part > LEAST => part *= FINER,
                (Some(low), None) => return quotient(&low, &base, h),
                (None, Some(high)) => return quotient(&base, &high, h),
                (None, None) => return vec![f64::NAN; base.values.len()],
            }
        }
    }
}
