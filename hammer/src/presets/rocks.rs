//! Rocks by name, and the rock law's parameters for a bit of many inserts.
//!
//! A spherical insert of radius `R`, pressed by `p << R` into rock of constant hardness `H`, touches it on the area
//! `2 pi R p`. With `n` inserts side by side the loading line is straight:
//!
//! ```text
//! F = 2 pi R H n p,      KR = 2 pi R H n,      work = H x volume,  volume = n pi R p^2
//! ```
//!
//! The ratio `gamma` of unloading to loading follows from the speed at which an insert rebounds. The same tests bound
//! viscosity and energy barrier: 1.7e4 N s/m and 0.4 J cannot be distinguished from zero, and ten times as much is
//! excluded. Each insert is assumed to have less, [`INSERT_VISCOSITY`] and [`INSERT_BARRIER`]; with these the bits of
//! hammers stand still between blows.

use crate::numerics::math;
use crate::quantities::domain::{Domain, ParameterError};
use crate::quantities::parameters::{Parameters, Rock};
use std::f64::consts::PI;
use thiserror::Error;

/// Diameter of the bit to which the reference rock's parameters belong, m: that of a 3-inch hammer.
pub const REFERENCE_HOLE: f64 = 0.09;

impl Rock {
    /// Converts rock under a bit like the reference's to rock under a bit of another diameter (m), by area.
    pub(crate) fn spread(&mut self, diameter: f64) {
        let share = (diameter / REFERENCE_HOLE) * (diameter / REFERENCE_HOLE);
        self.stiffness *= share;
        self.viscosity *= share;
        self.energy_barrier *= share;
    }
}

/// A number of a rock, with its range and its source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// The number, in SI units.
    pub value: f64,
    /// Its least and largest value according to the source.
    pub range: [f64; 2],
    /// The source, and how the number follows from it.
    pub source: &'static str,
    /// False if the number is an assumption.
    pub measured: bool,
}

/// A rock.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RockType {
    /// Its name.
    pub name: &'static str,
    /// Hardness `H`, Pa.
    pub hardness: Figure,
    /// Ratio `gamma` of unloading to loading stiffness.
    pub unloading_ratio: Figure,
    /// Uniaxial compressive strength, Pa: the least and the largest.
    pub strength: [f64; 2],
}

/// The specific energy equals the strength within this factor, unless a rate was measured.
const ABOUT_STRENGTH: f64 = 1.6;
const OF_STRENGTH: &str = "about the uniaxial compressive strength, up to a factor of 1.6 (Teale 1965, IJRMMS \
    2:57). Two rates of the field, with the power printed for hammers of their sizes, give 182 MJ/m3 (165 mm, \
    granite, 22.5 m/h) and 245 MJ/m3 (175 mm, limestone of 172 to 207 MPa, steered, 13.7 m/h)";

impl RockType {
    /// Specific energy: the work that breaks out a volume of rock, J/m3.
    pub fn specific_energy(&self) -> Figure {
        let [low, high] = self.strength;
        let (value, inside) = ((low * high).sqrt(), 0.5 * math::ln(high / low));
        let factor = math::exp(math::hypot(inside, math::ln(ABOUT_STRENGTH)));
        let range = [value / factor, value * factor];
        Figure { value, range, source: OF_STRENGTH, measured: false }
    }
}

