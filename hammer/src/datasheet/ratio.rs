//! Ratios of two hammers in what their samples tell: which unknowns cancel, and which do not.
//!
//! In one rock the specific energy cancels, always. Of *one hammer* under other conditions (pressure, feed, hole, rock)
//! everything that is unknown of the hammer cancels too: members are divided one by one, since both samples are drawn alike.
//! What the model does not know of a condition remains: over pressure the members' own exponents, and of air the scatter
//! [`ROW`] of numbers that makers print; over feed [`OF_FEED`]; over hole an exponent with the error [`OF_HOLE`]. Of *two
//! hammers* nothing else cancels: members are paired at random, [`TIMES`] of one for each of the other. Of *two rocks* the
//! specific energies are drawn apart.

use super::sample::{drawn, spread};
use super::{Datasheet, Quantity};
use crate::numerics::math;

/// Pairs of each member, of two hammers.
const TIMES: usize = 20;
/// Relative standard errors: of a ratio over feed, of the exponent of the hole's diameter, of a printed number of air.
const OF_FEED: f64 = 0.05;
const OF_HOLE: f64 = 0.25;
const ROW: f64 = 0.09;
/// Pressures whose logarithms differ by less are nearly one.
const NEARLY: f64 = 0.2;
/// First dimension of the random numbers of ratios.
const NOISE: usize = 1 << 30;

/// What two hammers are compared in: the columns of a sample.
pub const COMPARED: [&str; 5] = [RATE, "blow energy", "frequency", "power of the blows", AIR];
const RATE: &str = "rate of penetration";
const AIR: &str = "free air";
const ENERGY: &str = "specific energy";
/// What belongs to the conditions of a hammer and not to it.
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
    /// What was given; none of a hammer that is known as a scene.
    pub sheet: Option<Datasheet>,
    /// The rock, as it was named.
    pub rock: String,
    /// Name and members of each number.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Weights of the members.
    pub weights: Vec<f64>,
    /// Relative standard error of all numbers beside, and of the specific energy alone.
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

/// A relation of two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// The same numbers of a hammer are given; conditions may be others.
    OneHammer,
    /// Other numbers are given.
    TwoHammers,
}

impl Relation {
    /// Whether two sheets are of one hammer.
    pub fn of(a: &Side, b: &Side) -> Self {
        let (Some(one), Some(other)) = (&a.sheet, &b.sheet) else { return Self::TwoHammers };
        // Without an outside diameter the hole says how large the hammer is.
        let sized = [one, other].iter().all(|sheet| sheet.get(Quantity::OuterDiameter).is_some());
        let condition = |q: &Quantity| CONDITIONS.contains(q) || sized && *q == Quantity::Hole;
        let alike = Quantity::all().filter(|q| !condition(q)).all(|q| one.get(q) == other.get(q));
        if alike && one.air == other.air { Self::OneHammer } else { Self::TwoHammers }
    }
}

/// The ratios of `a` over `b`: name, and median and ends of the range of 80 %.
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
        let wide = width(a, b, relation, name).hypot(a.errors[0]).hypot(b.errors[0]);
        let of_rock =
            if of_rate && a.rock != b.rock { a.errors[1].hypot(b.errors[1]) } else { 0.0 };
        let list = pairs.iter().enumerate().map(|(k, pair)| {
            let at = |list: &[f64], i: usize| list[i % list.len()];
            let mut ratio = at(x, pair.a) * at(e, pair.a) / (at(y, pair.b) * at(f, pair.b));
            if apart {
                ratio *= at(f, pair.other) / at(e, pair.one);
            }
            let noise = wide.hypot(of_rock) * drawn(k, NOISE);
            (ratio * math::exp(noise), pair.weight)
        });
        Some((*name, spread(list.collect())))
    };
    COMPARED.iter().filter_map(each).collect()
}

/// Whether specific energies are divided out: always, but of two rocks in each of which a rate was measured.
fn divided(a: &Side, b: &Side) -> bool {
    let measured = |side: &Side| side.get(Quantity::Rate).is_some();
    a.rock == b.rock || !(measured(a) && measured(b))
}

/// A pair of members, two others for what is drawn apart, and its weight.
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
            // A random order is that of random numbers.
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

/// What the model leaves open of a ratio, as a relative standard error.
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
    // Printed numbers of two pressures scatter apart, but for such as are nearly one.
    let apart = (pressure / NEARLY).min(1.0);
    let row = if name == AIR { std::f64::consts::SQRT_2 * ROW * apart } else { 0.0 };
    (if feed { OF_FEED } else { 0.0 }).hypot(OF_HOLE * hole).hypot(row)
}

/// What makers print that belongs to a pressure, an outside diameter and a piston: with another of these it is another.
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
    /// Why a change of this sheet to another is refused: a number changes to which printed ones belong that stay.
    pub fn refused_change(&self, after: &Self) -> Option<String> {
        BELONGS.iter().find_map(|(changed, printed)| {
            let [old, new] = [self, after].map(|sheet| sheet.get(*changed));
            old.zip(new).filter(|(old, new)| old != new)?;
            let stays = |q: Quantity| self.get(q).is_some() && self.get(q) == after.get(q);
            let stay = printed.iter().filter(|q| stays(**q));
            let mut names: Vec<&str> = stay.map(|q| q.name()).collect();
            // A table of air has pressures of its own.
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
