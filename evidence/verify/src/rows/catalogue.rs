//! Hammers of makers' catalogues, compared with the engine's air hammers.
//!
//! One number of each hammer is fitted, the area of its supply ports, to the air at the lowest pressure printed. Air
//! at two other pressures, power and frequency are held out.

use crate::rows::row::{Row, Rows};
use hammer::Scene;
use hammer::datasheet::{Datasheet, DatasheetError, Quantity};
use hammer::means::{Averages, Kind, Steady, Wanted, steady};
use hammer::presets::AirHammer;
use std::fmt::Write as _;

/// Source of the hammers, their air and their power.
const MAKER: &str = "Sandvik, *Down the Hole Rock Drilling Tools*, catalogue of 2023: outer diameter, air \
    (DIN 1343) at 150, 250 and 350 psi, power output at 24 bar; its table was read in a transcription";
const BORE_SOURCE: &str = "Drillco, *Puma 3.1 maintenance sheet*";
/// Blows per second of such hammers at 24 bar, from makers.
const FREQUENCY: [f64; 2] = [35.0, 45.0];
const EPIROC: &str = "Epiroc, *COP M6 operator's instructions*, page 6: a COP M8 at 25 bar strikes 2,160 \
    times a minute";
/// Pascals of a psi.
const PSI: f64 = 6894.757;
/// Pressures at which air is printed, Pa.
const PRESSURES: [f64; 3] = [150.0 * PSI, 250.0 * PSI, 350.0 * PSI];

