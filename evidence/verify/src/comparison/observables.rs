//! The numbers of a scene that engine and reference are compared by, and their rounding.

use crate::comparison::bodies;
use crate::drawn::scenes::RandomScene;
use crate::scene::is_loose;
use hammer::{Machine, Source};
use oracles::dd::Dd;
use oracles::law::{Event, Quantity};
use oracles::linear::Real;
use oracles::record::Sampled;
use oracles::run::Run;

/// The numbers compared at an instant, each with its kind, which determines its scale.
pub(crate) const OBSERVABLES: [(&str, usize); 30] = [
    ("piston_position", 0),
    ("bit_position", 0),
    ("bit_tip_position", 0),
    ("contact_gap", 0),
    ("tip_depth", 0),
    ("piston_velocity", 1),
    ("bit_velocity", 1),
    ("bit_tip_velocity", 1),
    ("contact_force", 2),
    ("rock_force", 2),
    ("applied_drive_force", 2),
    ("energy_drive", 3),
    ("energy_gravity", 3),
    ("energy_feed", 3),
    ("energy_kinetic", 3),
    ("energy_strain", 3),
    ("energy_contact", 3),
    ("energy_rock_stored", 3),
    ("energy_rock_dissipated", 3),
    ("energy_viscous", 3),
    ("energy_damping", 3),
    ("energy_retuned", 3),
    ("casing_position", 0),
    ("casing_velocity", 1),
    ("chuck_force", 2),
    ("relative_position", 0),
    ("relative_velocity", 1),
    ("drive_chamber_pressure", 4),
    ("return_chamber_pressure", 4),
    ("air_mass", 5),
];

/// Kinds of numbers: positions, forces.
pub(crate) const PLACE: usize = 0;
pub(crate) const FORCE: usize = 2;

/// Index of the casing's numbers.
const CASING: usize = 22;

pub(crate) type Observed = [f64; OBSERVABLES.len()];

/// Scales of rounding: for each kind the largest number so far, but not less than the arithmetic starts from.
/// Oscillation is measured from the static shape, whose displacement is the compliance of springs and bars, and whose
/// speed is that of a load's wave. A work is a load times positions whose difference is the displacement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    place: f64,
    speed: f64,
    force: f64,
    energy: f64,
    /// For the air: pressure, Pa, and mass in both chambers, kg; then the relative error of the air or of a line's
    /// reaction.
    pressure: f64,
    air: f64,
    air_error: f64,
    viscosity: f64,
    /// Stiffness of the springs at the bit, N/m, and the displacement of bit or casing.
    spring: f64,
    bit: f64,
    /// Mass of all bodies, kg; resolution of guards on positions (m) and speeds (m/s).
    mass: f64,
    guards: [f64; 2],
}

impl Scales {
    pub(crate) fn new(case: &RandomScene) -> Self {
        let p = &case.parameters;
        let mass = p.total_mass();
        let load = case.loads().iter().sum::<f64>() + mass * p.gravity.abs();
        let (bars, meeting) = (bodies::compliance(p), p.meeting_stiffness());
        let yielded = load * (1.0 / p.rock.stiffness + 1.0 / meeting + bars);
        let mut place = p.contact.initial_gap + yielded;
        let waves =
            load / bodies::least_impedance(p) + load / (p.rock.stiffness * p.bit_mass()).sqrt();
        let mut speed = p.piston.initial_velocity.abs() + waves;
        let mut viscosity = p.rock.viscosity + p.drive.impedance;
        let mut spring = p.rock.unloading_ratio * p.rock.stiffness + meeting;
        if p.has_casing() {
            // As for the rock: the chuck yields, and the lighter of its bodies oscillates on it.
            place += load / p.chuck.stiffness;
            speed += load / (p.chuck.stiffness * p.bit_mass().min(p.casing_mass())).sqrt();
            viscosity += p.chuck.viscosity + p.casing.impedance;
            spring += p.chuck.stiffness;
        }
        if is_loose(p) {
            // Likewise for each joint, with the lightest possible body.
            let joint = &p.drill.joint;
            let ends = [p.drill.shank, p.drill.rod].map(|part| part.length * part.area);
            let lightest = p.material.density * ends[0].min(ends[1]);
            place += p.drill.rods as f64 * (load / joint.stiffness + joint.slack);
            speed += load / (joint.stiffness * lightest).sqrt();
            viscosity += p.material.damping_time * joint.stiffness;
            spring += joint.stiffness;
        }
        let (bit, force) = (load * bars, load + viscosity * speed);
        let (energy, guards) = (load * place, p.resolutions());
        let (pressure, air, air_error) = match p.drive.source {
            Source::Air => {
                let most = case.inputs.supply_pressure.max(case.inputs.exhaust_pressure);
                (most, bodies::air(p, most), p.air.error)
            }
            // A line's windows change a speed by less than the guards' resolution, 1e-10 of a hammer's speeds.
            _ => (0.0, 0.0, if p.drive.impedance > 0.0 { 1e-10 } else { 0.0 }),
        };
        Self {
            place,
            speed,
            force,
            energy,
            pressure,
            air,
            air_error,
            viscosity,
            spring,
            bit,
            mass,
            guards,
        }
    }

