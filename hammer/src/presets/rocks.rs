//! Rocks by name, and the rock law's parameters for a bit of many inserts.
//!
//! A spherical insert of radius `R` pressed by `p << R` into rock of constant hardness `H` touches it on
//! the area `2 pi R p`; `n` of them side by side make the straight loading line
//!
//! ```text
//! F = 2 pi R H n p,      KR = 2 pi R H n,      work = H x volume,  volume = n pi R p^2
//! ```
//!
//! The ratio `gamma` of unloading to loading follows from how fast an insert rebounds. Viscosity and
//! energy barrier are bounded by the same tests: 1.7e4 N s/m and 0.4 J cannot be told from none there, ten
//! times as much is excluded. Each insert is given less, [`INSERT_VISCOSITY`] and [`INSERT_BARRIER`], with
//! which the bits of hammers stand still between blows; it is an assumption.

use crate::quantities::domain::{Domain, ParameterError};
use crate::quantities::parameters::{Parameters, Rock};
use std::f64::consts::PI;
use thiserror::Error;

/// Diameter of the bit that the reference rock's parameters are taken for, m: that of a 3 inch hammer.
pub(crate) const REFERENCE_HOLE: f64 = 0.09;

impl Rock {
    /// Makes rock under a bit like the reference's that under one of another diameter (m), by its area.
    pub(crate) fn spread(&mut self, diameter: f64) {
        let share = (diameter / REFERENCE_HOLE) * (diameter / REFERENCE_HOLE);
        self.stiffness *= share;
        self.viscosity *= share;
        self.energy_barrier *= share;
    }
}

/// A number of a rock, with what it is known by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// The number, SI.
    pub value: f64,
    /// The least and the largest that the source allows.
    pub range: [f64; 2],
    /// Where it is from, and how it follows from there.
    pub source: &'static str,
    /// False of an assumption.
    pub measured: bool,
}

/// A rock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RockType {
    /// Its name.
    pub name: &'static str,
    /// Hardness `H`, Pa.
    pub hardness: Figure,
    /// Ratio `gamma` of unloading to loading stiffness.
    pub unloading_ratio: Figure,
    /// Work that breaks a volume of it out of a hole, J/m3; `None` where there is no number.
    pub specific_energy: Option<Figure>,
}

/// The rocks, in the order in which drillers know them to be harder. Hardness is from the deepest penetration `p` of one insert of 8.51 mm: the loading line
/// that stops the piston at `p` has the stiffness `KR = 2 pi R H`, and the ratio is that of the same
/// blow's rebound (`reports/measured.md`).
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
        specific_energy: None,
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
        specific_energy: Some(Figure {
            value: 219e6,
            range: [150e6, 320e6],
            source: "no single rock: midway between a field rate in granite (165 mm, 22.5 m/h with its size's \
                     34.5 kW: 150 MJ/m3) and the average of hard rock (Zhang and Ouchterlony 2021: 399 \
                     MJ/m3 of blow energy, of which the rock takes 0.57 to 0.79, up to 320)",
            measured: false,
        }),
    },
];

/// What a bit is to the rock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inserts {
    /// How many.
    pub count: usize,
    /// Radius of each one's tip, m.
    pub radius: f64,
}

/// Of a bit whose inserts are not known: radius of each one's tip (m), and hole that it has to break (m2).
const USUAL: (f64, f64) = (7e-3, 8e-4);

impl Inserts {
    /// Those of a bit for a hole of a diameter (m): one of 7 mm for each 8 cm2, as the 8 on 90 mm.
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

/// What a bit or a rock cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RockError {
    /// A rock that is not in the table.
    #[error("there is no rock {0:?}: there are {names}", names = names())]
    Unknown(String),
    /// A number out of its range.
    #[error(transparent)]
    Range(#[from] ParameterError),
}

fn names() -> String {
    let names: Vec<&str> = ROCKS.iter().map(|rock| rock.name).collect();
    names.join(", ")
}

/// Viscosity (N s/m) and energy barrier (J) that one insert is given: a tenth of what the reference's bit
/// has. `n` inserts of stiffness `k` under a bit of mass `M` stand still below `2 sqrt(k M / n)` each, 1.1e4
/// for the 8 of 7 mm under 3.4 kg in granite.
const INSERT_VISCOSITY: f64 = 2.5e3;
const INSERT_BARRIER: f64 = 0.12;

impl Figure {
    /// The factor by which the ends of the range are off the value, where it is in their middle.
    fn factor(&self) -> f64 {
        let [low, high] = self.range;
        (high / low).sqrt()
    }
}

impl RockType {
    /// The rock of a name, or of a word that only one name has; letters may be large or small.
    ///
    /// # Errors
    /// There is none of it; the names that there are.
    pub fn named(name: &str) -> Result<&'static Self, RockError> {
        let wanted = name.trim().to_lowercase();
        let has = |rock: &&Self| rock.name.split(' ').any(|word| word == wanted);
        let mut with = ROCKS.iter().filter(has);
        let of_word = with.next().filter(|_| with.next().is_none());
        let rock = ROCKS.iter().find(|rock| rock.name == wanted).or(of_word);
        rock.ok_or_else(|| RockError::Unknown(name.into()))
    }

