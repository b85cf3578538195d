//! The statements of `search::tracker`, one by one, on thousands of drawn guards. The true course of a guard is
//! enclosed in balls, whose radii include all rounding.

use crate::scenes::Random;
use hammer::modal::structure::Structure;
use hammer::modal::system::{Recipe, System};
use hammer::modal::track::Track;
use hammer::numerics::poly::Poly;
use hammer::search::signal::{Part, Signal};
use hammer::search::tracker::{GuardTracker, Work};
use hammer::{Mode, RockMode};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Resolution.
const R: f64 = 1e-9;
/// Error of the engine's own motion, over `R`: a thousand rotations, each with a rounding of amplitudes that sum to
/// 10, and frequencies to a rounding over 1000 rad: below 0.01.
const MOTION: f64 = 0.02;
const MODE: Mode = Mode::starting(RockMode::FreeFlight);

/// Ten to the power of a number that is uniform between two.
fn power_of_ten(random: &mut Random, low: f64, high: f64) -> f64 {
    10f64.powf(random.between(low, high))
}

/// `c0 + c1 t + c2 t^2 + sum a cos(w t + p)`, whose course is known in closed form.
#[derive(Clone, Debug)]
struct Guard {
    waves: Vec<[f64; 3]>,
    drift: [f64; 3],
}

impl Guard {
    /// A few waves of any frequencies, or many that cancel at the start, or two that nearly
    /// agree (a slow beat); with a drift in a third of the cases.
    fn drawn(random: &mut Random) -> Self {
        let base = power_of_ten(random, 3.0, 5.0);
        let waves: Vec<[f64; 3]> = match (5.0 * random.unit()) as usize {
            0 => {
                // `sum (-1)^k C(n, k) cos((k + 1) x)` is of size `x^n` near 0.
                let n = 3 + (12.0 * random.unit()) as u32;
                let choose = |k| (0..k).fold(1.0, |b, i| b * f64::from(n - i) / f64::from(i + 1));
                let size = 8.0 / 2f64.powi(n as i32);
                let sign = |k| if k % 2 == 0 { size } else { -size };
                (0..=n).map(|k| [base * f64::from(k + 1), sign(k) * choose(k), 0.0]).collect()
            }
            1 => {
                let (apart, phase) = (random.between(0.05, 0.2), random.between(0.0, TAU));
                let beat = base * (1.0 + apart);
                vec![[base, 1.0, phase], [beat, random.between(-1.0, 1.0), phase]]
            }
            _ => {
                let count = 1 + (5.0 * random.unit()) as usize;
                let wave = |_| {
                    let w = base * power_of_ten(random, 0.0, 2.0);
                    [w, random.between(0.05, 0.6), random.between(0.0, TAU)]
                };
                (0..count).map(wave).collect()
            }
        };
        let mut guard = Self { waves, drift: [0.0; 3] };
        if random.unit() < 1.0 / 3.0 {
            let w = guard.fastest() * power_of_ten(random, -2.0, -0.5);
            guard.drift[1] = random.between(-0.5, 0.5) * w;
            guard.drift[2] = random.between(-0.1, 0.1) * w * w;
        }
        guard
    }

    fn fastest(&self) -> f64 {
        self.waves.iter().fold(0.0, |a, w| a.max(w[0]))
    }

    /// A ball that contains the value, and the slope.
    fn ball(&self, t: f64) -> ([f64; 2], f64) {
        let [c0, c1, c2] = self.drift;
        let (mut value, mut slope) = (c0 + t * (c1 + t * c2), c1 + 2.0 * t * c2);
        let mut radius = 4.0 * f64::EPSILON * (c0.abs() + t * (c1.abs() + t * c2.abs()));
        for [w, a, p] in &self.waves {
            let x = w * t + p;
            value += a * x.cos();
            slope -= a * w * x.sin();
            // Rounding of its argument, of its cosine, and of its share in the sum.
            radius += f64::EPSILON * a.abs() * (x.abs() + p.abs() + 1.0 + self.waves.len() as f64);
        }
        ([value, radius], slope)
    }

    fn value(&self, t: f64) -> f64 {
        self.ball(t).0[0]
    }

    fn curvature(&self) -> f64 {
        let waves = self.waves.iter().map(|[w, a, _]| a.abs() * w * w);
        waves.sum::<f64>() + 2.0 * self.drift[2].abs()
    }

