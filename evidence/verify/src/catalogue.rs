//! Hammers of makers' catalogues: what is published of them, and what `hammer::datasheet` says.
//!
//! No maker publishes energy, frequency and rate of one hammer where a reader can check them. One
//! publishes the power of the blows with the air that it takes: that is held out here. A hammer is
//! solved from pressure, air, bore and piston; its power is compared with the maker's.

use crate::row::{Row, Rows};
use hammer::datasheet::{Datasheet, DatasheetError, Quantity, Solution};
use hammer::sensitivity::Scene;
use std::fmt::Write as _;

/// Where the hammers, their air and their power are from.
const MAKER: &str = "Sandvik, *Down the Hole Rock Drilling Tools*, catalogue of 2023: outer diameter, air \
    (DIN 1343) at 350 psi and power output at 24 bar; its table was read in a transcription";
/// Bore over outer diameter: its wear sleeve is 74 mm outside and 64.09 mm inside.
const BORE: f64 = 64.09 / 74.0;
const BORE_SOURCE: &str = "Drillco, *Puma 3.1 maintenance sheet*";
/// Blows a minute of one maker's hammers of 89 to 1092 mm, at 24 to 14 bar.
const FREQUENCY: [f64; 2] = [925.0, 1750.0];
const FREQUENCY_SOURCE: &str =
    "range of Numa's hammers, cnjcdrill.com, *Working Principle of Air DTH Hammer*";
/// Mean driving pressure over the supply's: one number for all, the only one that is chosen here, so that
/// the frequencies lie in that range. The power does not depend on it.
const EFFECTIVENESS: f64 = 0.45;
/// J/m3.
const SPECIFIC_ENERGY: f64 = 399e6;

/// A hammer of the catalogue.
pub struct Hammer {
    /// Nominal size.
    pub name: &'static str,
    /// Outer diameter, m.
    pub outer: f64,
    /// Free air at 350 psi, m3/min.
    pub air: f64,
    /// Power output, W.
    pub power: f64,
    /// A piston of about that size, as the catalogue says none: mass (kg), outer diameter of its hammer
    /// (m), and where they are from.
    pub piston: (f64, f64, &'static str),
    /// Hole that it drills, m: a size that is sold for it.
    pub hole: f64,
}

const SPM: &str = "drillrigtools-en.com, *DTH Hammers (Medium Air Pressure)*";
const MINCON: &str = "Mincon, *DTH Product Catalogue*, as quoted in the same repository, \
    `research/rigs/longhole-rig.md`, section 4.1";

/// The hammers.
pub const HAMMERS: [Hammer; 5] = [
    Hammer {
        name: "3.5 inch",
        outer: 0.085,
        air: 11.1,
        power: 20.9e3,
        piston: (4.1, 0.077, MINCON),
        hole: 0.09,
    },
    Hammer {
        name: "4 inch",
        outer: 0.105,
        air: 16.9,
        power: 29.1e3,
        piston: (7.4, 0.098, SPM),
        hole: 0.115,
    },
    Hammer {
        name: "5 inch",
        outer: 0.127,
        air: 21.4,
        power: 31.7e3,
        piston: (17.7, 0.124, MINCON),
        hole: 0.14,
    },
    Hammer {
        name: "6 inch",
        outer: 0.15,
        air: 24.0,
        power: 34.5e3,
        piston: (23.0, 0.148, SPM),
        hole: 0.165,
    },
    Hammer {
        name: "9 inch",
        outer: 0.21,
        air: 32.5,
        power: 54.8e3,
        piston: (43.0, 0.182, SPM),
        hole: 0.229,
    },
];

/// 350 psi, Pa.
const PRESSURE: f64 = 350.0 * 6894.757;

impl Hammer {
    /// Of a piston that is like the published one in proportion, kg.
    fn piston_mass(&self) -> f64 {
        let (mass, outer, _) = self.piston;
        mass * (self.outer / outer).powi(3)
    }