/// The rocks, ordered as drillers experience them, from soft to hard. Hardness follows from the deepest penetration `p`
/// of one insert of 8.51 mm: the loading line that stops the piston at `p` has the stiffness `KR = 2 pi R H`. The ratio
/// follows from the rebound of the same blow (`reports/measured.md`). Strengths are typical of such rocks: no strength
/// test of the two tested rocks is published.
pub const ROCKS: &[RockType] = &[
    RockType {
        name: "st anne limestone",
        hardness: Figure {
            value: 1.96e9,
            range: [1.65e9, 2.37e9],
            source: "Yang 2025 (IJRMMS 191:106125): one insert of 8.51 mm at 10.66 m/s goes 1.05 mm deep, \
                     KR = 1.048e8 (0.881e8 to 1.267e8) N/m; read off figures to a tenth",
            measured: true,
        },
        unloading_ratio: Figure {
            value: 6.0,
            range: [4.7, 7.7],
            source: "Yang 2025: it rebounds at 4.2 m/s, read off figures to a tenth",
            measured: true,
        },
        strength: [50e6, 250e6],
    },
    RockType {
        name: "kuru granite",
        hardness: Figure {
            value: 1.57e9,
            range: [1.29e9, 4.04e9],
            source: "Yang 2026: one insert of 8.51 mm at 9 m/s goes 1.0 mm deep, KR = 8.38e7 (6.91e7 to \
                     2.16e8) N/m: 0.6 to 1.1 mm over the tests",
            measured: true,
        },
        unloading_ratio: Figure {
            value: 3.0,
            range: [2.4, 3.8],
            source: "Yang 2026: it rebounds at 4.65 m/s, read off figures to a tenth",
            measured: true,
        },
        strength: [100e6, 250e6],
    },
    by_strength("weak, R2", [5e6, 25e6]),
    by_strength("medium strong, R3", [25e6, 50e6]),
    by_strength("strong, R4", [50e6, 100e6]),
    by_strength("very strong, R5", [100e6, 250e6]),
    by_strength("extremely strong, R6", [250e6, 400e6]),
];

/// A rock of known strength: a class of the International Society for Rock Mechanics. Its hardness follows from the
/// strength by [`OF_UCS`]; the range of a class also includes that of its strengths.
const fn by_strength(name: &'static str, strength: [f64; 2]) -> RockType {
    let [least, usual, most] = OF_UCS;
    let hardness = Figure {
        value: usual * root(strength[0] * strength[1]),
        range: [least * strength[0], most * strength[1]],
        source: "15 times the uniaxial compressive strength (8 to 27): ours, from single inserts in limestone and granite",
        measured: false,
    };
    let unloading_ratio = Figure {
        value: 4.3,
        range: [2.4, 7.7],
        source: "the same inserts, over both rocks",
        measured: false,
    };
    RockType { name, hardness, unloading_ratio, strength }
}

/// A square root for constant functions, which have none. Newton's method finds it from above, to rounding.
const fn root(square: f64) -> f64 {
    let mut x = if square > 1.0 { square } else { 1.0 };
    let mut steps = 0;
    while steps < 100 {
        x = 0.5 * (x + square / x);
        steps += 1;
    }
    x
}

/// Hardness over uniaxial compressive strength: least, usual, largest. The tested inserts have 2.0 and 1.6 GPa in rocks
/// of some 110 and 160 MPa, with a scatter from 1.3 to 4. Kahraman, Fener and Kozman 2012 and Saadati 2020 give such
/// laws for measured rocks.
const OF_UCS: [f64; 3] = [8.0, 15.0, 27.0];
/// Strengths of rocks, Pa: least and largest.
const STRENGTHS: [f64; 2] = [1e6, 600e6];

/// A rock in numbers that do not depend on the bit, as in a rock file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Hardness `H`, Pa.
    pub hardness: f64,
    /// Ratio `gamma` of unloading to loading stiffness.
    pub unloading_ratio: f64,
    /// Viscosity under one insert, N s/m.
    pub insert_viscosity: f64,
    /// Energy barrier under one insert, J.
    pub insert_barrier: f64,
    /// Specific energy, J/m3.
    pub specific_energy: f64,
    /// Factor of the uncertainty of the specific energy.
    pub specific_energy_factor: f64,
}

/// A number in a rock file: its name, its unit, and its accessor.
pub type GroundRow = (&'static str, &'static str, fn(&mut Ground) -> &mut f64);

