//! How errors fall with the size of the elements, and why.
//!
//! Consistent mass disperses, `omega = c k (1 + (k h)^2 / 24)`, so a front that has run a
//! time `t` is as wide as `(c t h^2 / 8)^(1/3)`, an Airy function's integral. Hence
//!
//! * what is read at a front, or switched by one (an opening, a turn of the tip, and all
//!   that follows from it), errs by the front's width: order 2/3;
//! * what integrates over a front errs by the third moment of the Airy function, the first
//!   and second being zero: order 2; by the second moment where damping spreads it too: 4/3.
//!
//! Damping of `beta` spreads a front by `c sqrt(beta t)`: with `beta` as `h^(4/3)` that stays in proportion to
//! the Airy width, and the front keeps its shape as the mesh is refined; with `beta` and `KC` kept the front has
//! a width of its own, the mesh resolves it, and the order is 2.

use crate::rows::closed::{self, Struck};
use crate::rows::mesh;
use crate::rows::row::{Row, Rows};
use crate::rows::study::{Level, Quantity, Study, refined, remaining};
use hammer::{Error, Parameters};
use oracles::closed::{BLOWS, bar_on_unit_spring};
use oracles::waves::{Scene, Waves};
use std::time::Instant;

/// Steps a transit of the exact waves.
const STEPS: u32 = 1000;

/// How damping and penalty go with the mesh: `beta / T1` and `KC Lp / (E A)`.
type Scaling = fn(elements: f64) -> [f64; 2];

/// The blow of the studies: `kappa` 0.3, `gamma` 5.
const BLOW: [f64; 6] = BLOWS[3];

fn blow_scene(blow: [f64; 6], elements: usize, scaling: Scaling) -> Parameters {
    let [kappa, gamma, ..] = blow;
    let mut p = closed::blow_scene(kappa, gamma, elements);
    let [damping, penalty] = scaling(elements as f64);
    p.material.damping_time = damping * p.timescales().piston_transit;
    p.contact.stiffness = penalty * mesh::stretch(&p) / p.piston.length;
    p
}