    /// What the engine makes of pressure, air, bore, piston and hole; nothing is fitted to the power.
    pub fn solve(&self) -> Result<Solution, DatasheetError> {
        let known = vec![
            (Quantity::Pressure, PRESSURE),
            (Quantity::Bore, BORE * self.outer),
            (Quantity::PistonMass, self.piston_mass()),
            (Quantity::AirFlow, self.air / 60.0),
            (Quantity::Hole, self.hole),
            (Quantity::Effectiveness, EFFECTIVENESS),
        ];
        let mut rock = Scene::default();
        rock.parameters.rock.specific_energy = SPECIFIC_ENERGY;
        Datasheet { known, own_rock: false }.solve(&rock)
    }
}

/// A number of a solution, by the beginning of its name.
fn found(solution: &Solution, name: &str) -> f64 {
    solution.found.iter().find(|row| row.name.starts_with(name)).map_or(f64::NAN, |row| row.value)
}

const WHY: &str = "a quarter, as the powers of a catalogue are computed, and its air is measured at other \
    hammers' chokes; a frequency: the range that is published";

/// Power and frequency of each.
pub fn rows() -> Result<Vec<Row>, DatasheetError> {
    let mut list = Vec::new();
    for hammer in &HAMMERS {
        let solution = hammer.solve()?;
        let mut rows = Rows::new(hammer.name, "catalogue", WHY);
        let [low, high] = FREQUENCY;
        let [power, frequency] = ["power of the blows", "frequency"].map(|n| found(&solution, n));
        rows.add("power of the blows, W", hammer.power, power, 0.25 * hammer.power);
        rows.add("blows/min", 0.5 * (low + high), 60.0 * frequency, 0.5 * (high - low));
        list.extend(rows.list);
    }
    Ok(list)
}

/// The page.
pub fn page() -> Result<String, DatasheetError> {
    let mut out = format!(
        "# Hammers of a catalogue: `cargo verify --catalogue`\n\n\
         {MAKER}. Given to the datasheet: 350 psi, the air, the bore (outer diameter times \
         {BORE:.3}: {BORE_SOURCE}), the mass of a piston like one of that size in proportion, the hole. The \
         power is held out: air that works at the supply's pressure `p` gives `P = Q / (1/p + 1/p0)`. Mass \
         and effectiveness (mean driving pressure over the supply's) do not change it, only how it is \
         divided into energy and frequency. The effectiveness is one number for all, {EFFECTIVENESS}: \
         the only one that is chosen, so that the frequencies are those of such hammers.\n\n\
         | hammer | air, m3/min | power published, kW | ours, kW | off | blow energy, J | blows/min | impact \
         speed, m/s | hole, mm | rate, m/h |\n|---|---|---|---|---|---|---|---|---|---|\n"
    );
    for hammer in &HAMMERS {
        let solution = hammer.solve()?;
        let of = |name| found(&solution, name);
        let power = of("power of the blows");
        let _ = writeln!(
            out,
            "| {} | {} | {:.1} | {:.1} | {:+.0} % | {:.0} | {:.0} | {:.1} | {:.0} | {:.0} |",
            hammer.name,
            hammer.air,
            1e-3 * hammer.power,
            1e-3 * power,
            100.0 * (power / hammer.power - 1.0),
            of("blow energy"),
            60.0 * of("frequency"),
            of("impact speed"),
            1e3 * hammer.hole,
            3600.0 * of("rate of penetration"),
        );
    }
    let [low, high] = FREQUENCY;
    let _ = write!(
        out,
        "\nPublished of frequency: {low} to {high} blows/min ({FREQUENCY_SOURCE}). The rate is that at \
         {:.0} MJ/m3, the average of hard rock (Zhang and Ouchterlony 2021): an assumption.\n\n\
         Not found in a source that can be checked: the energy of a blow of these hammers, their \
         frequency one by one, and rates in a rock of known specific energy.\n\n\
         | hammer | piston, kg | of a hammer of | with a piston of | source |\n|---|---|---|---|---|\n",
        1e-6 * SPECIFIC_ENERGY
    );
    for hammer in &HAMMERS {
        let (mass, outer, source) = hammer.piston;
        let (name, own, outer) = (hammer.name, hammer.piston_mass(), 1e3 * outer);
        let _ = writeln!(out, "| {name} | {own:.1} | {outer} mm | {mass} kg | {source} |");
    }
    Ok(out)
}
