//! The one table of variables: a row's position is its value reference. Each row reads the engine
//! through its accessor, so that start values, ranges and getters cannot differ.

use crate::laws::mode::RockMode;
use crate::machine::Machine;
use crate::machine::blows::Blow;
use crate::quantities::domain::Domain;
use crate::quantities::inputs::Input;
use crate::quantities::parameters::{Fidelity, InputValues, Parameters, RULES, Rule, Source};
use crate::quantities::quantity::*;

/// Reads something of the engine.
pub type Read<T> = fn(&mut Machine) -> T;

/// One variable.
#[derive(Clone, Copy)]
pub struct Variable {
    /// Name, unique.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Causality, type and access.
    pub role: Role,
}

/// Causality, type and access: an output has no setter to call by mistake.
#[derive(Clone, Copy)]
pub enum Role {
    /// A parameter.
    Parameter {
        /// Type and access.
        slot: Slot,
        /// May change during simulation.
        tunable: bool,
    },
    /// A real input.
    Input {
        /// Type.
        quantity: Quantity,
        /// Which.
        input: Input,
        /// Where its start value is.
        start: fn(&mut InputValues) -> &mut f64,
        /// Order of magnitude.
        nominal: f64,
    },
    /// A real output.
    Output(Output),
    /// A local Boolean.
    Truth(Read<bool>),
    /// A local enumeration: its item's index.
    Choice(Enumeration, Read<usize>),
}

/// Type and access of a parameter.
#[derive(Clone, Copy)]
pub enum Slot {
    /// Real.
    Real(Quantity, fn(&mut Parameters) -> &mut f64),
    /// Integer.
    Integer(fn(&mut Parameters) -> &mut usize),
    /// Enumeration, as its item's index.
    Choice(Enumeration, fn(&Parameters) -> usize, fn(&mut Parameters, usize)),
}

/// A real output.
#[derive(Clone, Copy)]
pub struct Output {
    /// Type.
    pub quantity: Quantity,
    /// Value.
    pub value: Read<f64>,
    /// First time derivative.
    pub rate: Read<f64>,
    /// Second time derivative, where it is known.
    pub second: Option<Read<f64>>,
    /// Piecewise constant.
    pub discrete: bool,
    /// Zero at the start whatever the parameters.
    pub zero_at_start: bool,
    /// Cannot be negative.
    pub positive: bool,
    /// Order of magnitude.
    pub nominal: f64,
    /// Inputs whose present value shows at once.
    pub feedthrough: &'static [Input],
}

const fn fixed(
    name: &'static str,
    quantity: Quantity,
    description: &'static str,
    access: fn(&mut Parameters) -> &mut f64,
) -> Variable {
    let slot = Slot::Real(quantity, access);
    Variable { name, description, role: Role::Parameter { slot, tunable: false } }
}

const fn tunable(
    name: &'static str,
    quantity: Quantity,
    description: &'static str,
    access: fn(&mut Parameters) -> &mut f64,
) -> Variable {
    let slot = Slot::Real(quantity, access);
    Variable { name, description, role: Role::Parameter { slot, tunable: true } }
}

const fn count(
    name: &'static str,
    description: &'static str,
    access: fn(&mut Parameters) -> &mut usize,
) -> Variable {
    let slot = Slot::Integer(access);
    Variable { name, description, role: Role::Parameter { slot, tunable: false } }
}

/// The length of a body's section `k`, from 1.
macro_rules! section_length {
    ($body:ident, $k:literal) => {
        fixed(
            concat!(stringify!($body), ".segment[", $k, "].length"),
            LENGTH,
            concat!("Length of section ", $k, " of the ", stringify!($body), ", from the top"),
            |p| &mut p.$body.segment[$k - 1].length,
        )
    };
}

/// The area of a body's section `k`, from 1.
macro_rules! section_area {
    ($body:ident, $k:literal) => {
        fixed(
            concat!(stringify!($body), ".segment[", $k, "].area"),
            AREA,
            concat!(
                "Cross section of section ",
                $k,
                " of the ",
                stringify!($body),
                ", from the top"
            ),
            |p| &mut p.$body.segment[$k - 1].area,
        )
    };
}

const fn choice(
    name: &'static str,
    items: Enumeration,
    description: &'static str,
    get: fn(&Parameters) -> usize,
    set: fn(&mut Parameters, usize),
) -> Variable {
    let slot = Slot::Choice(items, get, set);
    Variable { name, description, role: Role::Parameter { slot, tunable: false } }
}

