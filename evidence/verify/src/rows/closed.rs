//! Closed forms 1 to 4: two bars, a bar on a spring, one pulse, one blow.

use crate::rows::mesh::{self, SPEED};
use crate::rows::row::{Row, Rows};
use hammer::{Error, Machine, Parameters};
use oracles::closed::{BAR_ON_SPRING, BLOWS, pulse as pulse_efficiency, two_bars as bars};
use oracles::waves::{Scene, Waves};

const FRONT: &str = "front spread (c t h2/8)^(1/3) by dispersion, plus Z/(2 KC); force: its steepest rate times that";
/// Elements per bar of length `Lp`, for the engine's rows.
const ELEMENTS: usize = 80;
/// Steps of the exact waves in one transit.
const STEPS: u32 = 1000;

/// The engine's results of a blow, in units of `Lp`, `c0`, `Z` and the impact speed.
#[derive(Clone, Copy, Debug)]
pub struct Struck {
    /// `eta`: energy kept by the rock over the piston's.
    pub share: f64,
    /// Largest rock force.
    pub peak: f64,
    /// Largest contact force.
    pub contact_peak: f64,
    /// Mean velocity of the piston at the end.
    pub piston: f64,
    /// Mean velocity of the bit at the end.
    pub bit: f64,
    /// Time from the first closing to the start of the longest flight.
    pub first: f64,
    /// End of the longest flight.
    pub second: f64,
    /// Impulse of the contact.
    pub impulse: f64,
}

/// Simulates a bare scene for `until` transits after the impact.
pub fn strike(p: &Parameters, until: f64) -> Result<Struck, Error> {
    let mut m = Machine::new(p, &mesh::no_inputs(), 0.0)?;
    m.keep_journal(true);
    let (transit, start) = (p.timescales().piston_transit, mesh::strike());
    m.advance(start + until * transit)?;
    let (force, mass) = (p.impedance_of(p.cross_section) * SPEED, p.piston_mass());
    let at = |t: f64| (t - start) / transit;
    let (mut opened, mut flight, mut first, mut second) = (f64::NAN, 0.0, f64::NAN, f64::NAN);
    for record in m.take_journal().iter().filter(|r| r.event.is_contact()) {
        let now = at(record.time);
        if !record.mode.closed() {
            opened = now;
        } else if now - opened > flight {
            (flight, first, second) = (now - opened, opened, now);
        }
    }
    let (peaks, energies, impulses) = (m.peaks(), m.energies(), m.impulses());
    let k = *m.kinematics();
    Ok(Struck {
        share: energies.rock_dissipated / (0.5 * mass * SPEED * SPEED),
        peak: peaks.rock_force() / force,
        contact_peak: peaks.contact_force() / force,
        piston: k.piston.velocity / SPEED,
        bit: k.bit.velocity / SPEED,
        first: if first.is_nan() { opened } else { first },
        second,
        impulse: impulses.contact / (mass * SPEED),
    })
}

/// Two free bars; `bit` is `Lb / Lp`.
fn bars_scene(bit: f64, elements: usize) -> Parameters {
    let mut p = mesh::bare(elements);
    p.bit.length *= bit;
    p.bit.elements = (bit * elements as f64).round() as usize;
    // Very soft rock: its force during the collision is 1e-9 of the contact force.
    p.rock.stiffness = 1.0;
    p
}

/// Two free bars; `bit` is `Lb / Lp`.
fn saint_venant(bit: f64) -> Result<Vec<Row>, Error> {
    let source = "St-Venant";
    let exact = bars(bit);
    let p = bars_scene(bit, ELEMENTS);
    let until = exact.push + 1.0;
    let ours = strike(&p, until)?;
    let spread = mesh::spread(&p, exact.push);
    let mut rows =
        Rows::new(format!("two bars, Lb/Lp = {bit}, {ELEMENTS} elements"), source, FRONT);
    // The force ends when the front is back; the faces of unequal bars stay together afterwards.
    rows.add("impulse / (Mp v0)", exact.impulse, ours.impulse, 0.5 * spread);
    rows.add("striker's mean velocity / v0", exact.after[0], ours.piston, 0.5 * spread);
    rows.add("bar's mean velocity / v0", exact.after[1], ours.bit, 0.5 * spread / bit);
    if bit == 1.0 {
        rows.add("time under force / T1", exact.push, ours.first, spread);
    }
    Ok(rows.list)
}

/// Length of a bit so heavy that it acts as a wall: it moves by 1e-7 of the spring's compression.
const WALL: f64 = 1e7;

