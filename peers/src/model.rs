//! The hammer as a nodal finite element model, assembled from the text alone.
//!
//! ```text
//! M v' = load - K u - C v,   u' = v,   psi' = CR p'^2 in DFC, else 0
//! ```
//!
//! `M` (consistent) and `K` are tridiagonal in the order piston top to bottom,
//! bit top to bottom; a closed contact couples the two middle nodes and keeps
//! them so. `K`, `C` and `load` depend on the mode ([`Model::system`]), and a
//! mode ends where one of its guards ([`Model::guards`]) rises through zero.
//!
//! Everything is generic over [`Real`], so that one text serves the reference
//! (double-double) and its competitors (`f64`). SI units.

use hammer::parameters::{Fidelity, InputValues, Parameters};
use serde::{Deserialize, Serialize};
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The arithmetic that the model needs.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The nearest `f64`.
    fn to_f64(self) -> f64;
}

impl Real for f64 {
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
}

/// A symmetric tridiagonal matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Tridiagonal<T> {
    /// `a[i][i]`.
    pub diagonal: Vec<T>,
    /// `a[i][i + 1]`.
    pub off: Vec<T>,
}

impl<T: Real> Tridiagonal<T> {
    fn zero(n: usize) -> Self {
        Self { diagonal: vec![T::default(); n], off: vec![T::default(); n - 1] }
    }

    /// `out -= A x`.
    #[inline]
    pub fn subtract_product(&self, x: &[T], out: &mut [T]) {
        let n = x.len();
        for i in 0..n {
            let mut sum = self.diagonal[i] * x[i];
            if i > 0 {
                sum = sum + self.off[i - 1] * x[i - 1];
            }
            if i + 1 < n {
                sum = sum + self.off[i] * x[i + 1];
            }
            out[i] = out[i] - sum;
        }
    }

    /// `A = L D L^T`, for [`Factor::solve`].
    pub fn factor(&self) -> Factor<T> {
        let n = self.diagonal.len();
        let mut lower = vec![T::default(); n - 1];
        let mut inverse = vec![T::default(); n];
        let mut pivot = self.diagonal[0];
        for i in 0..n {
            inverse[i] = T::from(1.0) / pivot;
            if i + 1 < n {
                lower[i] = self.off[i] * inverse[i];
                pivot = self.diagonal[i + 1] - lower[i] * self.off[i];
            }
        }
        Factor { lower, inverse }
    }
}

/// `L D L^T` of a [`Tridiagonal`].
#[derive(Clone, Debug)]
pub struct Factor<T> {
    lower: Vec<T>,
    inverse: Vec<T>,
}

impl<T: Real> Factor<T> {
    /// Solves in place, in `O(n)`.
    #[inline]
    pub fn solve(&self, x: &mut [T]) {
        let n = x.len();
        for i in 1..n {
            x[i] = x[i] - self.lower[i - 1] * x[i - 1];
        }
        x[n - 1] = x[n - 1] * self.inverse[n - 1];
        for i in (0..n - 1).rev() {
            x[i] = x[i] * self.inverse[i] - self.lower[i] * x[i + 1];
        }
    }
}

/// Phase of the bit/rock law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rock {
    /// Free flight.
    FF,
    /// Dissipative forward contact.
    DFC,
    /// Forward contact.
    FC,
    /// Backward contact.
    BC,
    /// Standstill.
    SS,
}

/// The discrete state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// Piston and bit touch.
    pub closed: bool,
    /// Bit/rock phase.
    pub rock: Rock,
    /// The relay drives the piston downward.
    pub down: bool,
}

impl Mode {
    /// Which of the eight linear systems holds: closed or open, times no rock,
    /// `KR` and `CR`, `KR`, `gamma KR`.
    pub fn system_index(self) -> usize {
        let rock = match self.rock {
            Rock::FF => 0,
            Rock::DFC => 1,
            Rock::FC => 2,
            Rock::BC | Rock::SS => 3,
        };
        4 * usize::from(self.closed) + rock
    }
}

