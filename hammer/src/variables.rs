//! The table of all variables: the rows of parameters and inputs, then those of all results. Each row has the
//! accessor that reads the engine, so that start values, ranges and getters agree.

mod arrays;

use crate::error::Error;
use crate::laws::mode::Tie;
use crate::machine::Machine;
use crate::machine::blows::Blow;
use crate::quantities::domain::Domain;
use crate::quantities::inputs::Input;
pub use crate::quantities::inputs::{INPUTS, InputRow};
use crate::quantities::parameters::Parameters;
use crate::quantities::quantity::*;
pub use crate::quantities::table::{PARAMETERS, Parameter, Reader, Slot};
pub use arrays::{ALONG, Along, OF_BLOW, OF_RECORD, OfBlow};

/// Communication step that is proposed to a host, s.
pub const STEP_SIZE: f64 = 1e-3;
/// Duration of a run that is proposed to a host, s.
pub const STOP_TIME: f64 = 0.6;

/// Reads a value of the engine.
pub type Read<T> = fn(&mut Machine) -> T;

/// Does the long part of a read.
pub type Prepare = fn(&Machine) -> Result<(), Error>;

/// One variable.
#[derive(Clone, Copy)]
pub struct Variable {
    /// Name, unique.
    pub name: &'static str,
    /// Meaning.
    pub description: &'static str,
    /// Causality, type and access.
    pub role: Role,
}

