//! The reference's drill string with loose joints, against closed forms.

use oracles::dd::Dd;
use oracles::joint::{Flying, Loose, trapped};
use oracles::law::{Event, Side};
use oracles::linear::Real;
use oracles::run::Run;
use oracles::scene::{Action, Body, Coupling, Drive, Fidelity, Input, RockLaw, Scene, Section};
use oracles::taylor::Accuracy;

const ACCURACY: Accuracy = Accuracy { order: 36, tolerance: 1e-28 };
const DENSITY: f64 = 8000.0;
const AREA: f64 = 1e-3;

/// A piston that nothing moves, a metre above rods of these lengths on rock that hardly holds them.
fn string(fidelity: Fidelity, lengths: &[f64], elements: usize, coupling: Coupling) -> Scene {
    let body = |&length: &f64| Body {
        sections: vec![Section { length, area: AREA, elements }],
        velocity: 0.0,
    };
    Scene {
        fidelity,
        youngs_modulus: 2e11,
        density: DENSITY,
        damping_time: 0.0,
        bodies: [0.1].iter().chain(lengths).map(body).collect(),
        coupling,
        contact_stiffness: 1e10,
        casing: None,
        anvil_area: 0.0,
        gap: 1.0,
        rock: RockLaw {
            stiffness: 1e-20,
            ratio: 1.0,
            viscosity: 0.0,
            barrier: 0.0,
            standstill_speed: 1e-3,
            standstill_penetration: 1e-6,
            reloads: false,
        },
        drive: Drive::Force,
        gravity: 0.0,
        inputs: [0.0; 4],
        resolutions: [1e-14, 1e-9],
    }
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} {b}, {tolerance:e}");
}

/// The instants at which two rods meet and part, their momentum and their energy.
#[test]
fn two_rigid_rods_exchange_their_speeds_through_the_thread_and_the_faces() {
    for damping in [0.0, 2e-6] {
        let coupling = Coupling { stiffness: 1e10, slack: 1e-4 };
        let mut scene = string(Fidelity::Rigid, &[0.5, 1.5], 1, coupling);
        scene.damping_time = damping;
        scene.bodies[2].velocity = 2.0;
        let masses = [0.5, 1.5].map(|length| DENSITY * AREA * length);
        let [total, mass] =
            [masses[0] + masses[1], masses[0] * masses[1] / (masses[0] + masses[1])];
        let flying = Flying { mass, stiffness: 1e10, damping, slack: 1e-4 };
        let instants = flying.instants(2.0, 9);
        let mut run = Run::<Dd>::new(&scene, ACCURACY);
        let ends: Vec<f64> =
            instants.windows(2).map(|pair| 0.5 * (pair[0][0] + pair[1][0])).collect();
        run.through(&ends, &[]).unwrap();
        let joints: Vec<_> =
            run.events.iter().filter(|e| matches!(e.event, Event::Joint(..))).collect();
        let turns = [Side::Open, Side::Pulled, Side::Open, Side::Pressed];
        assert_eq!(joints.len(), ends.len());
        for (i, (event, [time, _])) in joints.iter().zip(&instants).enumerate() {
            assert_eq!(event.event, Event::Joint(0, turns[i % 4]), "{i}");
            // Rounding of the closed form, a sum of `i` terms.
            close(
                event.time.to_f64(),
                *time,
                4.0 * (i + 1) as f64 * f64::EPSILON * instants[i.max(1)][0],
            );
        }
        for (sample, [_, apart]) in run.samples.iter().zip(&instants) {
            let [one, two] = [1, 2].map(|body| sample.state.v[body].to_f64());
            let momentum = masses[0] * one + masses[1] * two;
            close(momentum, 2.0 * masses[1], 1e-14 * momentum);
            let energy = sample.energies.stored.iter().fold(0.0, |sum, part| sum + part.to_f64());
            if sample.mode.joints[0] == Side::Open {
                close(two - one, *apart, 1e-14 * 2.0);
                let kinetic = 0.5 * (mass * apart * apart + momentum * momentum / total);
                close(energy, kinetic, 1e-14 * kinetic);
            }
            // What the start had and the joint no longer has, its dashpot took.
            let lost = 0.5 * masses[1] * 4.0 - energy;
            close(sample.energies.damping.to_f64(), lost, 1e-14 * energy);
        }
    }
}