/// What the rock remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory<T> {
    /// Foot of the loading line `ul`, m.
    pub ul: T,
    /// Foot of the unloading line `uu`, m.
    pub uu: T,
    /// Permanent gain of the last cycle `dp`, m.
    pub gain: T,
}

/// The continuous state.
#[derive(Clone, Debug, PartialEq)]
pub struct State<T> {
    /// Nodal displacements, m.
    pub u: Vec<T>,
    /// Nodal velocities, m/s.
    pub v: Vec<T>,
    /// Viscous work of the current cycle, J.
    pub psi: T,
}

/// What ends a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event {
    /// Q11 falls: the gap closes.
    Close,
    /// Q11 rises: the gap opens.
    Open,
    /// FF to DFC.
    Q1,
    /// DFC to BC.
    Q2,
    /// DFC to FC.
    Q3,
    /// FC to BC.
    Q4,
    /// BC to FF.
    Q5,
    /// BC to SS or DFC.
    Q6,
    /// SS to DFC.
    Q7,
    /// SS to BC.
    Q8,
    /// SS to FF.
    LiftOff,
    /// Relay to -1.
    Q9,
    /// Relay to +1.
    Q10,
}

impl Event {
    /// Order of events at one instant: contact, rock, relay.
    pub fn rank(self) -> u8 {
        match self {
            Self::Close | Self::Open => 0,
            Self::Q9 | Self::Q10 => 2,
            _ => 1,
        }
    }
}

/// A quantity that a guard watches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// `w2.u + g0`, m.
    Gap,
    /// `p = w1.u`, m.
    Tip,
    /// `p' = w1.v`, m/s.
    TipSpeed,
    /// `vr`, m.
    Relative,
    /// `psi`, J.
    Work,
}

impl Quantity {
    /// Height that an excursion of a guard must exceed to count.
    pub fn resolution(self) -> f64 {
        match self {
            Self::Gap | Self::Tip | Self::Relative => 1e-14, // m
            Self::TipSpeed => 1e-9,                          // m/s
            Self::Work => 1e-12,                             // J
        }
    }
}

/// `sign (quantity - offset)`, whose rise through zero is `event`.
#[derive(Clone, Copy, Debug)]
pub struct Guard<T> {
    /// What happens.
    pub event: Event,
    /// What is watched.
    pub quantity: Quantity,
    /// `+1` or `-1`.
    pub sign: f64,
    /// Level, in the quantity's unit.
    pub offset: T,
}

impl<T: Real> Guard<T> {
    /// The guard's value where its quantity is `q`.
    pub fn value(&self, q: T) -> T {
        T::from(self.sign) * (q - self.offset)
    }
}

/// The linear system of a mode.
#[derive(Clone, Debug)]
pub struct System<T> {
    /// Stiffness with contact and rock, N/m.
    pub stiffness: Tridiagonal<T>,
    /// Damping with rock viscosity, N s/m.
    pub damping: Tridiagonal<T>,
}

/// The assembled hammer.
#[derive(Clone, Debug)]
pub struct Model<T> {
    /// Index of the bit's highest node; the piston has the nodes before it.
    pub bit: usize,
    /// Consistent mass, kg.
    pub mass: Tridiagonal<T>,
    /// Its factors.
    pub mass_factor: Factor<T>,
    /// The eight systems, by [`Mode::system_index`].
    pub systems: Vec<System<T>>,
    /// Row whose product with `u` is the piston's mean minus the bit's.
    pub relative: Vec<T>,
    dead: Vec<T>,
    drive: Vec<T>,
    /// Meeting stiffness, N/m.
    pub contact_stiffness: T,
    parameters: Parameters,
    feed: T,
}

fn add_bar<T: Real>(matrix: &mut Tridiagonal<T>, first: usize, elements: usize, block: [T; 2]) {
    for i in first..first + elements {
        matrix.diagonal[i] = matrix.diagonal[i] + block[0];
        matrix.diagonal[i + 1] = matrix.diagonal[i + 1] + block[0];
        matrix.off[i] = matrix.off[i] + block[1];
    }
}

