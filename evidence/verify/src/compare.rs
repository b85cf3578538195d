//! The engine against the extended-precision reference on any scene and script.
//!
//! How far the two may be apart is not chosen: the reference solves the scene again with every
//! number off by a few units in the last place ([`oracles::perturb`]), and with guards that
//! resolve four times as much and as little. What these runs do not agree upon, no arithmetic of
//! double precision can know; where they take different events the comparison ends. Up to
//! there the engine must take the same events, and everything that it shows may differ by
//! [`FACTOR`] times what the perturbed runs do, and by rounding of the largest number of its
//! kind so far.

use crate::bodies;
use crate::draw::Draw;
use crate::scene;
use crate::script::{self, Deed};
use hammer::{Error, Machine};
use oracles::dd::Dd;
use oracles::law::{Event, Mode, Quantity};
use oracles::linear::Real;
use oracles::perturb::perturbed;
use oracles::run::{GivenUp, Run, Sampled};
use oracles::taylor::Accuracy;

/// The reference's series: their last term is a millionth of a double's last digit.
pub(crate) const ACCURACY: Accuracy = Accuracy { order: 36, tolerance: 1e-24 };
/// Series a run may take; by then each has seen some thousand radians of the fastest motion.
pub(crate) const PATIENCE: usize = 700;
/// Perturbed runs.
const SEEDS: [u64; 2] = [1, 2];
/// What the perturbed runs resolve, over what the engine does.
const COARSER: [f64; 2] = [4.0, 0.25];
/// Instants compared.
pub(crate) const INSTANTS: usize = 12;
/// Multiple of what a change of four units in the last place brings about that is granted: a
/// state passes through some tens of products a transition, each with a rounding of its own.
pub const FACTOR: f64 = 32.0;
/// Rounding granted to each number, over the scale of its kind ([`Scales`]).
pub const ROUNDING: f64 = 256.0 * f64::EPSILON;
/// Rounding granted for each event before, likewise: the state goes through two products with a
/// basis, each a sum of a few rounded terms, some units in the last place each.
pub const ROUNDING_PER_EVENT: f64 = 16.0 * f64::EPSILON;

/// What numbers are rounded by: the largest of their kind so far, but not less than what
/// arithmetic starts from. Oscillation is measured from the static shape, which is as far away
/// as springs and bars yield, and as fast as a load drives a wave; a work is a load times
/// places whose difference is its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    place: f64,
    speed: f64,
    force: f64,
    energy: f64,
    viscosity: f64,
    /// Of the stiffest spring that holds the bit, N/m, and how far the bit has been moved.
    spring: f64,
    bit: f64,
}

impl Scales {
    pub(crate) fn new(draw: &Draw) -> Self {
        let p = &draw.parameters;
        let weight = (p.piston_mass() + p.bit_mass()) * p.gravity.abs();
        let load = draw.loads().iter().sum::<f64>() + weight;
        let bars = bodies::compliance(p);
        let yielded = load * (1.0 / p.rock.stiffness + 1.0 / p.meeting_stiffness() + bars);
        let place = p.contact.initial_gap + yielded;
        let waves =
            load / bodies::least_impedance(p) + load / (p.rock.stiffness * p.bit_mass()).sqrt();
        let speed = p.piston.initial_velocity.abs() + waves;
        let viscosity = p.rock.viscosity;
        let spring = p.rock.unloading_ratio * p.rock.stiffness + p.meeting_stiffness();
        let (bit, force) = (load * bars, load + viscosity * speed);
        Self { place, speed, force, energy: load * place, viscosity, spring, bit }
    }

    /// Takes what is shown into account.
    pub(crate) fn grow(&mut self, shown: &Shown) {
        for (value, (_, kind)) in shown.iter().zip(SHOWN) {
            let scale = match kind {
                0 => &mut self.place,
                1 => &mut self.speed,
                2 => &mut self.force,
                _ => &mut self.energy,
            };
            *scale = scale.max(value.abs());
        }
        // A spring's length is a sum of motions of the bit, each rounded.
        self.bit = self.bit.max(shown[1].abs()).max(shown[2].abs());
        self.force = self.force.max(self.viscosity * self.speed).max(self.spring * self.bit);
        self.energy = self.energy.max(self.force * self.place);
    }