/// Exact waves of the blow, and when its longest flight ends.
fn exact(blow: [f64; 6], damping: f64, penalty: f64) -> (Waves, f64) {
    let [kappa, gamma, .., second] = blow;
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

fn quantities(orders: [f64; 5]) -> Vec<Quantity> {
    let names = [
        "energy kept by the rock, eta",
        "peak rock force / (Z v0)",
        "piston after / v0",
        "second collision / T1",
        "peak contact force / (Z v0)",
    ];
    names.into_iter().zip(orders).map(|(name, order)| quantity(name, order)).collect()
}

fn quantity(name: &str, order: f64) -> Quantity {
    Quantity { name: name.into(), order }
}

fn blow_level(elements: usize, scaling: Scaling, exact: &(Waves, f64)) -> Result<Level, Error> {
    let begun = Instant::now();
    let ours = closed::strike(&blow_scene(BLOW, elements, scaling), BLOW[5] + 2.5)?;
    let seconds = begun.elapsed().as_secs_f64();
    let errors = errors(&ours, exact);
    Ok(Level { elements, errors, events: ours.events, samples: ours.samples, seconds })
}

const FRONT: f64 = 2.0 / 3.0;

/// `beta / T1` and `KC Lp / (E A)` of the fronts of a width of their own: 0.05 T1 a transit
/// by damping, 0.025 T1 by the contact.
const FIXED: [f64; 2] = [0.0025, 20.0];

/// Fronts of a width of their own, the same in the exact waves.
pub fn resolved() -> Result<Study, Error> {
    let exact = exact(BLOW, FIXED[0], FIXED[1]);
    Ok(Study {
        title: "Damping and contact kept".into(),
        setting: "`beta` T1 / 400, `KC` 20 E A / Lp; against exact waves with that damping and that contact",
        quantities: quantities([2.0; 5]),
        levels: refined(|n| blow_level(n, |_| FIXED, &exact))?,
    })
}

/// Damping in proportion to the mesh's own spread, over `T1`.
fn proportion(n: f64) -> f64 {
    0.05 * n.powf(-4.0 / 3.0)
}

/// A bar on a spring, which integrates over fronts, and two bars, which part at one.
pub fn simple() -> Result<Study, Error> {
    let quantities = vec![
        quantity("bar on a spring, k = 1: peak force / (Z v0)", 2.0 * FRONT),
        quantity("bar on a spring, k = 1: contact time / T1", 2.0 * FRONT),
        quantity("two bars: impulse / (Mp v0)", FRONT),
        quantity("two bars: contact time / T1", FRONT),
    ];
    Ok(Study {
        title: "A bar on a spring, and two bars".into(),
        setting: "On the spring `beta` 0.05 T1 (h / Lp)^(4/3), the spring being the contact; two bars undamped, `KC` 2 E A / h; against the closed forms",
        quantities,
        levels: refined(simple_level)?,
    })
}

fn simple_level(elements: usize) -> Result<Level, Error> {
    let begun = Instant::now();
    let mut scene = closed::spring_scene(1.0, elements);
    scene.material.damping_time = proportion(elements as f64) * scene.timescales().piston_transit;
    let spring = closed::strike(&scene, 4.5)?;
    let bars = closed::strike(&closed::bars_scene(1.0, elements), 3.0)?;
    let seconds = begun.elapsed().as_secs_f64();
    let (peak, time) = bar_on_unit_spring();
    let errors =
        vec![spring.contact_peak - peak, spring.first - time, bars.impulse - 1.0, bars.first - 2.0];
    let (events, samples) = (spring.events + bars.events, spring.samples + bars.samples);
    Ok(Level { elements, errors, events, samples, seconds })
}

const RESOLVED: &str = "the larger of the changes from 40 to 80 elements, and from 20 to 40 over 2^(2/3), over 2^(2/3) - 1, the slowest order that a front has; exact waves: beta / T1 squared a transit";

/// Every blow of the fourth closed form with a front that the mesh resolves.
pub fn resolved_blows() -> Result<Vec<Row>, Error> {
    let mut list = Vec::new();
    for blow in BLOWS {
        let [kappa, gamma, .., second] = blow;
        let exact = exact(blow, FIXED[0], FIXED[1]);
        let off = |n: usize| -> Result<Vec<f64>, Error> {
            let ours = closed::strike(&blow_scene(blow, n, |_| FIXED), second + 2.5)?;
            Ok(errors(&ours, &exact))
        };
        let (quarter, half, full) = (off(20)?, off(40)?, off(80)?);
        let case = format!("one blow, kappa = {kappa}, gamma = {gamma}, 80 elements");
        let mut rows = Rows::new(case, "exact waves with that damping and contact", RESOLVED);
        let values = values(&exact);
        for (i, q) in quantities([2.0; 5]).into_iter().enumerate() {
            let mesh = remaining([quarter[i], half[i], full[i]]);
            let tolerance = mesh + FIXED[0] * FIXED[0] * second;
            rows.add(q.name, values[i], values[i] + full[i], tolerance);
        }
        list.extend(rows.list);
    }
    Ok(list)
}

/// All studies of one blow.
pub fn all() -> Result<Vec<Study>, Error> {
    Ok(vec![resolved()?, simple()?])
}

const WHY: &str = "half the way to the next power of the expansion, in h^(2/3)";

/// Observed orders as rows: at least the expected one, within [`WHY`]'s reason; what falls
/// faster is counted as expected.
pub fn order_rows(study: &Study) -> Vec<Row> {
    let mut rows = Rows::new(format!("blow: {}", study.title.to_lowercase()), "theory", WHY);
    for (i, q) in study.quantities.iter().enumerate().filter(|(_, q)| q.order > 0.0) {
        rows.add(q.name.clone(), q.order, study.fitted(i).min(q.order), 1.0 / 3.0);
    }
    rows.list
}

/// Orders of the settings in which theory says one.
pub fn rows() -> Result<Vec<Row>, Error> {
    Ok(all()?.iter().flat_map(order_rows).collect())
}