    /// True if the guard is proved to stay below `level` from `start` to `end`; false if a point is proved not to be
    /// below, or if nothing can be proved.
    fn is_below(&self, level: f64, start: f64, end: f64) -> bool {
        let curvature = self.curvature();
        let mut parts = vec![[start, end]];
        while let Some([a, b]) = parts.pop() {
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a) * (1.0 + 1e-15));
            let ([value, radius], slope) = self.ball(middle);
            // The slope's own rounding is far below a thousandth of the second term.
            let reach = slope.abs() * half + 0.5001 * curvature * half * half;
            if value + radius + reach < level {
                continue;
            }
            if value - radius >= level || middle <= a || middle >= b {
                return false;
            }
            parts.extend([[middle, b], [a, middle]]);
        }
        true
    }

    /// Maxima and minima up to `end` in order, `[time, value]`: where the slope changes sign between points so close
    /// that a bound on the curvature excludes others. Two turns between two of them differ by less than a hundredth
    /// of a resolution.
    fn turns(&self, end: f64) -> Vec<[f64; 2]> {
        let step = 0.02 / self.fastest();
        let count = (end / step).ceil() as usize;
        let slope = |t: f64| self.ball(t).1;
        let mut turns = vec![[0.0, self.value(0.0)]];
        for i in 0..count {
            let (mut a, mut b) = (i as f64 * step, ((i + 1) as f64 * step).min(end));
            let rises = slope(a) > 0.0;
            if rises == (slope(b) > 0.0) {
                continue;
            }
            for _ in 0..70 {
                let middle = 0.5 * (a + b);
                if (slope(middle) > 0.0) == rises { a = middle } else { b = middle }
            }
            turns.push([a, self.value(a)]);
        }
        turns.push([end, self.value(end)]);
        turns
    }

    fn track(&self) -> Track {
        let omega2: Vec<f64> = self.waves.iter().map(|w| w[0] * w[0]).collect();
        let system = system(&omega2);
        let displacements = self.waves.iter().map(|[_, a, p]| a * p.cos());
        let velocities = self.waves.iter().map(|[w, a, p]| -a * w * p.sin());
        let state: Vec<f64> = displacements.chain(velocities).collect();
        let mut z = vec![0.0; 2 * system.blocks()];
        system.to_modal(&state, &mut z);
        Track { system, z, at: 0.0 }
    }

    /// Tracks the guard up to `until`, or to a crossing, with bounded work.
    fn search(&self, until: f64) -> GuardTracker {
        let mut poly = Poly::default();
        poly.0[..3].copy_from_slice(&self.drift);
        let part = Part { track: 0, functional: 0, factor: 1.0 };
        let mut tracker = GuardTracker::new(Signal::new(poly, [Some(part), None], 0, R), 0.0);
        let (mut tracks, mut work) = (vec![self.track()], Work::default());
        while tracker.root.is_none() && tracker.clear <= until {
            tracker.extend(&mut tracks, &mut work);
            assert!(work.evaluations < 100_000, "it crawls at {}: {self:?}", tracker.clear);
        }
        tracker
    }
}

fn system(omega2: &[f64]) -> Arc<System> {
    let n = omega2.len();
    let recipe = Recipe {
        structure: Structure::free(omega2, 0.0),
        loads: std::array::from_fn(|_| vec![0.0; n]),
        functionals: vec![vec![1.0; n]],
        dampers: Vec::new(),
    };
    Arc::new(System::new(recipe, None, MODE).expect("a spectrum"))
}

/// Guards that start below zero, and whose highest maximum so far, drawn at random, is `x` resolutions above zero,
/// with `x` drawn from `range`. Each comes with `x`, the time of that maximum, and the end of its time.
fn tangents(
    seed: u64,
    count: usize,
    range: [f64; 2],
    mut check: impl FnMut(&Guard, f64, f64, f64),
) {
    let mut random = Random::new(seed);
    let mut checked = 0;
    while checked < count {
        let mut guard = Guard::drawn(&mut random);
        let until = power_of_ten(&mut random, 0.0, 1.8) / guard.fastest();
        let turns = guard.turns(until);
        // Without the start and the end.
        let inside = &turns[1..turns.len() - 1];
        let Some(top) = inside.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1])) else {
            continue;
        };
        let x = random.between(range[0], range[1]);
        guard.drift[0] += x * R - top[1];
        if guard.value(0.0) < -20.0 * R && guard.value(until) < -20.0 * R {
            check(&guard, x, top[0], until);
            checked += 1;
        }
    }
}

/// Statement 1: a guard that is clear until `t` is below `r` up to `t`, proved for every guard. The crossing of each
/// guard that reaches `r` is found.
#[test]
fn what_is_clear_is_below_the_resolution() {
    tangents(1, 3000, [-6.0, 6.0], |guard, x, at, until| {
        let tracker = guard.search(until);
        let clear = tracker.horizon().min(until);
        assert!(guard.is_below((1.0 + MOTION) * R, 0.0, clear), "{x}: clear to {clear}");
        if x > 1.0 + MOTION {
            assert!(tracker.root.is_some_and(|t| t <= at), "{x} is missed: {:?}", tracker.root);
        }
    });
}

