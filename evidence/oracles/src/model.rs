//! The hammer as a nodal finite element model, assembled from the text alone.
//!
//! ```text
//! M v' = load - K u - C v,   u' = v,   psi' = CR p'^2 in DFC, else 0
//! ```
//!
//! `M` (consistent) and `K` are tridiagonal in the order piston top to bottom,
//! bit top to bottom; a closed contact couples the two middle nodes and keeps
//! them so. (Spectral elements add what of `K` is beyond, and have a diagonal `M`.) `K`, `C` and `load` depend on the mode ([`Model::system`]), and a
//! mode ends where one of its guards ([`Model::guards`]) rises through zero.
//!
//! Everything is generic over [`Real`], so that one text serves the reference
//! (double-double) and its competitors (`f64`). SI units.

use crate::assembly::{add_bar, add_element, add_spectral_bar};
pub use crate::law::{Event, Guard, Memory, Mode, Quantity, Rock, State};
pub use crate::linear::{Factor, Field, Real, Tridiagonal};
use crate::scene::{Body, Drive, Fidelity, Input, RockLaw, Scene};
use crate::spectral::{Far, solve};

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
    /// Stiffness of the bars alone, N/m.
    pub bars: Tridiagonal<T>,
    /// What of it is beyond the tridiagonal, N/m: none of linear elements.
    pub far: Far<T>,
    /// The eight systems, by [`Mode::system_index`].
    pub systems: Vec<System<T>>,
    /// Row whose product with `u` is the piston's mean minus the bit's.
    pub relative: Vec<T>,
    /// Nodal forces of gravity, N.
    pub weight: Vec<T>,
    /// Nodal forces of a unit driving force.
    pub drive: Vec<T>,
    /// Meeting stiffness, N/m.
    pub contact_stiffness: T,
    /// What it was assembled from, as it is now.
    pub scene: Scene,
}

impl<T: Real> Model<T> {
    /// Assembles the hammer; rigid bodies have one node each.
    pub fn new(scene: &Scene) -> Self {
        let nodes = |body: &Body| match scene.fidelity {
            Fidelity::Rigid => 1,
            Fidelity::Elastic => body.elements() + 1,
            Fidelity::Spectral(degree) => degree * body.elements() + 1,
        };
        let [piston, lower] = &scene.bodies;
        let (bit, n) = (nodes(piston), nodes(piston) + nodes(lower));
        let (mut mass, mut bars) = (Tridiagonal::zero(n), Tridiagonal::zero(n));
        let mut far = Vec::new();
        for (body, first) in [(piston, 0), (lower, bit)] {
            match scene.fidelity {
                Fidelity::Spectral(degree) => {
                    let what = (scene, body, degree);
                    add_spectral_bar(what, first, &mut mass, &mut bars, &mut far);
                }
                _ => add_bar(scene, body, first, &mut mass, &mut bars),
            }
        }
        let mut model = Self {
            bit,
            mass_factor: mass.factor(),
            systems: Vec::new(),
            relative: Vec::new(),
            weight: Vec::new(),
            drive: Vec::new(),
            contact_stiffness: T::from(scene.contact_stiffness),
            scene: scene.clone(),
            mass,
            bars,
            far,
        };
        model.assemble();
        model.rows();
        model
    }

    /// Takes over another rock law, and another amplitude of the relay.
    pub fn retune(&mut self, rock: RockLaw, force: Option<f64>) {
        self.scene.rock = rock;
        if let (Drive::Relay { amplitude, .. }, Some(force)) = (&mut self.scene.drive, force) {
            *amplitude = force;
        }
        self.assemble();
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
        let gravity = T::from(self.scene.gravity);
        self.relative =
            piston.iter().zip(&bit).map(|(&p, &b)| p / piston_mass - b / bit_mass).collect();
        self.weight = piston.iter().zip(&bit).map(|(&p, &b)| (p + b) * gravity).collect();
        self.drive = piston.iter().map(|&p| p / piston_mass).collect();
    }

    fn assemble(&mut self) {
        self.systems = (0..8).map(|index| self.system_of(index)).collect();
    }

    fn system_of(&self, index: usize) -> System<T> {
        let r = T::from;
        let (tip, beta) = (self.nodes() - 1, r(self.scene.damping_time));
        let mut stiffness = self.bars.clone();
        let mut damping = Tridiagonal {
            diagonal: self.bars.diagonal.iter().map(|&k| beta * k).collect(),
            off: self.bars.off.iter().map(|&k| beta * k).collect(),
        };
        if index >= 4 {
            let kc = self.contact_stiffness;
            add_element(&mut stiffness, self.bit - 1, [kc, -kc]);
        }
        stiffness.diagonal[tip] = stiffness.diagonal[tip] + self.rock_stiffness(index % 4);
        if index % 4 == 1 {
            damping.diagonal[tip] = damping.diagonal[tip] + r(self.scene.rock.viscosity);
        }
        System { stiffness, damping }
    }

