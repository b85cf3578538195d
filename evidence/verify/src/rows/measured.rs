//! Measurements by others: one insert struck once on two rocks, and the energy of crushed volume.
//!
//! A cylindrical piston strikes a cylindrical bit with one spherical insert on rock (Yang 2025, Int. J. Rock Mech.
//! Min. Sci. 191:106125, St Anne limestone; Yang 2026, Kuru granite). Only the rock's `KR` is fitted, and only to the
//! largest penetration; all other measurements are held out. Viscosity and barrier are zero, since for one insert a
//! tenth of the reference's has no visible effect. The unloading ratio has no effect before the turn, and determines
//! the rebound.

use crate::rows::mesh;
use crate::rows::row::{Row, Rows};
use hammer::{Error, InputValues, Machine, Parameters, Segment};
use std::fmt::Write as _;

/// A measured blow. Numbers were read from figures, to about a tenth.
pub struct Test {
    /// Rock and source.
    pub name: &'static str,
    /// Impact speed, m/s.
    pub speed: f64,
    /// Largest penetration, m, and its range over blows.
    pub penetration: [f64; 3],
    /// End of loading after the strike, s.
    pub loading: f64,
    /// Indentation speed, m/s.
    pub indentation: f64,
    /// Rebound of the bit, m/s.
    pub rebound: f64,
    /// Unloading ratio for the held-out rebound, within the range of the rocks' unloading.
    pub ratio: f64,
}

/// The two tests.
pub const TESTS: [Test; 2] = [
    Test {
        name: "St Anne limestone (Yang 2025)",
        speed: 10.66,
        penetration: [1.05e-3, 0.945e-3, 1.155e-3],
        loading: 254e-6,
        indentation: 7.9,
        rebound: 4.2,
        ratio: 5.5,
    },
    Test {
        name: "Kuru granite (Yang 2026)",
        speed: 9.0,
        penetration: [1.0e-3, 0.6e-3, 1.1e-3],
        loading: 255e-6,
        indentation: 5.62,
        rebound: 4.65,
        ratio: 3.0,
    },
];

/// Windows of the penetration, over its largest value, in which the indentation speed is a slope.
pub const WINDOWS: [[f64; 2]; 3] = [[0.1, 0.9], [0.2, 0.6], [0.3, 0.7]];

/// The engine's results of a blow.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Largest penetration, m.
    pub penetration: f64,
    /// End of loading after the strike, s.
    pub loading: f64,
    /// Slopes of the penetration over the windows, m/s.
    pub slopes: [f64; WINDOWS.len()],
    /// Largest upward mean velocity of the bit, as it leaves the rock, m/s.
    pub rebound: f64,
    /// Largest rock force, N.
    pub force: f64,
}

/// Sampling step of the penetration, s, and duration, s.
const STEP: f64 = 0.5e-6;
const SPAN: f64 = 1e-3;

fn scene(speed: f64, stiffness: f64, ratio: f64) -> Parameters {
    let area = |width: f64| std::f64::consts::FRAC_PI_4 * width * width;
    let mut p = mesh::bare(40);
    p.mesh.degree = 5;
    p.material.youngs_modulus = 200e9;
    p.cross_section = area(0.030);
    p.piston.segments.set(&[Segment { length: 0.26, area: area(0.0265) }]);
    p.bit.length = 0.265;
    p.piston.initial_velocity = speed;
    p.material.damping_time = 2e-8;
    (p.rock.stiffness, p.rock.unloading_ratio) = (stiffness, ratio);
    p
}