/// Statement 2: a guard that crosses exceeds `3 r / 8` before it turns, and does not exceed `r` before the crossing
/// is reported; the reported instant is a zero.
#[test]
fn what_crosses_is_a_zero_and_comes_to_lie_above_three_eighths() {
    let mut crossings = 0;
    tangents(2, 3000, [-0.5, 3.0], |guard, x, top, until| {
        let Some(at) = guard.search(until).root.filter(|at| *at <= until) else { return };
        crossings += 1;
        // The next maximum after it.
        let next = guard.turns(until).into_iter().find(|turn| turn[0] > at).expect("a top");
        // A maximum below `r` that was not taken may be taken when the guard returns to the same height.
        let again = x < 1.0 + MOTION && next[1] > (x - MOTION) * R;
        assert!(at <= top || again, "{x} is taken at {at}, after its top at {top}");
        assert!(next[1] > (0.375 - MOTION) * R, "{x}: only {:e} after {at}", next[1]);
        assert!(guard.is_below((1.0 + MOTION) * R, 0.0, at), "{x}: {at}");
        let ([value, radius], slope) = guard.ball(at);
        // The engine's motion has that error, and a zero cannot be closer than its own rounding.
        let off = radius + MOTION * R + slope.abs() * f64::EPSILON * at;
        assert!(value.abs() <= off, "{x}: {value:e} at {at}");
    });
    assert!(crossings > 1500, "{crossings} crossings");
}

/// Statement 2: a guard that is above `r` at first, and not falling from below `4 r`, has crossed.
#[test]
fn what_is_first_seen_beyond_its_level_has_crossed() {
    let mut random = Random::new(3);
    for _ in 0..2000 {
        let mut guard = Guard::drawn(&mut random);
        let above = R * power_of_ten(&mut random, 0.0, 6.0);
        guard.drift[0] += above - guard.value(0.0);
        if above > 4.0 * R * (1.0 + MOTION) || guard.ball(0.0).1 >= 0.0 {
            assert_eq!(guard.search(1.0 / guard.fastest()).root, Some(0.0), "{above:e}");
        }
    }
}

/// Statement 3: a guard that peaks below `3 r / 8` and turns back is not taken.
#[test]
fn what_turns_back_near_zero_is_not_taken() {
    tangents(4, 4000, [-6.0, 0.375 - MOTION], |guard, x, _, until| {
        let tracker = guard.search(until);
        assert!(tracker.root.is_none_or(|at| at > until), "{x} is taken");
    });
}

/// Statement 4: a guard that is below `4 r` and falling at first, or below `r / 2`, is tracked from there. It is not
/// taken while it exceeds its start value by no more than `r`; where it is taken, it is at its start value, to `r`.
#[test]
fn what_begins_a_little_above_zero_is_watched_from_there() {
    let mut random = Random::new(7);
    let (mut fell, mut crossed) = (0, 0);
    for _ in 0..4000 {
        let mut guard = Guard::drawn(&mut random);
        let above = R * random.between(0.0, 4.0 - MOTION);
        guard.drift[0] += above - guard.value(0.0);
        let (_, slope) = guard.ball(0.0);
        if slope >= 0.0 && above > (0.5 - MOTION) * R {
            continue;
        }
        let until = 8.0 / guard.fastest();
        let tracker = guard.search(until);
        let first = tracker.horizon().min(until);
        assert!(guard.is_below(above + (1.0 + MOTION) * R, 0.0, first), "{above:e}: {first}");
        // Steep enough that a parabola reaches zero; the engine's is up to sqrt 2 wider.
        let steep = slope < 0.0 && slope * slope >= 3.0 * guard.curvature() * above;
        assert!(!steep || tracker.root != Some(0.0), "{above:e}");
        fell += u64::from(steep);
        let Some(at) = tracker.root.filter(|at| *at <= until) else { continue };
        crossed += 1;
        let ([value, radius], slope) = guard.ball(at);
        let off = radius + MOTION * R + slope.abs() * f64::EPSILON * at;
        // A zero, or an instant before which it was below `r` for long.
        let risen = value - above;
        assert!((-off..=R + off).contains(&risen), "{above:e}: {value:e} at {at}");
        // A turn nearer to the start value than the motion's error does not count.
        let far = |[when, value]: &[f64; 2]| *when > at && (value - above).abs() > MOTION * R;
        if let Some([_, top]) = guard.turns(until).into_iter().find(far) {
            assert!(top > above + (0.375 - MOTION) * R, "{above:e}: only {top:e} after {at}");
        }
    }
    assert!(fell > 500 && crossed > 300, "{fell} {crossed}");
}
