//! Translates the engine's scenes and events into the oracles' own terms.

use hammer::Drill;
use hammer::{
    Body as Part, Chamber, Fidelity, InputValues, Mode, Parameters, Port, Record, Relay, Reloading,
    RockEvent, RockMode, Segment, Source, Tie, TieState,
};
use oracles::scene::{self, Body, RockLaw};
use oracles::{law, waves};

/// A body's sections, with the number of elements of each.
fn body(p: &Parameters, part: Part) -> Body {
    let (sections, total) = (p.sections(part), p.spans(part));
    let parts = sections.as_slice().iter().zip(sections.spans(total));
    let section =
        parts.map(|(s, elements)| scene::Section { length: s.length, area: s.area, elements });
    Body { sections: section.collect(), velocity: 0.0 }
}

/// The bodies of a drill string with loose joints, which are divided where its rods' faces meet, in the middle of the
/// sleeves.
fn string(p: &Parameters) -> Vec<Body> {
    let Drill { rods, shank, rod, coupling, .. } = p.drill;
    let shorter = |part: Segment, by: f64| Segment { length: part.length - by, ..part };
    let half = Segment { length: 0.5 * coupling.length, ..coupling };
    let mut bodies = vec![vec![half, shorter(rod, coupling.length), half]; rods + 1];
    bodies[0] = vec![shorter(shank, half.length), half];
    bodies[rods] = vec![half, shorter(rod, half.length)];
    if p.bit.segments.is_empty() {
        bodies[rods].push(Segment { length: p.bit.length, area: p.cross_section });
    }
    bodies[rods].extend(&p.bit.segments[..]);
    // One mesh, which is divided among the bodies.
    let mut elements = p.sections(Part::Bit).spans(p.spans(Part::Bit)).into_iter();
    let mut section = |s: &Segment| {
        let elements = elements.next()?;
        Some(scene::Section { length: s.length, area: s.area, elements })
    };
    let body = |parts: Vec<Segment>| Body {
        sections: parts.iter().filter(|s| s.length > 0.0).filter_map(&mut section).collect(),
        velocity: 0.0,
    };
    bodies.into_iter().map(body).collect()
}

/// True if rods are joined loosely.
pub fn is_loose(p: &Parameters) -> bool {
    p.drill.rods > 0 && p.drill.joint.stiffness > 0.0
}

/// The finite element model of a scene.
pub fn finite_elements(p: &Parameters, inputs: &InputValues) -> scene::Scene {
    let mut bodies = vec![body(p, Part::Piston)];
    bodies.extend(if is_loose(p) { string(p) } else { vec![body(p, Part::Bit)] });
    bodies[0].velocity = p.piston.initial_velocity;
    let fidelity = match p.fidelity {
        Fidelity::Rigid => scene::Fidelity::Rigid,
        Fidelity::Elastic if p.mesh.degree == 1 => scene::Fidelity::Elastic,
        Fidelity::Elastic => scene::Fidelity::Spline(p.mesh.degree),
    };
    let uniform = p.piston.segments.is_empty() && p.bit.segments.is_empty();
    let contact_stiffness = if p.fidelity == Fidelity::Rigid && uniform {
        let stretch = p.material.youngs_modulus * p.cross_section;
        let lengths = [p.piston.length, p.bit.length];
        scene::rigid_meeting(p.contact.stiffness, stretch, lengths)
    } else {
        // For stepped rigid bodies, the engine's own value.
        p.meeting_stiffness()
    };
    scene::Scene {
        fidelity,
        youngs_modulus: p.material.youngs_modulus,
        density: p.material.density,
        damping_time: p.material.damping_time,
        bodies,
        coupling: match is_loose(p) {
            true => {
                scene::Coupling { stiffness: p.drill.joint.stiffness, slack: p.drill.joint.slack }
            }
            false => scene::Coupling::default(),
        },
        contact_stiffness,
        gap: p.contact.initial_gap,
        rock: rock_law(p),
        drive: match p.drive.source {
            Source::Air => scene::Drive::Air(air(p, inputs)),
            Source::Force => scene::Drive::Force,
            Source::Pressure => {
                scene::Drive::Pressure { areas: [p.drive.area_drive, p.drive.area_return] }
            }
            _ => scene::Drive::Relay { amplitude: p.drive.amplitude, stroke: p.drive.stroke },
        },
        anvil_area: match p.drive.source {
            Source::Air => p.drive.area_return,
            _ => p.drive.anvil_area,
        },
        impedance: p.drive.impedance,
        gravity: p.gravity,
        inputs: [
            inputs.feed_force,
            inputs.drive_force,
            inputs.drive_pressure,
            inputs.return_pressure,
        ],
        casing: p.has_casing().then_some(scene::Casing {
            mass: p.casing.mass,
            sections: if p.casing.segments.is_empty() {
                Vec::new()
            } else {
                body(p, Part::Casing).sections
            },
            impedance: p.casing.impedance,
            stiffness: p.chuck.stiffness,
            viscosity: p.chuck.viscosity,
            travel: p.chuck.travel,
            idle_travel: p.chuck.idle_travel,
        }),
        resolutions: p.resolutions(),
    }
}

