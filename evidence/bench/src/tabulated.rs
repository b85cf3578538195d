//! Tabulated exact propagators: what a good afternoon's work gives.
//!
//! With the state `x = (e, v / OMEGA, 1, F_A, foot)`, where `e` holds each body's first
//! displacement and then the elongations of its elements, a mode is `x' = A x`, so
//! `x(t + h) = exp(A h) x(t)`. (With the displacements themselves, rounding in
//! `M^-1 K` accelerates a bar that has moved by 50 mm: 1e-11 s in the first impact.)
//! For each of the eight modes the exponentials of the
//! scan step `d`, of `2^k d` and of `2^-k d` are tabulated, with the rows that give
//! the watched quantities at the 64 scan points of a block. A block is scanned at
//! once; the first scan interval that ends above a guard is entered and bisected
//! with the tables down to `2^-32 d`. What rises and falls again within `d` is
//! missed: `d` is the accuracy.

use crate::schema::{Answer, Peer, Task};
use nalgebra::DMatrix;
use oracles::law::{Event, Guard, Memory, Mode, Quantity, Rock, State};
use oracles::model::Model;

const OMEGA: f64 = 2e6;
const BLOCK: usize = 64;
const DOUBLINGS: usize = 6;
const HALVINGS: usize = 32;
const QUANTITIES: [Quantity; 4] =
    [Quantity::Gap, Quantity::Tip, Quantity::TipSpeed, Quantity::Relative];

/// Gauss-Legendre of order 8 on `[0, 1]`: abscissae and weights.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The tables of one mode.
struct Tables {
    /// `exp(A d 2^k)`.
    up: Vec<DMatrix<f64>>,
    /// `exp(A d 2^-k)`, `k` from 1.
    down: Vec<DMatrix<f64>>,
    /// For each quantity its values at the scan points `1..=BLOCK`, one row each.
    scan: Vec<DMatrix<f64>>,
    /// Tip speed at the abscissae of every scan interval.
    speeds: DMatrix<f64>,
    /// Row `q` of entry `k`: quantity `q` after `d 2^-(k+1)`.
    halved: Vec<DMatrix<f64>>,
    /// Tip speed at the abscissae of `d 2^-(k+1)`.
    halved_speeds: Vec<DMatrix<f64>>,
}