    /// Includes these numbers in the scales.
    pub(crate) fn grow(&mut self, observables: &Observed) {
        for (value, (_, kind)) in observables.iter().zip(OBSERVABLES) {
            let scale = match kind {
                0 => &mut self.place,
                1 => &mut self.speed,
                2 => &mut self.force,
                3 => &mut self.energy,
                4 => &mut self.pressure,
                _ => &mut self.air,
            };
            *scale = scale.max(value.abs());
        }
        // A spring's length is a sum of rounded motions of the bit.
        let moved = [observables[1], observables[2], observables[CASING]];
        self.bit = moved.iter().fold(self.bit, |most, x| most.max(x.abs()));
        self.force = self.force.max(self.viscosity * self.speed).max(self.spring * self.bit);
        self.energy = self.energy.max(self.force * self.place);
    }

    pub(crate) fn of(&self, kind: usize) -> f64 {
        [self.place, self.speed, self.force, self.energy, self.pressure, self.air][kind]
    }

    /// Allowed difference of a number of this kind by the air's error.
    pub(crate) fn of_air(&self, kind: usize) -> f64 {
        let part = match kind {
            FORCE => 10.0,
            PLACE => 1.0,
            _ => 3.0,
        };
        part * self.air_error * self.of(kind)
    }

    /// Resolution of the engine's guards for a kind of number: a position, a speed, the force of springs and dashpots
    /// at these, and the corresponding work.
    pub(crate) fn resolved(&self, kind: usize) -> f64 {
        let [place, speed] = self.guards;
        let energy = self.force * place + self.mass * self.speed * speed;
        let force = self.spring * place + self.viscosity * speed;
        // There are no guards on the air.
        [place, speed, force, energy, 0.0, 0.0][kind]
    }

    /// Kind of number that the guard of this event is on.
    pub(crate) fn kind_of_guard(event: Event) -> usize {
        match event {
            Event::Close | Event::Open | Event::Q1 | Event::Q5 | Event::LiftOff => 0,
            Event::Q9 | Event::Q10 | Event::Port(..) => 0,
            Event::Whole(..) | Event::End(_) | Event::Joint(..) | Event::Vent(_) => 0,
            Event::Q2 | Event::Q4 | Event::Q6 | Event::Q7 | Event::Q8 => 1,
            Event::Q3 => 3,
        }
    }
}

/// The numbers of the reference.
pub(crate) fn of_reference(run: &Run<Dd>, sample: &Sampled<Dd>) -> Observed {
    exactly(run, sample).map(Real::to_f64)
}

/// The numbers of the reference in extended precision.
pub(crate) fn exactly(run: &Run<Dd>, sample: &Sampled<Dd>) -> [Dd; OBSERVABLES.len()] {
    let (model, state, e) = (&run.model, &sample.state, &sample.energies);
    let mean = |row: &[Dd], x: &[Dd], nodes: std::ops::Range<usize>| {
        nodes.fold(Dd::default(), |sum, i| sum + row[i] * x[i])
    };
    // A unit of the driving force is distributed like the piston's mass, its reaction like the casing's.
    let piston = |x: &[Dd]| mean(&model.drive, x, 0..model.bit);
    let bit = |x: &[Dd]| mean(&model.bit_mean, x, model.bit..model.tip + 1);
    let casing = |x: &[Dd]| -mean(&model.drive, x, model.tip + 1..model.nodes());
    let [contact, rock] = sample.forces;
    let cased = model.scene.casing.is_some();
    let chuck = sample.joints.first().copied().filter(|_| cased).unwrap_or_default();
    let [kinetic, strain, closed, held] = e.stored;
    let gap = model.quantity(Quantity::Gap, state);
    [
        piston(&state.u),
        bit(&state.u),
        state.u[model.tip],
        gap,
        sample.memory.uu,
        piston(&state.v),
        bit(&state.v),
        state.v[model.tip],
        contact,
        rock,
        sample.force,
        e.drive,
        e.gravity,
        e.feed,
        kinetic,
        strain,
        closed,
        held,
        e.rock,
        e.viscous,
        e.damping,
        e.retuned,
        casing(&state.u),
        casing(&state.v),
        chuck,
        model.quantity(Quantity::Relative, state),
        model.mean_difference(&state.v),
        sample.pressures[0],
        sample.pressures[1],
        sample.taken,
    ]
}

/// How many of [`OBSERVABLES`], from the first, are positions, velocities and forces of the motion.
pub(crate) const MOTIONS: usize = 10;

/// These numbers by name, for outputs and for their derivatives.
macro_rules! motions {
    ($of:expr) => {{
        let k = $of;
        [
            k.piston.displacement,
            k.bit.displacement,
            k.tip.displacement,
            k.gap.displacement,
            k.tip_depth,
            k.piston.velocity,
            k.bit.velocity,
            k.tip.velocity,
            k.contact_force,
            k.rock_force,
        ]
    }};
}
pub(crate) use motions;

/// The present numbers of the engine.
pub(crate) fn of_engine(machine: &Machine) -> Observed {
    let (k, e) = (machine.kinematics(), machine.energies());
    let mut observables = [0.0; OBSERVABLES.len()];
    observables[..MOTIONS].copy_from_slice(&motions!(k));
    observables[MOTIONS] = k.applied_drive_force;
    // All energies but the residual.
    observables[MOTIONS + 1..CASING].copy_from_slice(&e.values()[..11]);
    let is_air = machine.parameters().drive.source == Source::Air;
    let pressures = machine.chamber_pressures().map(|[p, _]| if is_air { p } else { 0.0 });
    observables[CASING..].copy_from_slice(&[
        k.casing.displacement,
        k.casing.velocity,
        k.chuck_force,
        k.relative.displacement,
        k.relative.velocity,
        pressures[0],
        pressures[1],
        machine.air_mass()[0],
    ]);
    observables
}
