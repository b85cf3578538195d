//! Whole cycles of the reference hammer against exact waves in damped bars that meet through the same spring, from
//! rest to the stationary cycle.

use crate::rows::mesh::remaining;
use crate::rows::row::{Row, Rows};
use hammer::{Error, Event, InputValues, Machine, Parameters, Record, Relay};
use oracles::waves::{Scene, Waves};

/// Number of cycles: in the last ones, each repeats the previous one to 1e-4 ms.
const CYCLES: usize = 15;
/// Steps of the exact waves in one transit, and coarser ones that show their error.
const STEPS: [u32; 2] = [300, 200];
/// The cycles of a hammer from rest.
#[derive(Clone, Debug)]
struct Cycles {
    /// Periods of the relay, s.
    periods: Vec<f64>,
    /// Hole advance over the last period, m/s.
    tip_rate: f64,
    /// Relative mean speed at the last impact, m/s.
    speed: f64,
    /// Time from the first closing to the last opening of each collision in the last cycle, s.
    collisions: Vec<f64>,
}

fn differences(x: &[f64]) -> Vec<f64> {
    x.windows(2).map(|p| p[1] - p[0]).collect()
}

/// Durations of collisions, s: contacts closer than `longest_gap` belong to one collision.
pub fn collisions(spells: &[[f64; 2]], longest_gap: f64) -> Vec<f64> {
    let mut merged: Vec<[f64; 2]> = Vec::new();
    for &[start, end] in spells {
        match merged.last_mut() {
            Some(last) if start - last[1] < longest_gap => last[1] = end,
            _ => merged.push([start, end]),
        }
    }
    merged.iter().map(|s| s[1] - s[0]).collect()
}

/// Times of contact in a journal that starts open, s.
pub fn spells(journal: &[Record]) -> Vec<[f64; 2]> {
    let times: Vec<f64> = journal.iter().filter(|r| r.event.is_contact()).map(|r| r.time).collect();
    times.chunks_exact(2).map(|c| [c[0], c[1]]).collect()
}

fn collision_gap(p: &Parameters) -> f64 {
    2.0 * (p.timescales().piston_transit + p.timescales().bit_transit)
}

/// Start of a time span from just before the last impact to after its rebound.
fn last_cycle(p: &Parameters, returns: &[f64]) -> f64 {
    returns[CYCLES] - 0.1 * p.timescales().pressure
}

/// Duration of the cycles, s.
fn span(p: &Parameters) -> f64 {
    (CYCLES as f64 + 0.7) * 4.7 * p.timescales().pressure
}

fn continuum(scene: Scene, steps: u32) -> Cycles {
    let p = Parameters::default();
    let mut waves = Waves::new(scene, steps);
    waves.advance(span(&p));
    let periods = differences(&waves.returns[..=CYCLES]);
    let advance = waves.depths[CYCLES] - waves.depths[CYCLES - 1];
    let from = last_cycle(&p, &waves.returns);
    let last: Vec<_> = waves.collisions.iter().filter(|c| c.start >= from).collect();
    let spells: Vec<_> = last.iter().map(|c| [c.start, c.end]).collect();
    Cycles {
        tip_rate: advance / periods[CYCLES - 1],
        periods,
        speed: last.first().map_or(f64::NAN, |c| c.speed),
        collisions: collisions(&spells, collision_gap(&p)),
    }
}

fn engine(elements: usize) -> Result<Cycles, Error> {
    let mut p = Parameters::default();
    p.mesh.degree = 1;
    (p.piston.elements, p.bit.elements) = (elements, elements);
    let mut m = Machine::new(&p, &InputValues::default(), 0.0)?;
    m.keep_journal(true);
    m.advance(span(&p))?;
    let journal = m.take_journal();
    let returns: Vec<f64> =
        journal.iter().filter(|r| r.event == Event::Relay(Relay::Return)).map(|r| r.time).collect();
    let mut spells = spells(&journal);
    spells.retain(|s| s[0] >= last_cycle(&p, &returns));
    let blow = m.blow().copied().unwrap_or_default();
    Ok(Cycles {
        periods: differences(&returns[..=CYCLES]),
        tip_rate: blow.tip_rate,
        speed: blow.speed,
        collisions: collisions(&spells, collision_gap(&p)),
    })
}