/// `exp(a h)` by a scaled Taylor sum and squarings.
fn exponential(a: &DMatrix<f64>, h: f64) -> DMatrix<f64> {
    let n = a.nrows();
    let norm = (0..n).map(|i| a.row(i).iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    let squarings = (norm * h).log2().ceil().max(0.0) as i32;
    let scaled = a * (h / 2f64.powi(squarings));
    let mut sum = DMatrix::identity(n, n);
    let mut term = sum.clone();
    for k in 1..40 {
        term = &term * &scaled / f64::from(k);
        sum += &term;
        if term.amax() < 1e-18 {
            break;
        }
    }
    for _ in 0..squarings {
        sum = &sum * &sum;
    }
    sum
}

/// `A` of one of the eight systems.
fn generator(model: &Model<f64>, mode: Mode) -> DMatrix<f64> {
    let n = model.nodes();
    let zero = vec![0.0; n];
    let mut a = DMatrix::zeros(2 * n + 3, 2 * n + 3);
    let mut out = zero.clone();
    for j in 0..n {
        let mut unit = zero.clone();
        let end = if j < model.bit { model.bit } else { n };
        unit[j..end].fill(1.0);
        model.acceleration(mode, &zero, &unit, &zero, &mut out);
        (0..n).for_each(|i| a[(n + i, j)] = out[i] / OMEGA);
        unit.fill(0.0);
        unit[j] = 1.0;
        a[(j, n + j)] = OMEGA;
        if j != 0 && j != model.bit {
            a[(j, n + j - 1)] = -OMEGA;
        }
        model.acceleration(mode, &zero, &zero, &unit, &mut out);
        (0..n).for_each(|i| a[(n + i, n + j)] = out[i]);
    }
    // The load is affine in F_A and the foot: three loads give its parts.
    let [amplitude, _] = model.scene.drive.relay();
    let load = |down: bool, foot: f64| {
        let memory = Memory { ul: foot, uu: foot, ..Memory::default() };
        let mut out = vec![0.0; n];
        let load = model.load(Mode { down, ..mode }, &memory);
        model.acceleration(mode, &load, &zero, &zero, &mut out);
        out
    };
    let (plus, minus, foot) = (load(true, 0.0), load(false, 0.0), load(true, 1.0));
    for i in 0..n {
        a[(n + i, 2 * n)] = 0.5 * (plus[i] + minus[i]) / OMEGA;
        a[(n + i, 2 * n + 1)] = 0.5 * (plus[i] - minus[i]) / amplitude / OMEGA;
        a[(n + i, 2 * n + 2)] = (foot[i] - plus[i]) / OMEGA;
    }
    a
}

/// The row that reads a quantity.
fn reader(model: &Model<f64>, quantity: Quantity) -> DMatrix<f64> {
    let n = model.nodes();
    let gap = model.scene.gap;
    let mut row = DMatrix::zeros(1, 2 * n + 3);
    match quantity {
        Quantity::Gap => {
            (0..model.bit).for_each(|i| row[i] = -1.0);
            (row[model.bit], row[2 * n]) = (1.0, gap);
        }
        Quantity::Tip => (model.bit..n).for_each(|i| row[i] = 1.0),
        Quantity::TipSpeed => row[2 * n - 1] = OMEGA,
        Quantity::Relative => {
            for i in 0..n {
                let end = if i < model.bit { model.bit } else { n };
                row[i] = model.relative[i..end].iter().sum();
            }
            row[2 * n] = -gap;
        }
        Quantity::Work => unreachable!("the work is a quadrature"),
        Quantity::Joint(_) => unreachable!("no joint is among the scenes"),
    }
    row
}

/// Rows of `first` times the powers `0..count` of `step`, stacked.
fn stack(first: &DMatrix<f64>, step: &DMatrix<f64>, count: usize) -> DMatrix<f64> {
    let (height, width) = first.shape();
    let mut table = DMatrix::zeros(height * count, width);
    let mut rows = first.clone();
    for k in 0..count {
        table.rows_mut(k * height, height).copy_from(&rows);
        rows *= step;
    }
    table
}

impl Tables {
    fn new(model: &Model<f64>, mode: Mode, d: f64) -> Self {
        let a = generator(model, mode);
        let mut up = vec![exponential(&a, d)];
        (0..DOUBLINGS).for_each(|k| up.push(&up[k] * &up[k]));
        let readers = QUANTITIES.map(|q| reader(model, q));
        let lengths: Vec<f64> = (1..=HALVINGS as i32).map(|k| d * 2f64.powi(-k)).collect();
        let down: Vec<_> = lengths.iter().map(|&h| exponential(&a, h)).collect();
        let nodes = |h: f64| {
            let rows = GAUSS.map(|(x, _)| &readers[2] * exponential(&a, x * h));
            DMatrix::from_rows(&rows.map(|row| row.row(0).into_owned()))
        };
        let all = DMatrix::from_rows(&readers.each_ref().map(|row| row.row(0).into_owned()));
        Self {
            scan: readers.iter().map(|row| stack(&(row * &up[0]), &up[0], BLOCK)).collect(),
            speeds: stack(&nodes(d), &up[0], BLOCK),
            halved: down.iter().map(|e| &all * e).collect(),
            halved_speeds: lengths.iter().map(|&h| nodes(h)).collect(),
            up,
            down,
        }
    }
}

/// `y = m x`, by columns.
fn product(m: &DMatrix<f64>, x: &[f64], y: &mut [f64]) {
    y.fill(0.0);
    for (column, &x) in m.as_slice().chunks_exact(m.nrows()).zip(x) {
        y.iter_mut().zip(column).for_each(|(y, c)| *y += c * x);
    }
}

fn dot(m: &DMatrix<f64>, row: usize, x: &[f64]) -> f64 {
    m.as_slice().iter().skip(row).step_by(m.nrows()).zip(x).map(|(a, b)| a * b).sum()
}

/// The solver.
pub struct Tabulated<'a> {
    model: &'a Model<f64>,
    d: f64,
    tables: Vec<Tables>,
}

