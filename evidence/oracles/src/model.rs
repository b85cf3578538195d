//! The hammer as a nodal finite element model, assembled from the text alone.
//!
//! ```text
//! M v' = load - K u - C v,   u' = v,   psi' = CR p'^2 in DFC, else 0
//! ```
//!
//! `M` (consistent) and `K` are tridiagonal in the order piston top to bottom, then the body that it
//! strikes, and so on to the bit; a closed contact couples the piston's lowest node with the next and
//! keeps them so. (Splines have more diagonals of both.) `K`, `C` and
//! `load` depend on the mode ([`Model::system`]; [`Joint`]s add their own), and a mode ends where one of
//! its guards ([`Model::guards`]) rises through zero.
//!
//! A casing's nodes come after the bit's, top to bottom, one if it is rigid, of mass `Mc`; feed and string
//! act on its highest, the chuck on its lowest.
//!
//! Everything is generic over [`Real`], so that one text serves the reference
//! (double-double) and its competitors (`f64`). SI units.

mod joint;
mod start;

use crate::assembly::{add_bar, add_element, add_spline_bar};
pub use crate::law::{Event, Guard, Memory, Mode, Quantity, Rock, State};
pub use crate::linear::{Banded, Factor, Real};
pub use joint::Joint;

use crate::scene::{AirLaw, Drive, Fidelity, Input, RockLaw, Scene, Section};
use std::ops::Range;

/// The linear system of a mode.
#[derive(Clone, Debug)]
pub struct System<T> {
    /// Stiffness with contact and rock, N/m.
    pub stiffness: Banded<T>,
    /// Damping with rock viscosity, N s/m.
    pub damping: Banded<T>,
}

/// The assembled hammer.
#[derive(Clone, Debug)]
pub struct Model<T> {
    /// Index of each body's highest node, the casing's last, and the number of nodes.
    pub starts: Vec<usize>,
    /// Index of the node that the piston strikes; the piston has the nodes before it.
    pub bit: usize,
    /// Index of the bit's lowest node; those of a casing come after it.
    pub tip: usize,
    /// What joins the bodies below the piston, top to bottom.
    pub joints: Vec<Joint<T>>,
    /// Consistent mass, kg.
    pub mass: Banded<T>,
    /// Its factors.
    pub mass_factor: Factor<T>,
    /// Stiffness of the bars alone, N/m.
    pub bars: Banded<T>,
    /// The eight systems, by [`Mode::system_index`].
    pub systems: Vec<System<T>>,
    /// Row whose product with `u` is the mean of all from the struck node to the tip.
    pub bit_mean: Vec<T>,
    /// Row whose product with `u` is the piston's mean minus that of the body it strikes.
    pub over: Vec<T>,
    /// The same, but in a casing minus the casing's.
    pub relative: Vec<T>,
    /// Nodal forces of gravity, N.
    pub weight: Vec<T>,
    /// Nodal forces of a unit driving force, and of its reaction on a casing.
    pub drive: Vec<T>,
    /// The same of a unit force with which the return chamber presses on the struck body.
    pub anvil: Vec<T>,
    /// Meeting stiffness, N/m.
    pub contact_stiffness: T,
    /// The scene, with the present tuning.
    pub scene: Scene,
}

impl<T: Real> Model<T> {
    /// Assembles the hammer. A rigid body has one node.
    pub fn new(scene: &Scene) -> Self {
        let around = scene.casing.as_ref().map(|casing| &casing.sections);
        let bodies: Vec<&Vec<Section>> =
            scene.bodies.iter().map(|body| &body.sections).chain(around).collect();
        let mut starts = vec![0];
        for sections in &bodies {
            starts.push(starts[starts.len() - 1] + scene.fidelity.unknowns(sections));
        }
        let (n, tip) = (starts[bodies.len()], starts[scene.bodies.len()] - 1);
        let (mut mass, mut bars) = (Banded::zero(n), Banded::zero(n));
        for (sections, &first) in bodies.into_iter().zip(&starts) {
            let bar = |degree| (scene, &sections[..], degree);
            match scene.fidelity {
                Fidelity::Spline(degree) => {
                    add_spline_bar(bar(degree), first, &mut mass, &mut bars);
                }
                _ => add_bar(scene, sections, first, &mut mass, &mut bars),
            }
        }
        if let Some(casing) = scene.casing.as_ref().filter(|casing| casing.sections.is_empty()) {
            mass.diagonal[tip + 1] = T::from(casing.mass);
        }
        let mut model = Self {
            bit: starts[1],
            tip,
            starts,
            joints: Vec::new(),
            mass_factor: mass.factor(0, n),
            systems: Vec::new(),
            bit_mean: Vec::new(),
            over: Vec::new(),
            relative: Vec::new(),
            weight: Vec::new(),
            drive: Vec::new(),
            anvil: Vec::new(),
            contact_stiffness: T::from(scene.contact_stiffness),
            scene: scene.clone(),
            mass,
            bars,
        };
        model.joints = Joint::all(scene, &model.stack());
        model.assemble();
        model.rows();
        model
    }

