//! Scenes drawn over the whole domain, log-uniformly.

use crate::comparison::bodies;
use crate::drawn::actions::{Action, Actions, actions};
use crate::drawn::air::{air, set_air};
use crate::drawn::draws::{log, or_zero, signed};
use hammer::{
    Bit, Casing, ChuckLaw, Contact, Drill, Drive, FASTEST_WAVE, Joint, MAX_DEGREE, Material, Mesh,
    Piston, Rock, SOFTEST_JOINT,
};
use hammer::{
    Error, Fidelity, InputValues, MAX_SEGMENTS, Machine, Parameters, Reloading, Segment, Segments,
    Source,
};
use proptest::prelude::*;
use serde::{Deserialize, Serialize};

/// A drawn scene, its duration, and its communication points.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RandomScene {
    /// Parameters.
    pub parameters: Parameters,
    /// Inputs.
    pub inputs: InputValues,
    /// Duration, in units of [`RandomScene::unit`].
    pub duration: f64,
    /// Communication points, as shares of the duration.
    pub cuts: Vec<f64>,
    /// Actions on it.
    #[serde(default)]
    pub actions: Actions,
}

impl RandomScene {
    /// A scene without actions, over this time, s.
    pub fn alone(parameters: Parameters, inputs: InputValues, duration: f64) -> Self {
        let actions = Actions::default();
        let case = Self { parameters, inputs, duration: 1.0, cuts: Vec::new(), actions };
        Self { duration: duration / case.unit(), ..case }
    }

    /// Largest force of the drive on the piston, and on the bit, without actions, N.
    fn pushes(&self) -> [f64; 2] {
        let (p, i) = (&self.parameters, &self.inputs);
        match p.drive.source {
            Source::Pressure => {
                let [down, up] = [i.drive_pressure, i.return_pressure];
                let push = down * p.drive.area_drive - up * p.drive.area_return;
                [push.abs(), (up * p.drive.anvil_area).abs()]
            }
            Source::Air => {
                let most = i.supply_pressure.max(i.exhaust_pressure);
                let [down, up] = [p.drive.area_drive, p.drive.area_return].map(|area| most * area);
                [down.max(up), up]
            }
            _ => [p.drive.amplitude.max(i.drive_force.abs()), 0.0],
        }
    }

    /// Largest force on the piston, and on the bit, approximately, N.
    pub fn loads(&self) -> [f64; 2] {
        let [drive, anvil] = self.pushes();
        let done = self.actions.force(&self.parameters);
        [drive + done, anvil + self.inputs.feed_force.abs() + done]
    }

    /// The longer of a wave's transit of both bars and back, and a hundredth of the time to the first blow. A scene
    /// lasts tens of these.
    pub fn unit(&self) -> f64 {
        let p = &self.parameters;
        let scales = p.timescales();
        let waves = 2.0 * (scales.piston_transit + scales.bit_transit);
        let push = self.loads()[0] / p.piston_mass();
        let fall = (2.0 * p.contact.initial_gap / (push + p.gravity.abs() + 1e-3)).sqrt();
        let flight = fall.min(p.contact.initial_gap / p.piston.initial_velocity.abs().max(1e-3));
        waves + 0.02 * flight
    }

    /// The same scene, lasting no longer than `span`, s.
    pub fn within(&self, span: f64) -> Self {
        let short = span / self.unit();
        Self { duration: self.duration.min(short), ..self.clone() }
    }

    /// End of the run, s: no body moves a metre, beyond which the rounding of a position comes near the resolution of
    /// a guard.
    pub fn end(&self) -> f64 {
        let p = &self.parameters;
        let [drive, feed] = self.loads();
        let casing = if p.has_casing() { p.casing_mass() } else { f64::INFINITY };
        let lightest = p.piston_mass().min(p.bit_mass()).min(casing);
        let push = (drive + feed) / lightest + p.gravity.abs();
        let metre = (2.0 / push).sqrt().min(1.0 / p.piston.initial_velocity.abs());
        (self.duration * self.unit()).min(metre)
    }

    /// The actions with their instants, s.
    ///
    /// # Errors
    /// See [`Actions::schedule`].
    pub fn schedule(&self) -> Result<Vec<(f64, Action)>, Error> {
        self.actions.schedule(&self.parameters, &self.inputs, self.end())
    }
}

