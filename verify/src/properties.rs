//! Properties that hold for every scene: proptest draws the scene, log-uniformly over the
//! domain, and a machine under watch must keep them.

use crate::hard_cases::trajectory;
use crate::watch::{Fault, Watched};
use hammer::parameters::{Bit, Contact, Drive, Material, Piston, Rock};
use hammer::{Error, Fidelity, InputValues, Machine, Parameters, Source, State};
use proptest::prelude::*;

/// A scene, for how many of its own times it is followed, and where it is cut.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Parameters.
    pub parameters: Parameters,
    /// Inputs.
    pub inputs: InputValues,
    /// Duration, in units of [`Draw::unit`].
    pub duration: f64,
    /// Communication points, in parts of the duration.
    pub cuts: Vec<f64>,
}

impl Draw {
    /// The longer of the wave's way through both bars and back, and a hundredth of the
    /// time to the first blow: a scene is followed through tens of these.
    pub fn unit(&self) -> f64 {
        let p = &self.parameters;
        let scales = p.timescales();
        let waves = 2.0 * (scales.piston_transit + scales.bit_transit);
        let push = p.drive.amplitude.max(self.inputs.drive_force.abs()) / p.piston_mass();
        let fall = (2.0 * p.contact.initial_gap / (push + p.gravity.abs() + 1e-3)).sqrt();
        let flight = fall.min(p.contact.initial_gap / p.piston.initial_velocity.abs().max(1e-3));
        waves + 0.02 * flight
    }

    /// End of the run, s: no body goes a metre, beyond which rounding of a position comes
    /// near the resolution of a guard.
    pub fn end(&self) -> f64 {
        let p = &self.parameters;
        let load =
            self.inputs.feed_force.abs() + p.drive.amplitude.max(self.inputs.drive_force.abs());
        let push = load / p.piston_mass().min(p.bit_mass()) + p.gravity.abs();
        let metre = (2.0 / push).sqrt().min(1.0 / p.piston.initial_velocity.abs());
        (self.duration * self.unit()).min(metre)
    }
}

