//! The fixed point of the return map, its multipliers and its gradients.

use crate::error::Error;
use crate::laws::event::Event;
use crate::machine::Machine;
use crate::machine::ledger::Energies;
use crate::machine::state::State;
use crate::modal::model::Model;
use crate::numerics::kernel::inner_product;
use crate::numerics::math;
use crate::periodic::fault::CycleError;
use crate::periodic::krylov::{Solver, leading};
use crate::periodic::lap::{Course, Lap, Schedule};
use crate::periodic::point::{Point, line_of, vector_of, weights};
use crate::tangent::line::Line;
use crate::tangent::{Caution, Seed, Strike, Tangents};
use num_complex::Complex64;

/// How a cycle is sought.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Turns of the relay (or periods of the drive) that the cycle closes after.
    pub laps: usize,
    /// Inputs over a period, where the drive is no relay.
    pub schedule: Option<Schedule>,
    /// Where to begin: a cycle found before, of a scene with as many modes. Otherwise, the
    /// machine as it stands.
    pub start: Option<Orbit>,
    /// Laps that are simulated before Newton's method begins.
    pub settle: usize,
    /// Steps at the most.
    pub steps: usize,
    /// Largest distance of `P(x)` from `x`, over the size of `x` (roots of energies).
    pub accuracy: f64,
    /// A lap that takes longer does not come back, s.
    pub limit: f64,
    /// Most Krylov vectors spent on multipliers; 0: none are wanted.
    pub multipliers: usize,
}

impl Default for Search {
    fn default() -> Self {
        Self {
            laps: 1,
            schedule: None,
            start: None,
            settle: 4,
            steps: 60,
            accuracy: 1e-10,
            limit: 10.0,
            multipliers: 24,
        }
    }
}

impl Search {
    pub(super) fn course(&self) -> Course {
        Course { schedule: self.schedule.clone(), laps: self.laps.max(1), limit: self.limit }
    }
}

/// The point of a cycle on its section.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit(pub(super) Point);

/// Derivatives of a cycle by one seed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gradient {
    /// Of the period, s.
    pub period: f64,
    /// Of the hole's advance in a period, m.
    pub advance: f64,
    /// Of the mean rate of penetration, m/s.
    pub rop: f64,
    /// Of the blows, their times from the section on.
    pub strikes: Vec<Strike>,
    /// Of works and losses of a period; what is stored comes back to what it was.
    pub energies: Energies,
    /// Of the largest contact and rock force.
    pub peaks: [f64; 2],
    /// Least change of the parameter that would turn the order of two events.
    pub reach: f64,
}

/// A stationary cycle.
#[derive(Clone, Debug)]
pub struct Cycle {
    /// s.
    pub period: f64,
    /// Advance of the hole in a period, m.
    pub advance: f64,
    /// `advance / period`, m/s.
    pub rop: f64,
    /// Blows, their times from the section on.
    pub strikes: Vec<Strike>,
    /// Works and losses of a period, J; what is stored comes back to what it was.
    pub energies: Energies,
    /// Largest contact and rock force, N.
    pub peaks: [f64; 2],
    /// Number of events in a period.
    pub events: usize,
    /// Which, in their order.
    pub sequence: Vec<Event>,
    /// Leading multipliers, largest first.
    pub multipliers: Vec<Complex64>,
    /// How far the map still moves the point, over its size.
    pub distance: f64,
    /// Steps made, and how many of them were Newton's.
    pub steps: [usize; 2],
    /// Derivatives, in the order of the seeds.
    pub gradients: Vec<Gradient>,
    /// Places where these are one-sided or undefined.
    pub cautions: Vec<Caution>,
    /// The point on the section, to begin another search from.
    pub orbit: Orbit,
    /// The state there, to go on from.
    pub state: State,
}

impl Cycle {
    /// True if nearby motions come closer, as far as the multipliers found tell.
    pub fn is_stable(&self) -> bool {
        self.multipliers.iter().all(|m| math::norm(*m) < 1.0)
    }

    /// A number that cycles of another order of events hardly share (FNV-1a of 32 bits).
    pub fn fingerprint(&self) -> f64 {
        let byte = |hash: u32, byte: u8| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        let names = self.sequence.iter().map(|event| format!("{event},"));
        f64::from(names.fold(0x811c_9dc5, |hash, name| name.bytes().fold(hash, byte)))
    }
}

/// The cycle that `machine` is near, and its derivatives by the seeds.
///
/// # Errors
/// See [`CycleError`].
pub fn stationary(
    machine: &mut Machine,
    search: &Search,
    seeds: &[Seed],
) -> Result<Cycle, CycleError> {
    let course = search.course();
    course.check(machine)?;
    let once = Course { laps: 1, ..course.clone() };
    if let Some(Orbit(point)) = &search.start {
        if point.body_state().len() != machine.motion().whole_state().len() {
            return Err(Error::Foreign.into());
        }
        machine.place(point.mode, point.memory(), point.psi(), point.body_state())?;
    }
    let settle = if search.start.is_some() { search.settle } else { search.settle.max(1) };
    for _ in 0..settle {
        once.run(machine)?;
    }
    machine.settle()?;
    let mut seeker = Seeker::new(machine, course)?;
    let steps = seeker.seek(search)?;
    seeker.finish(search, seeds, steps)
}