/// One blow of the test rig on rock of this stiffness (N/m) and unloading ratio.
pub fn strike(speed: f64, stiffness: f64, ratio: f64) -> Result<Found, Error> {
    let p = scene(speed, stiffness, ratio);
    let mut m = Machine::new(&p, &mesh::no_inputs(), 0.0)?;
    let struck = p.contact.initial_gap / speed;
    let (mut path, mut force, mut rebound) = (Vec::new(), 0.0f64, 0.0f64);
    while m.time() < SPAN {
        m.advance(m.time() + STEP)?;
        force = force.max(m.peaks().rock_force());
        let k = m.kinematics();
        rebound = rebound.max(-k.bit.velocity);
        path.push([m.time(), k.tip.displacement]);
    }
    let mut top = [0.0; 2];
    for point in &path {
        top = if point[1] > top[1] { *point } else { top };
    }
    let at = |part: f64| path.iter().find(|point| point[1] >= part * top[1]).map_or(0.0, |p| p[0]);
    let slopes = WINDOWS.map(|[a, b]| (b - a) * top[1] / (at(b) - at(a)));
    Ok(Found { penetration: top[1], loading: top[0] - struck, slopes, rebound, force })
}

impl Test {
    /// Loading stiffness (N/m) at which the largest penetration is the measured one, by secants in logarithms. The
    /// penetration falls about as `KR^(-1/2)`.
    pub fn stiffness(&self) -> Result<f64, Error> {
        let off = |k: f64| -> Result<f64, Error> {
            Ok((strike(self.speed, k, self.ratio)?.penetration / self.penetration[0]).ln())
        };
        let (mut a, mut b) = (8e7f64, 1.2e8f64);
        let (mut fa, mut fb) = (off(a)?, off(b)?);
        for _ in 0..4 {
            let next = (b.ln() - fb * (b.ln() - a.ln()) / (fb - fa)).exp();
            (a, fa, b) = (b, fb, next);
            fb = off(b)?;
        }
        Ok(b)
    }
}

const TENTH: &str = "a tenth, to which the figures were read; the scatter of the penetration, which a time follows by half and a speed whole";

/// The held-out quantities of both tests.
pub fn rows() -> Result<Vec<Row>, Error> {
    let mut list = Vec::new();
    for test in &TESTS {
        let found = strike(test.speed, test.stiffness()?, test.ratio)?;
        let [middle, low, high] = test.penetration;
        let scatter = 0.5 * (high - low) / middle;
        let mut rows = Rows::new(test.name, "measured, figures", TENTH);
        let within = |value: f64, part: f64| value * (0.1 + part * scatter);
        let (loading, slope) = (1e6 * test.loading, test.indentation);
        rows.add("end of loading, us", loading, 1e6 * found.loading, within(loading, 0.5));
        for (window, ours) in ["10 to 90 %", "20 to 60 %"].iter().zip(found.slopes) {
            rows.add(format!("indentation speed, {window}, m/s"), slope, ours, within(slope, 1.0));
        }
        rows.add("rebound, m/s", test.rebound, found.rebound, within(test.rebound, 1.0));
        list.extend(rows.list);
    }
    Ok(list)
}

/// Blow energies (J) and permanent penetration of a blow (m) of the settled reference hammer, at fractions of its
/// driving force.
pub fn blows() -> Result<Vec<[f64; 2]>, Error> {
    let one = |part: f64| {
        let mut p = Parameters::default();
        p.drive.amplitude *= part;
        let mut m = Machine::new(&p, &InputValues::default(), 0.0)?;
        m.advance(2.0)?;
        let settled = || m.step_blows().iter().rev().take(20);
        let mean = |of: fn(&hammer::Blow) -> f64| settled().map(of).sum::<f64>() / 20.0;
        Ok([mean(|blow| blow.energy), mean(|blow| blow.penetration)])
    };
    [0.5, 0.6, 0.7, 0.85, 1.0, 1.2, 1.4, 1.7, 2.0].into_iter().map(one).collect()
}

/// Exponent of a power law by least squares in logarithms, and its standard error.
pub fn exponent(points: &[[f64; 2]]) -> [f64; 2] {
    let n = points.len() as f64;
    let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::ln)).collect();
    let mean = [0, 1].map(|k| logs.iter().map(|p| p[k]).sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        logs.iter().map(|p| f(p[0] - mean[0], p[1] - mean[1])).sum()
    };
    let (xx, xy) = (sum(&|x, _| x * x), sum(&|x, y| x * y));
    let slope = xy / xx;
    let rest = sum(&|x, y| (y - slope * x).powi(2));
    [slope, (rest / (n - 2.0) / xx).sqrt()]
}