    /// Replaces the rock law, and the relay's amplitude.
    pub fn retune(&mut self, rock: RockLaw, force: Option<f64>) {
        self.scene.rock = rock;
        if let (Drive::Relay { amplitude, .. }, Some(force)) = (&mut self.scene.drive, force) {
            *amplitude = force;
        }
        self.assemble();
    }

    /// `M 1` of some bodies and its sum.
    fn lumped(&self, body: Range<usize>) -> (Vec<T>, T) {
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
        let (bit, bit_mass) = self.lumped(self.bit..self.tip + 1);
        let gravity = T::from(self.scene.gravity);
        let all = self.lumped(0..self.nodes()).0;
        self.weight = all.into_iter().map(|m| m * gravity).collect();
        self.bit_mean = bit.iter().map(|&b| b / bit_mass).collect();
        self.drive = piston.iter().map(|&p| p / piston_mass).collect();
        let (struck, struck_mass) = self.lumped(self.bit..self.starts[2]);
        self.anvil = struck.into_iter().map(|s| s / struck_mass).collect();
        let pairs = self.drive.iter().zip(&self.anvil);
        self.over = pairs.map(|(&p, &s)| p - s).collect();
        self.relative = self.over.clone();
        if self.scene.casing.is_some() {
            let (casing, casing_mass) = self.lumped(self.tip + 1..self.nodes());
            for row in [&mut self.drive, &mut self.anvil] {
                let shares = row.iter_mut().zip(&casing);
                shares.for_each(|(sum, &share)| *sum = *sum - share / casing_mass);
            }
            self.relative = self.drive.clone();
        }
    }

    fn assemble(&mut self) {
        self.systems = (0..8).map(|index| self.system_of(index)).collect();
    }