pub(super) struct Seeker<'a> {
    machine: &'a mut Machine,
    course: Course,
    /// Where the present lap started.
    pub(super) start: Point,
    pub(super) weights: Vec<f64>,
    /// One line that carries Krylov vectors.
    carrier: Tangents,
}

impl<'a> Seeker<'a> {
    pub(super) fn new(machine: &'a mut Machine, course: Course) -> Result<Self, Error> {
        let start = Point::of(machine.motion());
        let carrier = Tangents::from_here(machine, &[Seed::State])?;
        Ok(Self { machine, course, start, weights: Vec::new(), carrier })
    }

    pub(super) fn lap_from(&mut self, start: &Point) -> Result<Lap, CycleError> {
        self.machine.place(start.mode, start.memory(), start.psi(), start.body_state())?;
        let lap = self.course.run(self.machine)?;
        if self.weights.is_empty() {
            let slowest = 2.0 * std::f64::consts::PI / lap.period;
            self.weights = weights(self.machine.motion().model(), slowest);
        }
        Ok(lap)
    }

    /// How far a lap goes, weighted, and that over the size of its start.
    pub(super) fn defect(&self, start: &Point, lap: &Lap) -> (Vec<f64>, f64) {
        let weighted =
            |x: &[f64]| -> Vec<f64> { x.iter().zip(&self.weights).map(|(x, w)| x * w).collect() };
        let (a, b) = (weighted(&start.x), weighted(&lap.end.x));
        let apart: Vec<f64> = b.iter().zip(&a).map(|(b, a)| b - a).collect();
        let distance = (inner_product(&apart, &apart) / inner_product(&a, &a)).sqrt();
        let other = start.mode != lap.end.mode || distance.is_nan();
        (apart, if other { f64::INFINITY } else { distance })
    }

    fn seek(&mut self, search: &Search) -> Result<(Lap, f64, [usize; 2]), CycleError> {
        let mut point = self.start.clone();
        let mut lap = self.lap_from(&point)?;
        let (mut apart, mut distance) = self.defect(&point, &lap);
        let mut newton = 0;
        for step in 0..search.steps {
            // Rounding is reached where a step no longer helps.
            if distance <= 0.01 * search.accuracy {
                self.start = point;
                return Ok((lap, distance, [step, newton]));
            }
            let before = distance;
            let candidates = self.candidates(&point, &lap, &apart, distance);
            let mut best: Option<(Point, Lap, Vec<f64>, f64, bool)> = None;
            for (candidate, by_newton) in candidates {
                let Ok(next) = self.lap_from(&candidate) else { continue };
                let (a, d) = self.defect(&candidate, &next);
                if best.as_ref().is_none_or(|b| d < b.3) {
                    best = Some((candidate, next, a, d, by_newton));
                }
                if d < 0.3 * before {
                    break;
                }
            }
            let Some((next, next_lap, next_apart, next_distance, by_newton)) = best else {
                return Err(CycleError::NotFound { laps: self.course.laps, steps: step, distance });
            };
            if distance <= search.accuracy && next_distance >= distance {
                self.start = point;
                return Ok((lap, distance, [step, newton]));
            }
            newton += usize::from(by_newton);
            (point, lap, apart, distance) = (next, next_lap, next_apart, next_distance);
        }
        if distance <= search.accuracy {
            self.start = point;
            return Ok((lap, distance, [search.steps, newton]));
        }
        let steps = search.steps;
        Err(CycleError::NotFound { laps: self.course.laps, steps, distance })
    }

    /// Where to try next: Newton's point, points short of it, and where the map leads.
    fn candidates(
        &mut self,
        point: &Point,
        lap: &Lap,
        apart: &[f64],
        distance: f64,
    ) -> Vec<(Point, bool)> {
        let mapped = (lap.end.clone(), false);
        if !distance.is_finite() {
            return vec![mapped];
        }
        let mut solver = Solver::default();
        let (step, left) = solver.solve(apart, |u| self.times(lap, u));
        if left > 0.1 || step.iter().any(|x| !x.is_finite()) {
            return vec![mapped];
        }
        let moved = |part: f64| {
            let mut next = point.clone();
            for ((x, s), w) in next.x.iter_mut().zip(&step).zip(&self.weights) {
                *x += part * s / w;
            }
            (next, true)
        };
        vec![moved(1.0), mapped, moved(0.3), moved(0.1), moved(0.02)]
    }