/// The compared numbers, in ms, mm/s and m/s.
fn values(c: &Cycles) -> Vec<(&'static str, f64)> {
    let names = ["period 1, ms", "period 2, ms", "period 3, ms", "period 4, ms", "period 5, ms"];
    let mut list: Vec<_> = names.into_iter().zip(c.periods.iter().map(|p| 1e3 * p)).collect();
    list.push(("period 15, ms", 1e3 * c.periods[CYCLES - 1]));
    list.push(("tip rate, mm/s", 1e3 * c.tip_rate));
    list.push(("relative mean speed at impact, m/s", c.speed));
    list.push(("collisions in cycle 15", c.collisions.len() as f64));
    list.push(("first collision, ms", 1e3 * c.collisions[0]));
    list.push(("second collision, ms", 1e3 * c.collisions.get(1).copied().unwrap_or(f64::NAN)));
    list
}

/// The continuum of a scene.
fn scene() -> Scene {
    crate::scene::continuum(&Parameters::default(), &InputValues::default())
}

const MESH: &str = "the larger of the changes from the mesh of half as many elements, and from a quarter to half over 2^(2/3), over 2^(2/3) - 1: 2/3 is the slowest order that a front has; change of the exact waves from 200 to 300 steps per transit; tip rate: a front late by beta / 2 at the speed of impact";

/// Fifteen cycles on two meshes against the continuum.
pub fn rows() -> Result<Vec<Row>, Error> {
    let [fine, rough] = STEPS.map(|steps| continuum(scene(), steps));
    let coarse = rough.clone();
    let (exact, rough) = (values(&fine), values(&rough));
    let meshes = [20, 40, 80, 160].map(|n| Ok(values(&engine(n)?)));
    let meshes = meshes.into_iter().collect::<Result<Vec<_>, Error>>()?;
    let mut list = Vec::new();
    for (elements, three) in [80, 160].into_iter().zip(meshes.windows(3)) {
        let case = format!("reference hammer from rest, {elements} elements");
        let mut rows = Rows::new(case, "exact waves, damped, 300 steps per transit", MESH);
        for (i, (name, value)) in three[2].iter().enumerate() {
            let mesh = remaining([0, 1, 2].map(|k| three[k][i].1));
            let late = if name.starts_with("tip rate") { late_front(&fine) } else { 0.0 };
            let steps = (exact[i].1 - rough[i].1).abs();
            rows.add(*name, exact[i].1, *value, mesh + steps + late);
        }
        list.extend(rows.list);
    }
    list.extend(printed(&fine, &coarse));
    Ok(list)
}

/// Error of the tip rate by the part of damping that the exact waves neglect (see [`Waves`]), mm/s.
fn late_front(c: &Cycles) -> f64 {
    1e3 * 0.5 * Parameters::default().material.damping_time * c.speed / c.periods[CYCLES - 1]
}

/// The printed values of the continuum, to which meshes of degree 7 converge.
fn printed(ours: &Cycles, rough: &Cycles) -> Vec<Row> {
    let why = "half a unit of the last digit printed; twice the change of the exact waves from 200 to 300 steps per transit, for their error falls with the steps; the waves' damping is of first order in beta, 6e-6 a transit, and a blow has four; tip rate: a front late by beta / 2 too";
    let mut rows = Rows::new("exact waves, stationary", "the model's description", why);
    let mut add = |name, printed, unit: f64, of: &dyn Fn(&Cycles) -> f64, late| {
        let steps = 2.0 * (of(ours) - of(rough)).abs();
        let damping = 4.0 * 6e-6 * printed;
        rows.add(name, printed, of(ours), 0.5 * unit + steps + damping + late);
    };
    add("period, ms", 45.62937, 1e-5, &|c| 1e3 * c.periods[CYCLES - 1], 0.0);
    add("tip rate, mm/s", 39.4515, 1e-4, &|c| 1e3 * c.tip_rate, late_front(ours));
    add("relative mean speed at impact, m/s", 11.51841, 1e-5, &|c| c.speed, 0.0);
    rows.list
}
