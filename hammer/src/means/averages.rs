//! Means over blows, and their errors.
//!
//! The blows of a motion that does not repeat are correlated series, one from each simulation. All series are cut at
//! the same blow, after which the start no longer matters ([`transient`]). The rest is divided into batches, whose sums
//! are nearly independent. Every mean is a ratio of sums over blows. The rate of penetration, for instance, is that of
//! drilled lengths `P` and periods `T`:
//!
//! ```text
//! R = sum P / sum T,      error^2 = t^2 sum over B batches of (P_b - R T_b)^2 / (B (B - 1) mean(T_b)^2)
//! ```
//!
//! (the delta method). `t` is Student's: it widens an error that is estimated from few batches, so that the
//! true value is within one standard error in 68.3 % of all cases.

use crate::machine::blows::Blow;
use crate::numerics::math;

/// A figure of a blow.
type Of = fn(&Blow) -> f64;
/// Name of a mean, and the two figures of a blow whose sums are divided.
type Ratio = (&'static str, Of, Of);

const PERIOD: Of = |blow| blow.period;
const EACH: Of = |_| 1.0;

#[rustfmt::skip]
const RATIOS: [Ratio; Averages::COUNT] = [
    ("rop", |b| b.length, PERIOD),
    ("tip_rate", |b| b.penetration, PERIOD),
    ("blow_frequency", EACH, PERIOD),
    ("period", PERIOD, EACH),
    ("advance", |b| b.penetration, EACH),
    ("blow_speed", |b| b.speed, EACH),
    ("blow_energy", |b| b.energy, EACH),
    ("rebound_speed", |b| b.account().rebound_speed, EACH),
    ("rebound_ratio", |b| b.account().rebound_speed, |b| b.speed),
    ("contact_force_peak", |b| b.account().peaks.contact_force(), EACH),
    ("rock_force_peak", |b| b.account().peaks.rock_force(), EACH),
    ("energy_drive", |b| b.account().drive, EACH),
    ("energy_gravity", |b| b.account().gravity, EACH),
    ("energy_feed", |b| b.account().feed, EACH),
    ("energy_rock_dissipated", |b| b.account().rock_dissipated, EACH),
    ("energy_viscous", |b| b.account().viscous, EACH),
    ("energy_damping", |b| b.account().damping, EACH),
    ("air_flow", |b| b.air, PERIOD),
];

/// One number for each of [`Averages::names`]: means over blows, their errors, or their spreads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Averages(pub [f64; Averages::COUNT]);

impl Averages {
    /// Number of means.
    pub const COUNT: usize = 18;

    /// Names of the means.
    pub fn names() -> impl Iterator<Item = &'static str> {
        RATIOS.iter().map(|(name, ..)| *name)
    }

    /// The mean with this name; NaN if there is none.
    pub fn get(&self, name: &str) -> f64 {
        Self::names().position(|known| known == name).map_or(f64::NAN, |k| self.0[k])
    }

    /// The rate of penetration of the hole, m/s.
    pub fn rop(&self) -> f64 {
        self.0[0]
    }

    /// Mean speed of the piston just before it meets the bit, m/s.
    pub fn speed(&self) -> f64 {
        self.get("blow_speed")
    }

    /// The advance of the bit's tip per time, m/s.
    pub fn tip_rate(&self) -> f64 {
        self.0[1]
    }

    /// This number for both rates, and infinity for the other means: the allowed errors if only the rates matter.
    pub fn of_rates(number: f64) -> Self {
        let mut all = [f64::INFINITY; Self::COUNT];
        all[..2].fill(number);
        Self(all)
    }
}

/// Means over series of blows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Means {
    /// Means.
    pub mean: Averages,
    /// Standard errors of the means; infinite if there are too few blows.
    pub error: Averages,
    /// Standard deviations from blow to blow.
    pub spread: Averages,
    /// Number of blows.
    pub blows: usize,
}

/// Least number of batches of all series together. With fewer batches, the error would too often be too small and end
/// the search too soon. Then the least number of blows in a batch: shorter batches are correlated, as blows are.
const BATCHES: usize = 40;
const SHORTEST: usize = 4;