impl Ground {
    /// All numbers of a rock file.
    pub const ROWS: [GroundRow; 6] = [
        ("hardness", "Pa", |g| &mut g.hardness),
        ("unloading_ratio", "1", |g| &mut g.unloading_ratio),
        ("insert_viscosity", "N.s/m", |g| &mut g.insert_viscosity),
        ("insert_barrier", "J", |g| &mut g.insert_barrier),
        ("specific_energy", "J/m3", |g| &mut g.specific_energy),
        ("specific_energy_factor", "1", |g| &mut g.specific_energy_factor),
    ];

    /// The rock for a name, a word that occurs in only one name, a class ("R5", "very strong"), or a strength ("180
    /// MPa").
    ///
    /// # Errors
    /// There is no such rock. The error lists the names that exist.
    pub fn named(text: &str) -> Result<(Self, Vec<String>), RockError> {
        let kind = RockType::named(text)?;
        Ok((Self::from(&kind), kind.assumptions()))
    }

    /// The rock of a scene, under a bit.
    pub fn of(rock: &Rock, bit: &Inserts) -> Self {
        let count = bit.count as f64;
        Self {
            hardness: rock.stiffness / (2.0 * PI * bit.radius * count),
            unloading_ratio: rock.unloading_ratio,
            insert_viscosity: rock.viscosity / count,
            insert_barrier: rock.energy_barrier / count,
            specific_energy: rock.specific_energy,
            specific_energy_factor: rock.specific_energy_factor,
        }
    }

    /// The rock law's parameters under a bit. Other parameters are those of the reference rock.
    ///
    /// # Errors
    /// A number of inserts or a radius that no bit has.
    pub fn under(&self, bit: &Inserts) -> Result<Rock, RockError> {
        let count = bit.count as f64;
        Domain::Between(1.0, 500.0).check("inserts", count, "")?;
        Domain::Between(1e-3, 0.05).check("insert_radius", bit.radius, "m")?;
        Domain::Between(1e7, 1e11).check("hardness", self.hardness, "Pa")?;
        Ok(Rock {
            stiffness: 2.0 * PI * bit.radius * self.hardness * count,
            unloading_ratio: self.unloading_ratio,
            viscosity: count * self.insert_viscosity,
            energy_barrier: count * self.insert_barrier,
            specific_energy: self.specific_energy,
            specific_energy_factor: self.specific_energy_factor,
            ..Parameters::default().rock
        })
    }
}

impl From<&RockType> for Ground {
    fn from(kind: &RockType) -> Self {
        let energy = kind.specific_energy();
        Self {
            hardness: kind.hardness.value,
            unloading_ratio: kind.unloading_ratio.value,
            insert_viscosity: INSERT_VISCOSITY,
            insert_barrier: INSERT_BARRIER,
            specific_energy: energy.value,
            specific_energy_factor: energy.range[1] / energy.value,
        }
    }
}

/// The inserts of a bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inserts {
    /// Number of inserts.
    pub count: usize,
    /// Radius of an insert's tip, m.
    pub radius: f64,
}

/// Usual inserts, if a bit's are not known: radius of a tip (m), and area of the hole for each insert (m2).
const USUAL: (f64, f64) = (7e-3, 8e-4);

impl Inserts {
    /// The usual inserts of a bit for a hole of this diameter (m): one of 7 mm for each 8 cm2, for example 8 for 90 mm.
    ///
    /// # Errors
    /// A diameter that no hole has.
    pub fn of_hole(diameter: f64) -> Result<Self, RockError> {
        Domain::Between(0.02, 2.0).check("hole", diameter, "m")?;
        let (radius, area) = USUAL;
        let count = (0.25 * PI * diameter * diameter / area).round().max(1.0) as usize;
        Ok(Self { count, radius })
    }
}

/// An error in a bit or a rock.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RockError {
    /// A rock that is not in the table.
    #[error("there is no rock {0:?}: there are {names}, a strength (\"180 MPa\"), or a file of a rock", names = names())]
    Unknown(String),
    /// A number out of its range.
    #[error(transparent)]
    Range(#[from] ParameterError),
}

fn names() -> String {
    let names: Vec<&str> = ROCKS.iter().map(|rock| rock.name).collect();
    names.join("; ")
}