/// Causality, type and access. An output has no setter that could be called by mistake.
#[derive(Clone, Copy)]
pub enum Role {
    /// A parameter.
    Parameter(&'static Parameter),
    /// A real input.
    Input(&'static InputRow),
    /// A real output.
    Output(Output),
    /// A local Boolean.
    Truth(Read<bool>),
    /// A local enumeration, as the index of its item.
    Choice(Enumeration, Read<usize>),
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
    /// True for a piecewise constant output.
    pub discrete: bool,
    /// Does the slow part of the first read after a step, which an interrupt may end.
    pub prepare: Option<Prepare>,
    /// True if the output is zero at the start for any parameters.
    pub zero_at_start: bool,
    /// True if the output cannot be negative.
    pub positive: bool,
    /// Order of magnitude.
    pub nominal: f64,
    /// Inputs whose present value affects the output immediately (feedthrough).
    pub feedthrough: &'static [Input],
    /// The output's derivative with respect to one of these inputs, at fixed state.
    pub slope: fn(&Machine, Input) -> f64,
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
        prepare: None,
        zero_at_start: false,
        positive: false,
        nominal,
        feedthrough: &[],
        slope: |_, _| 0.0,
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

/// Changes the row of an output. Any other kind of row is an error in the table.
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

    const fn summed(self) -> Self {
        adjust!(self, prepare = Some(Machine::prepare_ledger))
    }

    const fn searched(self) -> Self {
        adjust!(self, prepare = Some(Machine::prepare_peaks))
    }

    const fn zero_at_start(self) -> Self {
        adjust!(self, zero_at_start = true)
    }

    const fn positive(self) -> Self {
        adjust!(self, positive = true)
    }

    const fn fed_by(self, inputs: &'static [Input], slope: fn(&Machine, Input) -> f64) -> Self {
        adjust!(adjust!(self, feedthrough = inputs), slope = slope)
    }

    /// The variable with this name, and its value reference.
    pub fn named(name: &str) -> Option<(usize, &'static Self)> {
        VARIABLES.iter().enumerate().find(|(_, variable)| variable.name == name)
    }

    /// Values that a parameter may have; `None` for any other variable.
    pub fn domain(&self) -> Option<Domain> {
        match &self.role {
            Role::Parameter(row) => Some(row.domain),
            _ => None,
        }
    }

    /// The reason why a scene does not read this parameter or input; `None` if it reads it.
    pub fn unread(&self, parameters: &Parameters) -> Option<String> {
        match &self.role {
            Role::Parameter(row) => row.unread(parameters),
            Role::Input(row) => row.reader.unread(row.name, parameters),
            _ => None,
        }
    }
}

/// Names by value reference, one a line. A reference belongs to its name for ever: new names are added at the end.
const REFERENCES: &[u8] = include_bytes!("references.txt");

const TOTAL: usize = PARAMETERS.len() + INPUTS.len() + RESULTS.len();

/// Every variable. A variable's position is its value reference.
pub static VARIABLES: [Variable; TOTAL] = {
    let mut rows = [RESULTS[0]; TOTAL];
    let (mut next, mut from) = (0, 0);
    while next < TOTAL {
        let mut to = from;
        while to < REFERENCES.len() && REFERENCES[to] != b'\n' {
            to += 1;
        }
        let (_, rest) = REFERENCES.split_at(from);
        rows[next] = named(rest.split_at(to - from).0);
        (next, from) = (next + 1, to + 1);
    }
    assert!(from == REFERENCES.len(), "references.txt names more variables than there are");
    rows
};

/// The row with this name. It is found when the program is compiled.
const fn named(name: &[u8]) -> Variable {
    let mut k = 0;
    while k < TOTAL {
        let (input, result) = (PARAMETERS.len(), PARAMETERS.len() + INPUTS.len());
        let row = if k < input {
            let row = &PARAMETERS[k];
            Variable { name: row.name, description: row.description, role: Role::Parameter(row) }
        } else if k < result {
            let row = &INPUTS[k - input];
            Variable { name: row.name, description: row.description, role: Role::Input(row) }
        } else {
            RESULTS[k - result]
        };
        if equal(row.name.as_bytes(), name) {
            return row;
        }
        k += 1;
    }
    panic!(
        "a variable that references.txt lacks, which gets a line at its end; or a name there of none"
    )
}

const fn equal(a: &[u8], b: &[u8]) -> bool {
    let mut k = 0;
    while k < a.len() && k < b.len() && a[k] == b[k] {
        k += 1;
    }
    k == a.len() && k == b.len()
}

/// Names and values of the parameters that differ from the reference hammer's.
pub fn differences(parameters: &Parameters) -> Vec<(&'static str, f64)> {
    let reference = Parameters::default();
    let changed = VARIABLES.iter().filter_map(|variable| {
        let Role::Parameter(row) = variable.role else { return None };
        let value = row.slot.read(parameters);
        (value != row.slot.read(&reference)).then_some((row.name, value))
    });
    changed.collect()
}

/// The last blow; zeros before the first.
fn last(machine: &Machine) -> Blow {
    machine.blow().copied().unwrap_or_default()
}

/// The results. Add new rows in their group, and their names at the end of `references.txt`.
#[rustfmt::skip]
static RESULTS: &[Variable] = &[
    output("piston_position", LENGTH, 1e-2, "Mean displacement of the piston, positive downward",
        [|m| m.kinematics().piston.displacement, |m| m.kinematics().piston.velocity])
        .second(|m| m.kinematics().piston.acceleration),
    output("piston_velocity", VELOCITY, 10.0, "Mean velocity of the piston",
        [|m| m.kinematics().piston.velocity, |m| m.kinematics().piston.acceleration])
        .second(|m| m.kinematics().piston_jerk),
    output("bit_position", LENGTH, 1e-2, "Mean displacement of the bit, positive downward",
        [|m| m.kinematics().bit.displacement, |m| m.kinematics().bit.velocity])
        .second(|m| m.kinematics().bit.acceleration),
    output("bit_velocity", VELOCITY, 10.0, "Mean velocity of the bit",
        [|m| m.kinematics().bit.velocity, |m| m.kinematics().bit.acceleration])
        .second(|m| m.kinematics().bit_jerk),
    output("bit_tip_position", LENGTH, 1e-2, "Displacement of the bit's face on the rock",
        [|m| m.kinematics().tip.displacement, |m| m.kinematics().tip.velocity])
        .second(|m| m.kinematics().tip.acceleration),
    output("bit_tip_velocity", VELOCITY, 10.0, "Velocity of the bit's face on the rock",
        [|m| m.kinematics().tip.velocity, |m| m.kinematics().tip.acceleration]),
    output("relative_position", LENGTH, 1e-2, "Mean position of the piston over the bit: 0 at rigid contact, negative apart; with a casing, its position in the casing, and with loose joints, over the shank",
        [|m| m.kinematics().relative.displacement, |m| m.kinematics().relative.velocity])
        .second(|m| m.kinematics().relative.acceleration),
    output("relative_velocity", VELOCITY, 10.0, "Rate of relative_position",
        [|m| m.kinematics().relative.velocity, |m| m.kinematics().relative.acceleration])
        .second(|m| m.kinematics().relative_jerk),
    output("contact_gap", LENGTH, 1e-2, "Gap of piston and bit, negative in contact",
        [|m| m.kinematics().gap.displacement, |m| m.kinematics().gap.velocity])
        .second(|m| m.kinematics().gap.acceleration),
    output("contact_force", FORCE, 1e5, "Force between piston and bit",
        [|m| m.kinematics().contact_force, |m| m.kinematics().contact_force_rate])
        .second(|m| m.kinematics().contact_force_acceleration).positive(),
    truth("contact_closed", "Piston and bit are in contact", |m| m.mode().closed()),
    output("rock_force", FORCE, 1e5, "Force of the rock on the bit, positive upward",
        [|m| m.kinematics().rock_force, |m| m.kinematics().rock_force_rate]),
    Variable { name: "rock_mode", description: "Mode of the bit/rock law",
        role: Role::Choice(ROCK_MODE, |m| m.mode().rock as usize) },
    output("applied_drive_force", FORCE, 1e3, "Driving force on the piston, positive downward",
        [|m| m.kinematics().applied_drive_force, |m| m.kinematics().applied_drive_force_rates[0]])
        .second(|m| m.kinematics().applied_drive_force_rates[1])
        .fed_by(&[Input::DriveForce, Input::DrivePressure, Input::ReturnPressure, Input::ExhaustPressure], Machine::force_per),
    output("drive_chamber_pressure", PRESSURE, 1e6, "Absolute pressure in the drive chamber when drive.source is Air, else 0",
        [|m| m.chamber_pressures()[0][0], |m| m.chamber_pressures()[0][1]]).positive()
        .fed_by(&[Input::ExhaustPressure], Machine::chamber_pressure_per),
    output("return_chamber_pressure", PRESSURE, 1e6, "Absolute pressure in the return chamber when drive.source is Air, else 0",
        [|m| m.chamber_pressures()[1][0], |m| m.chamber_pressures()[1][1]]).positive()
        .fed_by(&[Input::ExhaustPressure], Machine::chamber_pressure_per),
    output("casing_position", LENGTH, 1e-2, "Displacement of the casing, positive downward; 0 without one",
        [|m| m.kinematics().casing.displacement, |m| m.kinematics().casing.velocity])
        .second(|m| m.kinematics().casing.acceleration),
    output("casing_velocity", VELOCITY, 1.0, "Velocity of the casing",
        [|m| m.kinematics().casing.velocity, |m| m.kinematics().casing.acceleration]),
    output("chuck_force", FORCE, 1e4, "Force of the bit on the casing, positive where the chuck's shoulder presses on the bit",
        [|m| m.kinematics().chuck_force, |m| m.kinematics().chuck_force_rate]),
    output("drive_volume", VOLUME, 1e-4, "Volume that the piston has swept with drive.area_drive since the start, positive downward: its difference over a step is the mean flow",
        [|m| m.parameters().drive.area_drive * m.swept(), |m| m.parameters().drive.area_drive * m.kinematics().relative.velocity])
        .second(|m| m.parameters().drive.area_drive * m.kinematics().relative.acceleration).zero_at_start(),
    output("return_volume", VOLUME, 1e-4, "Volume that the piston has swept with drive.area_return since the start, positive downward: its difference over a step is the mean flow",
        [|m| m.parameters().drive.area_return * m.swept(), |m| m.parameters().drive.area_return * m.kinematics().relative.velocity])
        .second(|m| m.parameters().drive.area_return * m.kinematics().relative.acceleration).zero_at_start(),
    output("drive_flow", FLOW, 1e-3, "Rate of drive_volume: the flow into the chamber above the piston",
        [|m| m.parameters().drive.area_drive * m.kinematics().relative.velocity, |m| m.parameters().drive.area_drive * m.kinematics().relative.acceleration])
        .second(|m| m.parameters().drive.area_drive * m.kinematics().relative_jerk),
    output("return_flow", FLOW, 1e-3, "Rate of return_volume: the flow out of the chamber below the piston",
        [|m| m.parameters().drive.area_return * m.kinematics().relative.velocity, |m| m.parameters().drive.area_return * m.kinematics().relative.acceleration])
        .second(|m| m.parameters().drive.area_return * m.kinematics().relative_jerk),
    record("drive_flow_mean", FLOW, 1e-3, "Mean of drive_flow over the last communication step when drive.source is Force or Pressure, else 0",
        |m| m.parameters().drive.area_drive * m.step_speed()),
    record("return_flow_mean", FLOW, 1e-3, "Mean of return_flow over the last communication step when drive.source is Force or Pressure, else 0",
        |m| m.parameters().drive.area_return * m.step_speed()),
    output("drive_line_pressure", PRESSURE, 1e6, "Pressure at the piston of a line to the drive chamber (drive.impedance): its wave drive_pressure less the impedance's part; 0 without an area",
        [|m| m.line_pressures()[0][0], |m| m.line_pressures()[0][1]])
        .fed_by(&[Input::DrivePressure], |m, input| f64::from(m.line_pressure_per(input, 0))),
    output("return_line_pressure", PRESSURE, 1e6, "The same of a line to the return chamber: its wave return_pressure and the impedance's part",
        [|m| m.line_pressures()[1][0], |m| m.line_pressures()[1][1]])
        .fed_by(&[Input::ReturnPressure], |m, input| f64::from(m.line_pressure_per(input, 1))),
    record("tip_depth", LENGTH, 1e-2, "Depth of the bit's crater since the start, at the last unloading; of the hole: drilled_length",
        |m| m.kinematics().tip_depth).zero_at_start(),

    output("contact_impulse", IMPULSE, 10.0, "Impulse of contact_force since the start",
        [|m| m.impulses().contact, |m| m.kinematics().contact_force])
        .second(|m| m.kinematics().contact_force_rate).summed().positive().zero_at_start(),
    output("rock_impulse", IMPULSE, 100.0, "Impulse of rock_force since the start",
        [|m| m.impulses().rock, |m| m.kinematics().rock_force])
        .second(|m| m.kinematics().rock_force_rate).summed().zero_at_start(),
    record("contact_count", COUNT, 10.0, "Collisions of piston and bit since the start",
        |m| m.counters().contacts as f64).positive(),
    record("blow_count", COUNT, 10.0, "Blows since the start: first collisions of the piston's falls",
        |m| m.counters().blows as f64).positive(),
    record("rock_cycle_count", COUNT, 100.0, "Drilling cycles of the rock begun since the start",
        |m| m.counters().rock_cycles as f64).positive(),
    record("event_count", COUNT, 1000.0, "Changes of mode since the start",
        |m| m.counters().events as f64).positive(),

    output("contact_force_peak", FORCE, 1e5, "Largest contact_force over the last communication step",
        [|m| m.peaks().contact_force(), |_| 0.0]).searched().positive(),
    output("rock_force_peak", FORCE, 1e5, "Largest rock_force over the last communication step",
        [|m| m.peaks().rock_force(), |_| 0.0]).searched(),
    output("chuck_force_peak", FORCE, 1e5, "Largest chuck_force over the last communication step; 0 without a casing",
        [|m| m.peaks().tie_force(Tie::Chuck), |_| 0.0]).searched(),

    record("blow_time", TIME, 0.1, "Instant of the last blow", |m| last(m).time),
    record("blow_speed", VELOCITY, 10.0, "Mean speed of the piston over the bit at the last blow",
        |m| last(m).speed),
    record("blow_energy", ENERGY, 200.0, "Half the piston's mass times blow_speed squared",
        |m| last(m).energy).positive(),
    record("blow_period", TIME, 0.05, "Time between the last two blows, 0 before the second",
        |m| last(m).period).positive(),
    record("blow_penetration", LENGTH, 1e-3, "Gain of the bit's tip over the last complete blow period",
        |m| last(m).penetration),
    record("contact_duration", TIME, 1e-4, "Duration of the last complete collision, first closing to last opening",
        |m| m.contact_duration()).positive(),
    record("rop", ADVANCE, 3e-3, "Rate of penetration of the hole over the last complete blow period, by specific energy; known up to rock.specific_energy_factor",
        |m| last(m).rop).positive(),
    record("rop_mean", ADVANCE, 3e-3, "The same as rop since the first blow", |m| last(m).rop_mean).positive(),
    record("tip_rate", TIP_RATE, 0.03, "Gain of the bit's tip in its own crater per time, over the last complete blow period",
        |m| last(m).tip_rate),
    record("tip_rate_mean", TIP_RATE, 0.03, "The same as tip_rate since the first blow", |m| last(m).tip_rate_mean),

    output("drilled_length", LENGTH, 1e-2, "Length of hole: work given to the rock over the hole's area and the specific energy of its time",
        [|m| m.drilled_length(),
         |m| { let w = m.powers(); (w.rock_dissipated + w.viscous) / m.parameters().work_per_length() }]).zero_at_start(),

    output("air_mass", MASS, 1.0, "Air taken from the supply since the start when drive.source is Air, else 0",
        [|m| m.air_mass()[0], |m| m.air_mass()[1]]).zero_at_start(),
    record("air_flow", AIR_FLOW, 0.1, "Free air (0 degrees Celsius, 1.01325e5 Pa) taken from the supply over the last complete blow period, per that period",
        |m| last(m).air_flow),

    output("energy_drive", ENERGY, 200.0, "Work of the driving force, with a casing also of its reaction", energy!(drive)).summed().zero_at_start(),
    output("energy_gravity", ENERGY, 10.0, "Work of gravity", energy!(gravity)).summed().zero_at_start(),
    output("energy_feed", ENERGY, 10.0, "Work of the feed force", energy!(feed)).summed().zero_at_start(),
    output("energy_kinetic", ENERGY, 200.0, "Kinetic energy of all bodies", energy!(kinetic)).summed().positive(),
    output("energy_strain", ENERGY, 100.0, "Strain energy of both bodies", energy!(strain)).summed().positive(),
    output("energy_contact", ENERGY, 1.0, "Energy of the contact's penalty stiffness and of the chuck's", energy!(contact)).summed().positive(),
    output("energy_rock_stored", ENERGY, 10.0, "Recoverable energy of the rock", energy!(rock_stored)).summed().positive(),
    output("energy_rock_dissipated", ENERGY, 100.0, "Energy that the rock's elastic loading has cost for good", energy!(rock_dissipated)).summed().zero_at_start(),
    output("energy_viscous", ENERGY, 10.0, "Energy spent in the rock's viscous resistance", energy!(viscous)).summed().zero_at_start(),
    output("energy_damping", ENERGY, 1.0, "Energy spent in the bodies' material damping, in the chuck and in the drill string", energy!(damping)).summed().zero_at_start(),
    record("energy_retuned", ENERGY, 1.0, "Energy put in by changes of tunable parameters",
        |m| m.energies().retuned).summed().zero_at_start(),
    output("energy_residual", ENERGY, 1e-6, "Works less losses and the gains of all stored energies since the start: error of the balance", energy!(residual)).summed(),
    record("energy_exchange", ENERGY, 1.0, "What the inputs of the drive have done beyond what they would have, had they moved linearly between the instants that successive values belong to (those of coupling.delay; where it is 0 the step's begin, with drive.impedance its middle; with derivatives the step's begin): energy that the exchange made (positive) or lost. Right within a factor of two at coupling.delay 0.5 and 1.5 where it passes 2 % of the drive's work; at -0.5 it is 0 and tells nothing; at 0 a host that steps all at once makes two to four times as much, and a partner that holds a flow, or that is stepped first, less or none",
        |m| m.exchanged_energy()).zero_at_start(),
    output("energy_air_residual", ENERGY, 1e-6, "Error of the air's balance when drive.source is Air: enthalpy that came in less its work and what the chambers gained",
        [|m| m.air_residual(), |_| 0.0]).zero_at_start(),

    truth("stalled", "The drive acts and strikes no more: the piston rests on the bit and the relay cannot switch, or no blow came for eight of the last blow's periods, before the first for 1 s", |m| m.stalled()),
];

impl OfBlow {
    /// The row of this output; `None` only if the table lacks it.
    #[must_use]
    pub fn row(&self) -> Option<&'static Output> {
        match Variable::named(self.output())?.1.role {
            Role::Output(ref output) => Some(output),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_figure_of_a_blow_has_an_output() {
        let is_output = |figure: &&OfBlow| figure.name.starts_with("step_");
        let figures = || OF_BLOW.iter().chain(&OF_RECORD).filter(is_output);
        assert!(figures().count() > OF_BLOW.len() && figures().all(|f| f.row().is_some()));
    }
}