    pub(crate) fn of(&self, kind: usize) -> f64 {
        [self.place, self.speed, self.force, self.energy][kind]
    }

    /// Rounding of a guard that announces this event.
    fn of_guard(&self, event: Event) -> f64 {
        match event {
            Event::Close | Event::Open | Event::Q1 | Event::Q5 | Event::LiftOff => self.place,
            Event::Q9 | Event::Q10 | Event::Port(..) | Event::Level(_) => self.place,
            Event::Q2 | Event::Q4 | Event::Q6 | Event::Q7 | Event::Q8 => self.speed,
            Event::Q3 => self.energy,
        }
    }
}

/// What is compared at an instant; its kind says which numbers it is measured by.
pub(crate) const SHOWN: [(&str, usize); 22] = [
    ("piston_position", 0),
    ("bit_position", 0),
    ("bit_tip_position", 0),
    ("contact_gap", 0),
    ("hole_depth", 0),
    ("piston_velocity", 1),
    ("bit_velocity", 1),
    ("bit_tip_velocity", 1),
    ("contact_force", 2),
    ("rock_force", 2),
    ("applied_drive_force", 2),
    ("energy_drive", 3),
    ("energy_gravity", 3),
    ("energy_feed", 3),
    ("energy_kinetic", 3),
    ("energy_strain", 3),
    ("energy_contact", 3),
    ("energy_rock_stored", 3),
    ("energy_rock_dissipated", 3),
    ("energy_viscous", 3),
    ("energy_damping", 3),
    ("energy_retuned", 3),
];

pub(crate) type Shown = [f64; SHOWN.len()];

/// The largest excess of one kind.
#[derive(Clone, Debug, Default)]
pub struct Worst {
    /// Of what.
    pub what: String,
    /// When, s.
    pub time: f64,
    /// The difference.
    pub error: f64,
    /// What was allowed.
    pub allowed: f64,
}

impl Worst {
    /// The difference over what was allowed.
    pub fn ratio(&self) -> f64 {
        if self.error == 0.0 { 0.0 } else { self.error / self.allowed }
    }

    pub(crate) fn note(&mut self, other: Self) {
        if other.ratio().is_nan() || other.ratio() > self.ratio() {
            *self = other;
        }
    }
}

/// What came of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Differences {
    /// Events compared.
    pub events: usize,
    /// Instants compared.
    pub instants: usize,
    /// Until when the scene is decided in double precision, s.
    pub until: f64,
    /// The worst of the numbers shown.
    pub shown: Worst,
    /// The worst of the events' times.
    pub timing: Worst,
    /// An event that is not the reference's.
    pub unlike: Option<String>,
}

impl Differences {
    /// True if everything is within what is allowed.
    pub fn none(&self) -> bool {
        self.unlike.is_none() && self.shown.ratio() <= 1.0 && self.timing.ratio() <= 1.0
    }
}

/// An engine's or a reference's account of a scene.
struct Account {
    events: Vec<(Dd, Event, Mode)>,
    /// Rates of the guards at these, of a reference.
    rates: Vec<f64>,
    shown: Vec<Shown>,
}

/// Compares the engine with the reference.
///
/// # Errors
/// The engine's, if it refuses the scene before the scene is undecided.
pub fn compare(draw: &Draw) -> Result<Differences, Error> {
    let scene = scene::finite_elements(&draw.parameters, &draw.inputs);
    // A unit of its pace a series, to be on the safe side: events take more.
    let draw = &draw.within(PATIENCE as f64 * Run::<f64>::new(&scene, ACCURACY).pace());
    let script = draw.script()?;
    let instants: Vec<f64> =
        (1..=INSTANTS).map(|i| draw.end() * i as f64 / INSTANTS as f64).collect();
    let told = script::told(&draw.parameters, &script);
    let (reference, mut until) = solve(&scene, &told, &instants);
    let mut others = Vec::new();
    for (seed, coarser) in SEEDS.into_iter().zip(COARSER) {
        let (mut scene, told) = perturbed(&scene, &told, seed);
        scene.resolutions = scene.resolutions.map(|r| coarser * r);
        let (other, reached) = solve(&scene, &told, &instants);
        until = until.min(reached).min(parting(&reference.events, &other.events));
        others.push(other);
    }
    let engine = engine(draw, &script, &instants, until)?;
    Ok(judge(&engine, &reference, &others, &instants, (until, Scales::new(draw))))
}

