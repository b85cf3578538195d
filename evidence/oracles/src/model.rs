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

pub use crate::law::{Event, Guard, Memory, Mode, Quantity, Rock, State};
pub use crate::linear::{Factor, Field, Real, Tridiagonal};
use hammer::parameters::{Fidelity, InputValues, Parameters};

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
    /// Dead loads, N.
    pub dead: Vec<T>,
    /// Nodal forces of a unit driving force.
    pub drive: Vec<T>,
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
        self.quantity_of(quantity, &state.u, &state.v, state.psi)
    }

    /// Reads a quantity off the parts of a state.
    pub fn quantity_of(&self, quantity: Quantity, u: &[T], v: &[T], psi: T) -> T {
        let gap = T::from(self.parameters.contact.initial_gap);
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