impl Means {
    /// The means of series of equal length that forget their start before their middle.
    pub fn of(series: &[&[Blow]]) -> Self {
        let begin = transient(series);
        let settled: Vec<&[Blow]> = series.iter().map(|list| &list[begin..]).collect();
        let all = RATIOS.map(|ratio| errors(&settled, ratio));
        let [mean, error, spread] = [0, 1, 2].map(|k| Averages(all.map(|numbers| numbers[k])));
        Self { mean, error, spread, blows: settled.iter().map(|list| list.len()).sum() }
    }

    /// The means of the blows of a cycle, which have no error.
    pub fn exact(blows: &[Blow]) -> Self {
        let all = RATIOS.map(|ratio| errors(&[blows], ratio));
        let [mean, spread] = [0, 2].map(|k| Averages(all.map(|numbers| numbers[k])));
        Self { mean, error: Averages::default(), spread, blows: blows.len() }
    }

    /// The largest standard error over the allowed error, both relative to the mean. It is at most 1 if no error is too
    /// large.
    pub fn error_ratio(&self, wanted: &Averages) -> f64 {
        let all = self.error.0.iter().zip(&self.mean.0).zip(&wanted.0);
        let wanted = all.filter(|(_, wanted)| wanted.is_finite());
        wanted.map(|((error, mean), wanted)| error / mean.abs() / wanted).fold(0.0, f64::max)
    }
}

/// Factor of a deviation that is estimated with this many degrees of freedom: the true value is within the product in
/// 68.3 % of all cases. It is Student's quantile at 84.1 %, by its expansion in the inverse of the degrees of freedom,
/// to 1e-3 for 4 and more.
fn student(freedom: f64) -> f64 {
    1.0 + 1.0 / (2.0 * freedom) + 1.0 / (4.0 * freedom * freedom)
}

/// Mean, standard error and spread of a ratio.
fn errors(series: &[&[Blow]], (_, above, below): Ratio) -> [f64; 3] {
    let sums = |list: &[Blow]| {
        list.iter().fold([0.0; 2], |[a, b], blow| [a + above(blow), b + below(blow)])
    };
    let whole =
        series.iter().map(|list| sums(list)).fold([0.0; 2], |s, t| [s[0] + t[0], s[1] + t[1]]);
    let mean = whole[0] / whole[1];
    let count: usize = series.iter().map(|list| list.len()).sum();
    let deviation = |blow: &Blow| above(blow) / below(blow) - mean;
    let squares: f64 =
        series.iter().flat_map(|list| *list).map(|b| math::powi(deviation(b), 2)).sum();
    let spread = (squares / count as f64).sqrt();
    let each = BATCHES.div_ceil(series.len().max(1));
    let (mut off, mut under, mut batches) = (0.0, 0.0, 0.0);
    for list in series.iter().filter(|list| list.len() >= SHORTEST) {
        let count = each.min(list.len() / SHORTEST);
        for batch in list.chunks_exact(list.len() / count).take(count) {
            let [a, b] = sums(batch);
            off += math::powi(a - mean * b, 2);
            under += b;
            batches += 1.0;
        }
    }
    let error = if batches > 1.0 {
        student(batches - 1.0) * (off / (batches * (batches - 1.0))).sqrt()
            / (under / batches).abs()
    } else {
        f64::INFINITY
    };
    [mean, error, spread]
}

/// The least share of a series that counts as transient. A single run cannot show a drift as large as the standard
/// error of the rest, so the series is cut later than the test suggests.
const START: f64 = 0.25;