const fn input(
    name: &'static str,
    quantity: Quantity,
    nominal: f64,
    description: &'static str,
    input: Input,
    start: fn(&mut InputValues) -> &mut f64,
) -> Variable {
    Variable { name, description, role: Role::Input { quantity, input, start, nominal } }
}

/// A continuous output.
const fn output(
    name: &'static str,
    quantity: Quantity,
    nominal: f64,
    description: &'static str,
    [value, rate]: [Read<f64>; 2],
) -> Variable {
    let output = Output {
        quantity,
        value,
        rate,
        second: None,
        discrete: false,
        zero_at_start: false,
        positive: false,
        nominal,
        feedthrough: &[],
    };
    Variable { name, description, role: Role::Output(output) }
}

/// A piecewise constant output.
const fn record(
    name: &'static str,
    quantity: Quantity,
    nominal: f64,
    description: &'static str,
    value: Read<f64>,
) -> Variable {
    output(name, quantity, nominal, description, [value, |_| 0.0]).second(|_| 0.0).held()
}

const fn truth(name: &'static str, description: &'static str, value: Read<bool>) -> Variable {
    Variable { name, description, role: Role::Truth(value) }
}

/// Adjusts an output's row; any other row is a mistake of the table.
macro_rules! adjust {
    ($row:expr, $field:ident = $value:expr) => {{
        let mut row = $row;
        match &mut row.role {
            Role::Output(output) => output.$field = $value,
            _ => panic!("only outputs"),
        }
        row
    }};
}

/// An energy and its rate.
macro_rules! energy {
    ($field:ident) => {
        [|m| m.energies().$field, |m| m.powers().$field]
    };
}

impl Variable {
    const fn second(self, rate: Read<f64>) -> Self {
        adjust!(self, second = Some(rate))
    }

    const fn held(self) -> Self {
        adjust!(self, discrete = true)
    }

    const fn zero_at_start(self) -> Self {
        adjust!(self, zero_at_start = true)
    }

    const fn positive(self) -> Self {
        adjust!(self, positive = true)
    }

    const fn fed_by(self, inputs: &'static [Input]) -> Self {
        adjust!(self, feedthrough = inputs)
    }

    /// Values that a parameter may take; `None` for anything else.
    pub fn domain(&self) -> Option<Domain> {
        let Role::Parameter { slot, .. } = &self.role else { return None };
        match slot {
            Slot::Choice(items, ..) => Some(Domain::Between(1.0, items.items.len() as f64)),
            _ => self.rule().map(|rule| rule.domain),
        }
    }

    /// False for a parameter that the scene does not read: its value is of no account then.
    pub fn applies(&self, parameters: &Parameters) -> bool {
        self.rule().is_none_or(|rule| (rule.applies)(parameters))
    }

    fn rule(&self) -> Option<&'static Rule> {
        RULES.iter().find(|rule| rule.name == self.name)
    }
}

impl Slot {
    /// The parameter as a number; an enumeration's first item is 1.
    pub fn read(&self, parameters: &Parameters) -> f64 {
        let mut copy = *parameters;
        match self {
            Self::Real(_, access) => *access(&mut copy),
            Self::Integer(access) => *access(&mut copy) as f64,
            Self::Choice(_, get, _) => get(parameters) as f64 + 1.0,
        }
    }

    /// Writes a number that lies in the variable's domain.
    pub fn write(&self, parameters: &mut Parameters, value: f64) {
        match self {
            Self::Real(_, access) => *access(parameters) = value,
            Self::Integer(access) => *access(parameters) = value as usize,
            Self::Choice(_, _, set) => set(parameters, (value as usize).saturating_sub(1)),
        }
    }
}

const FIDELITIES: [Fidelity; 2] = [Fidelity::Rigid, Fidelity::Elastic];
const SOURCES: [Source; 4] = [Source::Relay, Source::Force, Source::Pressure, Source::Chambers];

/// The last blow; zeros before the first.
fn last(machine: &Machine) -> Blow {
    machine.blow().copied().unwrap_or_default()
}

const fn rock_index(mode: RockMode) -> usize {
    match mode {
        RockMode::FreeFlight => 0,
        RockMode::DissipativeForward => 1,
        RockMode::Forward => 2,
        RockMode::Backward => 3,
        RockMode::Standstill => 4,
    }
}