/// Each joint carries the feed and the weights above it, and nothing moves.
#[test]
fn a_string_rests_on_its_joints() {
    for fidelity in [Fidelity::Rigid, Fidelity::Elastic, Fidelity::Spectral(5), Fidelity::Spline(4)]
    {
        let coupling = Coupling { stiffness: 3e9, slack: 1e-4 };
        let lengths = [0.5, 1.5, 0.7];
        let mut scene = string(fidelity, &lengths, 2, coupling);
        (scene.gravity, scene.inputs[Input::Feed as usize]) = (10.0, 500.0);
        scene.rock.stiffness = 1e8;
        let mut run = Run::<Dd>::new(&scene, ACCURACY);
        let start = run.model.start().0;
        run.through(&[1e-3], &[]).unwrap();
        let sample = &run.samples[0];
        assert!(run.events.is_empty(), "{:?}", run.events);
        let mut carried = 500.0;
        for (length, force) in lengths.iter().zip(&sample.joints) {
            carried += 10.0 * DENSITY * AREA * length;
            close(force.to_f64(), carried, 4.0 * f64::EPSILON * carried);
        }
        close(sample.forces[1].to_f64(), carried + 10.0 * DENSITY * AREA * 0.7, 1e-12);
        for i in run.model.bit..run.model.nodes() {
            // Rounding of forces of a newton on elements of a kilogram, 1e-31 of them a step.
            close((sample.state.u[i] - start.u[i]).to_f64(), 0.0, 1e-28);
        }
    }
}

/// A string that its weights pull up flies from the rock as one: its joints press it by what the feed
/// gives each part of its mass.
#[test]
fn a_lifted_string_starts_without_oscillation() {
    let coupling = Coupling { stiffness: 3e9, slack: 1e-4 };
    let mut scene = string(Fidelity::Elastic, &[0.5, 1.5, 0.7], 2, coupling);
    (scene.gravity, scene.inputs[Input::Feed as usize]) = (-10.0, 100.0);
    let mut run = Run::<Dd>::new(&scene, ACCURACY);
    let start = run.model.start().0;
    run.through(&[1e-3], &[]).unwrap();
    let sample = &run.samples[0];
    assert!(run.events.is_empty(), "{:?}", run.events);
    let (mut above, all) = (0.0, 2.7);
    for (length, force) in [0.5, 1.5].iter().zip(&sample.joints) {
        above += length;
        close(force.to_f64(), 100.0 * (1.0 - above / all), 1e-12);
    }
    let way = 0.5 * (100.0 / (DENSITY * AREA * all) - 10.0) * 1e-6;
    for i in run.model.bit..run.model.nodes() {
        close((sample.state.u[i] - start.u[i]).to_f64(), way, 1e-14 * way.abs());
    }
}

/// Spectral elements of 1 m of rod, and their degree: they carry waves of `pi` of their nodes.
const ELEMENTS: usize = 16;
const DEGREE: usize = 10;
/// Rate of the wave's force over time squared, N/s2.
const RATE: f64 = 4e12;

/// When a joint closes, s, and its force a time after the wave's arrival, N.
fn closed(scene: &Scene, schedule: &[(f64, Action)], to: Side, instants: [f64; 3]) -> [f64; 4] {
    let mut run = Run::<f64>::new(scene, Accuracy { order: 20, tolerance: 1e-14 });
    run.through(&instants, schedule).unwrap();
    let is_last = |e: &&oracles::record::Passed<f64>| e.event == Event::Joint(0, to);
    let event = run.events.iter().rfind(is_last).expect("it closes");
    let force = |i: usize| run.samples[i].joints[0];
    [event.time, force(0), force(1), force(2)]
}