/// A hammer of the catalogue.
pub struct Hammer {
    /// Nominal size.
    pub name: &'static str,
    /// Outer diameter, m.
    pub outer: f64,
    /// Free air at [`PRESSURES`], m3/min.
    pub air: [f64; 3],
    /// Power output, W.
    pub power: f64,
    /// A published piston of about that size, since the catalogue has none: mass (kg), outer diameter of its hammer
    /// (m), and source.
    pub piston: (f64, f64, &'static str),
    /// Diameter of the hole, m: a size of bit that is sold for it.
    pub hole: f64,
    /// Mass of the casing (kg) and feed that holds it down at 24 bar (N): assumed.
    pub held: (f64, f64),
}

const SPM: &str = "drillrigtools-en.com, *DTH Hammers (Medium Air Pressure)*";
const MINCON: &str = "Mincon, *DTH Product Catalogue*, read in a transcription";

const fn hammer(
    name: &'static str,
    [outer, hole]: [f64; 2],
    air: [f64; 3],
    power: f64,
    piston: (f64, f64, &'static str),
    held: (f64, f64),
) -> Hammer {
    Hammer { name, outer, air, power, piston, hole, held }
}

/// The hammers. Tests assert the first four; the printed numbers of the last contradict each other.
pub const HAMMERS: [Hammer; 5] = [
    hammer("3.5 inch", [0.085, 0.09], [4.5, 8.3, 11.1], 20.9e3, (4.1, 0.077, MINCON), (16.0, 12e3)),
    hammer("4 inch", [0.105, 0.115], [6.7, 12.5, 16.9], 29.1e3, (7.4, 0.098, SPM), (27.0, 17e3)),
    hammer("5 inch", [0.127, 0.14], [7.1, 14.9, 21.4], 31.7e3, (17.7, 0.124, MINCON), (40.0, 19e3)),
    hammer("6 inch", [0.15, 0.165], [8.8, 17.8, 24.0], 34.5e3, (23.0, 0.148, SPM), (65.0, 25e3)),
    hammer("9 inch", [0.21, 0.229], [17.6, 26.2, 32.5], 54.8e3, (43.0, 0.182, SPM), (127.0, 49e3)),
];

/// The hammer with fitted ports, and its long-run response at each of [`PRESSURES`].
pub struct Found {
    hammer: AirHammer,
    means: [Steady; 3],
}

impl Hammer {
    /// Mass of a piston scaled from the published one, kg.
    fn piston_mass(&self) -> f64 {
        let (mass, outer, _) = self.piston;
        mass * (self.outer / outer).powi(3)
    }

    /// Fits the ports to the air at one of [`PRESSURES`], and nothing else.
    pub fn solve(&self, given: usize) -> Result<Found, DatasheetError> {
        let (outer, piston, hole, (casing, feed)) =
            (self.outer, self.piston_mass(), self.hole, self.held);
        let first = AirHammer { outer, piston, casing, supply: 2e-4, hole, feed, stroke: 1.0 };
        let hammer = fitted(first, PRESSURES[given], self.air[given] / 60.0)?;
        let [low, middle, high] = PRESSURES.map(|pressure| long_run(&hammer, pressure, 0.01));
        Ok(Found { hammer, means: [low?, middle?, high?] })
    }

    /// The power (W) and its range that `datasheet` gives for the diameters, the piston and the air at one of
    /// [`PRESSURES`].
    fn predicted(&self, given: usize) -> Result<[f64; 3], DatasheetError> {
        let sheet = Datasheet {
            known: vec![
                (Quantity::OuterDiameter, self.outer),
                (Quantity::Hole, self.hole),
                (Quantity::PistonMass, self.piston_mass()),
                (Quantity::Pressure, PRESSURES[2]),
            ],
            air: vec![[PRESSURES[given], self.air[given] / 60.0]],
            ..Datasheet::default()
        };
        let found = sheet.sample(&Scene::default())?;
        let power = found.iter().find(|row| row.name == "power of the blows");
        Ok(power.map_or([f64::NAN; 3], |row| [row.value, row.range[0], row.range[1]]))
    }
}

/// The long-run response at a supply pressure (Pa). Where blows do not repeat, the standard error is at most
/// [`AIR_ERROR`] of the air and `others` of energy and frequency.
fn long_run(hammer: &AirHammer, pressure: f64, others: f64) -> Result<Steady, DatasheetError> {
    let mut error = Averages::of_rates(f64::INFINITY);
    for (number, name) in error.0.iter_mut().zip(Averages::names()) {
        match name {
            "air_flow" => *number = AIR_ERROR,
            "blow_energy" | "blow_frequency" => *number = others,
            _ => {}
        }
    }
    let wanted = Wanted { error, threads: 2, ..Wanted::default() };
    let found = steady(&hammer.at(pressure), &wanted, &mut |_, _| true)?;
    let why = match found {
        Steady { kind: Kind::Stalled, .. } => "stalls",
        Steady { reached: false, .. } => "is too irregular for a mean of 20,000 blows",
        _ => return Ok(found),
    };
    let [bar, mm2] = [1e-5 * pressure, 1e6 * hammer.supply];
    let text = format!("at {bar:.1} bar with supply ports of {mm2:.0} mm2 it {why}");
    Err(DatasheetError::Contradiction(text))
}

/// Standard error of the air of blows that do not repeat.
const AIR_ERROR: f64 = 5e-3;
/// The largest supply port over the bore's area: three times the largest of the presets.
const WIDEST: f64 = 0.1;

/// The hammer with the supply ports with which it takes this air (m3/s) at this pressure (Pa): by secants in
/// logarithms, which begin as if air were proportional to the ports.
fn fitted(mut hammer: AirHammer, pressure: f64, air: f64) -> Result<AirHammer, DatasheetError> {
    let widest = WIDEST * std::f64::consts::FRAC_PI_4 * (AirHammer::BORE * hammer.outer).powi(2);
    let (mut before, mut slope): (Option<[f64; 2]>, f64) = (None, 1.0);
    for _ in 0..12 {
        let flow = long_run(&hammer, pressure, f64::INFINITY)?.mean.get("air_flow");
        let [port, found] = [hammer.supply.ln(), flow.ln()];
        let off = air.ln() - found;
        if off.abs() < AIR_ERROR {
            return Ok(hammer);
        }
        if hammer.supply == widest && off > 0.0 {
            return Err(DatasheetError::Contradiction(format!(
                "at {:.1} bar it takes at most {:.2} m3/min (supply ports a tenth of the bore), {:.0} % less than \
                 the {:.2} printed",
                1e-5 * pressure,
                60.0 * flow,
                100.0 * (1.0 - flow / air),
                60.0 * air
            )));
        }
        if let Some([old, had]) = before {
            slope = ((found - had) / (port - old)).clamp(0.2, 3.0);
        }
        before = Some([port, found]);
        hammer.supply = (hammer.supply * (off / slope).clamp(-0.7, 0.7).exp()).min(widest);
    }
    Err(DatasheetError::Contradiction("no supply ports were found in 12 rounds".into()))
}

/// Tolerance of the held-out numbers: the error of another program of the same model with these hammers (16 %), and
/// printed digits.
const HELD_OUT: f64 = 0.17;
const WHY: &str = "17 %: what another program of the same model was off by, and printed digits; a \
    frequency: the range that makers print, in whole blows";

/// Held-out air, power and frequency of the hammers that are asserted.
pub fn rows() -> Result<Vec<Row>, DatasheetError> {
    let mut list = Vec::new();
    for hammer in &HAMMERS[..4] {
        let [_, middle, high] = hammer.solve(0)?.means.map(|means| means.mean);
        let mut rows = Rows::new(hammer.name, "catalogue", WHY);
        for (blow, air, psi) in [(middle, hammer.air[1], 250), (high, hammer.air[2], 350)] {
            let found = 60.0 * blow.get("air_flow");
            rows.add(format!("air at {psi} psi, m3/min"), air, found, HELD_OUT * air);
        }
        let [low, most] = FREQUENCY;
        rows.add("power of the blows, W", hammer.power, power(&high), HELD_OUT * hammer.power);
        // Printed as whole blows.
        let wide = 0.5 * (most - low) + 0.5;
        rows.add("blows a second", 0.5 * (low + most), high.get("blow_frequency"), wide);
        list.extend(rows.list);
    }
    Ok(list)
}

/// Power of the blows, W.
fn power(mean: &Averages) -> f64 {
    mean.get("blow_energy") * mean.get("blow_frequency")
}

/// The page.
pub fn page() -> Result<String, DatasheetError> {
    let mut out = String::new();
    sizes(&mut out)?;
    epiroc(&mut out)?;
    makers(&mut out);
    Ok(out)
}

fn sizes(out: &mut String) -> Result<(), DatasheetError> {
    let _ = write!(
        out,
        "# Hammers of a catalogue: `cargo verify --catalogue`\n\n\
         {MAKER}. The hammers are those of the presets `air_3_5_inch` to `air_6_inch`: air inside, a \
         casing, a feed; faces, stroke, ports and dead volumes alike in proportion to the area of the bore \
         (0.866 of the outer diameter: {BORE_SOURCE}), the piston like one of that size in proportion. One \
         number of each is fitted, the area of its supply ports, to the air at 150 psi. **Air at 250 and 350 \
         psi and power are held out**; frequency and impact speed are not quite: by them one shape of faces, \
         stroke and ports, the same for all sizes, was chosen among six. Where the blows do not repeat, air is a mean \
         with a standard error of at most 0.5 %, energy and frequency of 1 %.\n\n\
         | hammer | ports, mm2 | air at 150, 250, 350 psi, m3/min: published | ours | off at 250, 350 psi \
         | power at 350 psi: published, kW | ours, kW | off | `datasheet` from the air at 150 psi, 80 % of hammers, \
         kW | blows a second | blow energy, J | impact speed, m/s | rate at 200 MJ/m3 (at 310 to 130), m/h \
         |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n"
    );
    for hammer in &HAMMERS {
        let Found { hammer: fitted, means } = hammer.solve(0)?;
        let [low, middle, last] = means.map(|means| means.mean);
        let flows = [low, middle, last].map(|mean| 60.0 * mean.get("air_flow"));
        let off = |k: usize| 100.0 * (flows[k] / hammer.air[k] - 1.0);
        let power = power(&last);
        let [_, least, most] = hammer.predicted(0)?;
        let rate = 3600.0 * last.rop();
        let _ = writeln!(
            out,
            "| {} | {:.0} | {:.1}, {:.1}, {:.1} | {:.1}, {:.1}, {:.1} | {:+.0} %, {:+.0} % | {:.1} | \
             {:.1} | {:+.0} % | {:.1} to {:.1} | {:.1} | {:.0} | {:.1} | {:.0} ({:.0} to {:.0}) |",
            hammer.name,
            1e6 * fitted.supply,
            hammer.air[0],
            hammer.air[1],
            hammer.air[2],
            flows[0],
            flows[1],
            flows[2],
            off(1),
            off(2),
            1e-3 * hammer.power,
            1e-3 * power,
            100.0 * (power / hammer.power - 1.0),
            1e-3 * least,
            1e-3 * most,
            last.get("blow_frequency"),
            last.get("blow_energy"),
            last.get("blow_speed"),
            rate,
            rate * 200.0 / 310.0,
            rate * 200.0 / 130.0,
        );
    }
    nine_inches(out)?;
    let [low, high] = FREQUENCY;
    let _ = write!(
        out,
        "\nPublished frequencies are {low} to {high} a second. Not found in a source that can be checked: the energy of a blow of these hammers, their \
         frequency one by one, and rates in a rock of known specific energy.\n\n\
         | hammer | piston, kg | of a hammer of | with a piston of | source |\n|---|---|---|---|---|\n"
    );
    for hammer in &HAMMERS {
        let (mass, outer, source) = hammer.piston;
        let (name, own, outer) = (hammer.name, hammer.piston_mass(), 1e3 * outer);
        let _ = writeln!(out, "| {name} | {own:.1} | {outer} mm | {mass} kg | {source} |");
    }
    Ok(())
}

/// Finds which printed number of the nine-inch hammer contradicts the others.
fn nine_inches(out: &mut String) -> Result<(), DatasheetError> {
    let hammer = &HAMMERS[4];
    let Found { hammer: fitted, means } = hammer.solve(2)?;
    let flows = means.each_ref().map(|means| 60.0 * means.mean.get("air_flow"));
    let power = power(&means[2].mean);
    let off = |ours: f64, printed: f64| 100.0 * (ours / printed - 1.0);
    let [value, least, most] = hammer.predicted(2)?.map(|power| 1e-3 * power);
    let _ = writeln!(
        out,
        "\n**The printed numbers of the nine-inch hammer contradict each other.** From 150 to 350 psi its air grows \
         {:.2} times, that of the other four 2.5 to 3.0 times, and that of choked ports at least 2.2 times, as the \
         absolute pressure does. With the ports fitted to its air at 350 psi instead ({:.0} mm2) it has {:.1} kW \
         ({:+.0} %) and takes {:.1} and {:.1} m3/min at 150 and 250 psi ({:+.0} %, {:+.0} %). From the air at 350 psi \
         `datasheet` gives {value:.1} kW ({least:.1} to {most:.1}), which holds the {:.1} published. So the air \
         printed at 150 psi is what contradicts.",
        hammer.air[2] / hammer.air[0],
        1e6 * fitted.supply,
        1e-3 * power,
        off(power, hammer.power),
        flows[0],
        flows[1],
        off(flows[0], hammer.air[0]),
        off(flows[1], hammer.air[1]),
        1e-3 * hammer.power,
    );
    Ok(())
}

/// An 8-inch hammer of another maker, scaled from the 6-inch one by area. Nothing is fitted to it.
fn epiroc(out: &mut String) -> Result<(), DatasheetError> {
    let area = (0.181f64 / 0.15).powi(2);
    let hammer = AirHammer {
        outer: 0.181,
        piston: 43.0 * (0.181f64 / 0.182).powi(3),
        casing: 65.0 * area,
        supply: 1.9e-4 * area,
        hole: 0.203,
        feed: 25e3 * area,
        stroke: 1.0,
    };
    let mean = long_run(&hammer, 25e5, 0.01)?.mean;
    let _ = write!(
        out,
        "\n## Another maker's frequency\n\n{EPIROC}. The six-inch hammer above, by area (outside 181 mm, \
         piston {:.0} kg as SPM's of 182 mm, ports {:.0} mm2), nothing fitted: {:.0} a minute, {:.0} J, \
         {:.1} m/s, {:.1} m3/min.\n",
        hammer.piston,
        1e6 * hammer.supply,
        60.0 * mean.get("blow_frequency"),
        mean.get("blow_energy"),
        mean.get("blow_speed"),
        60.0 * mean.get("air_flow"),
    );
    Ok(())
}

/// Makers' numbers, one row for each hammer and pressure.
const MAKERS: &str = include_str!("../../../oracles/data/makers.csv");
/// Newtons of a kilogram's weight.
const KGF: f64 = 9.80665;

/// A row of that file: a hammer, the gauge pressure (Pa) and the free air (m3/s) at which it is printed.
struct Printed {
    model: &'static str,
    hammer: AirHammer,
    pressure: f64,
    air: f64,
}

impl Printed {
    /// Parses a row; none if it has no air.
    fn read(line: &'static str) -> Option<Self> {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |k: usize| cells.get(k)?.parse::<f64>().ok();
        let outer = 1e-3 * number(1)?;
        let hole = number(4).zip(number(5)).map_or(1.1 * outer, |(a, b)| 5e-4 * (a + b));
        // If no feed is recommended, the presets' feed scaled by area.
        let feed = number(9)
            .zip(number(10))
            .map_or(25e3 * (outer / 0.15).powi(2), |(a, b)| 0.5 * KGF * (a + b));
        let hammer = AirHammer::in_proportion(outer, number(6)?, hole, feed);
        Some(Self { model: cells[0], hammer, pressure: 1e5 * number(11)?, air: number(12)? / 60.0 })
    }

    /// Air at this row's pressure with the ports that are fitted to another row's air, m3/s.
    fn predicted(&self, given: &Self) -> Result<f64, DatasheetError> {
        let hammer = fitted(given.hammer, given.pressure, given.air)?;
        Ok(long_run(&hammer, self.pressure, f64::INFINITY)?.mean.get("air_flow"))
    }
}

/// Holds out each row in turn: the ports are fitted to the same hammer's row at the nearest other pressure.
fn makers(out: &mut String) {
    *out += "\n## Makers' tables, row by row\n\nEach row of `evidence/oracles/data/makers.csv` (with its sources) \
        is held out in turn: piston, diameters and feed as printed, the supply ports fitted to the air at the \
        nearest other pressure, nothing else.\n\n\
        | hammer | given at, bar | held out at, bar | air: published, m3/min | ours | off |\n|---|---|---|---|---|---|\n";
    let rows: Vec<Printed> = MAKERS.lines().filter_map(Printed::read).collect();
    let mut off = Vec::new();
    for row in &rows {
        let others = rows.iter().filter(|o| o.model == row.model && o.pressure != row.pressure);
        let apart = |o: &Printed| (o.pressure / row.pressure).ln().abs();
        let Some(given) = others.min_by(|a, b| apart(a).total_cmp(&apart(b))) else { continue };
        let cells = match row.predicted(given) {
            Ok(air) => {
                off.push((air / row.air).ln().abs());
                format!("{:.2} | {:+.0} %", 60.0 * air, 100.0 * (air / row.air - 1.0))
            }
            Err(error) => format!("{error} | |"),
        };
        let [from, to] = [given, row].map(|r| 1e-5 * r.pressure);
        let (model, air) = (row.model, 60.0 * row.air);
        let _ = writeln!(out, "| {model} | {from:.1} | {to:.1} | {air:.2} | {cells} |");
    }
    off.sort_by(f64::total_cmp);
    if let (Some(middle), Some(worst)) = (off.get(off.len() / 2), off.last()) {
        let _ = writeln!(
            out,
            "\nOff by a factor of {:.2} in the middle, {:.2} at worst, of {} rows that could be predicted. Printed \
             air that grows by a sixth from 5 to 10 bar (SPM830, SPM930) is that of no choked port.",
            middle.exp(),
            worst.exp(),
            off.len()
        );
    }
}