/// Viscosity (N s/m) and energy barrier (J) of one insert: a tenth of those of the reference hammer's bit. Under a bit
/// of mass `M`, `n` inserts of stiffness `k` stand still if the viscosity of each is below `2 sqrt(k M / n)`: 1.1e4 for
/// 8 inserts of 7 mm under 3.4 kg in granite.
const INSERT_VISCOSITY: f64 = 2.5e3;
const INSERT_BARRIER: f64 = 0.12;

impl RockType {
    /// The rock for a name, a word that occurs in only one name, or a strength. Case does not matter.
    ///
    /// # Errors
    /// There is no such rock. The error lists the names that exist.
    pub fn named(name: &str) -> Result<Self, RockError> {
        let wanted = name.trim().to_lowercase();
        if let Some(number) = wanted.strip_suffix("mpa") {
            let unknown = |_| RockError::Unknown(name.into());
            let strength = 1e6 * number.trim().parse::<f64>().map_err(unknown)?;
            let [low, high] = STRENGTHS;
            Domain::Between(low, high).check("strength", strength, "Pa")?;
            return Ok(by_strength("rock of a strength", [strength; 2]));
        }
        let is = |rock: &&RockType| {
            let all = rock.name.to_lowercase();
            all == wanted || all.split(", ").any(|part| part == wanted)
        };
        let has = |rock: &&RockType| rock.name.split(' ').any(|word| word == wanted);
        let mut with = ROCKS.iter().filter(has);
        let of_word = with.next().filter(|_| with.next().is_none());
        let rock = ROCKS.iter().find(is).or(of_word);
        rock.copied().ok_or_else(|| RockError::Unknown(name.into()))
    }

    /// A sentence for each rock that is harder in this table although drillers know it to be softer.
    fn against_experience(&self) -> impl Iterator<Item = String> {
        let easier =
            ROCKS.iter().take_while(|rock| rock.name != self.name && rock.hardness.measured);
        let known = easier.filter(|_| self.hardness.measured);
        let odd = known.filter(|rock| rock.hardness.value >= self.hardness.value);
        odd.map(|rock| {
            let [low, high] = self.hardness.range;
            format!(
                "{} is softer here ({:.2} GPa) than {} ({:.2} GPa), which drillers know to be the \
                 easier rock: the tests of one insert scatter from {:.2} to {:.2} GPa. Run the upper \
                 end too.",
                self.name,
                1e-9 * self.hardness.value,
                rock.name,
                1e-9 * rock.hardness.value,
                1e-9 * low,
                1e-9 * high
            )
        })
    }