    fn rock_stiffness(&self, rock: usize) -> T {
        let r = &self.scene.rock;
        match rock {
            0 => T::default(),
            1 | 2 => T::from(r.stiffness),
            _ => T::from(r.ratio) * T::from(r.stiffness),
        }
    }

    /// A power of two near the reciprocal of the fastest rate, s.
    pub fn unit(&self) -> f64 {
        let mass = |i: usize| self.mass.diagonal[i].to_f64();
        let rates = self.systems.iter().flat_map(|system| {
            let stiffness = &system.stiffness.diagonal;
            let damping = &system.damping.diagonal;
            (0..stiffness.len()).map(move |i| {
                // Bounds of one node, thrice for the others that consistent mass brings in.
                let (k, c) = (stiffness[i].to_f64() / mass(i), damping[i].to_f64() / mass(i));
                (6.0 * k).sqrt().max(3.0 * c)
            })
        });
        let fastest = rates.fold(f64::MIN_POSITIVE, f64::max);
        (-fastest.log2().round()).exp2()
    }

    /// Number of nodes of both bodies.
    pub fn nodes(&self) -> usize {
        self.mass.diagonal.len()
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

    /// Gravity, and what springs push with where `u = 0`, N: all but the inputs.
    pub fn standing(&self, mode: Mode, memory: &Memory<T>) -> Vec<T> {
        let mut load = self.weight.clone();
        if mode.closed {
            let push = self.contact_stiffness * T::from(self.scene.gap);
            load[self.bit - 1] = load[self.bit - 1] + push;
            load[self.bit] = load[self.bit] - push;
        }
        let tip = self.nodes() - 1;
        let rock = self.rock_stiffness(mode.system_index() % 4);
        load[tip] = load[tip] + rock * self.foot(mode, memory);
        load
    }

    /// All forces of a mode where the inputs stay as they start, N.
    pub fn load(&self, mode: Mode, memory: &Memory<T>) -> Vec<T> {
        self.load_of(mode, memory, &self.scene.inputs.map(|value| vec![T::from(value)]))
    }

    /// All forces of a mode under the inputs' present values, N.
    pub fn load_of(&self, mode: Mode, memory: &Memory<T>, values: &[Vec<T>; 4]) -> Vec<T> {
        let (feed, force) = (values[Input::Feed as usize][0], self.driving(mode, values)[0]);
        let mut load = self.standing(mode, memory);
        load[self.bit] = load[self.bit] + feed;
        load.iter_mut().zip(&self.drive).for_each(|(sum, &share)| *sum = *sum + force * share);
        load
    }

    /// `F_A` as a polynomial, N, of the inputs' coefficients; of the relay, its present force.
    pub fn driving(&self, mode: Mode, inputs: &[Vec<T>; 4]) -> Vec<T> {
        let of = |input: Input| &inputs[input as usize];
        match self.scene.drive {
            Drive::Relay { amplitude, .. } => {
                vec![T::from(if mode.down { amplitude } else { -amplitude })]
            }
            Drive::Force => of(Input::Force).clone(),
            Drive::Pressure { areas } | Drive::Chambers { areas, .. } => {
                let [down, up] = [Input::DrivePressure, Input::ReturnPressure].map(of);
                let at = |row: &[T], k: usize, area: f64| {
                    T::from(area) * row.get(k).copied().unwrap_or_default()
                };
                let terms = 0..down.len().max(up.len());
                terms.map(|k| at(down, k, areas[0]) - at(up, k, areas[1])).collect()
            }
        }
    }

    /// The right-hand side: `v' = M^-1 (load - K u - C v)`, in `O(n)`.
    #[inline]
    pub fn acceleration(&self, mode: Mode, load: &[T], u: &[T], v: &[T], out: &mut [T]) {
        self.imbalance(mode, load, u, v, out);
        self.mass_factor.solve(out);
    }

    /// `load - K u - C v`, N.
    #[inline]
    pub fn imbalance(&self, mode: Mode, load: &[T], u: &[T], v: &[T], out: &mut [T]) {
        let system = self.system(mode);
        out.copy_from_slice(load);
        system.stiffness.subtract_product(u, out);
        system.damping.subtract_product(v, out);
        let beta = T::from(self.scene.damping_time);
        for &(i, j, k) in &self.far {
            out[i] = out[i] - k * (u[j] + beta * v[j]);
            out[j] = out[j] - k * (u[i] + beta * v[i]);
        }
    }

    /// `psi'`, W.
    pub fn power(&self, mode: Mode, v: &[T]) -> T {
        let speed = v[v.len() - 1];
        match mode.rock {
            Rock::DFC => T::from(self.scene.rock.viscosity) * speed * speed,
            _ => T::default(),
        }
    }

    /// `F_R`, N.
    pub fn rock_force(&self, mode: Mode, memory: &Memory<T>, state: &State<T>) -> T {
        let tip = self.nodes() - 1;
        let spring =
            self.rock_stiffness(mode.system_index() % 4) * (state.u[tip] - self.foot(mode, memory));
        match mode.rock {
            Rock::DFC => spring + T::from(self.scene.rock.viscosity) * state.v[tip],
            _ => spring,
        }
    }

    /// Reads a quantity off a state.
    pub fn quantity(&self, quantity: Quantity, state: &State<T>) -> T {
        self.quantity_of(quantity, &state.u, &state.v, state.psi)
    }

    /// Reads a quantity off the parts of a state.
    pub fn quantity_of(&self, quantity: Quantity, u: &[T], v: &[T], psi: T) -> T {
        let gap = T::from(self.scene.gap);
        match quantity {
            Quantity::Gap => self.gap(u) + gap,
            Quantity::Tip => u[self.nodes() - 1],
            Quantity::TipSpeed => v[self.nodes() - 1],
            Quantity::Relative => self.mean_difference(u) - gap,
            Quantity::Work => psi,
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
        let rock = &self.scene.rock;
        let [displacement, velocity] = self.scene.resolutions;
        let guard = |event, quantity, sign, offset| {
            let height = match quantity {
                Quantity::Gap | Quantity::Tip | Quantity::Relative => displacement,
                Quantity::TipSpeed => velocity,
                Quantity::Work => 0.0,
            };
            Guard { event, quantity, sign, offset, height }
        };
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
                list.push(guard(Event::Q3, Quantity::Work, 1.0, T::from(rock.barrier)));
            }
            Rock::FC => list.push(guard(Event::Q4, speed, -1.0, zero)),
            Rock::BC => {
                list.push(guard(Event::Q5, Quantity::Tip, -1.0, memory.uu));
                list.push(guard(Event::Q6, speed, 1.0, zero));
            }
            Rock::SS if rock.reloads => {
                let turned = memory.uu + memory.turned / self.rock_stiffness(3);
                list.push(guard(Event::LiftOff, Quantity::Tip, -1.0, memory.uu));
                list.push(guard(Event::Q7, Quantity::Tip, 1.0, turned));
            }
            Rock::SS => {
                list.push(guard(Event::LiftOff, Quantity::Tip, -1.0, memory.uu));
                list.push(guard(Event::Q7, speed, 1.0, vs));
                list.push(guard(Event::Q8, speed, -1.0, -vs));
            }
        }
        match self.scene.drive {
            Drive::Relay { .. } if mode.down => {
                list.push(guard(Event::Q9, Quantity::Relative, 1.0, zero));
            }
            Drive::Relay { stroke, .. } => {
                list.push(guard(Event::Q10, Quantity::Relative, -1.0, -T::from(stroke)));
            }
            // A run knows the ports.
            Drive::Force | Drive::Pressure { .. } | Drive::Chambers { .. } => {}
        }
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
        let gamma = T::from(self.scene.rock.ratio);
        let p = state.u[self.nodes() - 1];
        match event {
            Event::Close => mode.closed = true,
            Event::Open => mode.closed = false,
            Event::Q9 => mode.down = false,
            Event::Q10 => mode.down = true,
            Event::Port(..) | Event::Level(_) => {}
            Event::Q1 => (mode.rock, state.psi) = (Rock::DFC, T::default()),
            Event::Q3 => mode.rock = Rock::FC,
            Event::Q8 => mode.rock = Rock::BC,
            Event::Q2 | Event::Q4 => {
                let foot = p - (p - memory.ul) / gamma;
                memory.turned = self.rock_stiffness(2) * (p - memory.ul);
                (memory.gain, memory.uu, mode.rock) = (foot - memory.uu, foot, Rock::BC);
            }
            Event::Q5 | Event::LiftOff => (memory.ul, mode.rock) = (memory.uu, Rock::FF),
            Event::Q6 if self.scene.rock.reloads => mode.rock = Rock::SS,
            Event::Q6 if memory.gain < T::from(self.scene.rock.standstill_penetration) => {
                mode.rock = Rock::SS;
            }
            Event::Q6 | Event::Q7 => {
                memory.ul = p - gamma * (p - memory.uu);
                (mode.rock, state.psi) = (Rock::DFC, T::default());
            }
        }
    }