/// Mass and stiffness of one bar; a rigid one is a single node.
fn bar<T: Real>(p: &Parameters, length: f64, elements: usize) -> ([T; 2], [T; 2]) {
    let r = T::from;
    let h = r(length) / r(elements.max(1) as f64);
    let mass = r(p.material.density) * r(p.cross_section) * h / r(6.0);
    let stiffness = r(p.material.youngs_modulus) * r(p.cross_section) / h;
    ([mass * r(2.0), mass], [stiffness, -stiffness])
}

impl<T: Real> Model<T> {
    /// Assembles the hammer; rigid bodies have one node each.
    pub fn new(parameters: &Parameters, inputs: &InputValues) -> Self {
        let p = parameters;
        let counts = match p.fidelity {
            Fidelity::Rigid => [0, 0],
            Fidelity::Elastic => [p.piston.elements, p.bit.elements],
        };
        let (bit, n) = (counts[0] + 1, counts[0] + counts[1] + 2);
        let (mut mass, mut bars) = (Tridiagonal::zero(n), Tridiagonal::zero(n));
        for (first, elements, length) in
            [(0, counts[0], p.piston.length), (bit, counts[1], p.bit.length)]
        {
            let (m, k) = bar::<T>(p, length, elements);
            add_bar(&mut mass, first, elements, m);
            add_bar(&mut bars, first, elements, k);
            if elements == 0 {
                mass.diagonal[first] = m[0] * T::from(3.0);
            }
        }
        let mut model = Self {
            bit,
            mass_factor: mass.factor(),
            systems: Vec::new(),
            relative: Vec::new(),
            dead: Vec::new(),
            drive: Vec::new(),
            contact_stiffness: T::from(p.meeting_stiffness()),
            parameters: *p,
            feed: T::from(inputs.feed_force),
            mass,
        };
        model.systems = (0..8).map(|index| model.assemble(index, &bars)).collect();
        model.rows();
        model
    }

    /// `M 1` of one body and its sum.
    fn lumped(&self, body: std::ops::Range<usize>) -> (Vec<T>, T) {
        let mut row = vec![T::default(); self.nodes()];
        let one: Vec<T> =
            (0..self.nodes()).map(|i| T::from(f64::from(u8::from(body.contains(&i))))).collect();
        self.mass.subtract_product(&one, &mut row);
        let row: Vec<T> = row.into_iter().map(|x| -x).collect();
        let total = row.iter().fold(T::default(), |sum, &x| sum + x);
        (row, total)
    }

    fn rows(&mut self) {
        let (piston, piston_mass) = self.lumped(0..self.bit);
        let (bit, bit_mass) = self.lumped(self.bit..self.nodes());
        let gravity = T::from(self.parameters.gravity);
        self.relative =
            piston.iter().zip(&bit).map(|(&p, &b)| p / piston_mass - b / bit_mass).collect();
        self.dead = piston.iter().zip(&bit).map(|(&p, &b)| (p + b) * gravity).collect();
        self.dead[self.bit] = self.dead[self.bit] + self.feed;
        self.drive = piston.iter().map(|&p| p / piston_mass).collect();
    }

    fn assemble(&self, index: usize, bars: &Tridiagonal<T>) -> System<T> {
        let r = T::from;
        let rock = &self.parameters.rock;
        let (tip, beta) = (self.nodes() - 1, r(self.parameters.material.damping_time));
        let mut stiffness = bars.clone();
        let mut damping = Tridiagonal {
            diagonal: bars.diagonal.iter().map(|&k| beta * k).collect(),
            off: bars.off.iter().map(|&k| beta * k).collect(),
        };
        if index >= 4 {
            let kc = self.contact_stiffness;
            add_bar(&mut stiffness, self.bit - 1, 1, [kc, -kc]);
        }
        stiffness.diagonal[tip] = stiffness.diagonal[tip] + self.rock_stiffness(index % 4);
        if index % 4 == 1 {
            damping.diagonal[tip] = damping.diagonal[tip] + r(rock.viscosity);
        }
        System { stiffness, damping }
    }