/// The page.
pub fn page() -> Result<String, Error> {
    let mut out = String::from(
        "# Measured by others: `cargo verify --measured`\n\n\
         One spherical insert of radius 8.51 mm, a piston of 26.5 mm by 260 mm on a bit of 30 mm by \
         265 mm, E 200 GPa, struck once. Measurements of Aising, published by Yang (2025, IJRMMS \
         191:106125) and Yang (2026), read off figures to a tenth. `KR` is found from the largest \
         penetration alone; the rest is held out. A slope says which part of the penetration it is \
         taken over: the window decides as much as the rock. The rebound is the bit's mean velocity as it leaves \
         the rock. In brackets: at `KR` from the ends of \
         the scatter of the penetration (limestone: the tenth of the reading).\n",
    );
    for test in &TESTS {
        let [middle, low, high] = test.penetration;
        let found = |penetration| -> Result<(f64, Found), Error> {
            let test = Test { penetration: [penetration, low, high], name: "", ..*test };
            let stiffness = test.stiffness()?;
            Ok((stiffness, strike(test.speed, stiffness, test.ratio)?))
        };
        let all = [found(middle)?, found(low)?, found(high)?];
        let cell = |of: &dyn Fn(&(f64, Found)) -> f64, unit: f64, digits: usize| {
            let [a, b, c] = [0, 1, 2].map(|k| of(&all[k]) / unit);
            format!("{a:.digits$} ({:.digits$} to {:.digits$})", b.min(c), b.max(c))
        };
        let _ = write!(
            out,
            "\n## {}, {} m/s\n\n`KR` {} 1e8 N/m.\n\n| quantity | measured | ours |\n|---|---|---|\n\
             | penetration, mm (fitted) | {:.2} ({:.2} to {:.2}) | {} |\n\
             | end of loading, us | {:.0} | {} |\n",
            test.name,
            test.speed,
            cell(&|f| f.0, 1e8, 3),
            1e3 * middle,
            1e3 * low,
            1e3 * high,
            cell(&|f| f.1.penetration, 1e-3, 2),
            1e6 * test.loading,
            cell(&|f| f.1.loading, 1e-6, 0),
        );
        for (k, [a, b]) in WINDOWS.iter().enumerate() {
            let _ = writeln!(
                out,
                "| indentation speed, slope from {:.0} to {:.0} %, m/s | {} | {} |",
                100.0 * a,
                100.0 * b,
                test.indentation,
                cell(&|f| f.1.slopes[k], 1.0, 2),
            );
        }
        for ratio in [2.0, 3.0, 4.0, 5.5, 7.0] {
            let rebound = strike(test.speed, all[0].0, ratio)?.rebound;
            let _ = writeln!(
                out,
                "| rebound at an unloading ratio of {ratio}, m/s | {} | {rebound:.2} |",
                test.rebound
            );
        }
        let force = cell(&|f| f.1.force, 1e3, 0);
        let _ = writeln!(out, "| largest force, kN | not measured | {force} |");
    }
    out += "\nFor scale: a finite-discrete-element code by others gives 1.29 mm, 7.34 m/s and 284 us \
        for the limestone in 105,690 s of computing; these blows take milliseconds each.\n";
    let points = blows()?;
    let [slope, error] = exponent(&points);
    let _ = write!(
        out,
        "\n## Energy of volume\n\n\
         The US Bureau of Mines found in nine rocks (RI 7300) that the energy per volume broken does \
         not depend on the blow's energy. A spherical insert pressed in by `p` breaks `pi R p^2`. Of \
         the settled reference hammer at 0.5 to 2 times its driving force, the penetration of a blow \
         goes like its energy to the power {slope:.3} +- {error:.3} (standard error), so the volume \
         like {:.3} +- {:.3}.\n\n| energy of a blow, J | penetration, mm |\n|---|---|\n",
        2.0 * slope,
        2.0 * error,
    );
    for [energy, penetration] in points {
        let _ = writeln!(out, "| {energy:.1} | {:.4} |", 1e3 * penetration);
    }
    Ok(out)
}