/// A free bar strikes a spring: the penalty itself, on a bit that acts as a wall.
fn spring_scene(k: f64, elements: usize) -> Parameters {
    let mut p = mesh::bare(elements);
    p.bit.length = WALL * p.piston.length;
    p.bit.elements = 1;
    p.contact.stiffness = k * mesh::stretch(&p) / p.piston.length;
    p
}

/// A free bar against the published table.
fn on_spring([k, peak, time]: [f64; 3]) -> Result<Vec<Row>, Error> {
    let source = "d'Alembert, table";
    let ours = strike(&spring_scene(k, ELEMENTS), time + 1.0)?;
    // The spring is the penalty itself, which here delays nothing.
    let late = (time / (8.0 * (ELEMENTS * ELEMENTS) as f64)).cbrt();
    let mut rows =
        Rows::new(format!("bar on a spring, k = {k}, {ELEMENTS} elements"), source, FRONT);
    rows.add("peak force / (Z v0)", peak, ours.contact_peak, 2.0 * k * late);
    // The force falls to zero at its own rate; before that a front of height 2 may come twice.
    rows.add("contact time / T1", time, ours.first, 2.0 * late);
    Ok(rows.list)
}

/// A rectangular pulse in a long bit, on bilinear rock.
fn pulse(b: f64) -> Result<Vec<Row>, Error> {
    let (source, gamma, long) = ("closed form", 4.0, 8.0);
    let exact = pulse_efficiency(b, gamma);
    let mut p = mesh::bare(40);
    p.bit.length *= long;
    p.bit.elements = 320;
    p.rock.unloading_ratio = gamma;
    p.rock.stiffness = 0.5 * b * mesh::stretch(&p) / p.piston.length;
    let ours = strike(&p, long + 6.0)?;
    let mut rows = Rows::new(format!("one pulse, b = {b}, 40 elements"), source, FRONT);
    // Power at the tip is at most Z v0^2, 2 in units of the energy in a transit.
    rows.add("energy kept by the rock, eta", exact, ours.share, 2.0 * mesh::spread(&p, long + 2.0));
    Ok(rows.list)
}

/// A bare scene on rock of stiffness `kappa`.
pub fn blow_scene(kappa: f64, gamma: f64, elements: usize) -> Parameters {
    let mut p = mesh::bare(elements);
    p.rock.unloading_ratio = gamma;
    p.rock.stiffness = kappa * mesh::stretch(&p) / p.piston.length;
    p
}

/// Equal bars, one blow on virgin rock.
fn blow([kappa, gamma, share, peak, speed, second]: [f64; 6]) -> Result<Vec<Row>, Error> {
    let source = "exact waves, table";
    let name = format!("one blow, kappa = {kappa}, gamma = {gamma}");
    let p = blow_scene(kappa, gamma, ELEMENTS);
    let ours = strike(&p, second + 2.5)?;
    let (early, late) = (mesh::spread(&p, 4.0), mesh::spread(&p, second));
    let mut rows = Rows::new(format!("{name}, {ELEMENTS} elements"), source, FRONT);
    // Power into the rock at the peak is F v, with v below v0.
    rows.add("energy kept by the rock, eta", share, ours.share, 2.0 * peak * late);
    rows.add("peak rock force / (Z v0)", peak, ours.peak, kappa * early);
    // Two collisions, each with a front of force 1/2 or less at its start and end.
    rows.add("piston after / v0", speed, ours.piston, 2.0 * late);
    // Momenta have an error of a front; divided by the speed of closing, it is that of the flight.
    let mut waves = Waves::new(Scene::unit(kappa, gamma, 1.0), STEPS);
    waves.advance(second + 2.5);
    let closing = 2.0 * waves.collisions[1].impulse;
    let tolerance = early * (1.0 + second - 2.0) / closing;
    rows.add("second collision / T1", second, ours.second, tolerance);
    Ok(rows.list)
}

/// Closed form 1.
pub fn two_bars() -> Result<Vec<Row>, Error> {
    gather([1.0, 2.25, 0.4], saint_venant)
}

/// Closed form 2.
pub fn springs() -> Result<Vec<Row>, Error> {
    gather(BAR_ON_SPRING, on_spring)
}

/// Closed form 3.
pub fn pulses() -> Result<Vec<Row>, Error> {
    gather([0.4, 1.25643, 3.0], pulse)
}

/// Closed form 4.
pub fn blows() -> Result<Vec<Row>, Error> {
    gather(BLOWS, blow)
}

fn gather<T, const N: usize>(
    cases: [T; N],
    rows: impl Fn(T) -> Result<Vec<Row>, Error>,
) -> Result<Vec<Row>, Error> {
    let lists: Result<Vec<_>, _> = cases.into_iter().map(rows).collect();
    Ok(lists?.concat())
}