/// A joint that a pulse of tension has opened by half its slack, and a wave of compression then closes;
/// and one that a wave of tension opens, until the thread pulls.
#[test]
fn a_wave_passes_a_loose_joint_once_its_way_is_used_up() {
    let coupling = Coupling { stiffness: 1.2e9, slack: 1e-4 };
    let (arrival, impedance) = (1.0 / 5000.0, AREA * 4e7);
    let joint = Loose { impedance, stiffness: coupling.stiffness };
    let wave = |sign: f64| Action::Set(Input::Feed, vec![0.0, 0.0, sign * 2.0 * RATE]);
    // -top 16 (t (T - t)/T^2)^2, whose integral is -8/15 T top, moves a free end up by half the slack.
    let (pulse, opened) = (1.2e-4, 0.5 * coupling.slack);
    let fourth = 16.0 / f64::powi(pulse, 4) * 0.5 * opened * impedance / (8.0 / 15.0 * pulse);
    let pull = [0.0, 0.0, -2.0 * pulse * pulse, 12.0 * pulse, -24.0].map(|c| fourth * c);
    let pull_bend = pull[2].abs();
    let pull = (0.0, Action::Set(Input::Feed, pull.to_vec()));
    for (schedule, from, way, sign, to) in [
        (vec![pull, (pulse, wave(1.0))], pulse, opened, 1.0, Side::Pressed),
        (vec![(0.0, wave(-1.0))], 0.0, coupling.slack, -1.0, Side::Pulled),
    ] {
        let time = joint.closing(RATE, way);
        let since = [0.5 * time, time + joint.delay(), time + 4.0 * joint.delay()];
        let scene = string(Fidelity::Spectral(DEGREE), &[1.0, 1.0], ELEMENTS, coupling);
        let found = closed(&scene, &schedule, to, since.map(|time| from + arrival + time));
        // What is faster than the mesh: of a jump of a force's second derivative its part 1/w^3, which moves
        // the faces by twice that over Z w; of a kink of the force, 1/(pi w) of the change of its slope.
        let fastest = 5000.0 * 2.0 * (DEGREE * ELEMENTS) as f64;
        let (speed, bent) = (2.0 * RATE * time * time / impedance, 2.0 * RATE + 2.0 * pull_bend);
        let late = 2.0 * bent / impedance / fastest.powi(3) / speed;
        let kink = RATE * time * time / joint.delay() / (std::f64::consts::PI * fastest);
        close(found[0], from + arrival + time, late);
        for (found, at) in found[1..].iter().zip(since) {
            close(*found, sign * joint.passed(RATE, at, time), if at < time { 0.0 } else { kink });
        }
    }
}

/// A piston strikes a string of two rods, and its pulse comes back from the free end as tension: the
/// joint leaves what the slack takes in the lower rod, and the rest goes up.
#[test]
fn slack_traps_momentum_in_the_last_rod() {
    for slack in [0.0, 4e-4, 2e-3] {
        let coupling = Coupling { stiffness: 2e9, slack };
        // What the joint sends back of the blow comes again when all is over.
        let mut scene = string(Fidelity::Spectral(DEGREE), &[2.0, 1.0], ELEMENTS, coupling);
        (scene.contact_stiffness, scene.gap, scene.damping_time) = (2e9, 1e-6, 1e-7);
        (scene.bodies[0].sections[0].length, scene.bodies[0].velocity) = (0.25, 10.0);
        let mut run = Run::<f64>::new(&scene, Accuracy { order: 20, tolerance: 1e-14 });
        run.through(&[1.1e-3], &[]).unwrap();
        let (model, v) = (&run.model, &run.samples[0].state.v);
        let mut momenta = vec![0.0; v.len()];
        model.mass.subtract_product(v, &mut momenta);
        let of =
            |body: usize| -momenta[model.starts[body]..model.starts[body + 1]].iter().sum::<f64>();
        let given = DENSITY * AREA * 0.25 * 10.0 - of(0);
        let left = trapped(given, AREA * 4e7, slack);
        // Contact and joint, of 1e-5 s both, are late in the pulse by (1 + x + x^2/2) exp(-x) of it, 20 of
        // these after its end.
        close(of(2), left, 1e-6 * given);
        close(of(1), given - left, 1e-6 * given);
    }
}