fn log(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

/// Log-uniform, or zero one time in six.
fn or_zero(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![1 => Just(0.0), 5 => log(low, high)]
}

fn signed(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    (or_zero(low, high), any::<bool>()).prop_map(|(x, s)| if s { -x } else { x })
}

fn bodies() -> impl Strategy<Value = (Fidelity, Material, f64, Piston, Bit)> {
    let fidelity = prop_oneof![1 => Just(Fidelity::Rigid), 3 => Just(Fidelity::Elastic)];
    let material = (log(1e9, 1e12), log(1e3, 2e4), or_zero(1e-11, 1e-4)).prop_map(
        |(youngs_modulus, density, damping_time)| Material {
            youngs_modulus,
            density,
            damping_time,
        },
    );
    let piston = (log(0.01, 10.0), 1usize..16, signed(1e-3, 20.0)).prop_map(
        |(length, elements, initial_velocity)| Piston { length, elements, initial_velocity },
    );
    let bit = (log(0.01, 10.0), 1usize..16).prop_map(|(length, elements)| Bit { length, elements });
    (fidelity, material, log(1e-5, 1e-1), piston, bit)
}

fn rock() -> impl Strategy<Value = Rock> {
    let ratio = log(1e-6, 1e4).prop_map(|x| 1.0 + x);
    (
        log(1e5, 1e11),
        ratio,
        or_zero(1e1, 1e9),
        or_zero(1e-6, 1e6),
        or_zero(1e-6, 1.0),
        or_zero(1e-9, 1e-3),
    )
        .prop_map(|(stiffness, unloading_ratio, viscosity, energy_barrier, vs, dps)| Rock {
            stiffness,
            unloading_ratio,
            viscosity,
            energy_barrier,
            standstill_speed: vs,
            standstill_penetration: dps,
        })
}

fn drive() -> impl Strategy<Value = Drive> {
    let source = prop_oneof![3 => Just(Source::Relay), 1 => Just(Source::Force)];
    (source, or_zero(1.0, 1e5), log(1e-3, 1.0)).prop_map(|(source, amplitude, stroke)| Drive {
        source,
        amplitude,
        stroke,
        ..Parameters::default().drive
    })
}

prop_compose! {
    /// Any scene.
    pub fn draw()(
        (fidelity, material, cross_section, piston, bit) in bodies(),
        stiffness in log(1e7, 1e14),
        initial_gap in or_zero(1e-7, 0.3),
        rock in rock(),
        drive in drive(),
        gravity in signed(0.1, 20.0),
        feed_force in signed(1.0, 1e5),
        drive_force in signed(1.0, 1e5),
        duration in 1.0..30f64,
        cuts in prop::collection::vec(0.0..1f64, 1..6),
    ) -> Draw {
        let contact = Contact { stiffness, initial_gap };
        let parameters = Parameters {
            fidelity, material, cross_section, piston, bit, contact, rock, drive, gravity,
        };
        let inputs = InputValues { feed_force, drive_force, ..InputValues::default() };
        let mut cuts = cuts;
        cuts.sort_by(f64::total_cmp);
        Draw { parameters, inputs, duration, cuts }
    }
}

/// Samples a scene may take: each of its units is some radians of its fastest mode, the
/// mesh's or the penalty's, and the search takes a few samples a radian; a rattling
/// contact multiplies that by its events.
pub fn allowed(draw: &Draw) -> u64 {
    let p = &draw.parameters;
    let n = p.piston.elements.max(p.bit.elements) as f64;
    let nodal = p.material.density * p.cross_section * p.piston.length.min(p.bit.length) / n / 6.0;
    let mesh = 4.0 * n * p.wave_speed() / p.piston.length.min(p.bit.length);
    let springs = p.contact.stiffness.max(p.rock.unloading_ratio * p.rock.stiffness);
    let fastest = mesh + (springs / nodal).sqrt();
    20_000 + (40.0 * fastest * draw.end()) as u64
}

/// Signs, monotone losses, energy and work, looked at in forty slices.
///
/// # Errors
/// The first fault.
pub fn keeps_the_laws(draw: &Draw) -> Result<(), Fault> {
    let mut watched = Watched::new(&draw.parameters, &draw.inputs, allowed(draw))?;
    // A bit that negative feed stretches into the piston starts with energy in the contact
    // that the ledger does not count: no scene to balance (see the report's limits).
    if watched.machine.kinematics().contact_gap < 0.0 {
        return Ok(());
    }
    watched.look()?;
    match watched.run(draw.end(), 40) {
        Err(Fault::Engine(Error::Cascade { .. })) if too_small(&mut watched.machine) => Ok(()),
        other => other,
    }
}

/// A motion so small that the resolution of a guard is a part of it: there a cascade is an
/// honest answer.
fn too_small(m: &mut Machine) -> bool {
    let k = *m.kinematics();
    let way = k.piston_position.abs() + k.bit_position.abs();
    way < 1e6 * hammer::guard::DISPLACEMENT_RESOLUTION
}

fn advance(m: &mut Machine, end: f64, cuts: &[f64]) -> Result<(), Error> {
    for cut in cuts {
        m.advance(cut * end)?;
        // Looking must not disturb.
        m.kinematics();
        m.energies();
        m.peaks();
    }
    m.advance(end)
}

fn machine(draw: &Draw) -> Result<Machine, Error> {
    Machine::new(&draw.parameters, &draw.inputs, 0.0)
}

/// The state, bit for bit: also zeros' signs and all that a comparison of floats forgives.
///
/// # Panics
/// If a state cannot be serialised.
pub fn bits(m: &mut Machine) -> Vec<u8> {
    postcard::to_allocvec(&trajectory(m)).expect("a state is plain data")
}

/// Whether one step and many give the same state, bit for bit.
///
/// # Errors
/// Whatever the engine says.
pub fn slices_alike(draw: &Draw) -> Result<bool, Error> {
    let (mut one, mut many) = (machine(draw)?, machine(draw)?);
    one.advance(draw.end())?;
    advance(&mut many, draw.end(), &draw.cuts)?;
    Ok(bits(&mut one) == bits(&mut many))
}

/// Whether a state saved at a cut, written out and read back, continues bit for bit; into
/// a fresh machine, and into one that has gone on.
///
/// # Errors
/// Whatever the engine says.
///
/// # Panics
/// If a state cannot be written or read.
pub fn restores(draw: &Draw) -> Result<bool, Error> {
    let (mut m, end) = (machine(draw)?, draw.end());
    m.advance(draw.cuts[0] * end)?;
    let state = m.state();
    let json = serde_json::to_string(&state).expect("a state can be written");
    let read: State = serde_json::from_str(&json).expect("a state can be read");
    let packed = postcard::to_allocvec(&state).expect("a state can be packed");
    let unpacked: State = postcard::from_bytes(&packed).expect("a state can be unpacked");
    m.advance(end)?;
    let straight = bits(&mut m);
    let mut fresh = machine(draw)?;
    fresh.restore(&read)?;
    fresh.advance(end)?;
    m.restore(&unpacked)?;
    m.advance(end)?;
    Ok(bits(&mut fresh) == straight && bits(&mut m) == straight)
}

/// The scene with every mass, stiffness, viscosity, force and `WR` times `a`.
pub fn heavier(draw: &Draw, a: f64) -> Draw {
    let mut d = draw.clone();
    let p = &mut d.parameters;
    // Through the section: density and modulus keep the waves' speed.
    p.cross_section *= a;
    for x in [
        &mut p.contact.stiffness,
        &mut p.rock.stiffness,
        &mut p.rock.viscosity,
        &mut p.rock.energy_barrier,
        &mut p.drive.amplitude,
        &mut d.inputs.feed_force,
        &mut d.inputs.drive_force,
    ] {
        *x *= a;
    }
    d
}

/// The scene with every displacement, velocity and force times `b`, and `WR` times `b^2`.
pub fn larger(draw: &Draw, b: f64) -> Draw {
    let mut d = draw.clone();
    let p = &mut d.parameters;
    p.rock.energy_barrier *= b * b;
    for x in [
        &mut p.piston.initial_velocity,
        &mut p.contact.initial_gap,
        &mut p.rock.standstill_speed,
        &mut p.rock.standstill_penetration,
        &mut p.drive.amplitude,
        &mut p.drive.stroke,
        &mut p.gravity,
        &mut d.inputs.feed_force,
        &mut d.inputs.drive_force,
    ] {
        *x *= b;
    }
    d
}

/// Times, events and tip positions of two scenes that scale: the largest difference of the
/// tip's position at the cuts over its size, or none if the events differ.
///
/// # Errors
/// Whatever the engine says.
pub fn scaled_apart(draw: &Draw, other: &Draw, factor: f64) -> Result<Option<f64>, Error> {
    let (mut m, mut n) = (machine(draw)?, machine(other)?);
    m.keep_journal(true);
    n.keep_journal(true);
    let mut worst: f64 = 0.0;
    for cut in draw.cuts.iter().chain(&[1.0]) {
        m.advance(cut * draw.end())?;
        n.advance(cut * draw.end())?;
        let (x, y) = (*m.kinematics(), *n.kinematics());
        let size =
            x.piston_position.abs() + x.bit_position.abs() + draw.parameters.contact.initial_gap;
        for (u, v) in
            [(x.piston_position, y.piston_position), (x.bit_tip_position, y.bit_tip_position)]
        {
            if u != v / factor {
                worst = worst.max((u - v / factor).abs() / size);
            }
        }
    }
    let names =
        |m: &mut Machine| m.take_journal().iter().map(|r| (r.event, r.mode)).collect::<Vec<_>>();
    Ok((names(&mut m) == names(&mut n)).then_some(worst))
}

/// A property's name and its test on one drawn scene.
pub type Property = (&'static str, fn(&Draw) -> Result<(), String>);

/// All properties.
pub const PROPERTIES: [Property; 4] = [
    ("F_C and F_R never pull, uu and losses never fall, energy balances, work is bounded", |d| {
        keeps_the_laws(d).map_err(|fault| fault.to_string())
    }),
    ("the trajectory does not depend on communication points, bit for bit", |d| {
        told(slices_alike(d), "the states differ")
    }),
    ("a saved state, written out and read back, continues bit for bit", |d| {
        told(restores(d), "the states differ")
    }),
    ("masses, stiffnesses and forces times 4^k: the same motion, bit for bit", |d| {
        let a = 4f64.powi((d.cuts[0] * 12.0) as i32 - 6);
        told(scaled_apart(d, &heavier(d, a), 1.0).map(|x| x == Some(0.0)), "the motions differ")
    }),
];

/// A cascade is told by the first property; where it is, there is nothing to compare.
fn told(same: Result<bool, Error>, else_what: &str) -> Result<(), String> {
    match same {
        Ok(true) | Err(Error::Cascade { .. }) => Ok(()),
        Ok(false) => Err(else_what.into()),
        Err(error) => Err(error.to_string()),
    }
}

/// Draws `cases` scenes for a property, always the same ones.
///
/// # Errors
/// The smallest scene found that fails it.
pub fn check(property: &Property, cases: u32) -> Result<(), String> {
    use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(config, rng);
    runner
        .run(&draw(), |d| property.1(&d).map_err(TestCaseError::fail))
        .map_err(|failure| failure.to_string())
}
