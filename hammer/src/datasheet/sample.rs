//! The sample of hammers that fit a sheet, with medians and ranges of the numbers that follow.

use super::drilled::Drilled;
use super::member::{Blow, COUNT, Kind, Point, Row};
use super::{Datasheet, DatasheetError, Quantity};
use crate::numerics::math;
use crate::quantities::warnings::FASTEST;
use crate::scene::Scene;

/// Number of hammers. They are drawn in antithetic pairs.
const MEMBERS: usize = 240;
/// 80 % of a normal distribution lie within this many standard deviations.
const WIDE: f64 = 1.2816;
/// A quantile is the mean over this share of the weights on either side of it.
const ABOUT: f64 = 0.03;
/// How steeply a hammer's weight falls beyond the speed that steel withstands.
const SHARP: f64 = 60.0;
/// Work to the rock over blow energy: median, standard error, and maximum. The drills of RI 7300 have 0.57 to 0.79.
const SHARE: (f64, f64) = (0.68, 0.12);
const MOST: f64 = 0.95;
/// Half-widths of 80 % ranges, as factors: of a rock's hardness, and of a feed.
const HARDNESS: f64 = 1.75;
const FEED: f64 = 1.3;

#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    /// The blow with the casing held down, and the blow at the actual feed.
    pub held: Blow,
    pub blow: Blow,
    pub weight: f64,
    /// Work to the rock over blow energy; stiffness of the rock, N/m.
    pub share: f64,
    pub stiffness: f64,
    pub specific_energy: f64,
    pub feed: f64,
    /// Rate of penetration, and the rate at which the bit advances, which is an upper bound of it, m/s.
    pub rate: f64,
    pub tip_rate: f64,
    /// Largest force on the rock, N.
    pub peak: f64,
    measure: Measure,
}

/// Numbers that determine a member's rate.
#[derive(Clone, Copy, Debug)]
struct Measure {
    /// The measured rate with its random error, m/s, and the power of the blows at which it was measured, W.
    rate: Option<f64>,
    power: f64,
    area: f64,
}

pub(super) struct Sample {
    pub members: Vec<Member>,
    /// Dimensions of the median hammer.
    pub hammer: Blow,
    /// The given numbers, and the medians of the sample.
    pub solved: Vec<(Row, f64)>,
    /// Median impact speed before the limit of steel is applied, m/s.
    pub asked_speed: f64,
    /// Specific energy of the scene's rock, J/m3.
    rock_energy: f64,
}

