//! Blows of hammers that are driven from outside, and their records.

use crate::scenes::{Random, cased};
use hammer::presets::PRESETS;
use hammer::{
    Blow, Event, Fidelity, Input, InputValues, Machine, Parameters, Peaks, Relay, Scene, Source,
    Stops, Tie,
};

/// Shortest time between two blows, s: the fastest hammers strike 60 to 80 in a second.
const SHORTEST: f64 = 2.5e-3;

/// A law of the force on the piston, held over each step of [`Outside::step`].
#[derive(Clone, Copy, Debug)]
enum Law {
    /// A valve with memory, which switches so many seconds after the piston has passed an end of its stroke.
    Valve { lag: f64 },
    /// The paper's equation (3): a function of position and velocity, without memory.
    Letter,
    /// A valve whose force goes over so many seconds from one value to the other.
    Ramp { time: f64 },
    /// Of a given period, whatever the piston does: up for the first part of it.
    Pulses { period: f64, up: f64 },
}

/// A drive from outside.
struct Outside {
    law: Law,
    force: f64,
    stroke: f64,
    step: f64,
    /// Where the valve stands, and goes: -1 up, 1 down.
    sign: f64,
    wanted: f64,
    /// When the valve last began to turn, s.
    turned: f64,
    /// Passages of the upper end of the stroke.
    cycles: usize,
    above: bool,
}

impl Outside {
    /// The force for the step from here, N.
    fn force(&mut self, machine: &Machine) -> f64 {
        let (now, time) = (machine.kinematics().relative, machine.time());
        let (x, v) = (now.displacement, now.velocity);
        let above = x <= -self.stroke;
        self.cycles += usize::from(above && !self.above);
        self.above = above;
        let wanted = if above {
            1.0
        } else if x > 0.0 {
            -1.0
        } else {
            self.wanted
        };
        if wanted != self.wanted {
            (self.wanted, self.turned) = (wanted, time);
        }
        let since = time - self.turned;
        self.sign = match self.law {
            Law::Valve { lag } if since >= lag => self.wanted,
            Law::Valve { .. } => self.sign,
            Law::Letter => {
                if above || x <= 0.0 && v >= 0.0 {
                    1.0
                } else {
                    -1.0
                }
            }
            Law::Ramp { time } => self.wanted * (2.0 * since / time - 1.0).clamp(-1.0, 1.0),
            Law::Pulses { period, up } => {
                if time % period < up * period {
                    -1.0
                } else {
                    1.0
                }
            }
        };
        self.sign * self.force
    }
}

/// A drawn hammer and its drive.
fn drawn(case: usize, random: &mut Random) -> (Parameters, InputValues, Outside) {
    let mut p = Parameters::default();
    p.drive.source = Source::Force;
    p.fidelity = [Fidelity::Rigid, Fidelity::Elastic][case % 2];
    (p.piston.elements, p.bit.elements) = (6, 6);
    p.bit.length *= [1.0, 1.0, random.between(0.5, 2.0)][case % 3];
    p.rock.stiffness *= random.spread(0.2, 5.0);
    let law = match case / 2 % 4 {
        0 => Law::Valve { lag: random.between(0.0, 5e-3) },
        1 => Law::Letter,
        2 => Law::Ramp { time: random.between(1e-3, 5e-3) },
        _ => Law::Pulses { period: random.between(0.03, 0.08), up: random.between(0.25, 0.45) },
    };
    let inputs = InputValues { feed_force: random.between(2e3, 8e3), ..InputValues::default() };
    let (force, stroke) = (random.between(1200.0, 2400.0), random.between(0.03, 0.06));
    let outside = Outside {
        law,
        force,
        stroke,
        step: [2e-5, 5e-6][usize::from(matches!(law, Law::Letter))],
        sign: 1.0,
        wanted: 1.0,
        turned: f64::NEG_INFINITY,
        cycles: 0,
        above: true,
    };
    (p, inputs, outside)
}

/// At a blow, sums over the records of all blows are the machine's own: to the rounding of as many terms.
fn check_sums(machine: &Machine, blows: &[Blow], what: &str) {
    let sum = |of: &dyn Fn(&Blow) -> f64| blows.iter().map(of).sum::<f64>();
    let close = |a: f64, b: f64, size: f64| {
        assert!((a - b).abs() <= 1e-13 * blows.len() as f64 * size, "{what}: {a} {b}");
    };
    let e = machine.energies();
    let works = [e.drive, e.gravity, e.feed, e.rock_dissipated, e.viscous, e.damping];
    for (k, work) in works.into_iter().enumerate() {
        let recorded = sum(&|blow: &Blow| {
            let a = blow.account.expect("recorded");
            [a.drive, a.gravity, a.feed, a.rock_dissipated, a.viscous, a.damping][k]
        });
        close(recorded, work, e.turnover());
    }
    let drilled = machine.drilled_length();
    close(sum(&|blow| blow.length), drilled, drilled);
    close(sum(&|blow| blow.rock_work), works[3] + works[4], e.turnover());
    let periods = sum(&|blow| blow.period);
    close(periods, blows[blows.len() - 1].time - blows[0].time, periods);
    let shortest = blows.iter().skip(1).map(|blow| blow.period).fold(1.0, f64::min);
    assert!(shortest > SHORTEST, "{what}: {shortest}");
}