    /// The piston unstressed, the bit at rest and without oscillation: standing on the rock
    /// under its dead loads in SS with `ul = uu = 0`; or, if they lift it, just touching in FF,
    /// strained as its loads strain it in the uniform acceleration that follows.
    pub fn start(&self) -> (State<T>, Mode, Memory<T>) {
        let n = self.nodes();
        let zero = T::default();
        let mut u = vec![zero; n];
        let feed = T::from(self.scene.inputs[Input::Feed as usize]);
        let mut dead = self.weight[self.bit..].to_vec();
        dead[0] = dead[0] + feed;
        let load = dead.iter().fold(zero, |sum, &f| sum + f);
        let held = load >= zero;
        if held {
            u[n - 1] = load / self.rock_stiffness(3);
        } else {
            // What accelerates a node is not passed on; the row holds minus its share.
            let shares = &self.relative[self.bit..];
            dead.iter_mut().zip(shares).for_each(|(f, &share)| *f = *f + load * share);
        }
        let hung = self.hanging(&dead, u[n - 1]);
        u[self.bit..].copy_from_slice(&hung);
        // A lifted bit may be longer than the gap has room for: the piston is that much higher.
        let gap = self.gap(&u) + T::from(self.scene.gap);
        if gap < zero {
            u[..self.bit].fill(gap);
        }
        let mut v = vec![zero; n];
        v[..self.bit].fill(T::from(self.scene.bodies[0].velocity));
        v[self.bit..].fill(T::from(self.scene.bodies[1].velocity));
        let rock = if held { Rock::SS } else { Rock::FF };
        let turned = if held { load } else { zero };
        let memory = Memory { turned, ..Memory::default() };
        let closed = (self.gap(&u) + T::from(self.scene.gap)).to_f64() < -self.scene.resolutions[0];
        (State { u, v, psi: zero }, Mode { closed, rock, down: true }, memory)
    }