/// The blow at which the transient ends: after a quarter of the series, or at the blow of its first half after which
/// the standard error of the rest is smallest (MSER), whichever is later. Both rates are tested, each as the mean over
/// all series, because the series have their start in common.
fn transient(series: &[&[Blow]]) -> usize {
    let count = series.iter().map(|list| list.len()).min().unwrap_or(0);
    let [hole, tip]: [Of; 2] = [|blow| blow.length, |blow| blow.penetration];
    let least = [hole, tip].map(|above| {
        let rate = |k: usize| -> f64 {
            let rates = series.iter().map(|list| above(&list[k]) / list[k].period);
            rates.sum::<f64>() / series.len() as f64
        };
        let (mut sum, mut squares, mut best) = (0.0, 0.0, (f64::INFINITY, 0));
        for k in (0..count).rev() {
            let (rate, left) = (rate(k), (count - k) as f64);
            (sum, squares) = (sum + rate, squares + rate * rate);
            let variance = (squares / left - (sum / left) * (sum / left)).max(0.0);
            if k <= count / 2 && variance / left < best.0 {
                best = (variance / left, k);
            }
        }
        best.1
    });
    least[0].max(least[1]).max((START * count as f64) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A correlated series whose error is known. The mean of `n` values of `x' = a x + noise` with unit variance has
    /// the variance `1 / (n (1 - a)^2)` for large `n`. An estimate from 40 batches scatters by the share `1 /
    /// sqrt(78)`; the bounds are three times that.
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
            list.push(of_advance(100.0 + x));
        }
        let means = Means::of(&[&list]);
        let expected = 1.0 / ((1.0 - a) * (means.blows as f64).sqrt());
        let part = means.error.tip_rate() / expected;
        assert!((part - 1.0).abs() < 3.0 / 78.0_f64.sqrt(), "{part}");
        assert!(
            (means.mean.tip_rate() - 100.0).abs() < 4.0 * expected,
            "{:?}",
            means.mean.tip_rate()
        );
        let spread = 1.0 / (1.0 - a * a).sqrt();
        assert!(
            (means.spread.tip_rate() / spread - 1.0).abs() < 0.1,
            "{}",
            means.spread.tip_rate()
        );
    }

    fn of_advance(advance: f64) -> Blow {
        Blow { period: 1.0, penetration: advance, length: advance, ..Blow::default() }
    }

    /// 40 batches of four blows have means of 100 + d and 100 - d in turn. The variance of these is `40 d^2 / 39`, and
    /// that of the whole mean is a fortieth of it. Student's quantile for 39 degrees of freedom is 1.01299.
    #[test]
    fn the_error_of_a_mean_of_few_batches_is_student_s() {
        let list: Vec<Blow> =
            (0..160).map(|k| of_advance(if k / 4 % 2 == 0 { 103.0 } else { 97.0 })).collect();
        let [mean, error, _] = errors(&[&list], RATIOS[1]);
        assert!((mean - 100.0).abs() < 1e-12);
        let expected = 1.01299 * (9.0_f64 / 39.0).sqrt();
        assert!((error / expected - 1.0).abs() < 1e-4, "{error} {expected}");
    }

    /// No test detects a drift of half a unit in the first fifth, below a noise of ten. Nothing is left of the drift
    /// after the first quarter, and the noise cancels.
    #[test]
    fn a_start_that_no_test_can_see_is_not_in_the_mean() {
        let list: Vec<Blow> = (0..400)
            .map(|k| {
                let drift = if k < 80 { 0.5 } else { 0.0 };
                of_advance(100.0 + drift + if k % 2 == 0 { 10.0 } else { -10.0 })
            })
            .collect();
        let means = Means::of(&[&list, &list]);
        assert!((means.mean.tip_rate() - 100.0).abs() < 1e-12, "{means:?}");
        assert_eq!(means.blows, 600);
    }

    /// The rate of the hole can take longer to settle than that of the tip.
    #[test]
    fn a_start_that_one_of_the_rates_shows_is_cut_off_for_all() {
        let list: Vec<Blow> = (0..400)
            .map(|k| {
                let mut blow = of_advance(if k % 2 == 0 { 101.0 } else { 99.0 });
                blow.length -= if k < 160 { 20.0 } else { 0.0 };
                blow
            })
            .collect();
        let means = Means::of(&[&list]);
        assert!((means.mean.rop() - 100.0).abs() < 1e-12, "{means:?}");
    }

    #[test]
    fn an_error_is_reached_where_all_that_are_wanted_are() {
        let mut means = Means::default();
        (means.mean.0, means.error.0) = ([-2.0; Averages::COUNT], [0.02; Averages::COUNT]);
        let mut wanted = Averages::of_rates(0.01);
        assert_eq!(means.error_ratio(&wanted), 1.0);
        wanted.0[6] = 0.005;
        assert_eq!(means.error_ratio(&wanted), 2.0);
    }

    #[test]
    fn a_rate_is_a_ratio_of_sums_and_no_mean_of_ratios() {
        let blow = |period: f64, advance: f64| Blow { period, ..of_advance(advance) };
        let means = Means::exact(&[blow(1.0, 2.0), blow(3.0, 3.0)]);
        assert_eq!([means.mean.tip_rate(), means.mean.get("blow_frequency")], [1.25, 0.5]);
        assert!(means.mean.get("no such").is_nan());
    }
}