/// A normally distributed random number for a member and a dimension. It is the same for every sheet, so that two
/// sheets can be compared member by member, and an answer changes little if its sheet changes little.
pub(super) fn drawn(member: usize, dimension: usize) -> f64 {
    let mut state = ((member as u64 / 2 + 1) << 32) | (dimension as u64 + 1);
    let mut uniform = || {
        // The generator is splitmix64 (Steele, Lea, Flood 2014).
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    uniform();
    // The sum of twelve uniform numbers has the variance 1.
    let sum: f64 = (0..12).map(|_| uniform() - 0.5).sum();
    if member.is_multiple_of(2) { sum } else { -sum }
}

/// Numbers of the random dimensions: the unknowns come first, then those below, then from `ROWS` on the noise of the
/// rows.
const ROWS: usize = 100;
const OF_SHARE: usize = 50;
const OF_HARDNESS: usize = 51;
const OF_ENERGY: usize = 52;
const OF_FEED: usize = 53;
const OF_RATE: usize = 54;
const OF_MEANS: usize = 60;
const OF_STEP: usize = 1 << 20;

impl Sample {
    /// The hammers that fit a sheet, in the rock of a scene.
    pub fn of(sheet: &Datasheet, scene: &Scene) -> Result<Self, DatasheetError> {
        let (kind, rows) = (sheet.kind()?, sheet.rows());
        let drawn_alike = |member| Point::from_fn(|k, _| drawn(member, k));
        let mut members: Vec<Point> = (0..MEMBERS).map(drawn_alike).collect();
        kind.move_to(&rows, &mut members, |member, row, step| row.noise(member, step));
        let blows: Vec<Blow> = members.iter().map(|off| kind.blow(off, None)).collect();
        let speeds = blows.iter().map(|blow| (blow.speed(), 1.0)).collect();
        let [asked_speed, slow, _] = spread(speeds);
        // Steel does not withstand faster impacts, so faster hammers lose their weight. If most are faster, the slowest
        // tenth keeps its weight.
        let weight = |blow: &Blow| {
            let over = SHARP * math::ln(blow.speed() / FASTEST.max(slow));
            1.0 / (1.0 + math::exp(over.min(500.0)))
        };
        let weights: Vec<f64> = blows.iter().map(weight).collect();
        let sum: f64 = weights.iter().sum();
        let middle = members.iter().zip(&weights).map(|(off, w)| off * *w).sum::<Point>() / sum;
        let at = sheet.at.or(sheet.get(Quantity::Pressure));
        let solved = sheet.rows().into_iter().chain(sheet.of_hammer()).map(|row| {
            let each = members.iter().zip(&weights);
            (row, spread(each.map(|(off, w)| (kind.value(&row, off), *w)).collect())[0])
        });
        let solved = solved.filter(|(row, _)| !row.assumed).collect();
        let hammer = kind.hammer(&middle, at);
        let members = members.iter().zip(blows).enumerate().map(|(member, (off, own))| {
            let blow = at.map_or(own, |at| kind.at(off, at, sheet));
            Member::of(sheet, scene, member, own, blow, weights[member])
        });
        let rock_energy = scene.parameters.rock.specific_energy;
        Ok(Self { members: members.collect(), hammer, solved, asked_speed, rock_energy })
    }

    /// Scales the sample to the simulated means `now` of its median hammer at its feed: the medians of energy,
    /// frequency, air and rate become these means. `measured` are the means under the conditions of a measured rate;
    /// they determine the specific energy.
    pub fn drill(&mut self, now: &Drilled, measured: Option<&Drilled>) {
        let median = |of: &dyn Fn(&Member) -> f64| self.number(of).0;
        let energy = now.energy / median(&|m| m.held.energy);
        let frequency = now.frequency / median(&|m| m.held.frequency);
        // The flow of a liquid is proportional to its power.
        let air = if now.flow > 0.0 { now.flow / median(&|m| m.held.driving) } else { energy };
        // The power into the rock when the rate was measured, if a rate was measured.
        let power = measured.map(|then| then.energy * then.frequency * then.share);
        let own = median(&|m| m.measure.power);
        let [mid_share, mid_stiffness] = [median(&|m| m.share), median(&|m| m.stiffness)];
        let [of_rate, of_energy, of_period, of_air] = now.errors;
        for (k, m) in self.members.iter_mut().enumerate() {
            let off = |dimension, error: f64| math::exp(error * drawn(k, OF_MEANS + dimension));
            m.blow.energy *= energy * off(0, of_energy);
            m.blow.frequency *= frequency * off(1, of_period);
            m.blow.flow *= air * off(2, of_air);
            m.blow.driving *= air * off(2, of_air);
            // In soft rock the feed does much of the work, so the rock may take more than the blow's energy.
            m.share = (m.share * now.share / mid_share).min(MOST.max(now.share));
            let mut share = m.share;
            if let (Some(power), Some(rate)) = (power, m.measure.rate) {
                // The rock takes the same share at both rates.
                share = now.share;
                m.specific_energy = power * m.measure.power / own / (m.measure.area * rate);
            }
            m.rate = share * m.blow.power() / (m.measure.area * m.specific_energy);
            m.rate *= off(3, of_rate);
            // Penetration and force of a blow are proportional to the square root of its energy.
            let work = m.share * m.blow.energy / (now.share * now.energy);
            let stiffer = m.stiffness / mid_stiffness;
            m.tip_rate = now.tip_rate * m.blow.frequency / now.frequency * (work / stiffer).sqrt();
            m.peak = now.peak * (work * stiffer).sqrt();
        }
        let rate = self.number(|m| m.rate).0;
        let middle = self.number(|m| m.specific_energy).0;
        let by = if measured.is_some() { 1.0 } else { now.rate / rate };
        // With this specific energy the scene drills at the rate of the answer.
        let energy = now.rate * self.rock_energy / (by * rate);
        for m in &mut self.members {
            m.rate = (m.rate * by).min(m.tip_rate);
            m.specific_energy *= energy / middle;
        }
    }

    /// Median and 80 % range of a number.
    pub fn number(&self, of: impl Fn(&Member) -> f64) -> (f64, [f64; 2]) {
        let [middle, low, high] = spread(self.members.iter().map(|m| (of(m), m.weight)).collect());
        (middle, [low, high])
    }
}

impl Kind {
    /// The blow of a member at the working pressure `at`. The member's pressure deviates from `at` by the same factor
    /// as from the sheet's pressure. If the sheet has none, the member works at exactly `at`.
    fn at(&self, off: &Point, at: f64, sheet: &Datasheet) -> Blow {
        let own = |given| math::exp(self.logs(off)[0]) * at / given;
        self.blow(off, Some(sheet.get(Quantity::Pressure).map_or(at, own)))
    }
}

impl Row {
    /// Random measurement error of a row for a member and a step of the smoother, in standard errors.
    fn noise(&self, member: usize, step: i32) -> f64 {
        let row = self.quantity as usize + 32 * self.series;
        drawn(member, ROWS + row + OF_STEP * step as usize)
    }
}

impl Member {
    fn of(
        sheet: &Datasheet,
        scene: &Scene,
        member: usize,
        own: Blow,
        blow: Blow,
        weight: f64,
    ) -> Self {
        let about = |dimension: usize, wide: f64| math::exp(wide * drawn(member, dimension));
        let p = &scene.parameters;
        let share = (SHARE.0 * about(OF_SHARE, SHARE.1)).min(MOST);
        let known = math::ln(p.rock.specific_energy_factor) / WIDE;
        let hardness = if sheet.own_rock { 0.0 } else { math::ln(HARDNESS) / WIDE };
        let area = p.work_per_length() / p.rock.specific_energy;
        // The specific energy refers to the work that the rock receives in the model. Here that is the usual share of
        // the blow's energy.
        let rate = sheet.get(Quantity::Rate);
        let rate = rate.map(|rate| rate * about(OF_RATE, Quantity::Rate.entry().error));
        let (drilling, specific_energy) = match rate {
            Some(rate) => (SHARE.0, SHARE.0 * own.power() / (area * rate)),
            None => (share, p.rock.specific_energy * about(OF_ENERGY, known)),
        };
        // The feed that holds the casing down may exceed the printed feeds. Then these are the lower end of the range.
        let below = sheet.usual_feeds().filter(|_| drawn(member, OF_FEED) < 0.0);
        let below = below.map_or(0.0, |[printed, usual]| math::ln(usual / printed));
        let usual = scene.inputs.feed_force * about(OF_FEED, (math::ln(FEED) + below) / WIDE);
        let stiffness = p.rock.stiffness * about(OF_HARDNESS, hardness);
        // In a single thrust up to the force F, the rock dissipates (1 - 1/gamma) F^2 / (2 KR).
        let lost = 1.0 - 1.0 / p.rock.unloading_ratio;
        Self {
            held: blow,
            blow,
            weight,
            share,
            stiffness,
            specific_energy,
            feed: sheet.get(Quantity::Feed).unwrap_or(usual),
            rate: drilling * blow.power() / (area * specific_energy),
            tip_rate: f64::INFINITY,
            peak: (2.0 * stiffness * share * blow.energy / lost).sqrt(),
            measure: Measure { rate, power: own.power(), area },
        }
    }
}

/// Median and 80 % range of weighted numbers. Each quantile is the mean of the numbers around its rank, so it changes
/// little if numbers and weights change little, even if numbers change their order.
pub fn spread(mut list: Vec<(f64, f64)>) -> [f64; 3] {
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
    let least = list.first().map_or(f64::NAN, |first| first.0);
    let all: f64 = list.iter().map(|(_, weight)| weight).sum();
    [0.5, 0.1, 0.9].map(|part| {
        let [from, to] = [part - ABOUT, part + ABOUT].map(|end| end * all);
        let (mut below, mut sum) = (0.0, 0.0);
        for (value, weight) in &list {
            let share = (below + weight).min(to) - from.max(below);
            sum += share.max(0.0) * (value - least);
            below += weight;
        }
        least + sum / (to - from)
    })
}

const _: () = assert!(COUNT < OF_SHARE && OF_RATE < OF_MEANS && OF_MEANS + 4 < ROWS);

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean, variance and 80 % range equal those of a normal distribution, within four standard errors of 24,000
    /// numbers.
    #[test]
    fn what_is_drawn_is_normal() {
        let all: Vec<f64> = (0..MEMBERS).flat_map(|m| (0..100).map(move |d| drawn(m, d))).collect();
        let count = all.len() as f64;
        let mean = all.iter().sum::<f64>() / count;
        let square = all.iter().map(|x| x * x).sum::<f64>() / count;
        let inside = all.iter().filter(|x| x.abs() < WIDE).count() as f64 / count;
        assert!(
            mean.abs() < 1e-12 && (square - 1.0).abs() < 4.0 * (4.0 / count).sqrt(),
            "{square}"
        );
        // The sum of twelve uniform numbers has 0.2 % more within the range.
        assert!((inside - 0.8).abs() < 0.003 + 4.0 * (0.32 / count).sqrt(), "{inside}");
    }

    /// The quantiles of the numbers 0 to 1000 equal those of the uniform distribution to half of one number's share.
    /// The weights are equal, or double for even and zero for odd numbers.
    #[test]
    fn a_spread_is_that_of_a_uniform_distribution() {
        let equal: Vec<(f64, f64)> = (0..=1000).map(|k| (f64::from(k), 1.0)).collect();
        let even: Vec<(f64, f64)> =
            equal.iter().map(|(x, _)| (*x, 2.0 - 2.0 * (x % 2.0))).collect();
        for list in [equal, even] {
            for (found, exact) in spread(list).iter().zip([500.0, 100.0, 900.0]) {
                assert!((found - exact).abs() < 1.0, "{found} {exact}");
            }
        }
    }
}