    /// Displacements of the bit's nodes under forces, its tip held at `tip`.
    fn hanging(&self, forces: &[T], tip: T) -> Vec<T> {
        let n = forces.len() - 1;
        if self.far.is_empty() {
            // The force above a section is carried by every element below it.
            let mut u = vec![tip; n + 1];
            let mut carried = forces.iter().fold(T::default(), |sum, &f| sum + f) - forces[n];
            for i in (0..n).rev() {
                u[i] = u[i + 1] - carried / self.bars.off[self.bit + i];
                carried = carried - forces[i];
            }
            return u;
        }
        let mut k = vec![vec![T::default(); n]; n];
        for i in 0..n {
            k[i][i] = self.bars.diagonal[self.bit + i];
            if i + 1 < n {
                let off = self.bars.off[self.bit + i];
                (k[i][i + 1], k[i + 1][i]) = (off, off);
            }
        }
        for &(i, j, value) in self.far.iter().filter(|e| e.0 >= self.bit && e.1 < self.bit + n) {
            let (i, j) = (i - self.bit, j - self.bit);
            (k[i][j], k[j][i]) = (value, value);
        }
        // Relative to the tip, which then needs no column.
        let relative = solve(k, forces[..n].to_vec());
        relative.into_iter().chain([T::default()]).map(|u| u + tip).collect()
    }

    /// Kinetic energy, strain energy, contact energy and recoverable rock energy, J.
    pub fn stored(&self, mode: Mode, memory: &Memory<T>, state: &State<T>) -> [T; 4] {
        let half = T::from(0.5);
        let mut momentum = vec![T::default(); self.nodes()];
        self.mass.subtract_product(&state.v, &mut momentum);
        let pairs = state.v.iter().zip(&momentum);
        let kinetic = pairs.fold(T::default(), |sum, (&v, &p)| sum - half * v * p);
        let strain =
            self.bars.off.iter().zip(state.u.windows(2)).fold(T::default(), |sum, (&k, pair)| {
                sum - half * k * (pair[1] - pair[0]) * (pair[1] - pair[0])
            });
        // Rows of K sum to zero: a form in differences, whose digits do not cancel.
        let strain = self.far.iter().fold(strain, |sum, &(i, j, k)| {
            let stretch = state.u[j] - state.u[i];
            sum - half * k * stretch * stretch
        });
        let gap = self.quantity(Quantity::Gap, state);
        let contact =
            if mode.closed { half * self.contact_stiffness * gap * gap } else { T::default() };
        let unloading = self.rock_stiffness(3);
        let p = state.u[self.nodes() - 1];
        let rock = match mode.rock {
            Rock::FF => T::default(),
            Rock::DFC | Rock::FC => {
                let force = self.rock_stiffness(2) * (p - memory.ul);
                half * force * force / unloading
            }
            Rock::BC | Rock::SS => half * unloading * (p - memory.uu) * (p - memory.uu),
        };
        [kinetic, strain, contact, rock]
    }
}