/// Runs a drawn hammer; returns what was set when, and the records.
fn driven(case: usize, random: &mut Random) -> (Parameters, InputValues, Vec<[f64; 2]>, Vec<Blow>) {
    let (p, inputs, mut outside) = drawn(case, random);
    let what = format!("{case} {:?} {:?}", outside.law, p.fidelity);
    let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
    machine.take_blows();
    let mut stops = Stops::new(&machine, true, &[]);
    let (mut set, mut blows, mut cycles) = (Vec::new(), Vec::new(), Vec::new());
    while machine.time() < 0.5 {
        let force = outside.force(&machine);
        set.push([machine.time(), force]);
        machine.set_input(Input::DriveForce, &[force]).expect("an input");
        let to = machine.time() + outside.step;
        while machine.time() < to {
            let (_, stop) = machine.advance_keeping_start(to, Some(&mut stops)).expect("a step");
            blows.extend(machine.take_blows());
            if stop.blow {
                cycles.push(outside.cycles);
                check_sums(&machine, &blows, &what);
            }
        }
    }
    assert!(blows.len() >= 4 && blows.len() == cycles.len(), "{what}: {cycles:?}");
    if !matches!(outside.law, Law::Pulses { .. }) {
        // The first blow comes before the first rise.
        let every: Vec<usize> = (0..cycles.len()).collect();
        assert_eq!(cycles, every, "{what}: cycles of the drive before each blow");
    }
    (p, inputs, set, blows)
}

/// Drawn drives from outside, which push on after the blow, rest, or move slowly: one blow in each of their cycles, and
/// the same ones, to the last binary digit, in other slices of time and from restored states.
#[test]
fn a_drive_from_outside_strikes_one_blow_in_each_of_its_cycles() {
    let mut random = Random::new(68);
    for case in 0..24 {
        let (p, inputs, set, expected) = driven(case, &mut random);
        let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
        machine.take_blows();
        let mut blows = Vec::new();
        for [time, force] in set {
            while random.unit() < 0.02 {
                let to = machine.time() + random.unit() * (time - machine.time());
                machine.advance(to).expect("a step");
                let mut other = Machine::new(&p, &inputs, 0.0).expect("a scene");
                let stored = serde_json::to_string(&machine.state()).expect("a state in JSON");
                let state = serde_json::from_str(&stored).expect("a state");
                other.restore(&state).expect("a state of its own");
                machine = other;
            }
            machine.advance(time).expect("a step");
            machine.set_input(Input::DriveForce, &[force]).expect("an input");
            blows.extend(machine.take_blows());
            if blows.len() >= expected.len() {
                break;
            }
        }
        assert!(blows == expected, "{case}: {} and {} blows", blows.len(), expected.len());
    }
}

/// Every preset, and the reference hammer with each built-in drive, with a casing and in soft and hard rock.
#[test]
fn records_of_every_built_in_hammer_add_up() {
    let presets = PRESETS.iter().filter(|preset| !preset.name.contains("rod"));
    let mut scenes: Vec<_> = presets.map(|preset| (preset.name.into(), preset.start())).collect();
    for (stiffness, fidelity) in [(0.2, Fidelity::Rigid), (5.0, Fidelity::Elastic)] {
        for mut p in [Parameters::default(), cased()] {
            (p.fidelity, p.rock.stiffness) = (fidelity, stiffness * p.rock.stiffness);
            let name = format!("{stiffness} {}", p.casing.mass);
            scenes.push((name, Scene { parameters: p, ..Scene::default() }));
        }
    }
    for (name, scene) in scenes {
        let mut machine = scene.machine().expect("a scene");
        machine.take_blows();
        machine.keep_journal(true);
        let mut stops = Stops::new(&machine, true, &[]);
        while machine.counters().blows < 8 {
            machine.advance_keeping_start(10.0, Some(&mut stops)).expect("a step to a blow");
            assert!(machine.time() < 10.0, "{name} strikes no blow");
        }
        let blows = machine.take_blows();
        check_sums(&machine, &blows, &name);
        let down = |event| event == Event::Relay(Relay::Drive);
        let cycles = machine.take_journal().iter().filter(|record| down(record.event)).count();
        if scene.parameters.drive.source == Source::Relay {
            assert_eq!(cycles, 7, "{name}: falls between eight blows");
        }
    }
}

/// Largest forces of a record are those of the communication steps between two blows, within twice the error of a
/// search: 1e-12 m in the stiffness.
#[test]
fn the_forces_of_a_record_are_the_largest_between_two_blows() {
    let p = cased();
    let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
    machine.record_blows();
    let (mut stops, mut largest) = (Stops::new(&machine, true, &[]), [0.0_f64; 3]);
    while machine.counters().blows < 5 {
        let to = machine.time() + 1e-3;
        let (_, stop) = machine.advance_keeping_start(to, Some(&mut stops)).expect("a step");
        let all = |p: Peaks| [p.contact_force(), p.tie_force(Tie::Chuck), p.rock_force()];
        let step = all(machine.peaks());
        largest = std::array::from_fn(|k| largest[k].max(step[k]));
        if stop.blow {
            let found = all(machine.blow().and_then(|blow| blow.account).expect("recorded").peaks);
            let off = (0..3).map(|k| (found[k] - largest[k]).abs()).fold(0.0, f64::max);
            assert!(off <= 2e-12 * p.meeting_stiffness(), "{found:?} {largest:?}");
            largest = [0.0; 3];
        }
    }
}