    fn system_of(&self, index: usize) -> System<T> {
        let r = T::from;
        let (tip, beta) = (self.tip, r(self.scene.damping_time));
        let mut stiffness = self.bars.clone();
        let mut damping = self.bars.scaled(beta);
        if index >= 4 {
            let kc = self.contact_stiffness;
            add_element(&mut stiffness, self.bit - 1, [kc, -kc]);
        }
        stiffness.diagonal[tip] = stiffness.diagonal[tip] + self.rock_stiffness(index % 4);
        if index % 4 == 1 {
            damping.diagonal[tip] = damping.diagonal[tip] + r(self.scene.rock.viscosity);
        }
        if let Some(casing) = &self.scene.casing {
            damping.diagonal[tip + 1] = damping.diagonal[tip + 1] + r(casing.impedance);
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
                // Bounds for one node, and three times as much for the others, which consistent mass couples.
                let [ks, cs] = self.held(i);
                let k = (stiffness[i].to_f64() + ks) / mass(i);
                let c = (damping[i].to_f64() + cs) / mass(i);
                (6.0 * k).sqrt().max(3.0 * c)
            })
        });
        let fastest = rates.fold(f64::MIN_POSITIVE, f64::max);
        (-fastest.log2().round()).exp2()
    }

    /// Number of nodes of all bodies.
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

    /// Gravity, and the springs' forces at `u = 0`, N: all loads but the inputs.
    pub fn standing(&self, mode: Mode, memory: &Memory<T>) -> Vec<T> {
        let mut load = self.weight.clone();
        if mode.closed {
            let push = self.contact_stiffness * T::from(self.scene.gap);
            load[self.bit - 1] = load[self.bit - 1] + push;
            load[self.bit] = load[self.bit] - push;
        }
        self.add_joint_push(mode, &mut load);
        let tip = self.tip;
        let rock = self.rock_stiffness(mode.system_index() % 4);
        load[tip] = load[tip] + rock * self.foot(mode, memory);
        load
    }

    /// All forces of a mode under the inputs' start values, N.
    pub fn load(&self, mode: Mode, memory: &Memory<T>) -> Vec<T> {
        self.load_of(mode, memory, &self.scene.rows())
    }

    /// All forces of a mode under the inputs' present values, N.
    pub fn load_of(&self, mode: Mode, memory: &Memory<T>, values: &[Vec<T>; 6]) -> Vec<T> {
        let mut load = self.standing(mode, memory);
        load[self.fed()] = load[self.fed()] + values[Input::Feed as usize][0];
        self.push(&mut load, &self.driving(mode, values).map(|force| force[0]));
        load
    }

    /// Adds the forces of the drive on piston and struck body, with their reactions.
    pub fn push(&self, load: &mut [T], forces: &[T; 2]) {
        for (row, &force) in [&self.drive, &self.anvil].into_iter().zip(forces) {
            load.iter_mut().zip(row).for_each(|(sum, &share)| *sum = *sum + force * share);
        }
    }

    /// `F_A`, and the force of the return chamber on the struck body, N, as polynomials given by the inputs'
    /// coefficients; of a relay, its present force.
    pub fn driving(&self, mode: Mode, inputs: &[Vec<T>; 6]) -> [Vec<T>; 2] {
        let of = |input: Input| &inputs[input as usize];
        let nothing = || vec![T::default()];
        let force = match self.scene.drive {
            Drive::Relay { .. } if mode.vented => nothing(),
            Drive::Relay { amplitude, .. } => {
                vec![T::from(if mode.down { amplitude } else { -amplitude })]
            }
            Drive::Force => of(Input::Force).clone(),
            Drive::Pressure { areas } | Drive::Air(AirLaw { areas, .. }) => {
                let [down, up] = [Input::DrivePressure, Input::ReturnPressure].map(of);
                let at = |row: &[T], k: usize, area: f64| {
                    T::from(area) * row.get(k).copied().unwrap_or_default()
                };
                let terms = 0..down.len().max(up.len());
                terms.map(|k| at(down, k, areas[0]) - at(up, k, areas[1])).collect()
            }
        };
        let exhaust = match self.scene.drive {
            // For air, these inputs hold the pressures above the exhaust's.
            Drive::Pressure { .. } | Drive::Air(_) => T::default(),
            _ => return [force, nothing()],
        };
        let mut pressing = of(Input::ReturnPressure).clone();
        pressing[0] = pressing[0] - exhaust;
        [force, pressing.iter().map(|&p| p * T::from(self.scene.anvil_area)).collect()]
    }

    /// Reaction of a line at the piston to these velocities, N; a vented relay has none.
    pub fn line(&self, mode: Mode, v: &[T]) -> T {
        let vented = mode.vented && matches!(self.scene.drive, Drive::Relay { .. });
        T::from(if vented { 0.0 } else { -self.scene.impedance }) * self.mean_difference(v)
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
        self.add_joint_forces(mode, u, v, out);
    }

    /// `psi'`, W.
    pub fn power(&self, mode: Mode, v: &[T]) -> T {
        let speed = v[self.tip];
        match mode.rock {
            Rock::DFC => T::from(self.scene.rock.viscosity) * speed * speed,
            _ => T::default(),
        }
    }

    /// `F_R`, N.
    pub fn rock_force(&self, mode: Mode, memory: &Memory<T>, state: &State<T>) -> T {
        let tip = self.tip;
        let spring =
            self.rock_stiffness(mode.system_index() % 4) * (state.u[tip] - self.foot(mode, memory));
        match mode.rock {
            Rock::DFC => spring + T::from(self.scene.rock.viscosity) * state.v[tip],
            _ => spring,
        }
    }

    /// A quantity of a state.
    pub fn quantity(&self, quantity: Quantity, state: &State<T>) -> T {
        self.quantity_of(quantity, &state.u, &state.v, state.psi)
    }

    /// A quantity, from the parts of a state.
    pub fn quantity_of(&self, quantity: Quantity, u: &[T], v: &[T], psi: T) -> T {
        let gap = T::from(self.scene.gap);
        match quantity {
            Quantity::Gap => self.gap(u) + gap,
            Quantity::Tip => u[self.tip],
            Quantity::TipSpeed => v[self.tip],
            Quantity::Relative => self.mean_difference(u) - gap,
            Quantity::Work => psi,
            Quantity::Joint(i) => self.joints[i].apart(u),
        }
    }

    /// `w2.u`: the gap without `g0`.
    pub fn gap(&self, u: &[T]) -> T {
        u[self.bit] - u[self.bit - 1]
    }

    /// Difference of the means of the piston and of what it strikes, without `g0`.
    pub fn over(&self, u: &[T]) -> T {
        self.over.iter().zip(u).fold(T::default(), |sum, (&r, &x)| sum + r * x)
    }

    /// Difference of the means of the piston and of what it strikes, or of the casing: the relative position without
    /// `g0`.
    pub fn mean_difference(&self, u: &[T]) -> T {
        self.relative.iter().zip(u).fold(T::default(), |sum, (&r, &x)| sum + r * x)
    }

    /// The guards of a mode, in the order contact, joints, rock, relay.
    pub fn guards(&self, mode: Mode, memory: &Memory<T>) -> Vec<Guard<T>> {
        let zero = T::default();
        let rock = &self.scene.rock;
        let [displacement, velocity] = self.scene.resolutions;
        let guard = |event, quantity, sign, offset| {
            let height = match quantity {
                Quantity::TipSpeed => velocity,
                Quantity::Work => 0.0,
                _ => displacement,
            };
            Guard { event, quantity, sign, offset, height }
        };
        let mut list = vec![if mode.closed {
            guard(Event::Open, Quantity::Gap, 1.0, zero)
        } else {
            guard(Event::Close, Quantity::Gap, -1.0, zero)
        }];
        list.extend(self.joint_guards(mode));
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
            // A vented relay has nothing to turn.
            Drive::Relay { .. } if mode.vented => {}
            Drive::Relay { .. } if mode.down => {
                list.push(guard(Event::Q9, Quantity::Relative, 1.0, zero));
            }
            Drive::Relay { stroke, .. } => {
                list.push(guard(Event::Q10, Quantity::Relative, -1.0, -T::from(stroke)));
            }
            // Ports are handled by the run.
            Drive::Force | Drive::Pressure { .. } | Drive::Air(_) => {}
        }
        list
    }

    /// Applies an event to mode and memory.
    pub fn transition(
        &self,
        event: Event,
        mode: &mut Mode,
        memory: &mut Memory<T>,
        state: &mut State<T>,
    ) {
        let gamma = T::from(self.scene.rock.ratio);
        let p = state.u[self.tip];
        match event {
            Event::Close => mode.closed = true,
            Event::Open => mode.closed = false,
            Event::Q9 => mode.down = false,
            Event::Q10 => mode.down = true,
            Event::Port(..) | Event::Whole(..) | Event::End(_) => {}
            Event::Joint(i, side) => mode.joints[i] = side,
            // A vented relay waits in the position from which it drives again.
            Event::Vent(vented) => (mode.vented, mode.down) = (vented, true),
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

    /// Kinetic energy, strain energy, contact energy (with the joints') and recoverable rock energy, J.
    pub fn stored(&self, mode: Mode, memory: &Memory<T>, state: &State<T>) -> [T; 4] {
        let half = T::from(0.5);
        let mut momentum = vec![T::default(); self.nodes()];
        self.mass.subtract_product(&state.v, &mut momentum);
        let pairs = state.v.iter().zip(&momentum);
        let kinetic = pairs.fold(T::default(), |sum, (&v, &p)| sum - half * v * p);
        let strain = half * self.bars.square_of_differences(&state.u);
        let gap = self.quantity(Quantity::Gap, state);
        let contact =
            if mode.closed { half * self.contact_stiffness * gap * gap } else { T::default() };
        let contact = contact + self.joint_energy(mode, &state.u);
        let unloading = self.rock_stiffness(3);
        let p = state.u[self.tip];
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
