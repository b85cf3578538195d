//! Means over blows, and their errors.
//!
//! Blows of a motion that does not repeat form correlated series, one of each simulation. Each is
//! cut where the standard error of what is left is the smallest (MSER); what is left falls into
//! batches, whose sums are as good as independent. Every mean is a ratio of sums over blows, for
//! instance the rate of penetration that of drilled lengths `P` and periods `T`:
//!
//! ```text
//! R = sum P / sum T,      error^2 = sum over B batches of (P_b - R T_b)^2 / (B (B - 1) mean(T_b)^2)
//! ```
//!
//! (the delta method).

/// Numbers of a blow.
pub const NUMBERS: usize = 14;
/// Time since the blow before, the tip's gain in it, impact speed and energy; from the blow
/// before to this one: last speed at which the piston left the bit, largest contact and rock force,
/// works of drive, gravity and feed, what rock, its viscosity and the bodies took, and the length
/// drilled by specific energy. SI units.
pub type Numbers = [f64; NUMBERS];

/// Name of a mean, what its sum is over, and the sum below it (none: the number of blows).
type Ratio = (&'static str, Option<usize>, Option<usize>);
#[rustfmt::skip]
const RATIOS: [Ratio; Averages::COUNT] = [
    ("rop", Some(13), Some(0)),
    ("tip_rate", Some(1), Some(0)),
    ("blow_frequency", None, Some(0)),
    ("period", Some(0), None),
    ("advance", Some(1), None),
    ("blow_speed", Some(2), None),
    ("blow_energy", Some(3), None),
    ("rebound_speed", Some(4), None),
    ("rebound_ratio", Some(4), Some(2)),
    ("contact_force_peak", Some(5), None),
    ("rock_force_peak", Some(6), None),
    ("energy_drive", Some(7), None),
    ("energy_gravity", Some(8), None),
    ("energy_feed", Some(9), None),
    ("energy_rock_dissipated", Some(10), None),
    ("energy_viscous", Some(11), None),
    ("energy_damping", Some(12), None),
];

/// A number for each of [`Averages::names`]: means over blows, or their errors, or spreads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Averages(pub [f64; Averages::COUNT]);

impl Averages {
    /// How many there are.
    pub const COUNT: usize = 17;

    /// Their names.
    pub fn names() -> impl Iterator<Item = &'static str> {
        RATIOS.iter().map(|(name, ..)| *name)
    }

    /// One by its name; NaN if there is none.
    pub fn get(&self, name: &str) -> f64 {
        Self::names().position(|known| known == name).map_or(f64::NAN, |k| self.0[k])
    }

    /// The rate of penetration of the hole, m/s.
    pub fn rop(&self) -> f64 {
        self.0[0]
    }

    /// The gain of the bit's tip per time, m/s.
    pub fn tip_rate(&self) -> f64 {
        self.0[1]
    }
}

/// What series of blows come to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Means {
    /// Means.
    pub mean: Averages,
    /// Their standard errors; infinite where there are too few blows.
    pub error: Averages,
    /// Standard deviations from blow to blow.
    pub spread: Averages,
    /// Blows that these are of.
    pub blows: usize,
}

/// Batches of all series together, at least.
const BATCHES: usize = 20;

impl Means {
    /// Of series that have each forgotten their start some time before their middle.
    pub fn of(series: &[&[Numbers]]) -> Self {
        let settled: Vec<&[Numbers]> = series.iter().map(|list| &list[transient(list)..]).collect();
        let all = RATIOS.map(|ratio| errors(&settled, ratio));
        let [mean, error, spread] = [0, 1, 2].map(|k| Averages(all.map(|numbers| numbers[k])));
        Self { mean, error, spread, blows: settled.iter().map(|list| list.len()).sum() }
    }

    /// Of the blows of a cycle: they have no error.
    pub fn exact(blows: &[Numbers]) -> Self {
        let all = RATIOS.map(|ratio| errors(&[blows], ratio));
        let [mean, spread] = [0, 2].map(|k| Averages(all.map(|numbers| numbers[k])));
        Self { mean, error: Averages::default(), spread, blows: blows.len() }
    }

    /// The larger of the standard errors of the hole's and the tip's rate, over the rate.
    pub fn relative_error(&self) -> f64 {
        let [error, mean] = [&self.error, &self.mean];
        let part = |rate: fn(&Averages) -> f64| rate(error) / rate(mean).abs();
        part(Averages::rop).max(part(Averages::tip_rate))
    }
}

