//! Ratios of two hammers in the numbers of their samples, and the unknowns that cancel in them.
//!
//! In one rock the specific energy always cancels. If the two sides are *one hammer* under different conditions
//! (pressure, feed, hole, rock), all unknowns of the hammer cancel too: both samples have the same draws, so the
//! members are divided one by one. The error of the model's dependence on a condition remains. For pressure it is given
//! by the members' own exponents and, for air, by the scatter [`ROW`] of printed numbers; for feed by [`OF_FEED`]; for
//! the hole by an exponent with the error [`OF_HOLE`]. If the sides are *two hammers*, nothing else cancels: members
//! are paired at random, [`TIMES`] for each. For *two rocks* the specific energies are drawn independently.

use super::sample::{drawn, spread};
use super::{Datasheet, Quantity};
use crate::numerics::math;

/// Number of random pairs for each member if the sides are two hammers.
const TIMES: usize = 20;
/// Relative standard errors: of a ratio of two feeds, of the exponent of the hole's diameter, of a printed number for
/// air.
const OF_FEED: f64 = 0.05;
const OF_HOLE: f64 = 0.25;
const ROW: f64 = 0.09;
/// Pressures are nearly equal if their logarithms differ by less than this.
const NEARLY: f64 = 0.2;
/// First dimension of the random numbers of ratios.
const NOISE: usize = 1 << 30;

/// The columns of a sample in which two hammers are compared.
pub const COMPARED: [&str; 5] = [RATE, "blow energy", "frequency", "power of the blows", AIR];
const RATE: &str = "rate of penetration";
const AIR: &str = "free air";
const ENERGY: &str = "specific energy";
/// Quantities that belong to the conditions under which a hammer works.
const CONDITIONS: [Quantity; 7] = [
    Quantity::Altitude,
    Quantity::Inlet,
    Quantity::Feed,
    Quantity::Rate,
    Quantity::Pipe,
    Quantity::Rotation,
    Quantity::DampingRatio,
];

/// A side of a ratio.
#[derive(Clone, Debug, Default)]
pub struct Side {
    /// The given numbers; `None` for a hammer that is given as a scene.
    pub sheet: Option<Datasheet>,
    /// The name of the rock.
    pub rock: String,
    /// Name of each number, and its values in all members.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Weights of the members.
    pub weights: Vec<f64>,
    /// Relative standard errors in addition to the sample's: of all numbers, and of the specific energy alone.
    pub errors: [f64; 2],
}

impl Side {
    fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(own, _)| own == name).map(|(_, members)| members.as_slice())
    }

    fn get(&self, quantity: Quantity) -> Option<f64> {
        self.sheet.as_ref()?.get(quantity)
    }
}

/// How the two sides are related.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// The given numbers of the hammer are equal; only conditions may differ.
    OneHammer,
    /// Other given numbers differ.
    TwoHammers,
}

impl Relation {
    /// Finds out if two sheets describe one hammer.
    pub fn of(a: &Side, b: &Side) -> Self {
        let (Some(one), Some(other)) = (&a.sheet, &b.sheet) else { return Self::TwoHammers };
        // Without an outside diameter, the hole determines the size of the hammer.
        let sized = [one, other].iter().all(|sheet| sheet.get(Quantity::OuterDiameter).is_some());
        let condition = |q: &Quantity| CONDITIONS.contains(q) || sized && *q == Quantity::Hole;
        let alike = Quantity::all().filter(|q| !condition(q)).all(|q| one.get(q) == other.get(q));
        if alike && one.air == other.air { Self::OneHammer } else { Self::TwoHammers }
    }
}

/// The ratios of `a` over `b`: name, median, and ends of the 80 % range.
pub fn ratios(a: &Side, b: &Side) -> Vec<(&'static str, [f64; 3])> {
    let relation = Relation::of(a, b);
    let pairs = pairs(a, b, relation);
    let each = |name: &&'static str| {
        let [x, y] = [a.column(name)?, b.column(name)?];
        let of_rate = *name == RATE;
        let [e, f] = if of_rate && divided(a, b) {
            [a.column(ENERGY)?, b.column(ENERGY)?]
        } else {
            [&[1.0][..]; 2]
        };
        let apart = of_rate && divided(a, b) && a.rock != b.rock;
        let wide = math::length(&[width(a, b, relation, name), a.errors[0], b.errors[0]]);
        let of_rock =
            if of_rate && a.rock != b.rock { math::hypot(a.errors[1], b.errors[1]) } else { 0.0 };
        let list = pairs.iter().enumerate().map(|(k, pair)| {
            let at = |list: &[f64], i: usize| list[i % list.len()];
            let mut ratio = at(x, pair.a) * at(e, pair.a) / (at(y, pair.b) * at(f, pair.b));
            if apart {
                ratio *= at(f, pair.other) / at(e, pair.one);
            }
            let noise = math::hypot(wide, of_rock) * drawn(k, NOISE);
            (ratio * math::exp(noise), pair.weight)
        });
        Some((*name, spread(list.collect())))
    };
    COMPARED.iter().filter_map(each).collect()
}