fn bodies() -> impl Strategy<Value = (Fidelity, Material, f64, Piston, Bit)> {
    let fidelity = prop_oneof![1 => Just(Fidelity::Rigid), 3 => Just(Fidelity::Elastic)];
    let material = (log(1e9, 1e12), log(1e3, 2e4), or_zero(1e-11, 1e-4)).prop_map(
        |(youngs_modulus, density, damping_time)| Material {
            // Waves in solids are not faster.
            youngs_modulus: youngs_modulus.min(FASTEST_WAVE * FASTEST_WAVE * density),
            density,
            damping_time,
        },
    );
    let piston = (log(0.01, 10.0), 1usize..16, signed(1e-3, 20.0)).prop_map(
        |(length, elements, initial_velocity)| Piston {
            length,
            elements,
            initial_velocity,
            ..Parameters::default().piston
        },
    );
    let bit = (log(0.01, 10.0), 1usize..16).prop_map(|(length, elements)| Bit {
        length,
        elements,
        ..Parameters::default().bit
    });
    (fidelity, material, log(1e-5, 1e-1), piston, bit)
}

/// Number of a body's sections, zero half of the time; shares of its length, and ratios of its areas to the uniform
/// one: steps of up to a hundred, sections of any shortness.
type Steps = (usize, [[f64; 2]; MAX_SEGMENTS]);

fn steps() -> impl Strategy<Value = Steps> + Clone {
    let count = prop_oneof![1 => Just(0usize), 1 => 1..=MAX_SEGMENTS];
    let section = (log(0.01, 1.0), log(0.1, 10.0)).prop_map(|(share, ratio)| [share, ratio]);
    (count, prop::collection::vec(section, MAX_SEGMENTS)).prop_map(|(count, list)| {
        let total: f64 = list[..count].iter().map(|[share, _]| share).sum();
        let scaled = |k: usize| [list[k][0] / total.max(0.01), list[k][1]];
        (count, std::array::from_fn(scaled))
    })
}

/// The sections of a body of this length and area.
fn sections((count, list): Steps, length: f64, area: f64) -> Segments {
    let mut segments = Parameters::default().piston.segments;
    segments
        .set(&list.map(|[share, ratio]| Segment { length: share * length, area: ratio * area }));
    segments.set_count(count);
    segments
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
            ..Parameters::default().rock
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
    /// Any scene of piston and bit on any mesh, half of which are of splines.
    pub fn meshed()(
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
        degree in prop_oneof![3 => Just(1), 1 => Just(3), 2 => 2..=MAX_DEGREE],
        steps in [steps(), steps()],
    ) -> RandomScene {
        let (mut piston, mut bit) = (piston, bit);
        piston.segments = sections(steps[0], piston.length, cross_section);
        bit.segments = sections(steps[1], bit.length, cross_section);
        let mesh = Mesh { degree };
        let contact = Contact { stiffness, initial_gap };
        let parameters = Parameters {
            fidelity, material, cross_section, mesh, piston, bit, contact, rock, drive, gravity,
            ..Parameters::default()
        };
        // At the start a lifted bit is stretched by a hundredth at most, beyond which no bar is elastic.
        let length = parameters.piston.length + parameters.bit.length;
        let most = length.min(100.0) / (100.0 * bodies::compliance(&parameters));
        let feed_force = feed_force.clamp(-most, most);
        let inputs = InputValues { feed_force, drive_force, ..InputValues::default() };
        let mut cuts = cuts;
        cuts.sort_by(f64::total_cmp);
        RandomScene { parameters, inputs, duration, cuts, actions: Actions::default() }
    }
}

/// A casing: its mass over the bit's, and its string; the chuck, with the idle travel over its travel; and, if it is
/// elastic, sections, length and elements.
type CasingRow = ((f64, f64), (f64, f64, f64, f64), Option<(Steps, f64, usize)>);

fn casing() -> impl Strategy<Value = CasingRow> {
    let body = (log(0.3, 100.0), or_zero(1e2, 1e6));
    let idle = prop_oneof![1 => Just(0.0), 2 => log(0.01, 0.99)];
    let chuck = (log(1e7, 1e11), or_zero(1.0, 1e5), log(1e-4, 0.05), idle);
    let bar = prop::option::of((steps(), log(0.01, 10.0), 1usize..16));
    (body, chuck, bar)
}

/// The length of an elastic casing is limited by the strain of its `load`, N, to a thousandth: a very thin casing
/// would be compressed by more than its length, and its start would have no digits.
fn set_casing(p: &mut Parameters, load: f64, ((ratio, impedance), chuck, bar): CasingRow) {
    let (stiffness, viscosity, travel, idle) = chuck;
    p.casing = Casing { mass: ratio * p.bit_mass(), ..p.casing };
    p.chuck = ChuckLaw { stiffness, viscosity, travel, idle_travel: idle * travel };
    let load = load + p.casing.mass * p.gravity.abs();
    let longest =
        1e-3 * p.material.youngs_modulus * p.casing.mass / (p.material.density * load.max(1.0));
    if let Some((mut steps, length, elements)) = bar.filter(|_| longest > 0.01) {
        let length = length.min(longest);
        steps.0 = steps.0.max(1);
        p.casing.segments = sections(steps, length, 1.0);
        p.casing.elements = elements;
        let unit = p.casing_mass();
        p.casing.segments.iter_mut().for_each(|part| part.area *= p.casing.mass / unit);
    }
    // A weaker string is refused.
    let least = 10.0 * p.casing_mass().max(p.casing.mass);
    p.casing.impedance = if impedance > 0.0 { impedance.max(least) } else { 0.0 };
}