/// Every variable. New rows go to the end of their group; a host that reads
/// names from the description is not bothered by moved value references.
#[rustfmt::skip]
pub static VARIABLES: &[Variable] = &[
    choice("fidelity", FIDELITY, "How the bodies are modelled",
        |p| FIDELITIES.iter().position(|f| *f == p.fidelity).unwrap_or_default(),
        |p, i| if let Some(f) = FIDELITIES.get(i) { p.fidelity = *f }),
    fixed("material.youngs_modulus", MODULUS, "Young's modulus of both bodies",
        |p| &mut p.material.youngs_modulus),
    fixed("material.density", DENSITY, "Density of both bodies", |p| &mut p.material.density),
    fixed("material.damping_time", TIME, "Kelvin-Voigt damping time: damping matrix over stiffness matrix",
        |p| &mut p.material.damping_time),
    fixed("cross_section", AREA, "Cross section of bodies without sections of their own", |p| &mut p.cross_section),
    count("mesh.degree", "Degree of the bodies' mesh: 1 linear elements, above splines (elastic bodies)",
        |p| &mut p.mesh.degree),
    fixed("piston.length", LENGTH, "Length of the piston, unless it has sections", |p| &mut p.piston.length),
    count("piston.elements", "Number of elements (spans) of the piston's mesh (elastic bodies)",
        |p| &mut p.piston.elements),
    count("piston.segments", "Number of sections of the piston; 0: uniform, of piston.length and cross_section",
        |p| &mut p.piston.segments),
    section_length!(piston, 1), section_area!(piston, 1),
    section_length!(piston, 2), section_area!(piston, 2),
    section_length!(piston, 3), section_area!(piston, 3),
    section_length!(piston, 4), section_area!(piston, 4),
    section_length!(piston, 5), section_area!(piston, 5),
    section_length!(piston, 6), section_area!(piston, 6),
    section_length!(piston, 7), section_area!(piston, 7),
    section_length!(piston, 8), section_area!(piston, 8),
    fixed("piston.initial_velocity", VELOCITY, "Velocity of the piston at the start, positive downward",
        |p| &mut p.piston.initial_velocity),
    fixed("bit.length", LENGTH, "Length of the bit, unless it has sections", |p| &mut p.bit.length),
    count("bit.elements", "Number of elements (spans) of the bit's mesh (elastic bodies)", |p| &mut p.bit.elements),
    count("bit.segments", "Number of sections of the bit; 0: uniform, of bit.length and cross_section",
        |p| &mut p.bit.segments),
    section_length!(bit, 1), section_area!(bit, 1),
    section_length!(bit, 2), section_area!(bit, 2),
    section_length!(bit, 3), section_area!(bit, 3),
    section_length!(bit, 4), section_area!(bit, 4),
    section_length!(bit, 5), section_area!(bit, 5),
    section_length!(bit, 6), section_area!(bit, 6),
    section_length!(bit, 7), section_area!(bit, 7),
    section_length!(bit, 8), section_area!(bit, 8),
    fixed("contact.stiffness", STIFFNESS, "Penalty stiffness of the contact of piston and bit",
        |p| &mut p.contact.stiffness),
    fixed("contact.initial_gap", LENGTH, "Gap of piston and bit at the start", |p| &mut p.contact.initial_gap),
    tunable("rock.stiffness", STIFFNESS, "Loading stiffness of the rock under the bit", |p| &mut p.rock.stiffness),
    tunable("rock.unloading_ratio", RATIO, "Unloading stiffness over loading stiffness",
        |p| &mut p.rock.unloading_ratio),
    tunable("rock.viscosity", VISCOSITY, "Viscous resistance of intact rock", |p| &mut p.rock.viscosity),
    tunable("rock.energy_barrier", ENERGY, "Viscous work that breaks the rock and ends the viscous phase",
        |p| &mut p.rock.energy_barrier),
    fixed("rock.standstill_speed", VELOCITY, "Bit speed that ends standstill", |p| &mut p.rock.standstill_speed),
    fixed("rock.standstill_penetration", LENGTH, "Permanent gain of a cycle below which the bit stands still",
        |p| &mut p.rock.standstill_penetration),
    choice("drive.source", SOURCE, "Where the force on the piston comes from",
        |p| SOURCES.iter().position(|s| *s == p.drive.source).unwrap_or_default(),
        |p, i| if let Some(s) = SOURCES.get(i) { p.drive.source = *s }),
    tunable("drive.amplitude", FORCE, "Amplitude of the relay's force", |p| &mut p.drive.amplitude),
    fixed("drive.stroke", LENGTH, "Stroke at which the relay turns to driving", |p| &mut p.drive.stroke),
    fixed("drive.area_drive", AREA, "Area on which the pressure that drives acts", |p| &mut p.drive.area_drive),
    fixed("drive.area_return", AREA, "Area on which the pressure that returns acts", |p| &mut p.drive.area_return),
    fixed("chambers.drive.supply.position", LENGTH, "Position of the piston over the bit at which the supply of the drive chamber turns: open above it",
        |p| &mut p.chambers.drive.supply.position),
    fixed("chambers.drive.supply.open_pressure", PRESSURE, "Pressure that the drive chamber goes to when its supply opens", |p| &mut p.chambers.drive.supply.open_pressure),
    fixed("chambers.drive.supply.open_time", TIME, "Time that this takes; 0: at once", |p| &mut p.chambers.drive.supply.open_time),
    fixed("chambers.drive.supply.shut_pressure", PRESSURE, "Pressure that the drive chamber goes to when its supply closes", |p| &mut p.chambers.drive.supply.shut_pressure),
    fixed("chambers.drive.supply.shut_time", TIME, "Time that this takes; 0: at once", |p| &mut p.chambers.drive.supply.shut_time),
    fixed("chambers.drive.exhaust.position", LENGTH, "Position of the piston over the bit at which the exhaust of the drive chamber turns: open below it",
        |p| &mut p.chambers.drive.exhaust.position),
    fixed("chambers.drive.exhaust.open_pressure", PRESSURE, "Pressure that the drive chamber goes to when its exhaust opens", |p| &mut p.chambers.drive.exhaust.open_pressure),
    fixed("chambers.drive.exhaust.open_time", TIME, "Time that this takes; 0: at once", |p| &mut p.chambers.drive.exhaust.open_time),
    fixed("chambers.drive.exhaust.shut_pressure", PRESSURE, "Pressure that the drive chamber goes to when its exhaust closes", |p| &mut p.chambers.drive.exhaust.shut_pressure),
    fixed("chambers.drive.exhaust.shut_time", TIME, "Time that this takes; 0: at once", |p| &mut p.chambers.drive.exhaust.shut_time),
    fixed("chambers.return.supply.position", LENGTH, "Position of the piston over the bit at which the supply of the return chamber turns: open below it",
        |p| &mut p.chambers.returning.supply.position),
    fixed("chambers.return.supply.open_pressure", PRESSURE, "Pressure that the return chamber goes to when its supply opens", |p| &mut p.chambers.returning.supply.open_pressure),
    fixed("chambers.return.supply.open_time", TIME, "Time that this takes; 0: at once", |p| &mut p.chambers.returning.supply.open_time),
    fixed("chambers.return.supply.shut_pressure", PRESSURE, "Pressure that the return chamber goes to when its supply closes", |p| &mut p.chambers.returning.supply.shut_pressure),
    fixed("chambers.return.supply.shut_time", TIME, "Time that this takes; 0: at once", |p| &mut p.chambers.returning.supply.shut_time),
    fixed("chambers.return.exhaust.position", LENGTH, "Position of the piston over the bit at which the exhaust of the return chamber turns: open above it",
        |p| &mut p.chambers.returning.exhaust.position),
    fixed("chambers.return.exhaust.open_pressure", PRESSURE, "Pressure that the return chamber goes to when its exhaust opens", |p| &mut p.chambers.returning.exhaust.open_pressure),
    fixed("chambers.return.exhaust.open_time", TIME, "Time that this takes; 0: at once", |p| &mut p.chambers.returning.exhaust.open_time),
    fixed("chambers.return.exhaust.shut_pressure", PRESSURE, "Pressure that the return chamber goes to when its exhaust closes", |p| &mut p.chambers.returning.exhaust.shut_pressure),
    fixed("chambers.return.exhaust.shut_time", TIME, "Time that this takes; 0: at once", |p| &mut p.chambers.returning.exhaust.shut_time),
    fixed("gravity", ACCELERATION, "Gravity, positive downward along the hole", |p| &mut p.gravity),
    fixed("blow.minimum_speed", VELOCITY, "Slowest impact that counts as a blow, relative mean speed",
        |p| &mut p.blow.minimum_speed),

    input("feed_force", FORCE, 5e3, "Feed force on the bit's shoulder, positive downward",
        Input::FeedForce, |i| &mut i.feed_force),
    input("drive_force", FORCE, 1e3, "Force on the piston, positive downward, when drive.source is Force",
        Input::DriveForce, |i| &mut i.drive_force),
    input("drive_pressure", PRESSURE, 1e6, "Pressure that drives the piston down, when drive.source is Pressure",
        Input::DrivePressure, |i| &mut i.drive_pressure),
    input("return_pressure", PRESSURE, 1e6, "Pressure that returns the piston, when drive.source is Pressure",
        Input::ReturnPressure, |i| &mut i.return_pressure),

    output("piston_position", LENGTH, 1e-2, "Mean displacement of the piston, positive downward",
        [|m| m.kinematics().piston_position, |m| m.kinematics().piston_velocity])
        .second(|m| m.kinematics().piston_acceleration),
    output("piston_velocity", VELOCITY, 10.0, "Mean velocity of the piston",
        [|m| m.kinematics().piston_velocity, |m| m.kinematics().piston_acceleration])
        .second(|m| m.kinematics().piston_jerk),
    output("bit_position", LENGTH, 1e-2, "Mean displacement of the bit, positive downward",
        [|m| m.kinematics().bit_position, |m| m.kinematics().bit_velocity])
        .second(|m| m.kinematics().bit_acceleration),
    output("bit_velocity", VELOCITY, 10.0, "Mean velocity of the bit",
        [|m| m.kinematics().bit_velocity, |m| m.kinematics().bit_acceleration])
        .second(|m| m.kinematics().bit_jerk),
    output("bit_tip_position", LENGTH, 1e-2, "Displacement of the bit's face on the rock",
        [|m| m.kinematics().bit_tip_position, |m| m.kinematics().bit_tip_velocity])
        .second(|m| m.kinematics().bit_tip_acceleration),
    output("bit_tip_velocity", VELOCITY, 10.0, "Velocity of the bit's face on the rock",
        [|m| m.kinematics().bit_tip_velocity, |m| m.kinematics().bit_tip_acceleration]),
    output("relative_position", LENGTH, 1e-2, "Mean position of the piston over the bit: 0 at rigid contact, negative apart",
        [|m| m.kinematics().relative_position, |m| m.kinematics().relative_velocity])
        .second(|m| m.kinematics().relative_acceleration),
    output("relative_velocity", VELOCITY, 10.0, "Rate of relative_position",
        [|m| m.kinematics().relative_velocity, |m| m.kinematics().relative_acceleration])
        .second(|m| m.kinematics().relative_jerk),
    output("contact_gap", LENGTH, 1e-2, "Gap of piston and bit, negative in contact",
        [|m| m.kinematics().contact_gap, |m| m.kinematics().contact_gap_rate])
        .second(|m| m.kinematics().contact_gap_acceleration),
    output("contact_force", FORCE, 1e5, "Force between piston and bit",
        [|m| m.kinematics().contact_force, |m| m.kinematics().contact_force_rate])
        .second(|m| m.kinematics().contact_force_acceleration).positive(),
    truth("contact_closed", "Piston and bit are in contact", |m| m.mode().closed),
    output("rock_force", FORCE, 1e5, "Force of the rock on the bit, positive upward",
        [|m| m.kinematics().rock_force, |m| m.kinematics().rock_force_rate]),
    Variable { name: "rock_mode", description: "Mode of the bit/rock law",
        role: Role::Choice(ROCK_MODE, |m| rock_index(m.mode().rock)) },
    output("applied_drive_force", FORCE, 1e3, "Driving force on the piston, positive downward",
        [|m| m.kinematics().applied_drive_force, |m| m.kinematics().applied_drive_force_rates[0]])
        .second(|m| m.kinematics().applied_drive_force_rates[1])
        .fed_by(&[Input::DriveForce, Input::DrivePressure, Input::ReturnPressure]),
    output("drive_chamber_pressure", PRESSURE, 1e6, "Pressure in the drive chamber when drive.source is Chambers, else 0",
        [|m| m.chamber_pressures()[0][0], |m| m.chamber_pressures()[0][1]]).second(|_| 0.0).positive(),
    output("return_chamber_pressure", PRESSURE, 1e6, "Pressure in the return chamber when drive.source is Chambers, else 0",
        [|m| m.chamber_pressures()[1][0], |m| m.chamber_pressures()[1][1]]).second(|_| 0.0).positive(),
    record("hole_depth", LENGTH, 1e-2, "Depth of the hole since the start, at the last unloading",
        |m| m.kinematics().hole_depth).zero_at_start(),

    output("contact_impulse", IMPULSE, 10.0, "Impulse of contact_force since the start",
        [|m| m.impulses().contact, |m| m.kinematics().contact_force])
        .second(|m| m.kinematics().contact_force_rate).positive().zero_at_start(),
    output("rock_impulse", IMPULSE, 100.0, "Impulse of rock_force since the start",
        [|m| m.impulses().rock, |m| m.kinematics().rock_force])
        .second(|m| m.kinematics().rock_force_rate).zero_at_start(),
    record("contact_count", COUNT, 10.0, "Collisions of piston and bit since the start",
        |m| m.counters().contacts as f64).positive(),
    record("blow_count", COUNT, 10.0, "Blows since the start: first collisions of the piston's falls",
        |m| m.counters().blows as f64).positive(),
    record("rock_cycle_count", COUNT, 100.0, "Drilling cycles of the rock begun since the start",
        |m| m.counters().rock_cycles as f64).positive(),
    record("event_count", COUNT, 1000.0, "Changes of mode since the start",
        |m| m.counters().events as f64).positive(),
    record("undecided_count", COUNT, 1.0, "Excursions of an event function that stayed within its resolution, ignored",
        |m| m.counters().near_misses as f64).positive(),

    output("contact_force_peak", FORCE, 1e5, "Largest contact_force over the last communication step",
        [|m| m.peaks().contact_force, |_| 0.0]).positive(),
    output("rock_force_peak", FORCE, 1e5, "Largest rock_force over the last communication step",
        [|m| m.peaks().rock_force, |_| 0.0]),

    record("blow_time", TIME, 0.1, "Instant of the last blow", |m| last(m).time),
    record("blow_speed", VELOCITY, 10.0, "Mean speed of the piston over the bit at the last blow",
        |m| last(m).speed),
    record("blow_energy", ENERGY, 200.0, "Half the piston's mass times blow_speed squared",
        |m| last(m).energy).positive(),
    record("blow_period", TIME, 0.05, "Time between the last two blows, 0 before the second",
        |m| last(m).period).positive(),
    record("blow_penetration", LENGTH, 1e-3, "Advance of the hole over the last complete blow period",
        |m| last(m).penetration),
    record("contact_duration", TIME, 1e-4, "Duration of the last complete collision, first closing to last opening",
        |m| m.contact_duration()).positive(),
    record("rop", ADVANCE, 0.03, "Rate of penetration over the last complete blow period", |m| last(m).rop),
    record("rop_mean", ADVANCE, 0.03, "Mean rate of penetration since the first blow", |m| last(m).rop_mean),

    output("energy_drive", ENERGY, 200.0, "Work of the driving force", energy!(drive)).zero_at_start(),
    output("energy_gravity", ENERGY, 10.0, "Work of gravity", energy!(gravity)).zero_at_start(),
    output("energy_feed", ENERGY, 10.0, "Work of the feed force", energy!(feed)).zero_at_start(),
    output("energy_kinetic", ENERGY, 200.0, "Kinetic energy of both bodies", energy!(kinetic)).positive(),
    output("energy_strain", ENERGY, 100.0, "Strain energy of both bodies", energy!(strain)).positive(),
    output("energy_contact", ENERGY, 1.0, "Energy of the contact's penalty stiffness", energy!(contact)).positive(),
    output("energy_rock_stored", ENERGY, 10.0, "Recoverable energy of the rock", energy!(rock_stored)).positive(),
    output("energy_rock_dissipated", ENERGY, 100.0, "Energy that the rock's elastic loading has cost for good", energy!(rock_dissipated)).zero_at_start(),
    output("energy_viscous", ENERGY, 10.0, "Energy spent in the rock's viscous resistance", energy!(viscous)).zero_at_start(),
    output("energy_damping", ENERGY, 1.0, "Energy spent in the bodies' material damping", energy!(damping)).zero_at_start(),
    record("energy_retuned", ENERGY, 1.0, "Energy put in by changes of tunable parameters",
        |m| m.energies().retuned).zero_at_start(),
    output("energy_residual", ENERGY, 1e-6, "Works less all other energies: error of the balance", energy!(residual)),

    truth("stalled", "The piston rests on the bit and the drive (Relay or Chambers) cannot switch", |m| m.stalled()),
];