/// Mean, standard error and spread of a ratio.
fn errors(series: &[&[Numbers]], (_, above, below): Ratio) -> [f64; 3] {
    let pick = |blow: &Numbers, place: Option<usize>| place.map_or(1.0, |k| blow[k]);
    let sums = |list: &[Numbers]| {
        list.iter().fold([0.0; 2], |[a, b], blow| [a + pick(blow, above), b + pick(blow, below)])
    };
    let whole =
        series.iter().map(|list| sums(list)).fold([0.0; 2], |s, t| [s[0] + t[0], s[1] + t[1]]);
    let mean = whole[0] / whole[1];
    let count: usize = series.iter().map(|list| list.len()).sum();
    let deviation = |blow: &Numbers| pick(blow, above) / pick(blow, below) - mean;
    let squares: f64 = series.iter().flat_map(|list| *list).map(|b| deviation(b).powi(2)).sum();
    let spread = (squares / count as f64).sqrt();
    let each = BATCHES.div_ceil(series.len().max(1));
    let (mut off, mut under, mut batches) = (0.0, 0.0, 0.0);
    for list in series.iter().filter(|list| list.len() >= each) {
        for batch in list.chunks_exact(list.len() / each).take(each) {
            let [a, b] = sums(batch);
            off += (a - mean * b).powi(2);
            under += b;
            batches += 1.0;
        }
    }
    let error = if batches > 1.0 {
        (off / (batches * (batches - 1.0))).sqrt() / (under / batches).abs()
    } else {
        f64::INFINITY
    };
    [mean, error, spread]
}

/// Where the transient ends: the start, up to the middle, from which on the variance of the rate
/// over the number of blows squared is the least.
fn transient(list: &[Numbers]) -> usize {
    let (mut sum, mut squares, mut best) = (0.0, 0.0, (f64::INFINITY, 0));
    for (k, blow) in list.iter().enumerate().rev() {
        let (rate, count) = (blow[1] / blow[0], (list.len() - k) as f64);
        (sum, squares) = (sum + rate, squares + rate * rate);
        let variance = (squares / count - (sum / count) * (sum / count)).max(0.0);
        if k <= list.len() / 2 && variance / count < best.0 {
            best = (variance / count, k);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A correlated series whose error is known: `x' = a x + noise` of unit variance has a mean of
    /// `n` with the variance `1 / (n (1 - a)^2)` for large `n`. The estimate of 20 batches scatters by
    /// `1 / sqrt(38)` of itself; the bounds are three times that.
    #[test]
    fn the_error_knows_of_the_correlation_between_blows() {
        let (a, count) = (0.8, 40_000);
        let mut seed = 1_u64;
        let mut noise = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
        };
        let (mut x, mut list) = (0.0, Vec::new());
        for _ in 0..count {
            x = a * x + noise();
            let mut blow = [0.0; NUMBERS];
            blow[..2].copy_from_slice(&[1.0, 100.0 + x]);
            list.push(blow);
        }
        let found = Means::of(&[&list]);
        let known = 1.0 / ((1.0 - a) * (found.blows as f64).sqrt());
        let part = found.error.tip_rate() / known;
        assert!((part - 1.0).abs() < 3.0 / 38.0_f64.sqrt(), "{part}");
        assert!((found.mean.tip_rate() - 100.0).abs() < 4.0 * known, "{:?}", found.mean.tip_rate());
        let spread = 1.0 / (1.0 - a * a).sqrt();
        assert!(
            (found.spread.tip_rate() / spread - 1.0).abs() < 0.1,
            "{}",
            found.spread.tip_rate()
        );
    }

    #[test]
    fn a_rate_is_a_ratio_of_sums_and_no_mean_of_ratios() {
        let blow = |period: f64, advance: f64| {
            let mut blow = [0.0; NUMBERS];
            (blow[0], blow[1]) = (period, advance);
            blow
        };
        let found = Means::exact(&[blow(1.0, 2.0), blow(3.0, 3.0)]);
        assert_eq!([found.mean.tip_rate(), found.mean.get("blow_frequency")], [1.25, 0.5]);
        assert!(found.mean.get("no such").is_nan());
    }
}