fn air(p: &Parameters, inputs: &InputValues) -> scene::AirLaw {
    let law = &p.air;
    let chambers = [law.drive, law.returning];
    scene::AirLaw {
        areas: [p.drive.area_drive, p.drive.area_return],
        dead_volumes: chambers.map(|chamber| chamber.dead_volume),
        cylinder: law.cylinder,
        edges: chambers.map(|chamber| [chamber.supply, chamber.exhaust]),
        height: law.port_height,
        ports: [law.supply_area, law.exhaust_area],
        discharge: law.discharge,
        leakage: law.leakage_area,
        drag: law.drag,
        temperature: law.temperature,
        outside: [inputs.supply_pressure, inputs.exhaust_pressure],
        error: law.error,
        off: [0.0; 2],
    }
}

/// The rock's parameters.
pub fn rock_law(p: &Parameters) -> RockLaw {
    RockLaw {
        stiffness: p.rock.stiffness,
        ratio: p.rock.unloading_ratio,
        viscosity: p.rock.viscosity,
        barrier: p.rock.energy_barrier,
        standstill_speed: p.rock.standstill_speed,
        standstill_penetration: p.rock.standstill_penetration,
        reloads: p.rock.reloading == Reloading::Unloading,
    }
}

/// The continuum of a scene driven by its relay.
pub fn continuum(p: &Parameters, inputs: &InputValues) -> waves::Scene {
    let speed = p.wave_speed();
    let section = |s: &Segment| waves::Section {
        impedance: p.impedance_of(s.area),
        transit: s.length / speed,
    };
    waves::Scene {
        bodies: Part::ALL.map(|part| p.sections(part).as_slice().iter().map(section).collect()),
        damping: p.material.damping_time,
        penalty: p.contact.stiffness,
        stiffness: p.rock.stiffness,
        ratio: p.rock.unloading_ratio,
        viscosity: p.rock.viscosity,
        barrier: p.rock.energy_barrier,
        standstill: [p.rock.standstill_speed, p.rock.standstill_penetration],
        drive: [p.drive.amplitude, p.drive.stroke],
        feed: inputs.feed_force,
        gravity: p.gravity,
        gap: p.contact.initial_gap,
        speed: [p.piston.initial_velocity, 0.0],
    }
}

/// The same continuum undamped and with rigid faces.
pub fn sharp(p: &Parameters, inputs: &InputValues) -> waves::Scene {
    waves::Scene { damping: 0.0, penalty: f64::INFINITY, ..continuum(p, inputs) }
}

/// Translates a mode of the engine.
pub fn mode(p: &Parameters, mode: Mode) -> law::Mode {
    let rock = match mode.rock {
        RockMode::FreeFlight => law::Rock::FF,
        RockMode::DissipativeForward => law::Rock::DFC,
        RockMode::Forward => law::Rock::FC,
        RockMode::Backward => law::Rock::BC,
        RockMode::Standstill => law::Rock::SS,
    };
    law::Mode {
        closed: mode.closed(),
        rock,
        down: mode.relay == Relay::Drive,
        joints: joints(p, mode),
        vented: mode.vented,
    }
}

fn side(state: TieState) -> law::Side {
    match state {
        TieState::Open => law::Side::Open,
        TieState::Pressed => law::Side::Pressed,
        TieState::Pulled => law::Side::Pulled,
    }
}

fn joints(p: &Parameters, mode: Mode) -> [law::Side; law::MAX_JOINTS] {
    let rods = if is_loose(p) { p.drill.rods } else { 0 };
    let mut joints = [law::Side::Open; law::MAX_JOINTS];
    let chuck = p.has_casing().then_some(Tie::Chuck);
    let ties = chuck.into_iter().chain((0..).map(Tie::Joint).take(rods));
    joints.iter_mut().zip(ties).for_each(|(own, tie)| *own = side(mode.ties.of(tie)));
    joints
}

fn place(chamber: Chamber) -> usize {
    match chamber {
        Chamber::Drive => 0,
        Chamber::Return => 1,
    }
}

/// Translates an event of the engine's journal.
pub fn event(record: &Record, cased: bool) -> law::Event {
    use law::Event;
    match record.event {
        hammer::Event::CLOSING => Event::Close,
        hammer::Event::OPENING => Event::Open,
        hammer::Event::Relay(Relay::Return) => Event::Q9,
        hammer::Event::Relay(Relay::Drive) => Event::Q10,
        hammer::Event::Port { chamber, port, opens } => {
            Event::Port(place(chamber), usize::from(port == Port::Exhaust), opens)
        }
        hammer::Event::Opening { chamber, port, full } => {
            Event::Whole(place(chamber), usize::from(port == Port::Exhaust), full)
        }
        hammer::Event::End(inside) => Event::End(inside),
        hammer::Event::Tie(Tie::Joint(joint), to) => {
            Event::Joint(usize::from(joint) + usize::from(cased), side(to))
        }
        hammer::Event::Tie(_, to) => Event::Joint(0, side(to)),
        hammer::Event::Vent(vented) => Event::Vent(vented),
        other => rock_event(other),
    }
}

fn rock_event(event: hammer::Event) -> law::Event {
    use law::Event;
    let hammer::Event::Rock(event) = event else { unreachable!("{event} is never drawn") };
    match event {
        RockEvent::Touch => Event::Q1,
        RockEvent::DissipativeTurn => Event::Q2,
        RockEvent::Barrier => Event::Q3,
        RockEvent::Turn => Event::Q4,
        RockEvent::LiftOff => Event::Q5,
        RockEvent::Return => Event::Q6,
        RockEvent::Restart => Event::Q7,
        RockEvent::Retreat => Event::Q8,
        RockEvent::StandstillLiftOff => Event::LiftOff,
    }
}
