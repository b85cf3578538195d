//! Proof of the search's rounding: windows in interval arithmetic, rounded outward, contain every coefficient, and
//! find the same events along the motion of whole scenes.

use crate::scenes::Random;
use hammer::modal::structure::{Attachment, Structure};
use hammer::modal::system::{Recipe, System, TAYLOR};
use hammer::modal::track::Track;
use hammer::numerics::poly::Poly;
use hammer::search::signal::{Part, Signal};
use hammer::{Event, InputValues, Machine, Mode, Parameters, Record, RockMode};
use std::ops::{Add, Mul};
use std::sync::Arc;

/// An interval; every operation is rounded outward.
#[derive(Clone, Copy, Debug)]
struct Interval {
    low: f64,
    high: f64,
}

impl From<f64> for Interval {
    fn from(x: f64) -> Self {
        Self { low: x, high: x }
    }
}

impl Add for Interval {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { low: (self.low + other.low).next_down(), high: (self.high + other.high).next_up() }
    }
}

impl Mul for Interval {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let ends = [
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ];
        let low = ends.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let high = ends.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        Self { low: low.next_down(), high: high.next_up() }
    }
}

impl Interval {
    const ZERO: Self = Self { low: 0.0, high: 0.0 };

    fn wide(radius: f64) -> Self {
        Self { low: -radius, high: radius }
    }

    fn over(self, k: usize) -> Self {
        let k = k as f64;
        Self { low: (self.low / k).next_down(), high: (self.high / k).next_up() }
    }