/// True if the specific energies cancel. They do not for two rocks if a rate was measured in each.
fn divided(a: &Side, b: &Side) -> bool {
    let measured = |side: &Side| side.get(Quantity::Rate).is_some();
    a.rock == b.rock || !(measured(a) && measured(b))
}

/// A pair of members (`a`, `b`), two other members for independent draws, and the pair's weight.
struct Pair {
    a: usize,
    b: usize,
    one: usize,
    other: usize,
    weight: f64,
}

fn pairs(a: &Side, b: &Side, relation: Relation) -> Vec<Pair> {
    let [n, m] = [a.weights.len().max(1), b.weights.len().max(1)];
    let weight = |side: &Side, k: usize| side.weights.get(k).copied().unwrap_or(1.0);
    let mut list = Vec::new();
    for round in 0..TIMES {
        let order = |dimension: usize, count: usize| {
            // Sorting by random numbers gives a random order.
            let mut places: Vec<usize> = (0..count).collect();
            let key = |k: &usize| drawn(2 * k, NOISE + 1 + 3 * round + dimension);
            places.sort_by(|x, y| key(x).total_cmp(&key(y)));
            places
        };
        let [of_b, one, other] = [order(0, m), order(1, n), order(2, m)];
        for i in 0..n.max(m) {
            let (x, y) = match relation {
                Relation::OneHammer => (i % n, i % m),
                Relation::TwoHammers => (i % n, of_b[i % m]),
            };
            let both = weight(a, x) * weight(b, y);
            let weight = if relation == Relation::OneHammer { both.sqrt() } else { both };
            list.push(Pair { a: x, b: y, one: one[i % n], other: other[i % m], weight });
        }
    }
    list
}

/// The error of the model in a ratio, as a relative standard error.
fn width(a: &Side, b: &Side, relation: Relation, name: &str) -> f64 {
    let (Some(one), Some(other)) = (&a.sheet, &b.sheet) else { return 0.0 };
    if relation == Relation::TwoHammers {
        return 0.0;
    }
    let over = |x: Option<f64>, y: Option<f64>| match (x, y) {
        (Some(x), Some(y)) => math::ln(x / y).abs(),
        _ => 0.0,
    };
    let pressure = over(one.working_pressure(), other.working_pressure());
    let feed = one.get(Quantity::Feed) != other.get(Quantity::Feed);
    let hole = over(one.get(Quantity::Hole), other.get(Quantity::Hole));
    // Numbers printed for two pressures scatter independently, unless the pressures are nearly equal.
    let apart = (pressure / NEARLY).min(1.0);
    let row = if name == AIR { std::f64::consts::SQRT_2 * ROW * apart } else { 0.0 };
    math::length(&[if feed { OF_FEED } else { 0.0 }, OF_HOLE * hole, row])
}

/// Printed numbers that depend on the pressure, the outside diameter or the piston. They are no longer valid if that
/// changes.
const BELONGS: [(Quantity, &[Quantity]); 3] = [
    (
        Quantity::Pressure,
        &[
            Quantity::Power,
            Quantity::BlowEnergy,
            Quantity::AirFlow,
            Quantity::Flow,
            Quantity::Frequency,
            Quantity::ImpactSpeed,
            Quantity::Rate,
        ],
    ),
    (
        Quantity::OuterDiameter,
        &[
            Quantity::Power,
            Quantity::BlowEnergy,
            Quantity::AirFlow,
            Quantity::Frequency,
            Quantity::PistonMass,
            Quantity::Bore,
        ],
    ),
    (
        Quantity::PistonMass,
        &[Quantity::Power, Quantity::BlowEnergy, Quantity::AirFlow, Quantity::Frequency],
    ),
];

impl Datasheet {
    /// The reason why a change from this sheet to another is refused: a number changes, while printed numbers that
    /// depend on it stay the same.
    pub fn refused_change(&self, after: &Self) -> Option<String> {
        BELONGS.iter().find_map(|(changed, printed)| {
            let [old, new] = [self, after].map(|sheet| sheet.get(*changed));
            old.zip(new).filter(|(old, new)| old != new)?;
            let stays = |q: Quantity| self.get(q).is_some() && self.get(q) == after.get(q);
            let stay = printed.iter().filter(|q| stays(**q));
            let mut names: Vec<&str> = stay.map(|q| q.name()).collect();
            // A table of air has its own pressures.
            let sized = *changed != Quantity::Pressure;
            if sized && !self.air.is_empty() && self.air == after.air {
                names.push(Quantity::AirFlow.name());
            }
            let (first, name) = (names.first()?, changed.name());
            let instead = if *changed == Quantity::Pressure {
                "for this hammer at another pressure give at= instead"
            } else {
                "that would be another hammer"
            };
            Some(format!(
                "{name}= is changed while {} of the sheet, which belong to the {name} printed with them, stay: {instead}, \
                 or say what is printed with the new {name} ({first}=..., or {first}=None to leave it out)",
                names.join(", "),
            ))
        })
    }
}