    fn rock_stiffness(&self, rock: usize) -> T {
        let r = &self.parameters.rock;
        match rock {
            0 => T::default(),
            1 | 2 => T::from(r.stiffness),
            _ => T::from(r.unloading_ratio) * T::from(r.stiffness),
        }
    }

    /// Number of nodes of both bodies.
    pub fn nodes(&self) -> usize {
        self.mass.diagonal.len()
    }

    /// The parameters it was assembled from.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The linear system of a mode.
    pub fn system(&self, mode: Mode) -> &System<T> {
        &self.systems[mode.system_index()]
    }

    /// Where the present rock line meets zero force, m.
    pub fn foot(&self, mode: Mode, memory: &Memory<T>) -> T {
        match mode.rock {
            Rock::BC | Rock::SS => memory.uu,
            _ => memory.ul,
        }
    }

    /// The constant forces of a mode, N.
    pub fn load(&self, mode: Mode, memory: &Memory<T>) -> Vec<T> {
        let amplitude = T::from(self.parameters.drive.amplitude);
        let force = if mode.down { amplitude } else { -amplitude };
        let mut load: Vec<T> =
            self.dead.iter().zip(&self.drive).map(|(&d, &s)| d + force * s).collect();
        if mode.closed {
            let push = self.contact_stiffness * T::from(self.parameters.contact.initial_gap);
            load[self.bit - 1] = load[self.bit - 1] + push;
            load[self.bit] = load[self.bit] - push;
        }
        let tip = self.nodes() - 1;
        let rock = self.rock_stiffness(mode.system_index() % 4);
        load[tip] = load[tip] + rock * self.foot(mode, memory);
        load
    }

    /// The right-hand side: `v' = M^-1 (load - K u - C v)`, in `O(n)`.
    #[inline]
    pub fn acceleration(&self, mode: Mode, load: &[T], u: &[T], v: &[T], out: &mut [T]) {
        let system = self.system(mode);
        out.copy_from_slice(load);
        system.stiffness.subtract_product(u, out);
        system.damping.subtract_product(v, out);
        self.mass_factor.solve(out);
    }

    /// `psi'`, W.
    pub fn power(&self, mode: Mode, v: &[T]) -> T {
        let speed = v[v.len() - 1];
        match mode.rock {
            Rock::DFC => T::from(self.parameters.rock.viscosity) * speed * speed,
            _ => T::default(),
        }
    }

    /// `F_R`, N.
    pub fn rock_force(&self, mode: Mode, memory: &Memory<T>, state: &State<T>) -> T {
        let tip = self.nodes() - 1;
        let spring =
            self.rock_stiffness(mode.system_index() % 4) * (state.u[tip] - self.foot(mode, memory));
        match mode.rock {
            Rock::DFC => spring + T::from(self.parameters.rock.viscosity) * state.v[tip],
            _ => spring,
        }
    }

    /// Reads a quantity off a state.
    pub fn quantity(&self, quantity: Quantity, state: &State<T>) -> T {
        match quantity {
            Quantity::Gap => self.gap(&state.u) + T::from(self.parameters.contact.initial_gap),
            Quantity::Tip => state.u[self.nodes() - 1],
            Quantity::TipSpeed => state.v[self.nodes() - 1],
            Quantity::Relative => {
                self.mean_difference(&state.u) - T::from(self.parameters.contact.initial_gap)
            }
            Quantity::Work => state.psi,
        }
    }

    /// `w2.u`: the gap but for `g0`.
    pub fn gap(&self, u: &[T]) -> T {
        u[self.bit] - u[self.bit - 1]
    }

    /// `up_mean - ub_mean`: the relative position but for `g0`.
    pub fn mean_difference(&self, u: &[T]) -> T {
        self.relative.iter().zip(u).fold(T::default(), |sum, (&r, &x)| sum + r * x)
    }