    /// `P_x u`, weighted.
    pub(super) fn times(&mut self, lap: &Lap, u: &[f64]) -> Vec<f64> {
        let x: Vec<f64> = u.iter().zip(&self.weights).map(|(u, w)| u / w).collect();
        self.carrier.start_anew(vec![line_of(&x)]);
        self.carrier.replay(self.machine.motion().model(), &lap.tape);
        let free = self.course.is_free();
        let out = vector_of(&self.carrier.lines[0], lap.end.mode, &lap.rate, free);
        out.iter().zip(&self.weights).map(|(x, w)| x * w).collect()
    }

    /// `P_p`, weighted, at the start of the lap.
    pub(super) fn slope(&mut self, lap: &Lap, seed: Seed) -> Result<Vec<f64>, Error> {
        let mut tangents = Tangents::from_here(self.machine, &[seed])?;
        let modes = (self.start.x.len() - 3) / 2;
        replay(&mut tangents, self.machine.motion().model(), lap, vec![Line::zero(modes)]);
        let free = self.course.is_free();
        let out = vector_of(&tangents.lines[0], lap.end.mode, &lap.rate, free);
        Ok(out.iter().zip(&self.weights).map(|(x, w)| x * w).collect())
    }

    fn finish(
        mut self,
        search: &Search,
        seeds: &[Seed],
        (lap, distance, steps): (Lap, f64, [usize; 2]),
    ) -> Result<Cycle, CycleError> {
        let start = self.start.clone();
        let mut solver = Solver::default();
        let (mut gradients, mut cautions) = (Vec::new(), Vec::new());
        if !seeds.is_empty() {
            self.machine.place(start.mode, start.memory(), start.psi(), start.body_state())?;
            let mut tangents = Tangents::from_here(self.machine, seeds)?;
            self.gradients(&lap, &mut tangents, &mut solver);
            cautions = tangents.cautions().to_vec();
            let free = self.course.is_free();
            let each = 0..seeds.len();
            gradients = each.map(|index| gradient(&lap, &tangents, index, free)).collect();
        }
        let multipliers = self.multipliers(search, &lap);
        self.machine.place(start.mode, start.memory(), start.psi(), start.body_state())?;
        Ok(Cycle {
            period: lap.period,
            advance: lap.advance,
            rop: lap.advance / lap.period,
            sequence: lap.sequence(),
            strikes: lap.strikes,
            energies: lap.energies,
            peaks: lap.peaks,
            events: lap.tape.iter().filter(|(_, moment)| moment.is_some()).count(),
            multipliers,
            distance,
            steps,
            gradients,
            cautions,
            orbit: Orbit(start),
            state: self.machine.state(),
        })
    }

    /// Leaves in the lines the derivatives at the end of a lap whose start is the cycle's own,
    /// for every value of the parameter.
    fn gradients(&mut self, lap: &Lap, tangents: &mut Tangents, solver: &mut Solver) {
        let free = self.course.is_free();
        let modes = (self.start.x.len() - 3) / 2;
        let count = tangents.lines.len();
        let zero = vec![Line::zero(modes); count];
        let changes = tangents.changes.clone();
        replay(tangents, self.machine.motion().model(), lap, zero);
        let mut starts = Vec::with_capacity(count);
        for line in tangents.lines.clone() {
            let b: Vec<f64> = vector_of(&line, lap.end.mode, &lap.rate, free)
                .iter()
                .zip(&self.weights)
                .map(|(x, w)| x * w)
                .collect();
            let (x, _) = solver.solve(&b, |u| self.times(lap, u));
            let x: Vec<f64> = x.iter().zip(&self.weights).map(|(x, w)| x / w).collect();
            let mut line = line_of(&x);
            // What the dashpot has spent before the section is none of this period's.
            line.spent.viscous = -line.psi;
            starts.push(line);
        }
        tangents.changes = changes;
        tangents.carry_ledger();
        replay(tangents, self.machine.motion().model(), lap, starts);
    }

    fn multipliers(&mut self, search: &Search, lap: &Lap) -> Vec<Complex64> {
        if search.multipliers == 0 {
            return Vec::new();
        }
        // A start with a part in everything that a cycle forgets slowly.
        let start: Vec<f64> =
            (0..self.weights.len()).map(|i| 1.0 / (1.0 + (i * 7 % 13) as f64)).collect();
        let start = self.times(lap, &start);
        leading(&start, search.multipliers, 1e-7, |u| self.times(lap, u))
    }
}

fn replay(tangents: &mut Tangents, model: &Model, lap: &Lap, lines: Vec<Line>) {
    tangents.start_anew(lines);
    tangents.replay(model, &lap.tape);
}

fn gradient(lap: &Lap, tangents: &Tangents, index: usize, free: bool) -> Gradient {
    let line = &tangents.lines[index];
    let period = if free { line.instant } else { 0.0 };
    let advance = line.origin + line.unloaded - line.started;
    Gradient {
        period,
        advance,
        rop: (advance - lap.advance / lap.period * period) / lap.period,
        strikes: line.strikes.clone(),
        energies: line.spent_over(lap.end.mode, &lap.powers, period),
        peaks: tangents.peaks(index).map_or([0.0; 2], |p| [p.contact_force, p.rock_force]),
        reach: line.reach,
    }
}
