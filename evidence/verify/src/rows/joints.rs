//! Waves and momentum at a loose joint of a drill string, in closed form.

use crate::rows::mesh;
use crate::rows::row::{Row, Rows};
use hammer::{Drill, Joint};
use hammer::{Error, Event, Input, Machine, Parameters, Segment, Source, Tie, TieState};
use oracles::joint::{Loose, trapped};
use std::f64::consts::PI;

const AREA: f64 = 1.4e-3;

/// A free piston, a shank, and one rod that ends in 0.5 m of bit, all of one section, on very soft rock, with spans
/// of `h`.
fn bars([piston, shank, rod]: [f64; 3], joint: Joint, h: f64) -> Parameters {
    let mut p = mesh::bare(1);
    let part = |length| Segment { length, area: AREA };
    let coupling = Segment { length: 0.0, area: AREA };
    p.drill = Drill { rods: 1, shank: part(shank), rod: part(rod - 0.5), coupling, joint };
    p.piston.segments.set(&[part(piston)]);
    p.bit.segments.set(&[part(0.5)]);
    (p.mesh.degree, p.drive.source, p.rock.stiffness) = (5, Source::Force, 1.0);
    p.piston.elements = (piston / h) as usize;
    p.bit.elements = ((shank + rod) / h) as usize;
    p
}

/// Instant of the last event of this kind, s.
fn last(m: &mut Machine, event: Event) -> f64 {
    let journal = m.take_journal();
    journal.iter().rfind(|record| record.event == event).map_or(f64::NAN, |record| record.time)
}

/// Rate of the wave's force over time squared, N/s2.
const RATE: f64 = 4e12;
/// Spans of the mesh for waves, m.
const FINE: f64 = 0.01;
const KINKS: &str = "what is faster than w = 2 c/h, which quintic splines carry: of a jump of the force's second derivative its part 1/w^2, and of the faces' place twice that over Z w; of its kink where the joint closes, 1/(pi w) of the change of slope; damping makes t^2 of the wave t^2 + beta t0 on its way of t0";

/// A wave at a joint that is open by half its slack, which a wave of compression closes or a wave of tension opens
/// until the thread pulls. Before that it is fully reflected. A joint without slack only yields.
///
/// # Errors
/// Those of the engine.
pub fn waves() -> Result<Vec<Row>, Error> {
    let (stiffness, pulse, opened) = (1.2e9, 1.2e-4, 0.5e-4);
    let mut list = Vec::new();
    for (what, slack, to, way, sign) in [
        ("a joint is pressed", 1e-4, TieState::Pressed, opened, 1.0),
        ("a joint pulls", 1e-4, TieState::Pulled, 1e-4, -1.0),
        ("a joint without slack", 0.0, TieState::Pulled, 0.0, -1.0),
    ] {
        let mut p = bars([1.0, 1.2, 1.2], Joint { stiffness, slack }, FINE);
        (p.contact.initial_gap, p.piston.initial_velocity) = (1.0, 0.0);
        p.material.damping_time = 2e-9;
        let (z, c) = (p.impedance_of(AREA), p.wave_speed());
        let joint = Loose { impedance: z, stiffness };
        // The pull is -top 16 (t (T - t)/T^2)^2, whose integral is -8/15 T top.
        let fourth = 16.0 / f64::powi(pulse, 4) * 0.5 * opened * z / (8.0 / 15.0 * pulse);
        let pull = [0.0, 0.0, -2.0 * pulse * pulse, 12.0 * pulse, -24.0].map(|x| fourth * x);
        let mut m = Machine::new(&p, &mesh::no_inputs(), 0.0)?;
        m.keep_journal(true);
        let from = if to == TieState::Pressed { pulse } else { 0.0 };
        if from > 0.0 {
            m.set_input(Input::FeedForce, &pull)?;
            m.advance(from)?;
        }
        m.set_input(Input::FeedForce, &[0.0, 0.0, sign * 2.0 * RATE])?;
        // The middle of a span of the rod, 0.5 m and a half span below the joint.
        let (span, arrival) = (((1.2 + 0.5) / FINE).round() as usize, 1.2 / c);
        let below = (0.5 + 0.5 * FINE) / c;
        let closing = joint.closing(RATE, way);
        let (fastest, speed) = (2.0 * c / FINE, 2.0 * RATE * closing * closing / z);
        let bent = 2.0 * RATE + if from > 0.0 { 2.0 * pull[2].abs() } else { 0.0 };
        let spread = p.material.damping_time * (arrival + below);
        let late = (2.0 * bent / z / fastest.powi(3) + 2.0 / z * RATE * spread * closing) / speed;
        let kink = RATE * closing * closing / joint.delay() / (PI * fastest)
            + bent / fastest.powi(2)
            + RATE * spread;
        let mut rows = Rows::new(what, "characteristics", KINKS);
        for delays in [-1.0, 1.0, 2.5, 4.0] {
            let since = closing + delays * joint.delay();
            m.advance(from + arrival + below + since)?;
            let force = -sign * m.profile().bit_stress[span] * AREA;
            let quantity = format!("force below it {delays} tau after, N");
            rows.add(quantity, joint.passed(RATE, since, closing), force, kink);
        }
        if slack > 0.0 {
            let closed = last(&mut m, Event::Tie(Tie::Joint(0), to));
            rows.add("when it closes, s", from + arrival + closing, closed, late);
        }
        list.append(&mut rows.list);
    }
    Ok(list)
}

const TAIL: &str = "contact and joint, of 1e-5 s both, are late in the pulse by (1 + x + x^2/2) exp(-x) of it, x = 20 since its end; and rounding";

/// The pulse of a blow comes back from the free end as tension. The slack leaves its share of the momentum in the
/// rod, and the rest goes up into the shank.
///
/// # Errors
/// Those of the engine.
pub fn momentum_trapped() -> Result<Vec<Row>, Error> {
    let mut list = Vec::new();
    for slack in [0.0, 4e-4, 1e-2] {
        let z = Parameters::default().impedance_of(AREA);
        let stiffness = 0.5 * z / 1e-5;
        let mut p = bars([0.25, 2.0, 1.0], Joint { stiffness, slack }, 2.0 * FINE);
        (p.contact.stiffness, p.material.damping_time) = (stiffness, 1e-7);
        let mut m = Machine::new(&p, &mesh::no_inputs(), 0.0)?;
        // The time to the free end and back, and two transits of the piston.
        m.advance(mesh::strike() + (2.0 + 2.0 + 0.5) / p.wave_speed() + 20e-5)?;
        let k = m.kinematics();
        let masses = [0.25, 2.0, 1.0].map(|length| p.material.density * AREA * length);
        let speeds = [k.piston.velocity, k.piston.velocity - k.relative.velocity];
        let [piston, shank] = [masses[0] * speeds[0], masses[1] * speeds[1]];
        let rod = (masses[1] + masses[2]) * k.bit.velocity - shank;
        let given = masses[0] * mesh::SPEED - piston;
        let remaining = trapped(given, z, slack);
        let mut rows = Rows::new(format!("slack {slack:e} m"), "characteristics", TAIL);
        rows.add("momentum of the rod after the pulse, N s", remaining, rod, 1e-6 * given);
        rows.add("momentum of the shank, N s", given - remaining, shank, 1e-6 * given);
        list.append(&mut rows.list);
    }
    Ok(list)
}