    /// The assumptions behind this rock, one sentence each.
    pub fn assumptions(&self) -> Vec<String> {
        let mut list = vec![
            "All inserts act at once, each in rock that the others do not weaken.".into(),
            format!(
                "Each insert has a viscosity of {INSERT_VISCOSITY} N s/m and an energy barrier of \
                 {INSERT_BARRIER} J: tests of single inserts cannot tell them from zero."
            ),
        ];
        list.extend(self.against_experience());
        let Figure { value, range: [low, high], source, .. } = self.specific_energy();
        list.push(format!(
            "Specific energy {:.3e} J/m3 ({low:.2e} to {high:.2e}) is assumed: {source}. One measured rate \
             replaces it.",
            value
        ));
        list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ground(name: &str) -> Ground {
        Ground::named(name).expect("a rock").0
    }

    /// An insert of the tests has the measured stiffness, to the three digits of `H`.
    #[test]
    fn one_insert_has_the_stiffness_of_its_test() {
        for (name, stiffness) in [("St Anne limestone", 1.048e8), ("kuru granite", 8.38e7)] {
            let one = ground(name).under(&Inserts { count: 1, radius: 8.51e-3 }).expect("a bit");
            assert!((one.stiffness / stiffness - 1.0).abs() < 5e-3, "{name}: {}", one.stiffness);
        }
        for rock in ROCKS {
            for figure in [rock.hardness, rock.unloading_ratio, rock.specific_energy()] {
                let Figure { value, range: [low, high], source, .. } = figure;
                assert!(low < value && value < high && !source.is_empty());
            }
        }
    }

    /// `W = H V`: the work `KR p^2 / 2` up to a depth over the volume `n pi R p^2` is the hardness.
    #[test]
    fn work_over_volume_is_the_hardness() {
        let (rock, bit) = (ground("granite"), Inserts { count: 9, radius: 7e-3 });
        let (stiffness, depth) = (rock.under(&bit).expect("a bit").stiffness, 4e-4);
        let volume = 9.0 * PI * bit.radius * depth * depth;
        let work = 0.5 * stiffness * depth * depth;
        assert!((work / volume / rock.hardness - 1.0).abs() < 1e-14);
    }

    /// Teale: the specific energy equals the strength within a factor of 1.6. For a class, the range is wider by that
    /// of its strength.
    #[test]
    fn the_specific_energy_is_about_the_strength() {
        let known = ground("180 MPa");
        assert!((known.specific_energy / 180e6 - 1.0).abs() < 1e-12);
        assert!((known.specific_energy_factor / 1.6 - 1.0).abs() < 1e-12);
        for text in ["R5", "very strong", "Very strong, R5"] {
            let class = ground(text);
            assert!((class.specific_energy / (1e8f64 * 2.5e8).sqrt() - 1.0).abs() < 1e-12);
            let factor = (0.5 * 2.5f64.ln()).hypot(1.6f64.ln()).exp();
            assert!((class.specific_energy_factor / factor - 1.0).abs() < 1e-12);
        }
        for text in ["180", "0.1 MPa", "strong rock", "MPa", "9e9 MPa"] {
            assert!(Ground::named(text).is_err(), "{text}");
        }
    }

    /// A rock that is converted to a rock under a bit and back stays the same.
    #[test]
    fn a_rock_under_a_bit_is_read_back() {
        let (rock, bit) = (ground("limestone"), Inserts { count: 9, radius: 7e-3 });
        let mut back = Ground::of(&rock.under(&bit).expect("a bit"), &bit);
        let mut rock = rock;
        for (name, _, at) in Ground::ROWS {
            assert!((*at(&mut back) / *at(&mut rock) - 1.0).abs() < 1e-14, "{name}");
        }
    }

    /// A word is enough if only one rock has it. A rock that is softer in the table than in experience is reported.
    #[test]
    fn a_word_names_a_rock_and_what_is_odd_is_told() {
        assert_eq!(RockType::named(" Granite").expect("a rock").name, "kuru granite");
        let odd = |name| ground_texts(name).iter().filter(|t| t.contains("easier rock")).count();
        assert_eq!((odd("limestone"), odd("granite"), odd("R6")), (0, 1, 0));
    }

    fn ground_texts(name: &str) -> Vec<String> {
        Ground::named(name).expect("a rock").1
    }

    /// 8 inserts of 7 mm on 90 mm, and more in proportion to the area: (140 / 90)^2 times 8 on 140 mm.
    #[test]
    fn a_hole_says_how_many_inserts_it_takes() {
        let of_hole = |diameter| Inserts::of_hole(diameter).map(|bit| bit.count);
        assert_eq!((of_hole(0.09), of_hole(0.14)), (Ok(8), Ok(19)));
        assert!(of_hole(140.0).expect_err("no hole").to_string().starts_with("hole = 140"));
    }

    #[test]
    fn what_no_bit_has_is_refused_by_name() {
        let message = |count, radius| {
            ground("R4").under(&Inserts { count, radius }).expect_err("refused").to_string()
        };
        assert!(message(0, 7e-3).starts_with("inserts = 0"));
        assert_eq!(message(8, 7.0), "insert_radius = 7 is not allowed: it must be 0.001 to 0.05 m");
        assert!(message(8, f64::NAN).contains("insert_radius"));
        let unknown = RockType::named("cheese").expect_err("none").to_string();
        assert!(unknown.contains("kuru granite") && unknown.contains("180 MPa"), "{unknown}");
    }
}