/// When two sequences of events first differ, s.
fn parting(a: &[(Dd, Event, Mode)], b: &[(Dd, Event, Mode)]) -> f64 {
    let same = a.iter().zip(b).take_while(|(a, b)| a.1 == b.1 && a.2 == b.2).count();
    let next = [a, b].map(|list| list.get(same).map_or(f64::INFINITY, |e| e.0.to_f64()));
    next[0].min(next[1])
}

/// The reference's account, and until when it goes.
fn solve(
    scene: &oracles::scene::Scene,
    script: &oracles::scene::Script,
    instants: &[f64],
) -> (Account, f64) {
    let mut run = Run::<Dd>::new(scene, ACCURACY);
    run.patience = PATIENCE;
    let until = match run.through(instants, script) {
        Ok(()) => run.undecided(),
        Err(GivenUp::Cascade(time) | GivenUp::Long(time)) => time,
    };
    let events = run.events.iter().map(|e| (e.time, e.event, e.mode)).collect();
    let rates = run.events.iter().map(|e| e.rate.to_f64()).collect();
    let shown = run.samples.iter().map(|sample| of_reference(&run, sample)).collect();
    (Account { events, rates, shown }, until)
}

fn of_reference(run: &Run<Dd>, sample: &Sampled<Dd>) -> Shown {
    exactly(run, sample).map(Real::to_f64)
}

/// What is compared, in the reference's own numbers.
pub(crate) fn exactly(run: &Run<Dd>, sample: &Sampled<Dd>) -> [Dd; SHOWN.len()] {
    let (model, state, e) = (&run.model, &sample.state, &sample.energies);
    let mean = |x: &[Dd], nodes: std::ops::Range<usize>| {
        // The row holds weights of opposite sign for the two bodies.
        let sign = Dd::from(if nodes.start == 0 { 1.0 } else { -1.0 });
        nodes.fold(Dd::default(), |sum, i| sum + sign * model.relative[i] * x[i])
    };
    let (bit, n) = (model.bit, model.nodes());
    let [contact, rock] = sample.forces;
    let [kinetic, strain, closed, held] = e.stored;
    let gap = model.quantity(Quantity::Gap, state);
    [
        mean(&state.u, 0..bit),
        mean(&state.u, bit..n),
        state.u[n - 1],
        gap,
        sample.memory.uu,
        mean(&state.v, 0..bit),
        mean(&state.v, bit..n),
        state.v[n - 1],
        contact,
        rock,
        sample.force,
        e.drive,
        e.gravity,
        e.feed,
        kinetic,
        strain,
        closed,
        held,
        e.rock,
        e.viscous,
        e.damping,
        e.retuned,
    ]
}

fn of_engine(machine: &Machine) -> Shown {
    let (k, e) = (*machine.kinematics(), machine.energies());
    [
        k.piston_position,
        k.bit_position,
        k.bit_tip_position,
        k.contact_gap,
        k.hole_depth,
        k.piston_velocity,
        k.bit_velocity,
        k.bit_tip_velocity,
        k.contact_force,
        k.rock_force,
        k.applied_drive_force,
        e.drive,
        e.gravity,
        e.feed,
        e.kinetic,
        e.strain,
        e.contact,
        e.rock_stored,
        e.rock_dissipated,
        e.viscous,
        e.damping,
        e.retuned,
    ]
}

