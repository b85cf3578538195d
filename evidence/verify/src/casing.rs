//! The hammer in its casing: statics, waves, momentum, mean forces over a cycle.

use crate::row::{Row, Rows};
use hammer::parameters::Casing;
use hammer::{
    Error, Event, Fidelity, InputValues, Kinematics, Machine, Parameters, Record, Source, Tie,
    TieState,
};

/// A feed that presses, and one that hardly holds the casing against the drive, N.
const FEEDS: [f64; 2] = [5e3, 1.5e3];
/// Drill strings above: none, and one of some 5 cm2 of steel, N s/m.
const STRINGS: [f64; 2] = [0.0, 2e4];

/// The reference hammer in a rigid casing of ten times its bit.
fn cased(fidelity: Fidelity, impedance: f64) -> Parameters {
    let mut p = Parameters { fidelity, ..Parameters::default() };
    p.casing = Casing { mass: 10.0 * p.bit_mass(), impedance, ..p.casing };
    p
}

/// The same in an elastic casing of two sections, 0.8 m and 0.2 m.
fn stepped(impedance: f64) -> Parameters {
    let mut p = cased(Fidelity::Elastic, impedance);
    (p.casing.segments, p.casing.elements) = (2, 10);
    (p.casing.segment[0].length, p.casing.segment[1].length) = (0.8, 0.2);
    p.casing.segment[1].area *= 1.5;
    p
}

fn named(fidelity: Fidelity) -> &'static str {
    match fidelity {
        Fidelity::Rigid => "rigid",
        Fidelity::Elastic => "elastic",
    }
}

fn machine(p: &Parameters, feed: f64) -> Result<Machine, Error> {
    Machine::new(p, &InputValues { feed_force: feed, ..InputValues::default() }, 0.0)
}

/// All fidelities, casings, strings and feeds, and what they are called.
fn cases() -> impl Iterator<Item = (String, Parameters, f64)> {
    STRINGS.into_iter().flat_map(|string| {
        let rigid = [Fidelity::Rigid, Fidelity::Elastic]
            .map(|fidelity| (format!("{} bodies", named(fidelity)), cased(fidelity, string)));
        let elastic = ("elastic bodies and casing".into(), stepped(string));
        rigid.into_iter().chain([elastic]).flat_map(move |(kind, p)| {
            FEEDS.into_iter().map(move |feed| {
                let name = format!("{kind}, string {string:e} N s/m, feed {feed} N");
                (name, p, feed)
            })
        })
    })
}

const STATICS: &str = "rounding: 64 eps of the forces, and of the springs at the displacements";

/// The start, and what of it has changed before the first blow.
///
/// # Errors
/// Whatever the engine says.
pub fn statics() -> Result<Vec<Row>, Error> {
    let mut list = Vec::new();
    for (name, p, feed) in cases() {
        let mut m = machine(&p, feed)?;
        let chuck = feed + p.casing_mass() * p.gravity - p.drive.amplitude;
        let rock = chuck + p.bit_mass() * p.gravity;
        let mut rows = Rows::new(name, "statics", STATICS);
        // The first blow is at 13.7 ms.
        for time in [0.0, 0.01] {
            m.advance(time)?;
            let k = m.kinematics();
            let sizes = [feed, p.drive.amplitude, rock, p.chuck.stiffness * k.bit_position.abs()];
            let rounding = 64.0 * f64::EPSILON * sizes.iter().sum::<f64>();
            rows.add(format!("chuck force at {time} s, N"), chuck, k.chuck_force, rounding);
            rows.add(format!("rock force at {time} s, N"), rock, k.rock_force, rounding);
        }
        list.extend(rows.list);
    }
    Ok(list)
}

const WAVES: &str = "the mesh's error, quintic splines of 8 mm on a front of 1 cm: 1e-4";