/// A drill string of loose joints: number of rods, length and ratio of areas of each part, joint.
type StringRow = (usize, [(f64, f64); 3], (f64, f64));

fn string() -> impl Strategy<Value = StringRow> {
    let part = |low, high| (log(low, high), log(0.3, 3.0));
    let parts = [part(0.05, 2.0), part(0.1, 4.0)];
    let sleeve = (or_zero(0.1, 0.9), log(0.5, 5.0));
    let [shank, rod] = parts;
    (1usize..5, (shank, rod, sleeve), (log(1e8, 1e11), or_zero(1e-7, 1e-3)))
        .prop_map(|(rods, (shank, rod, sleeve), joint)| (rods, [shank, rod, sleeve], joint))
}

/// The mesh is as coarse as the engine allows, and no section is very short. The wave of a short piston would need a
/// fine mesh, so a short piston is lengthened.
fn set_string(p: &mut Parameters, (rods, parts, (stiffness, slack)): StringRow) {
    p.fidelity = Fidelity::Elastic;
    let part = |(length, ratio): (f64, f64)| Segment { length, area: ratio * p.cross_section };
    let [shank, rod, mut coupling] = parts.map(part);
    coupling.length *= rod.length.min(2.0 * shank.length);
    // A softer joint is refused.
    let softest = 1.001 * SOFTEST_JOINT * p.material.youngs_modulus * rod.area / rod.length;
    let stiffness = stiffness.max(softest);
    p.drill = Drill { rods, shank, rod, coupling, joint: Joint { stiffness, slack } };
    coarsen(p);
}

/// Surroundings of piston and bit: nothing, a casing, a drill string of loose joints, or both.
fn around() -> impl Strategy<Value = (Option<CasingRow>, Option<StringRow>)> {
    prop_oneof![
        3 => Just((None, None)),
        4 => casing().prop_map(|casing| (Some(casing), None)),
        2 => string().prop_map(|string| (None, Some(string))),
        2 => (casing(), string()).prop_map(|(casing, string)| (Some(casing), Some(string))),
    ]
}

/// Largest surplus of the feed that holds a casing or a string down, N.
const MOST_HELD: f64 = 2e4;

/// Any scene, with everything at once: any drive, rock with either way of reloading, a casing, a drill string, and
/// actions.
///
/// The feed holds a casing or a string down, with a surplus from a newton to 20 kN. One casing in four has any feed,
/// and begins lifted if that is too small. Rock with reloading along the unloading line is not retuned: a bit at rest
/// has the very force at which a drilling cycle begins, so retuning would begin a cycle at zero speed, and rounding
/// would decide what follows.
pub fn mixed() -> impl Strategy<Value = RandomScene> {
    mixed_by(vec![Source::Relay, Source::Force, Source::Pressure, Source::Air])
}

/// Mixed scenes driven by air.
pub fn airy() -> impl Strategy<Value = RandomScene> {
    mixed_by(vec![Source::Air])
}

/// Mixed scenes with a line at the piston, of up to a tenth of the largest impedance, ten times that of a real hose.
pub fn lined() -> impl Strategy<Value = RandomScene> {
    let drives = mixed_by(vec![Source::Relay, Source::Force, Source::Pressure]);
    (drives, log(1e-4, 0.1)).prop_map(|(mut case, part)| {
        case.parameters.drive.impedance = part * case.parameters.most_impedance();
        case
    })
}

/// How long the second blow of a drawn hammer is awaited, s.
const AWAITED: f64 = 0.2;