    fn middle(self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// Largest distance of its points from `x`.
    fn apart(self, x: f64) -> f64 {
        (x - self.low).max(self.high - x).next_up()
    }

    fn size(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

/// Slightly more than the norm of two numbers.
fn norm(x: f64, y: f64) -> f64 {
    x.hypot(y) * (1.0 + 1e-14)
}

/// `sum c_k x^k`.
fn horner(c: &[Interval], x: Interval) -> Interval {
    c.iter().rev().fold(Interval::ZERO, |sum, &c| sum * x + c)
}

/// The motion of a track, enclosed in a disc for each block: a centre, and a radius that the flow never enlarges.
#[derive(Clone)]
struct Discs {
    system: Arc<System>,
    z: Vec<f64>,
    radius: Vec<f64>,
    at: f64,
}

impl Discs {
    fn new(track: &Track) -> Self {
        let radius = vec![0.0; track.z.len()];
        Self { system: track.system.clone(), z: track.z.clone(), radius, at: track.at }
    }

    /// `(B h)^k z / k!` of the middles, for `k` up to `TAYLOR + 1`.
    fn series(&self, h: f64) -> Vec<Vec<Interval>> {
        let n = self.system.blocks();
        let mut y: Vec<Interval> = self.z.iter().map(|&x| x.into()).collect();
        let mut all = vec![y.clone()];
        for k in 1..=TAYLOR + 1 {
            for i in 0..n {
                let entry = |j: usize| Interval::from(self.block(i)[j]);
                let [p, q] = [y[i], y[n + i]].map(|x| (x * h.into()).over(k));
                y[i] = entry(0) * p + entry(1) * q;
                y[n + i] = entry(2) * p + entry(3) * q;
            }
            all.push(y.clone());
        }
        all
    }

    /// Block `i` of the generator; zero for padding and for the translation, which is not part of a modal vector.
    fn block(&self, i: usize) -> [f64; 4] {
        let none = i >= self.system.modes() || i == 0 && self.system.rigid;
        if none { [0.0; 4] } else { self.system.block(i) }
    }

    /// True if the coordinates of block `i` are independent: each has a disc of its own.
    fn is_diagonal(&self, i: usize) -> bool {
        let [_, b12, b21, _] = self.block(i);
        b12 == 0.0 && b21 == 0.0
    }

    /// Bounds on the coordinates of the sum of two vectors of block `i`, at all later times.
    fn sizes(&self, i: usize, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        if self.is_diagonal(i) {
            return [a[0] + b[0], a[1] + b[1]];
        }
        [norm(a[0], a[1]) + norm(b[0], b[1]); 2]
    }

    /// Moves on by `h`.
    fn step(&mut self, h: f64) {
        let (n, series) = (self.system.blocks(), self.series(h));
        for i in 0..n {
            let [p, q] = [i, n + i]
                .map(|j| series[..TAYLOR].iter().fold(Interval::ZERO, |sum, y| sum + y[j]));
            // The remainder after power `TAYLOR - 1` is `(B h)^TAYLOR / TAYLOR!` of a later state.
            let rest = [i, n + i].map(|j| series[TAYLOR][j].size());
            let [x, y] = [p.middle(), q.middle()];
            let grown = self.sizes(i, rest, [p.apart(x), q.apart(y)]);
            (self.z[i], self.z[n + i]) = (x, y);
            for (j, grown) in [i, n + i].into_iter().zip(grown) {
                self.radius[j] = (self.radius[j] + grown) * (1.0 + 1e-15);
            }
        }
        self.at += h;
    }

    /// Moves on to `t`, in steps of less than a radian of the fastest mode.
    fn go_to(&mut self, t: f64) {
        let span = t - self.at;
        let count = (span * self.system.rate_max).ceil().max(1.0);
        for _ in 0..count as usize {
            self.step(span / count);
        }
        self.at = t;
    }

    /// Adds the Taylor coefficients of a functional's derivative `order`, in units of `h`, to `q`. Returns their
    /// remainder.
    fn expand(&self, part: &Part, order: usize, h: f64, q: &mut [Interval]) -> f64 {
        let (n, series) = (self.system.blocks(), self.series(h));
        let row = &self.system.functionals[part.functional].rows[0];
        let terms = |y: &[Interval]| {
            row.iter().zip(y).fold(Interval::ZERO, |sum, (&c, &y)| sum + Interval::from(c) * y)
        };
        let scale = |k: usize| if order == 0 { part.factor } else { part.factor * k as f64 / h };
        for (k, q) in q.iter_mut().enumerate() {
            let k = k + order;
            let scale = scale(k);
            let rounded =
                Interval { low: scale - scale.abs() * 1e-15, high: scale + scale.abs() * 1e-15 };
            *q = *q + terms(&series[k]) * rounded;
        }
        let mut left = 0.0;
        for i in 0..n {
            let (k, j) = (TAYLOR + order, n + i);
            let entries: [f64; 4] = self.block(i).map(f64::abs);
            // `|B|` of a block is at most the root of the sum of its squares.
            let whole = entries.iter().map(|e| e * e).sum::<f64>().sqrt();
            let rates = if self.is_diagonal(i) { [entries[0], entries[3]] } else { [whole; 2] };
            let wide = [0, 1].map(|c| {
                let radius = self.radius[[i, j][c]];
                part.factor.abs() * if order == 0 { radius } else { radius * rates[c] }
            });
            let rest = [i, j].map(|j| series[k][j].size() * scale(k).abs());
            let [p, q] = self.sizes(i, wide, rest);
            left += if self.is_diagonal(i) {
                row[i].abs() * p + row[j].abs() * q
            } else {
                norm(row[i], row[j]) * p
            };
        }
        left * (1.0 + 1e-12)
    }
}

/// A guard on enclosed motions.
struct Enclosed {
    signal: Signal,
    discs: Vec<Discs>,
}

impl Enclosed {
    fn new(signal: Signal, tracks: &[Track]) -> Self {
        let mut discs: Vec<Discs> = tracks.iter().map(Discs::new).collect();
        discs.iter_mut().for_each(|d| {
            if d.at < 0.0 {
                d.go_to(0.0)
            }
        });
        Self { signal, discs }
    }

    /// `sum weight |z|`: bound on the sum of its modal terms.
    fn amplitude(&self) -> f64 {
        let parts = self.signal.parts.iter().flatten();
        let each = parts.map(|part| {
            let d = &self.discs[part.track];
            let weights = &d.system.functionals[part.functional].weights[self.signal.order];
            part.factor.abs() * weights.iter().zip(&d.z).map(|(w, z)| w * z.abs()).sum::<f64>()
        });
        each.sum()
    }

    /// Coefficients of the window of length `h` that begins at `t`, to which the discs are advanced.
    fn window(&self, t: f64, h: f64) -> [Interval; TAYLOR] {
        let mut p: Vec<Interval> = self.signal.poly().0.iter().map(|&c| c.into()).collect();
        // Shifted to `t`, then in units of `h`.
        for i in 0..p.len() - 1 {
            for k in (i..p.len() - 1).rev() {
                p[k] = p[k] + p[k + 1] * t.into();
            }
        }
        let mut q = [Interval::ZERO; TAYLOR];
        let mut power = Interval::from(1.0);
        for (q, p) in q.iter_mut().zip(p) {
            *q = p * power;
            power = power * h.into();
        }
        for part in self.signal.parts.iter().flatten() {
            let left = self.discs[part.track].expand(part, self.signal.order, h, &mut q);
            q[0] = q[0] + Interval::wide(left);
        }
        q
    }

    fn go_to(&mut self, t: f64) {
        for part in self.signal.parts.into_iter().flatten() {
            self.discs[part.track].go_to(t);
        }
    }

    /// About a radian of the fastest mode, or longer if nothing moves.
    fn length(&self) -> f64 {
        let parts = self.signal.parts.iter().flatten();
        let rates = parts.map(|part| {
            let d = &self.discs[part.track];
            if d.z.iter().all(|z| *z == 0.0) { 0.0 } else { d.system.rate_max }
        });
        2.0 / rates.fold(2e3, f64::max)
    }
}

/// True if the polynomial is proved to be below `level` on `[a, b]`.
fn is_below(q: &[Interval], level: f64, a: f64, b: f64) -> bool {
    let slope: Vec<Interval> =
        q.iter().enumerate().skip(1).map(|(k, &c)| c * (k as f64).into()).collect();
    let mut parts = vec![[a, b]];
    while let Some([a, b]) = parts.pop() {
        let middle = 0.5 * (a + b);
        let value = horner(q, middle.into());
        let half = Interval::wide((b - a) * (0.5 + 1e-15));
        let around = value + horner(&slope, Interval { low: a, high: b }) * half;
        if around.high < level {
            continue;
        }
        if value.low >= level || b - a < 1e-12 {
            return false;
        }
        parts.extend([[middle, b], [a, middle]]);
    }
    true
}

const MODE: Mode = Mode::starting(RockMode::FreeFlight);

/// Undamped systems, damped ones, and with a dashpot of any strength; states whose terms cancel, as ahead of a front.
#[test]
fn a_window_s_coefficients_err_by_no_more_than_it_says() {
    let mut random = Random::new(6);
    let resolution = 1e-9;
    let (mut closest, mut cancelled) = (f64::INFINITY, 0);
    for round in 0..600 {
        let n = 1 + (40.0 * random.unit()) as usize;
        let slowest = 10f64.powf(random.between(3.0, 5.0));
        let omega2: Vec<f64> =
            (0..n).map(|i| (slowest * (i as f64 + random.between(0.1, 1.0))).powi(2)).collect();
        let shape: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let viscosity = slowest * 10f64.powf(random.between(-2.0, 2.0));
        let dashpot = Attachment { shape: &shape, stiffness: slowest * slowest, viscosity };
        let recipe = Recipe {
            structure: Structure {
                attachments: if round % 2 == 0 { vec![dashpot] } else { Vec::new() },
                ..Structure::free(&omega2, [0.0, 0.01, 1.0][round % 3] / slowest)
            },
            loads: std::array::from_fn(|_| vec![0.0; n]),
            functionals: vec![vec![1.0; n]],
            dampers: Vec::new(),
        };
        let system = Arc::new(System::new(recipe, None, MODE).expect("a spectrum"));
        // Displacements for a velocity of order 1; every fourth state makes the terms cancel.
        let mut state: Vec<f64> =
            omega2.iter().map(|w2| random.between(-1.0, 1.0) / (w2.sqrt() + slowest)).collect();
        state.extend((0..n).map(|_| random.between(-1.0, 1.0)));
        if round % 4 == 0 {
            for half in state.chunks_mut(n) {
                half[n - 1] -= half.iter().sum::<f64>();
            }
            cancelled += 1;
        }
        let mut z = vec![0.0; 2 * system.blocks()];
        system.to_modal(&state, &mut z);
        let track = Track { system, z, at: 0.0 };
        let order = (round / 2) % 2;
        let mut poly = Poly::default();
        poly.0[..3].copy_from_slice(&[random.between(-1.0, 1.0), 10.0, -5.0]);
        let part = Part { track: 0, functional: 0, factor: 1.0 };
        let signal = Signal::new(poly, [Some(part), None], order, resolution);
        let guard = Enclosed::new(signal.clone(), std::slice::from_ref(&track));
        let t = random.between(0.0, 1e-3);
        let window = signal.expand(&[track], t, guard.amplitude());
        // The rows do not contain the translation.
        let exact = guard.window(t, window.h);
        let mut lost: f64 = exact[1..].iter().zip(&window.q[1..]).map(|(e, q)| e.apart(*q)).sum();
        // The first coefficient includes the remainder, an eighth of the resolution in all.
        lost += (exact[0].apart(window.q[0]) - resolution / 8.0).max(0.0);
        assert!(lost <= window.noise(), "{round}: {lost:e} lost, {:e} said", window.noise());
        if lost > 0.0 {
            closest = closest.min(window.noise() / lost);
        }
    }
    // A useless bound would be far off in every case.
    assert!(closest < 1e4 && cancelled == 150, "never closer than {closest:e}");
}

/// Error of the engine's motion after the rotations between two events: one rounding of all terms for each.
const ROTATIONS: f64 = 1000.0;

/// Proves an interval: no guard reaches its resolution before the event, and the event's own guard then does, through
/// zero. Returns the number of proved crossings.
fn prove(machine: &Machine, span: f64, event: Event) -> u64 {
    let (tracks, guards) = machine.tracked();
    let mut proved = 0;
    for (watched, signal) in guards {
        let mut guard = Enclosed::new(signal.clone(), &tracks);
        let r = signal.resolution;
        let off = ROTATIONS * f64::EPSILON * guard.amplitude();
        let mut t = 0.0;
        while t < span {
            let h = guard.length().min(span - t);
            let q = guard.window(t, h);
            assert!(
                is_below(&q, r + off, 0.0, 1.0),
                "{watched:?} before {event:?}: {t:e} of {span:e}"
            );
            t = if h == span - t { span } else { t + h };
            guard.go_to(t);
        }
        if watched == event {
            guard.crosses(span, r, off);
            proved += 1;
        }
    }
    proved
}

impl Enclosed {
    /// Asserts that it is zero at `t`, and then exceeds `3 r / 8` before it falls below zero.
    fn crosses(&mut self, mut t: f64, r: f64, off: f64) {
        let zero = self.window(t, self.length())[0];
        assert!(zero.low <= off && zero.high >= -off, "{zero:?} is no zero at {t:e}, r {r:e}");
        for _ in 0..100 {
            let h = self.length();
            let q = self.window(t, h);
            for i in 1..=64 {
                let value = horner(&q, (f64::from(i) / 64.0).into());
                if value.low >= 0.375 * r - off {
                    return;
                }
                assert!(value.high > -off, "it turns back at {t:e}: {value:?}, r {r:e}");
            }
            t += h;
            self.go_to(t);
        }
        panic!("it does not rise");
    }
}

/// Runs a scene and proves each of its intervals. Returns the numbers of intervals and of crossings.
fn prove_scene(p: &Parameters, to: f64) -> [u64; 2] {
    let start = || Machine::new(p, &InputValues::default(), 0.0).expect("a scene");
    let mut machine = start();
    machine.keep_journal(true);
    machine.advance(to).expect("events");
    let journal = machine.take_journal();
    let mut machine = start();
    let (mut before, mut rest) = (0.0, 0.0);
    let [mut stretches, mut crossings] = [0; 2];
    for Record { time, time_rest, event, .. } in journal {
        let span = (time - before) + (time_rest - rest);
        if span > 1e-10 {
            machine.advance(before + 0.5 * span).expect("a step");
            stretches += 1;
            crossings += prove(&machine, span, event);
        }
        (before, rest) = (time, time_rest);
    }
    [stretches, crossings]
}

/// The reference mesh through its first blow; and small meshes with a small gap, so that little time is flight,
/// through contact and every mode of the rock.
#[test]
fn windows_rounded_outward_find_the_events_of_a_blow_and_of_drawn_scenes() {
    let mut reference = Parameters::default();
    (reference.contact.initial_gap, reference.piston.initial_velocity) = (1e-4, 11.4);
    let [stretches, crossings] = prove_scene(&reference, 5e-4);
    assert!(stretches > 15 && crossings > 10, "{crossings} of {stretches}");
    let mut random = Random::new(9);
    let [mut stretches, mut crossings] = [0; 2];
    for _ in 0..12 {
        let mut p = Parameters::default();
        p.contact.initial_gap = 1e-3 * random.between(0.2, 1.0);
        p.piston.initial_velocity = random.between(1.0, 12.0);
        p.piston.elements = 2 + (4.0 * random.unit()) as usize;
        p.bit.elements = 2 + (4.0 * random.unit()) as usize;
        p.piston.length *= random.between(0.5, 2.0);
        p.rock.stiffness *= 10f64.powf(random.between(-1.0, 1.0));
        p.rock.viscosity *= 10f64.powf(random.between(-1.0, 1.0));
        p.rock.energy_barrier *= 10f64.powf(random.between(-2.0, 0.5));
        let [more, proved] = prove_scene(&p, 1.5e-3);
        (stretches, crossings) = (stretches + more, crossings + proved);
    }
    assert!(stretches > 200 && crossings > 150, "{crossings} of {stretches}");
}