    /// A sentence for each rock that drillers know to be softer, and that is harder in this table.
    fn against_experience(&self) -> impl Iterator<Item = String> {
        let easier = ROCKS.iter().take_while(|rock| rock.name != self.name);
        let odd = easier.filter(|rock| rock.hardness.value >= self.hardness.value);
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

    /// The rock law's parameters under a bit: stiffness, ratio, viscosity, barrier, and the specific
    /// energy where there is one. All else stays the reference's.
    ///
    /// # Errors
    /// A number of inserts or a radius that no bit has.
    pub fn under(&self, bit: &Inserts) -> Result<Rock, RockError> {
        let count = bit.count as f64;
        Domain::Between(1.0, 500.0).check("inserts", count, "")?;
        Domain::Between(1e-3, 0.05).check("insert_radius", bit.radius, "m")?;
        let reference = Parameters::default().rock;
        Ok(Rock {
            stiffness: 2.0 * PI * bit.radius * self.hardness.value * count,
            unloading_ratio: self.unloading_ratio.value,
            viscosity: count * INSERT_VISCOSITY,
            energy_barrier: count * INSERT_BARRIER,
            specific_energy: self
                .specific_energy
                .map_or(reference.specific_energy, |figure| figure.value),
            specific_energy_factor: self
                .specific_energy
                .map_or(reference.specific_energy_factor, |figure| figure.factor()),
            ..reference
        })
    }

    /// What is assumed where this rock is used, a sentence each.
    pub fn assumptions(&self) -> Vec<String> {
        let mut list = vec![
            "All inserts act at once, each in rock that the others do not weaken.".into(),
            format!(
                "Each insert has a viscosity of {INSERT_VISCOSITY} N s/m and an energy barrier of \
                 {INSERT_BARRIER} J: tests of single inserts cannot tell them from zero."
            ),
        ];
        list.extend(self.against_experience());
        match &self.specific_energy {
            None => list.push(format!(
                "No specific energy is known of {}: that of any rock is taken. Give one, or a measured \
                 rate.",
                self.name
            )),
            Some(figure) if !figure.measured => list.push(format!(
                "Specific energy {:.0} MJ/m3 is assumed: {}.",
                1e-6 * figure.value,
                figure.source
            )),
            Some(_) => {}
        }
        list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One insert of the tests has the stiffness that the tests gave, to the three digits of `H`.
    #[test]
    fn one_insert_has_the_stiffness_of_its_test() {
        for (name, stiffness) in [("St Anne limestone", 1.048e8), ("kuru granite", 8.38e7)] {
            let rock = RockType::named(name).expect("a rock");
            let one = rock.under(&Inserts { count: 1, radius: 8.51e-3 }).expect("a bit");
            assert!((one.stiffness / stiffness - 1.0).abs() < 5e-3, "{name}: {}", one.stiffness);
            for figure in [Some(rock.hardness), Some(rock.unloading_ratio), rock.specific_energy] {
                let Some(Figure { value, range: [low, high], source, .. }) = figure else {
                    continue;
                };
                assert!(low < value && value < high && !source.is_empty());
            }
            // The middle of its range in proportion, to three digits: one factor tells both ends.
            if let Some(figure) = rock.specific_energy {
                let ends = [figure.value / figure.factor(), figure.value * figure.factor()];
                let off = |k: usize| (ends[k] / figure.range[k] - 1.0).abs();
                assert!(off(0) < 2e-3 && off(1) < 2e-3, "{ends:?}");
            }
        }
    }

    /// `W = H V`: the work `KR p^2 / 2` up to a depth over the volume `n pi R p^2` is the hardness.
    #[test]
    fn work_over_volume_is_the_hardness() {
        let (rock, bit) = (&ROCKS[1], Inserts { count: 9, radius: 7e-3 });
        let (stiffness, depth) = (rock.under(&bit).expect("a bit").stiffness, 4e-4);
        let volume = 9.0 * PI * bit.radius * depth * depth;
        let work = 0.5 * stiffness * depth * depth;
        assert!((work / volume / rock.hardness.value - 1.0).abs() < 1e-14);
    }

    /// A word that one rock has is enough; a rock that comes out softer than drillers know says so.
    #[test]
    fn a_word_names_a_rock_and_what_is_odd_is_told() {
        assert_eq!(RockType::named(" Granite").expect("a rock").name, "kuru granite");
        for rock in ROCKS {
            let easier = ROCKS.iter().take_while(|other| other.name != rock.name);
            let odd = easier.filter(|other| other.hardness.value >= rock.hardness.value).count();
            let texts = rock.assumptions();
            assert_eq!(texts.iter().filter(|text| text.contains("easier rock")).count(), odd);
        }
        assert!(RockType::named("kuru granite").expect("it").assumptions().len() > 3);
    }

    /// 8 inserts of 7 mm on 90 mm, and as many more as the hole is wider: 140 mm has (140 / 90)^2 times 8.
    #[test]
    fn a_hole_says_how_many_inserts_it_takes() {
        let of_hole = |diameter| Inserts::of_hole(diameter).map(|bit| bit.count);
        assert_eq!((of_hole(0.09), of_hole(0.14)), (Ok(8), Ok(19)));
        assert!(of_hole(140.0).expect_err("no hole").to_string().starts_with("hole = 140"));
    }

    #[test]
    fn what_no_bit_has_is_refused_by_name() {
        let message = |count, radius| {
            ROCKS[0].under(&Inserts { count, radius }).expect_err("refused").to_string()
        };
        assert!(message(0, 7e-3).starts_with("inserts = 0"));
        assert_eq!(message(8, 7.0), "insert_radius = 7 is not allowed: it must be 0.001 to 0.05 m");
        assert!(message(8, f64::NAN).contains("insert_radius"));
        let unknown = RockType::named("cheese").expect_err("none").to_string();
        assert!(unknown.contains("kuru granite"), "{unknown}");
    }
}