struct Run<'a> {
    peer: &'a Tabulated<'a>,
    time: f64,
    mode: Mode,
    memory: Memory<f64>,
    x: Vec<f64>,
    next: Vec<f64>,
    psi: f64,
    guards: Vec<Guard<f64>>,
    answer: Answer,
}

impl<'a> Tabulated<'a> {
    /// Tabulates everything for a scan step of `d` seconds.
    pub fn new(model: &'a Model<f64>, d: f64) -> Self {
        let rocks = [Rock::FF, Rock::DFC, Rock::FC, Rock::BC];
        let mode = |index: usize| Mode::bare(index >= 4, rocks[index % 4]);
        let tables = (0..8).map(|index| Tables::new(model, mode(index), d)).collect();
        Self { model, d, tables }
    }
}

impl Peer for Tabulated<'_> {
    fn run(&mut self, task: &Task) -> Result<Answer, String> {
        let (state, mode, memory) = self.model.start();
        let mut x = state.u;
        let first = |i: usize| i == 0 || i == self.model.bit;
        (1..x.len()).rev().filter(|&i| !first(i)).for_each(|i| x[i] -= x[i - 1]);
        x.extend(state.v.iter().map(|v| v / OMEGA));
        x.extend([1.0, 0.0, 0.0]);
        let next = x.clone();
        let (answer, guards) = (Answer::default(), Vec::new());
        let mut run =
            Run { peer: self, time: 0.0, mode, memory, x, next, psi: 0.0, guards, answer };
        run.enter();
        for stop in task.stops() {
            while run.time < stop {
                run.block(stop);
            }
            let state = run.state();
            run.answer.keep(task, &state);
        }
        Ok(run.answer)
    }
}

