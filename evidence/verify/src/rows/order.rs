//! How errors fall with the size of the elements.
//!
//! Consistent mass is dispersive, `omega = c k (1 + (k h)^2 / 24)`. A front that has run for a time `t` is therefore
//! the integral of an Airy function, of width `(c t h^2 / 8)^(1/3)`. Hence
//!
//! * a number that is read at a front, or an event that a front causes (an opening, a turn of the
//!   tip, and all that follows from it), has an error of the front's width: order 2/3;
//! * an integral over a front has an error of the third moment of the Airy function, as the first
//!   and second are zero: order 2.
//!
//! Damping of `beta` spreads a front by `c sqrt(beta t)`. With `beta` and `KC` fixed the front has its own width, the
//! mesh resolves it, and the order is 2.

use crate::rows::closed::{self, Struck};
use crate::rows::mesh::{self, remaining};
use crate::rows::row::{Row, Rows};
use hammer::{Error, Parameters};
use oracles::closed::BLOWS;
use oracles::waves::{Scene, Waves};

/// Steps of the exact waves in one transit.
const STEPS: u32 = 1000;

/// The blow of the studies: `kappa` 0.3, `gamma` 5.
const BLOW: [f64; 6] = BLOWS[3];

fn blow_scene(blow: [f64; 6], elements: usize) -> Parameters {
    let [kappa, gamma, ..] = blow;
    let mut p = closed::blow_scene(kappa, gamma, elements);
    let [damping, penalty] = FIXED;
    p.material.damping_time = damping * p.timescales().piston_transit;
    p.contact.stiffness = penalty * mesh::stretch(&p) / p.piston.length;
    p
}

/// Exact waves of the blow, and the time when its longest flight ends.
fn exact(blow: [f64; 6]) -> (Waves, f64) {
    let ([kappa, gamma, .., second], [damping, penalty]) = (blow, FIXED);
    let scene = Scene { damping, penalty, ..Scene::unit(kappa, gamma, 1.0) };
    let mut waves = Waves::new(scene, STEPS);
    waves.advance(second + 2.5);
    let flights = waves.collisions.windows(2).map(|c| (c[1].start - c[0].end, c[1].start));
    let longest = flights.fold((0.0, f64::NAN), |a, b| if b.0 > a.0 { b } else { a });
    (waves, longest.1)
}

fn values((waves, second): &(Waves, f64)) -> [f64; 5] {
    [2.0 * waves.dissipated, waves.peak, waves.means[0].velocity, *second, waves.contact_peak]
}

fn errors(ours: &Struck, exact: &(Waves, f64)) -> Vec<f64> {
    let measured = [ours.share, ours.peak, ours.piston, ours.second, ours.contact_peak];
    measured.iter().zip(values(exact)).map(|(a, b)| a - b).collect()
}

const QUANTITIES: [&str; 5] = [
    "energy kept by the rock, eta",
    "peak rock force / (Z v0)",
    "piston after / v0",
    "second collision / T1",
    "peak contact force / (Z v0)",
];

/// `beta / T1` and `KC Lp / (E A)` of the fronts with a fixed width: 0.05 T1 in a transit by damping, 0.025 T1 by the
/// contact.
const FIXED: [f64; 2] = [0.0025, 20.0];

const RESOLVED: &str = "the larger of the changes from 40 to 80 elements, and from 20 to 40 over 2^(2/3), over 2^(2/3) - 1, the slowest order that a front has; exact waves: beta / T1 squared a transit";

/// All blows of closed form 4, with a front that the mesh resolves.
pub fn resolved_blows() -> Result<Vec<Row>, Error> {
    let mut list = Vec::new();
    for blow in BLOWS {
        let [kappa, gamma, .., second] = blow;
        let exact = exact(blow);
        let off = |n: usize| -> Result<Vec<f64>, Error> {
            let ours = closed::strike(&blow_scene(blow, n), second + 2.5)?;
            Ok(errors(&ours, &exact))
        };
        let (quarter, half, full) = (off(20)?, off(40)?, off(80)?);
        let case = format!("one blow, kappa = {kappa}, gamma = {gamma}, 80 elements");
        let mut rows = Rows::new(case, "exact waves with that damping and contact", RESOLVED);
        let values = values(&exact);
        for (i, name) in QUANTITIES.into_iter().enumerate() {
            let mesh = remaining([quarter[i], half[i], full[i]]);
            let tolerance = mesh + FIXED[0] * FIXED[0] * second;
            rows.add(name, values[i], values[i] + full[i], tolerance);
        }
        list.extend(rows.list);
    }
    Ok(list)
}

const WHY: &str = "half the way to the next power of the expansion, in h^(2/3)";

/// Elements per bar from which orders are computed.
const MESHES: [usize; 4] = [20, 40, 80, 160];
const ORDER: f64 = 2.0;

/// Observed orders, each the slope of a line through the logarithms. They must be at least the expected ones, up to
/// the tolerance of [`WHY`]; a higher order counts as the expected one.
pub fn rows() -> Result<Vec<Row>, Error> {
    let exact = exact(BLOW);
    let level = |n| Ok(errors(&closed::strike(&blow_scene(BLOW, n), BLOW[5] + 2.5)?, &exact));
    let levels = MESHES.into_iter().map(level).collect::<Result<Vec<_>, Error>>()?;
    let mut rows = Rows::new("blow: damping and contact kept", "theory", WHY);
    let off = |i: usize| (i as f64 - 1.5) * std::f64::consts::LN_2;
    for (q, name) in QUANTITIES.into_iter().enumerate() {
        let up: f64 =
            levels.iter().enumerate().map(|(i, level)| off(i) * level[q].abs().ln()).sum();
        let slope = -up / (0..MESHES.len()).map(|i| off(i).powi(2)).sum::<f64>();
        rows.add(name, ORDER, slope.min(ORDER), 1.0 / 3.0);
    }
    Ok(rows.list)
}