    /// The guards of a mode, in the order contact, rock, relay.
    pub fn guards(&self, mode: Mode, memory: &Memory<T>) -> Vec<Guard<T>> {
        let zero = T::default();
        let rock = &self.parameters.rock;
        let guard = |event, quantity, sign, offset| Guard { event, quantity, sign, offset };
        let mut list = vec![if mode.closed {
            guard(Event::Open, Quantity::Gap, 1.0, zero)
        } else {
            guard(Event::Close, Quantity::Gap, -1.0, zero)
        }];
        let speed = Quantity::TipSpeed;
        let vs = T::from(rock.standstill_speed);
        match mode.rock {
            Rock::FF => list.push(guard(Event::Q1, Quantity::Tip, 1.0, memory.ul)),
            Rock::DFC => {
                list.push(guard(Event::Q2, speed, -1.0, zero));
                let barrier = T::from(rock.energy_barrier);
                list.push(guard(Event::Q3, Quantity::Work, 1.0, barrier));
            }
            Rock::FC => list.push(guard(Event::Q4, speed, -1.0, zero)),
            Rock::BC => {
                list.push(guard(Event::Q5, Quantity::Tip, -1.0, memory.uu));
                list.push(guard(Event::Q6, speed, 1.0, zero));
            }
            Rock::SS => {
                list.push(guard(Event::LiftOff, Quantity::Tip, -1.0, memory.uu));
                list.push(guard(Event::Q7, speed, 1.0, vs));
                list.push(guard(Event::Q8, speed, -1.0, -vs));
            }
        }
        list.push(if mode.down {
            guard(Event::Q9, Quantity::Relative, 1.0, zero)
        } else {
            let stroke = T::from(self.parameters.drive.stroke);
            guard(Event::Q10, Quantity::Relative, -1.0, -stroke)
        });
        list
    }

    /// What an event does.
    pub fn transition(
        &self,
        event: Event,
        mode: &mut Mode,
        memory: &mut Memory<T>,
        state: &mut State<T>,
    ) {
        let gamma = T::from(self.parameters.rock.unloading_ratio);
        let p = state.u[self.nodes() - 1];
        match event {
            Event::Close => mode.closed = true,
            Event::Open => mode.closed = false,
            Event::Q9 => mode.down = false,
            Event::Q10 => mode.down = true,
            Event::Q1 => (mode.rock, state.psi) = (Rock::DFC, T::default()),
            Event::Q3 => mode.rock = Rock::FC,
            Event::Q8 => mode.rock = Rock::BC,
            Event::Q2 | Event::Q4 => {
                let foot = p - (p - memory.ul) / gamma;
                (memory.gain, memory.uu, mode.rock) = (foot - memory.uu, foot, Rock::BC);
            }
            Event::Q5 | Event::LiftOff => (memory.ul, mode.rock) = (memory.uu, Rock::FF),
            Event::Q6 if memory.gain < T::from(self.parameters.rock.standstill_penetration) => {
                mode.rock = Rock::SS;
            }
            Event::Q6 | Event::Q7 => {
                memory.ul = p - gamma * (p - memory.uu);
                (mode.rock, state.psi) = (Rock::DFC, T::default());
            }
        }
    }

    /// At rest: the piston unstressed, the bit standing on the rock under its
    /// dead loads (which must push it down) in SS with `ul = uu = 0`.
    pub fn start(&self) -> (State<T>, Mode, Memory<T>) {
        let n = self.nodes();
        let mode = Mode { closed: false, rock: Rock::SS, down: true };
        let mut u = vec![T::default(); n];
        // The force above a section is carried by the rock and by every element below it.
        let dead: Vec<T> = self.dead[self.bit..].to_vec();
        let mut carried = dead.iter().fold(T::default(), |sum, &f| sum + f);
        u[n - 1] = carried / self.rock_stiffness(3);
        for i in (self.bit..n - 1).rev() {
            carried = carried - self.dead[i + 1];
            u[i] = u[i + 1] - carried / self.systems[0].stiffness.off[i];
        }
        let mut v = vec![T::default(); n];
        v[..self.bit].fill(T::from(self.parameters.piston.initial_velocity));
        (State { u, v, psi: T::default() }, mode, Memory::default())
    }
}