/// The bit leaves the shoulder, and the lower end of an elastic casing is free. A wave of release
/// goes up, behind which the casing moves at `FS / Z`; a string of impedance `Zs` reflects
/// `(Z - Zs) / (Z + Zs)` of it. So the mean velocity grows by `FS / Z` in the first `L / c`, and by
/// `(Z - Zs) / (Z + Zs)` times as much in each of the next two: by nothing if the string has the
/// casing's own impedance.
///
/// # Errors
/// Whatever the engine says.
pub fn waves() -> Result<Vec<Row>, Error> {
    let mut list = Vec::new();
    for ratio in [0.0, 0.3, 1.0, 4.0] {
        // A casing of 1 m, at rest under the feed alone, and a bit that a piston drives away.
        let mut p = cased(Fidelity::Elastic, 0.0);
        (p.gravity, p.drive.source, p.mesh.degree) = (0.0, Source::Force, 5);
        (p.casing.segments, p.casing.elements) = (1, 120);
        p.casing.segment[0].length = 1.0;
        let z = p.impedance_of(p.casing.segment[0].area);
        p.casing.impedance = ratio * z;
        (p.contact.initial_gap, p.piston.initial_velocity, p.rock.stiffness) = (1e-6, 10.0, 1e5);
        let mut m = machine(&p, FEEDS[0])?;
        m.keep_journal(true);
        let parted = loop {
            m.advance(m.time() + 1e-5)?;
            let parts = |record: &Record| record.event == Event::Tie(Tie::Chuck, TieState::Open);
            if let Some(record) = m.take_journal().into_iter().find(parts) {
                break record.time;
            }
        };
        let mut speeds = [0.3, 0.8, 1.3, 2.8];
        for transits in &mut speeds {
            m.advance(parted + *transits / p.wave_speed())?;
            *transits = m.kinematics().casing_velocity;
        }
        let [a, b, c, d] = speeds.map(|speed| speed * z / FEEDS[0]);
        let mut rows = Rows::new(format!("string of {ratio} Z"), "characteristics", WAVES);
        rows.add("gain in half a transit, FS/Z", 0.5, b - a, 1e-4);
        let back = 1.5 * (1.0 - ratio) / (1.0 + ratio);
        rows.add("gain in 1.5 transits after the first echo, FS/Z", back, d - c, 1e-4);
        list.extend(rows.list);
    }
    Ok(list)
}

const MOMENTUM: &str = "rounding: 2 eps per event on the impulses summed since the start";

/// Momentum of piston, bit and casing, N s.
fn momenta(p: &Parameters, k: &Kinematics) -> [f64; 3] {
    [
        p.piston_mass() * k.piston_velocity,
        p.bit_mass() * k.bit_velocity,
        p.casing_mass() * k.casing_velocity,
    ]
}

/// All that acts from outside, over two blows: the drive acts between piston and casing. What a
/// string takes from an elastic casing follows from the motion of its end, which is no output.
///
/// # Errors
/// Whatever the engine says.
pub fn momentum() -> Result<Vec<Row>, Error> {
    let mut list = Vec::new();
    let visible = |p: &Parameters| p.casing.segments == 0 || p.casing.impedance == 0.0;
    for (name, p, feed) in cases().filter(|(_, p, _)| visible(p)) {
        let mut m = machine(&p, feed)?;
        let from = m.kinematics().casing_position;
        let end = 0.1;
        m.advance(end)?;
        let (k, rock) = (*m.kinematics(), m.impulses().rock);
        let masses = p.total_mass();
        let pressed = (feed + masses * p.gravity) * end;
        let string = p.casing.impedance * (k.casing_position - from);
        let mut rows = Rows::new(name, "momentum", MOMENTUM);
        let size = pressed + rock + string.abs();
        let rounding = 2.0 * f64::EPSILON * m.counters().events as f64 * size;
        let given = pressed - rock - string;
        rows.add("momentum after 0.1 s, N s", given, momenta(&p, &k).iter().sum(), rounding);
        list.extend(rows.list);
    }
    Ok(list)
}

/// Gauss's rule of eight points on `[0, 1]`.
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_5],
    [0.960_289_856_497_536_2, 0.101_228_536_290_376_3],
];