/// Hammers that strike twice: rigid, or of one or two elements, each number of drive and rock within a factor of three
/// of the reference's. A scene ends a fiftieth after the second blow.
pub fn striking() -> impl Strategy<Value = RandomScene> {
    let bodies = (0usize..3, log(0.3, 3.0), log(0.3, 3.0));
    let drive = (log(0.3, 3.0), log(0.3, 3.0), log(0.3, 3.0));
    let rock = (log(0.3, 3.0), log(0.3, 3.0), or_zero(0.3, 3.0), log(0.3, 3.0));
    (bodies, drive, rock).prop_filter_map("no second blow", |(bodies, drive, rock)| {
        let (mut p, mut inputs) = (Parameters::default(), InputValues::default());
        p.mesh.degree = 1;
        (p.piston.elements, p.bit.elements) = (bodies.0.max(1), bodies.0.max(1));
        p.fidelity = if bodies.0 == 0 { Fidelity::Rigid } else { Fidelity::Elastic };
        (p.piston.length, p.bit.length) = (p.piston.length * bodies.1, p.bit.length * bodies.2);
        (p.drive.amplitude, p.drive.stroke) =
            (p.drive.amplitude * drive.0, p.drive.stroke * drive.1);
        inputs.feed_force *= drive.2;
        p.rock.stiffness *= rock.0;
        p.rock.viscosity *= rock.1;
        p.rock.energy_barrier *= rock.2;
        p.rock.unloading_ratio = 1.0 + (p.rock.unloading_ratio - 1.0) * rock.3;
        let mut machine = Machine::new(&p, &inputs, 0.0).ok()?;
        while machine.counters().blows < 2 && machine.time() < AWAITED {
            machine.advance(machine.time() + 1e-3).ok()?;
        }
        let second = (machine.counters().blows == 2).then(|| machine.blow().copied())??;
        Some(RandomScene::alone(p, inputs, 1.02 * second.time))
    })
}

fn mixed_by(sources: Vec<Source>) -> impl Strategy<Value = RandomScene> {
    let source = prop::sample::select(sources);
    let pressures = (signed(1e3, 1e8), signed(1e3, 1e8));
    let areas = (or_zero(1e-5, 1e-1), or_zero(1e-5, 1e-1), or_zero(1e-5, 1e-1));
    let strike = prop::option::weighted(0.8, (log(0.1, 20.0), or_zero(1e-3, 0.5)));
    let held = prop::option::weighted(0.75, log(1.0, MOST_HELD));
    let drive = (source, pressures, areas);
    let reloads = prop::bool::weighted(0.25);
    (meshed(), drive, reloads, around(), strike, (held, air())).prop_flat_map(
        |(mut case, (source, pressures, areas), reloads, (casing, string), strike, last)| {
            let (held, air) = last;
            let air = (source == Source::Air).then_some(air);
            let p = &mut case.parameters;
            // Air is added when the bodies are known.
            p.drive.source = if air.is_some() { Source::Force } else { source };
            (p.drive.area_drive, p.drive.area_return, p.drive.anvil_area) = areas;
            (case.inputs.drive_pressure, case.inputs.return_pressure) = pressures;
            if reloads {
                p.rock.reloading = Reloading::Unloading;
            }
            if let Some(string) = string {
                set_string(&mut case.parameters, string);
                let waves = case.unit();
                if let Some((speed, part)) = strike {
                    case.parameters.piston.initial_velocity = speed;
                    case.parameters.contact.initial_gap = part * waves * speed;
                }
            }
            if let Some(air) = air {
                set_air((&mut case.parameters, &mut case.inputs), air, string.is_some(), MOST_HELD);
            }
            let (cased, loose) = (casing.is_some(), string.is_some());
            if let Some(casing) = casing {
                let load = case.loads()[0] + MOST_HELD;
                set_casing(&mut case.parameters, load, casing);
            }
            let (p, [push, anvil]) = (&case.parameters, case.pushes());
            let lifted = (-p.gravity * p.bit_mass()).max(0.0) + anvil;
            let held = held.or(loose.then_some(1e3));
            case.inputs.feed_force = match held {
                Some(held) if cased => push - p.casing_mass() * p.gravity + lifted + held,
                Some(held) if loose => lifted + held,
                _ => case.inputs.feed_force,
            };
            let unit = case.unit();
            actions(source, unit).prop_map(move |mut actions| {
                if reloads {
                    actions.list.retain(|(_, action)| !matches!(action, Action::Retune(_)));
                    actions.at_event = None;
                }
                RandomScene { actions, ..case.clone() }
            })
        },
    )
}

/// Removes very short sections from a drawn drill string, and reduces its spans to the engine's least number.
fn coarsen(p: &mut Parameters) {
    let (piston, bit) = (&mut p.piston, &mut p.bit);
    for (list, length) in [(&mut piston.segments, piston.length), (&mut bit.segments, bit.length)] {
        list.iter_mut().for_each(|part| part.length = part.length.max(0.1 * length));
    }
    p.bit.elements = 1;
    while p.validate().is_err() {
        if p.bit.elements < MOST_ELEMENTS {
            p.bit.elements += 1;
        } else {
            p.bit.elements = 1;
            p.piston.length *= 1.5;
            p.piston.segments.iter_mut().for_each(|part| part.length *= 1.5);
            // A piston that is refused for another reason would be lengthened for ever.
            assert!(p.piston.length < 1e6, "{:?}", p.validate());
        }
    }
}

/// Most elements of a drawn drill string, since the reference's time grows with them.
const MOST_ELEMENTS: usize = 40;