impl Run<'_> {
    fn tables(&self) -> &Tables {
        &self.peer.tables[self.mode.system_index()]
    }

    fn state(&self) -> State<f64> {
        let n = self.peer.model.nodes();
        let v = self.x[n..2 * n].iter().map(|v| v * OMEGA).collect();
        let mut u = self.x[..n].to_vec();
        (1..n).filter(|&i| i != self.peer.model.bit).for_each(|i| u[i] += u[i - 1]);
        State { u, v, psi: self.psi }
    }

    fn enter(&mut self) {
        let n = self.peer.model.nodes();
        let [amplitude, _] = self.peer.model.scene.drive.relay();
        self.x[2 * n + 1] = if self.mode.down { amplitude } else { -amplitude };
        self.x[2 * n + 2] = self.peer.model.foot(self.mode, &self.memory);
        self.guards = self.peer.model.guards(self.mode, &self.memory);
    }

    /// Viscous work from the tip speeds at the abscissae of one interval of `h`.
    fn work(&self, speeds: &[f64], h: f64) -> f64 {
        let sum: f64 = GAUSS.iter().zip(speeds).map(|((_, w), v)| w * v * v).sum();
        h * self.peer.model.scene.rock.viscosity * sum
    }

    /// Scans up to a block and stops at the first event, at `stop` or at its end.
    fn block(&mut self, stop: f64) {
        let d = self.peer.d;
        let whole = ((stop - self.time) / d).floor();
        let points = (whole as usize).min(BLOCK);
        let works = self.works();
        let mut first = points;
        let mut values = [0.0; BLOCK];
        for guard in &self.guards {
            let height = guard.height;
            let index = QUANTITIES.iter().position(|&q| q == guard.quantity);
            let above = match index {
                Some(q) => {
                    product(&self.tables().scan[q], &self.x, &mut values);
                    values[..first].iter().position(|&q| guard.value(q) > height)
                }
                None => works[..first].iter().position(|&w| guard.value(self.psi + w) > height),
            };
            first = above.unwrap_or(first);
        }
        self.jump(first, &works);
        if first < points {
            let event = self.bisect(d, true);
            self.pass(event);
        } else if points < BLOCK {
            let rest = stop - self.time;
            match self.bisect(rest, false) {
                Some(event) => self.pass(Some(event)),
                None => self.time = stop,
            }
        }
    }

    /// Viscous work from now to each scan point.
    fn works(&self) -> [f64; BLOCK] {
        let mut works = [0.0; BLOCK];
        if self.mode.rock == Rock::DFC {
            let mut speeds = [0.0; 4 * BLOCK];
            product(&self.tables().speeds, &self.x, &mut speeds);
            let mut sum = 0.0;
            for (work, speeds) in works.iter_mut().zip(speeds.chunks_exact(4)) {
                sum += self.work(speeds, self.peer.d);
                *work = sum;
            }
        }
        works
    }

    /// Goes to the scan point `k`.
    fn jump(&mut self, k: usize, works: &[f64]) {
        let mut next = std::mem::take(&mut self.next);
        for level in (0..=DOUBLINGS).filter(|level| k >> level & 1 == 1) {
            product(&self.tables().up[level], &self.x, &mut next);
            // The inputs' rows are constant.
            std::mem::swap(&mut self.x, &mut next);
        }
        self.next = next;
        self.psi += if k > 0 { works[k - 1] } else { 0.0 };
        self.time += k as f64 * self.peer.d;
    }

    /// Goes towards `now + span` by halvings of `d`, as far as no guard is
    /// positive; the guard that stopped it, if any did. `certain`: one must.
    fn bisect(&mut self, span: f64, certain: bool) -> Option<Event> {
        let mut left = span;
        let mut stopped = None;
        for level in 0..HALVINGS {
            let h = self.peer.d * 0.5f64.powi(level as i32 + 1);
            if !certain && h > left {
                continue;
            }
            let speeds: Vec<f64> = if self.mode.rock == Rock::DFC {
                let table = &self.tables().halved_speeds[level];
                (0..4).map(|row| dot(table, row, &self.x)).collect()
            } else {
                vec![0.0; 4]
            };
            let psi = self.psi + self.work(&speeds, h);
            if let Some(event) = self.risen(level, psi) {
                stopped = Some(event);
                left = h;
                continue;
            }
            let mut next = std::mem::take(&mut self.next);
            product(&self.tables().down[level], &self.x, &mut next);
            self.next = std::mem::replace(&mut self.x, next);
            (self.psi, self.time, left) = (psi, self.time + h, left - h);
        }
        // The last interval ends above a guard even if no shorter one did.
        stopped.or_else(|| if certain { self.risen(HALVINGS - 1, self.psi) } else { None })
    }

    /// The first guard, in order, that is positive after halving `level`.
    fn risen(&self, level: usize, psi: f64) -> Option<Event> {
        let table = &self.tables().halved[level];
        self.guards.iter().find_map(|guard| {
            let q = QUANTITIES.iter().position(|&q| q == guard.quantity);
            let value = guard.value(q.map_or(psi, |q| dot(table, q, &self.x)));
            (value > guard.height).then_some(guard.event)
        })
    }

    fn pass(&mut self, event: Option<Event>) {
        let Some(event) = event else { return };
        let mut state = self.state();
        let model = self.peer.model;
        model.transition(event, &mut self.mode, &mut self.memory, &mut state);
        self.psi = state.psi;
        self.answer.events.push((self.time, event));
        self.enter();
    }
}