/// Impulses of the chuck and of the drive over a span, N s, by what the machine shows at Gauss's
/// points between its events.
fn sampled(m: &mut Machine, ahead: &mut Machine, end: f64, step: f64) -> Result<[f64; 2], Error> {
    ahead.take_journal();
    ahead.advance(end)?;
    let mut edges: Vec<f64> = ahead.take_journal().iter().map(|record| record.time).collect();
    edges.push(end);
    let (mut from, mut sums) = (m.time(), [0.0; 2]);
    for edge in edges {
        let parts = ((edge - from) / step).ceil().max(1.0);
        let span = (edge - from) / parts;
        for part in 0..parts as usize {
            let middle = from + span * (part as f64 + 0.5);
            let mut points: Vec<[f64; 2]> =
                GAUSS.iter().flat_map(|[x, w]| [[-x, *w], [*x, *w]]).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            for [x, weight] in points {
                m.advance(middle + 0.5 * span * x)?;
                let k = m.kinematics();
                let settled = [k.chuck_force, k.applied_drive_force];
                sums.iter_mut().zip(settled).for_each(|(sum, f)| *sum += 0.5 * span * weight * f);
            }
        }
        from = edge;
    }
    m.advance(end)?;
    Ok(sums)
}

const MEANS: &str = "rounding of the impulses summed since the start, 2 eps an event; Gauss's rule of 8 points on half a radian of the fastest motion errs below 1e-13 of the largest force";
const CYCLE: &str = "the momentum by which the cycle does not repeat, over the period";

/// Section 12's means: of the cycle after the thirtieth blow, with rigid bodies.
///
/// # Errors
/// Whatever the engine says.
pub fn mean_forces() -> Result<Vec<Row>, Error> {
    let mut list = Vec::new();
    for string in STRINGS {
        let (p, feed) = (cased(Fidelity::Rigid, string), FEEDS[0]);
        let (mut m, mut ahead) = (machine(&p, feed)?, machine(&p, feed)?);
        ahead.keep_journal(true);
        while m.counters().blows < 30 {
            m.advance(m.time() + 0.01)?;
        }
        ahead.advance(m.time())?;
        let period = m.blow().map_or(f64::NAN, |blow| blow.period);
        let (j0, k0) = (m.impulses(), *m.kinematics());
        // Contact and chuck in parallel on the lighter of the bodies: no motion is faster.
        let fastest = ((p.meeting_stiffness() + p.chuck.stiffness) * 4.0 / p.bit_mass()).sqrt();
        let end = m.time() + period;
        let [chuck, drive] = sampled(&mut m, &mut ahead, end, 0.5 / fastest)?;
        let (j1, k1) = (m.impulses(), *m.kinematics());
        let mean = |a: f64, b: f64| (b - a) / period;
        let (contact, rock) = (mean(j0.contact, j1.contact), mean(j0.rock, j1.rock));
        let [chuck, drive] = [chuck, drive].map(|impulse| impulse / period);
        let [before, after] = [&k0, &k1].map(|k| momenta(&p, k));
        let gained: [f64; 3] = std::array::from_fn(|i| mean(before[i], after[i]));
        let pull = string * mean(k0.casing_position, k1.casing_position);
        let weights = [p.piston_mass(), p.bit_mass(), p.casing.mass].map(|mass| mass * p.gravity);
        let events = m.counters().events as f64;
        let summed = j1.contact + j1.rock + feed * m.time();
        let largest = p.meeting_stiffness().sqrt() * 12.0 * p.bit_mass().sqrt();
        let rounding = 2.0 * f64::EPSILON * events * summed / period + 1e-13 * largest;
        let name = format!("rigid bodies, string {string:e} N s/m, cycle after blow 30");
        let mut rows = Rows::new(name.clone(), "momentum", MEANS);
        rows.add("piston: contact + gained, N", drive + weights[0], contact + gained[0], rounding);
        rows.add("bit: rock + gained, N", weights[1] + contact + chuck, rock + gained[1], rounding);
        let held = feed + weights[2] - drive - pull;
        rows.add("casing: chuck + gained, N", held, chuck + gained[2], rounding);
        let mut cycle = Rows::new(name, "periodic cycle", CYCLE);
        let off = |body: usize| gained[body].abs() + rounding;
        cycle.add("mean chuck force, N", held, chuck, off(2));
        cycle.add("mean rock force, N", weights[1] + contact + chuck, rock, off(1));
        list.extend(rows.list);
        list.extend(cycle.list);
    }
    Ok(list)
}