fn engine(
    draw: &Draw,
    script: &[(f64, Deed)],
    instants: &[f64],
    until: f64,
) -> Result<Account, Error> {
    let mut machine = Machine::new(&draw.parameters, &draw.inputs, 0.0)?;
    machine.keep_journal(true);
    let mut shown = Vec::new();
    for &instant in instants.iter().filter(|&&instant| instant < until) {
        script::follow(&mut machine, &draw.parameters, script, instant)?;
        shown.push(of_engine(&machine));
    }
    let event = |r: &hammer::Record| {
        (Dd { hi: r.time, lo: r.time_rest }, scene::event(r), scene::mode(r.mode))
    };
    let events = machine.take_journal().iter().map(event).collect();
    Ok(Account { events, rates: Vec::new(), shown })
}

fn judge(
    engine: &Account,
    reference: &Account,
    others: &[Account],
    instants: &[f64],
    (until, mut scales): (f64, Scales),
) -> Differences {
    let count = engine.shown.len().min(reference.shown.len());
    let last = count.checked_sub(1).map_or(-1.0, |i| instants[i]);
    let mut found = Differences { until: until.min(last), instants: count, ..Default::default() };
    for (i, &time) in instants.iter().enumerate().take(count) {
        scales.grow(&reference.shown[i]);
        let before = reference.events.partition_point(|e| e.0.to_f64() <= time);
        let rounding = ROUNDING + ROUNDING_PER_EVENT * before as f64;
        for (q, (what, kind)) in SHOWN.into_iter().enumerate() {
            let known = reference.shown[i][q];
            let apart = |other: &Account| (other.shown[i][q] - known).abs();
            let spread = others.iter().map(apart).fold(0.0, f64::max);
            found.shown.note(Worst {
                what: what.into(),
                time,
                error: (engine.shown[i][q] - known).abs(),
                allowed: FACTOR * spread + rounding * scales.of(kind),
            });
        }
    }
    times((engine, reference, others), last, &scales, &mut found);
    found
}

/// True if the next two events are at one instant, and taken in the other order.
fn tied(own: &[(Dd, Event, Mode)], known: &[(Dd, Event, Mode)]) -> bool {
    let ([a, b, ..], [x, y, ..]) = (own, known) else { return false };
    let apart = |p: Dd, q: Dd| (p - q).to_f64().abs();
    let reach = hammer::TIME_RESOLUTION + f64::EPSILON * x.0.to_f64();
    let together = apart(a.0, b.0).max(apart(x.0, y.0)).max(apart(a.0, x.0)) <= reach;
    together && a.1 == y.1 && b.1 == x.1 && b.2 == y.2
}

/// Events before the last instant compared.
fn times(
    (engine, reference, others): (&Account, &Account, &[Account]),
    last: f64,
    scales: &Scales,
    found: &mut Differences,
) {
    let wanted = reference.events.iter().filter(|e| e.0.to_f64() <= last);
    let mut skipped = 0;
    for (i, known) in wanted.enumerate() {
        if tied(&engine.events[i.min(engine.events.len())..], &reference.events[i..]) {
            skipped = 2;
        }
        if skipped > 0 {
            (skipped, found.events) = (skipped - 1, found.events + 1);
            continue;
        }
        let Some(own) = engine.events.get(i).filter(|own| own.1 == known.1 && own.2 == known.2)
        else {
            let own = engine.events.get(i);
            found.unlike = Some(format!("event {i} is {own:?} instead of {known:?}"));
            return;
        };
        let spread = others.iter().map(|o| (o.events[i].0 - known.0).to_f64().abs());
        let spread = spread.fold(0.0, f64::max);
        found.timing.note(Worst {
            what: format!("{:?}", known.1),
            time: known.0.to_f64(),
            error: (own.0 - known.0).to_f64().abs(),
            allowed: FACTOR * spread
                + hammer::TIME_RESOLUTION
                + f64::EPSILON * known.0.to_f64()
                + ROUNDING * scales.of_guard(known.1) / reference.rates[i].abs(),
        });
        found.events += 1;
    }
    if engine.events.len() > found.events {
        let own = &engine.events[found.events];
        if own.0.to_f64() < last {
            found.unlike = Some(format!("event {} is {own:?}, too many", found.events));
        }
    }
}
