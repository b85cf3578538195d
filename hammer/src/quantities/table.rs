//! The table of parameters, with one row each.
//!
//! Names, units, domains, start values, error messages and warnings of every interface follow from these rows.
//! `crate::variables` adds the rows of outputs.

use crate::quantities::domain::{Domain, ParameterError};
use crate::quantities::parameters::{
    Fidelity, MAX_DEGREE, MAX_ELEMENTS, Parameters, Reloading, Source,
};
use crate::quantities::quantity::*;
use crate::quantities::sections::{Body, MAX_RODS, MAX_SEGMENTS};

/// The part of a scene that reads a parameter or an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reader {
    /// Every scene.
    Every,
    /// Elastic bodies.
    Elastic,
    /// The drive, if its source is one of these.
    Drive(&'static [Source]),
    /// The standstill mode, unless reloading follows the unloading line.
    Standstill,
    /// The casing, if there is one.
    Casing,
    /// The drill string, if it has rods.
    Rods,
    /// The joints of the drill string, if they are not screwed tight.
    Joints,
    /// The casing, if it is elastic.
    ElasticCasing,
    /// One of these bodies, if it has no sections of its own.
    Uniform(&'static [Body]),
    /// The section of a body with this number, from 1, if the body has that many.
    Section(Body, usize),
}

/// Accessor of a real parameter.
pub type Access = fn(&mut Parameters) -> &mut f64;

/// The name of the real or integer parameter at this accessor; empty if there is none.
pub fn name_of<T>(field: fn(&mut Parameters) -> &mut T) -> &'static str {
    let mut parameters = Parameters::default();
    let place = std::ptr::from_ref(field(&mut parameters)).cast::<()>();
    let mut stands = |row: &&Parameter| match row.slot {
        Slot::Real(_, access) => std::ptr::from_ref(access(&mut parameters)).cast() == place,
        Slot::Integer(access) => std::ptr::from_ref(access(&mut parameters)).cast() == place,
        Slot::Choice(..) => false,
    };
    PARAMETERS.iter().find(|row| stands(row)).map_or("", |row| row.name)
}

/// Type and access of a parameter.
#[derive(Clone, Copy)]
pub enum Slot {
    /// Real.
    Real(Quantity, Access),
    /// Integer.
    Integer(fn(&mut Parameters) -> &mut usize),
    /// Enumeration, as the index of its item.
    Choice(Enumeration, fn(&Parameters) -> usize, fn(&mut Parameters, usize)),
}

/// A row of the table.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// Dotted name, unique.
    pub name: &'static str,
    /// Meaning.
    pub description: &'static str,
    /// Type and access.
    pub slot: Slot,
    /// Domain.
    pub domain: Domain,
    /// True if it may change at any communication point while the state stays the same; otherwise it is fixed at the
    /// start.
    pub tunable: bool,
    /// The part of a scene that reads it.
    pub reader: Reader,
    /// True if it may also be nearly zero or very large, to switch a law off.
    pub switches: bool,
}

/// Shortest body or section, m. The modes of much shorter ones cannot be distinguished in double precision.
const SHORTEST: f64 = 1e-6;

/// Length and area of each of a body's sections.
macro_rules! sections {
    ($body:ident $which:ident: $($k:literal)*) => {
        &[$(
            real(concat!(stringify!($body), ".segment[", $k, "].length"), LENGTH, Domain::AtLeast(SHORTEST),
                concat!("Length of section ", $k, " of the ", stringify!($body), ", from the top"),
                |p| &mut p.$body.segments.stored_mut($k - 1).length).read_by(Reader::Section(Body::$which, $k)),
            real(concat!(stringify!($body), ".segment[", $k, "].area"), AREA, Domain::Above(0.0),
                concat!("Cross section of section ", $k, " of the ", stringify!($body), ", from the top"),
                |p| &mut p.$body.segments.stored_mut($k - 1).area).read_by(Reader::Section(Body::$which, $k)),
        )*]
    };
}

/// Every parameter, in the order of the description. The value reference of a row is the line of its name in
/// `references.txt`. Everything is static, so unloading the library leaves nothing behind.
pub static PARAMETERS: [Parameter; COUNT] = joined();

#[rustfmt::skip]
const GROUPS: &[&[Parameter]] = {
    use Domain::{Above, Any, AtLeast, Between};
    use Reader::{Drive, Elastic, Uniform};
    const AIR: Reader = Drive(&[Source::Air]);
    &[
    &[
        choice("fidelity", FIDELITY, "How the bodies are modelled",
            |p| p.fidelity as usize, |p, i| if let Some(f) = Fidelity::ALL.get(i) { p.fidelity = *f }),
        real("material.youngs_modulus", MODULUS, Above(0.0), "Young's modulus of the bodies", |p| &mut p.material.youngs_modulus),
        real("material.density", DENSITY, Above(0.0), "Density of the bodies", |p| &mut p.material.density),
        real("material.damping_time", TIME, AtLeast(0.0), "Kelvin-Voigt damping time: damping matrix over stiffness matrix",
            |p| &mut p.material.damping_time).switch().read_by(Elastic),
        real("cross_section", AREA, Above(0.0), "Cross section of bodies without sections of their own", |p| &mut p.cross_section)
            .read_by(Uniform(&Body::ALL)),
        count("mesh.degree", Between(1.0, MAX_DEGREE as f64), "Degree of the bodies' mesh: 1 linear elements, above splines (elastic bodies)",
            |p| &mut p.mesh.degree).read_by(Elastic),
        real("piston.length", LENGTH, AtLeast(SHORTEST), "Length of the piston, unless it has sections", |p| &mut p.piston.length)
            .read_by(Uniform(&[Body::Piston])),
        count("piston.elements", Between(1.0, MAX_ELEMENTS as f64), "Number of elements (spans) of the piston's mesh (elastic bodies)",
            |p| &mut p.piston.elements).read_by(Elastic),
        count("piston.segments", Between(0.0, MAX_SEGMENTS as f64), "Number of sections of the piston; 0: uniform, of piston.length and cross_section",
            |p| p.piston.segments.count_mut()),
    ],
    sections!(piston Piston: 1 2 3 4 5 6 7 8),
    &[
        real("piston.initial_velocity", VELOCITY, Any, "Velocity of the piston at the start, positive downward", |p| &mut p.piston.initial_velocity),
        real("bit.length", LENGTH, AtLeast(SHORTEST), "Length of the bit, unless it has sections", |p| &mut p.bit.length)
            .read_by(Uniform(&[Body::Bit])),
        count("bit.elements", Between(1.0, MAX_ELEMENTS as f64), "Number of elements (spans) of the bit's mesh (elastic bodies)",
            |p| &mut p.bit.elements).read_by(Elastic),
        count("bit.segments", Between(0.0, MAX_SEGMENTS as f64), "Number of sections of the bit; 0: uniform, of bit.length and cross_section",
            |p| p.bit.segments.count_mut()),
    ],
    sections!(bit Bit: 1 2 3 4 5 6 7 8),
    &[
        count("drill.rods", Between(0.0, MAX_RODS as f64), "Number of rods of a drill string above the bit, which the piston strikes at its shank; 0: it strikes the bit",
            |p| &mut p.drill.rods),
        real("drill.shank.length", LENGTH, AtLeast(SHORTEST), "Length of the shank, to the face of the first rod", |p| &mut p.drill.shank.length).read_by(Reader::Rods),
        real("drill.shank.area", AREA, Above(0.0), "Cross section of the shank", |p| &mut p.drill.shank.area).read_by(Reader::Rods),
        real("drill.rod.length", LENGTH, AtLeast(SHORTEST), "Length of each rod, from face to face", |p| &mut p.drill.rod.length).read_by(Reader::Rods),
        real("drill.rod.area", AREA, Above(0.0), "Cross section of the rods", |p| &mut p.drill.rod.area).read_by(Reader::Rods),
        real("drill.coupling.length", LENGTH, AtLeast(0.0), "Length of the sleeve that couples a rod to what is above it, half of it on either; 0: none",
            |p| &mut p.drill.coupling.length).switch().read_by(Reader::Rods),
        real("drill.coupling.area", AREA, Above(0.0), "Cross section of a sleeve and of the steel inside together", |p| &mut p.drill.coupling.area).read_by(Reader::Rods),
        real("drill.joint.stiffness", STIFFNESS, AtLeast(0.0), "Stiffness of a joint's faces and of its thread; 0: screwed tight, so that the joint never parts",
            |p| &mut p.drill.joint.stiffness).switch().read_by(Reader::Rods),
        real("drill.joint.slack", LENGTH, AtLeast(0.0), "Way of a rod from where its face presses to where the thread pulls; 0: the joint holds both ways",
            |p| &mut p.drill.joint.slack).switch().read_by(Reader::Joints),
    ],
    &[
        real("contact.stiffness", STIFFNESS, Above(0.0), "Penalty stiffness of the contact of piston and bit", |p| &mut p.contact.stiffness),
        real("contact.initial_gap", LENGTH, AtLeast(0.0), "Gap of piston and bit at the start", |p| &mut p.contact.initial_gap),
        real("rock.stiffness", STIFFNESS, Above(0.0), "Loading stiffness of the rock under the bit", |p| &mut p.rock.stiffness).tunable(),
        real("rock.unloading_ratio", RATIO, Above(1.0), "Unloading stiffness over loading stiffness", |p| &mut p.rock.unloading_ratio).tunable(),
        real("rock.viscosity", VISCOSITY, AtLeast(0.0), "Viscous resistance of intact rock", |p| &mut p.rock.viscosity).tunable().switch(),
        real("rock.energy_barrier", ENERGY, AtLeast(0.0), "Viscous work that breaks the rock and ends the viscous phase",
            |p| &mut p.rock.energy_barrier).tunable().switch(),
        real("rock.standstill_speed", VELOCITY, AtLeast(0.0), "Bit speed that ends standstill", |p| &mut p.rock.standstill_speed)
            .read_by(Reader::Standstill),
        real("rock.standstill_penetration", LENGTH, AtLeast(0.0), "Permanent gain of a cycle below which the bit stands still",
            |p| &mut p.rock.standstill_penetration).read_by(Reader::Standstill),
        real("rock.specific_energy", SPECIFIC_ENERGY, Above(0.0), "Work given to the rock that breaks a volume of it out of the hole, for drilled_length and rop",
            |p| &mut p.rock.specific_energy).tunable(),
        real("rock.specific_energy_factor", RATIO, AtLeast(1.0), "Up to this factor the specific energy, and so rop, is known: it may be so many times more or less",
            |p| &mut p.rock.specific_energy_factor).tunable(),
        choice("rock.reloading", RELOADING, "Where a bit that turns down again in loaded rock begins to drill",
            |p| p.rock.reloading as usize, |p, i| if let Some(r) = Reloading::ALL.get(i) { p.rock.reloading = *r }),
        real("hole.diameter", LENGTH, Above(0.0), "Diameter of the hole, for drilled_length and rop", |p| &mut p.hole.diameter),
        real("casing.mass", MASS, AtLeast(0.0), "Mass of a rigid casing, through which feed and drive act on the bit; 0: no casing", |p| &mut p.casing.mass)
            .switch().read_by(Uniform(&[Body::Casing])),
        real("casing.impedance", VISCOSITY, AtLeast(0.0), "Impedance of an endless drill string above the casing; 0: none", |p| &mut p.casing.impedance)
            .switch().read_by(Reader::Casing),
        count("casing.elements", Between(1.0, MAX_ELEMENTS as f64), "Number of elements (spans) of an elastic casing's mesh",
            |p| &mut p.casing.elements).read_by(Reader::ElasticCasing),
        count("casing.segments", Between(0.0, MAX_SEGMENTS as f64), "Number of sections of the casing, which then has their mass; 0: rigid, of casing.mass",
            |p| p.casing.segments.count_mut()),
    ],
    sections!(casing Casing: 1 2 3 4 5 6 7 8),
    &[
        real("chuck.stiffness", STIFFNESS, Above(0.0), "Stiffness of the chuck's shoulder and ring", |p| &mut p.chuck.stiffness).read_by(Reader::Casing),
        real("chuck.viscosity", VISCOSITY, AtLeast(0.0), "Viscosity of the chuck's shoulder and ring", |p| &mut p.chuck.viscosity)
            .switch().read_by(Reader::Casing),
        real("chuck.travel", LENGTH, Above(0.0), "Travel of the bit from the chuck's shoulder to its ring", |p| &mut p.chuck.travel).read_by(Reader::Casing),
        real("chuck.idle_travel", LENGTH, AtLeast(0.0), "Travel of the bit beyond which the drive is vented, below chuck.travel; 0: never",
            |p| &mut p.chuck.idle_travel).switch().read_by(Reader::Casing),
        choice("drive.source", SOURCE, "Where the force on the piston comes from",
            |p| p.drive.source as usize, |p, i| if let Some(s) = Source::ALL.get(i) { p.drive.source = *s }),
        real("drive.amplitude", FORCE, AtLeast(0.0), "Amplitude of the relay's force", |p| &mut p.drive.amplitude).tunable()
            .read_by(Drive(&[Source::Relay])),
        real("drive.stroke", LENGTH, Above(0.0), "Stroke at which the relay turns to driving", |p| &mut p.drive.stroke)
            .read_by(Drive(&[Source::Relay])),
        real("drive.area_drive", AREA, AtLeast(0.0), "Area on which the pressure that drives acts", |p| &mut p.drive.area_drive)
            .read_by(Drive(&[Source::Pressure, Source::Air])),
        real("drive.area_return", AREA, AtLeast(0.0), "Area on which the pressure that returns acts", |p| &mut p.drive.area_return)
            .read_by(Drive(&[Source::Pressure, Source::Air])),
        real("drive.anvil_area", AREA, AtLeast(0.0), "Area of the bit's upper face on which the return chamber presses, less its exhaust's pressure",
            |p| &mut p.drive.anvil_area).switch().read_by(Drive(&[Source::Pressure])),
        real("coupling.delay", RATIO, Between(-0.5, 2.0), "How many steps before the middle of its communication step the instant lies that a drive's value belongs to. It is what the partner's value stands for: 0.5 the position at the step's begin, or differenced volumes, 0 a flow held over the step, -0.5 a position looked ahead to its end; plus 1 in a host that steps all at once. 0 holds the value as given",
            |p| &mut p.drive.delay).tunable().switch().read_by(Drive(&[Source::Force, Source::Pressure])),
        real("drive.impedance", VISCOSITY, AtLeast(0.0), "Impedance of a transmission line at the piston, pressure over flow times the square of its area: the drive's value is then the line's wave, and the piston also feels minus this times relative_velocity; 0: no line",
            |p| &mut p.drive.impedance).switch(),
    ],
    &[
        real("air.drive.dead_volume", VOLUME, Above(0.0), "Volume of the drive chamber with the piston at the end of its cylinder", |p| &mut p.air.drive.dead_volume).read_by(AIR),
        real("air.return.dead_volume", VOLUME, Above(0.0), "Volume of the return chamber with the piston on the bit", |p| &mut p.air.returning.dead_volume).read_by(AIR),
        real("air.cylinder", LENGTH, Above(0.0), "Travel of the piston from the bit to the end of its cylinder", |p| &mut p.air.cylinder).read_by(AIR),
        real("air.drive.supply", LENGTH, Any, "Position of the piston over the bit at which the supply of the drive chamber begins to open: open above it", |p| &mut p.air.drive.supply).read_by(AIR),
        real("air.drive.exhaust", LENGTH, Any, "Position of the piston over the bit at which the exhaust of the drive chamber begins to open: open below it", |p| &mut p.air.drive.exhaust).read_by(AIR),
        real("air.return.supply", LENGTH, Any, "Position of the piston over the bit at which the supply of the return chamber begins to open: open below it", |p| &mut p.air.returning.supply).read_by(AIR),
        real("air.return.exhaust", LENGTH, Any, "Position of the piston over the bit at which the exhaust of the return chamber begins to open: open above it", |p| &mut p.air.returning.exhaust).read_by(AIR),
        real("air.port_height", LENGTH, Above(0.0), "Travel of the piston from a port's edge to where the port is wholly open", |p| &mut p.air.port_height).read_by(AIR),
        real("air.supply_area", AREA, AtLeast(0.0), "Area of a supply port, wholly open", |p| &mut p.air.supply_area).switch().read_by(AIR),
        real("air.exhaust_area", AREA, AtLeast(0.0), "Area of an exhaust port, wholly open", |p| &mut p.air.exhaust_area).switch().read_by(AIR),
        real("air.discharge", RATIO, Between(0.0, 1.0), "Discharge coefficient of the ports", |p| &mut p.air.discharge).read_by(AIR),
        real("air.leakage_area", AREA, AtLeast(0.0), "Opening between the chambers past the piston", |p| &mut p.air.leakage_area).switch().read_by(AIR),
        real("air.drag", VISCOSITY, AtLeast(0.0), "Drag of the piston in its cylinder: force over speed", |p| &mut p.air.drag).switch().read_by(AIR),
        real("air.temperature", TEMPERATURE, Above(0.0), "Temperature of the supply's air, and of what an exhaust sucks in", |p| &mut p.air.temperature).read_by(AIR),
        real("air.error", RATIO, Between(1e-11, 1e-3), "Error of the gas allowed in each window of its integration, relative", |p| &mut p.air.error).read_by(AIR),
    ],
    &[
        real("gravity", ACCELERATION, Any, "Gravity, positive downward along the hole", |p| &mut p.gravity).switch(),
        real("blow.minimum_speed", VELOCITY, AtLeast(0.0), "Slowest impact that counts as a blow, relative mean speed",
            |p| &mut p.blow.minimum_speed).switch(),
        count("work_limit", Between(1.0, 3600.0), "Longest work of one call, in seconds of one core (counted in operations, so that it is the same on any); beyond it the call is refused",
            |p| &mut p.work_limit),
    ],
]
};

const COUNT: usize = {
    let (mut group, mut count) = (0, 0);
    while group < GROUPS.len() {
        count += GROUPS[group].len();
        group += 1;
    }
    count
};

const fn joined() -> [Parameter; COUNT] {
    let mut rows = [GROUPS[0][0]; COUNT];
    let (mut group, mut next) = (0, 0);
    while group < GROUPS.len() {
        let mut row = 0;
        while row < GROUPS[group].len() {
            rows[next] = GROUPS[group][row];
            (row, next) = (row + 1, next + 1);
        }
        group += 1;
    }
    rows
}

/// A fixed parameter that every scene reads.
const fn row(
    name: &'static str,
    description: &'static str,
    slot: Slot,
    domain: Domain,
) -> Parameter {
    let (tunable, reader, switches) = (false, Reader::Every, false);
    Parameter { name, description, slot, domain, tunable, reader, switches }
}

const fn real(
    name: &'static str,
    quantity: Quantity,
    domain: Domain,
    description: &'static str,
    access: Access,
) -> Parameter {
    row(name, description, Slot::Real(quantity, access), domain)
}

const fn count(
    name: &'static str,
    domain: Domain,
    description: &'static str,
    access: fn(&mut Parameters) -> &mut usize,
) -> Parameter {
    row(name, description, Slot::Integer(access), domain)
}

const fn choice(
    name: &'static str,
    items: Enumeration,
    description: &'static str,
    get: fn(&Parameters) -> usize,
    set: fn(&mut Parameters, usize),
) -> Parameter {
    let domain = Domain::Between(1.0, items.items.len() as f64);
    row(name, description, Slot::Choice(items, get, set), domain)
}

impl Parameter {
    const fn tunable(self) -> Self {
        Self { tunable: true, ..self }
    }

    const fn switch(self) -> Self {
        Self { switches: true, ..self }
    }

    const fn read_by(self, reader: Reader) -> Self {
        Self { reader, ..self }
    }

    /// The parameter of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PARAMETERS.iter().find(|row| row.name == name)
    }

    /// The reason why a scene does not read the parameter; `None` if it reads it.
    pub fn unread(&self, parameters: &Parameters) -> Option<String> {
        self.reader.unread(self.name, parameters)
    }

    /// Checks a number against the domain.
    ///
    /// # Errors
    ///
    /// The parameter, the number and the allowed range.
    pub fn check(&self, value: f64) -> Result<(), ParameterError> {
        let refuse = |allowed| Err(ParameterError { name: self.name, value, allowed });
        if !self.domain.contains(value) {
            return refuse(self.domain.describe());
        }
        match self.slot {
            Slot::Real(Quantity { magnitudes: [least, most], unit, .. }, _)
                if value != 0.0 && !(least..=most).contains(&value.abs()) =>
            {
                let zero = if self.domain.contains(0.0) { "0, or " } else { "" };
                let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
                refuse(format!("{zero}of a magnitude from {least:e} to {most:e}{unit}"))
            }
            _ => Ok(()),
        }
    }

    /// False for sections that this scene does not read, which may hold any number. Any other parameter must be in its
    /// domain even if the scene does not read it.
    pub fn is_checked(&self, parameters: &Parameters) -> bool {
        !matches!(self.reader, Reader::Section(..)) || self.reader.reads(parameters)
    }
}

impl Reader {
    /// True if a scene reads parameters with this reader.
    pub fn reads(self, parameters: &Parameters) -> bool {
        match self {
            Self::Every => true,
            Self::Elastic => parameters.fidelity == Fidelity::Elastic,
            Self::Drive(sources) => sources.contains(&parameters.drive.source),
            Self::Standstill => parameters.rock.reloading == Reloading::Loading,
            Self::Casing => parameters.has_casing(),
            Self::Rods => parameters.drill.rods > 0,
            Self::Joints => parameters.drill.loose() > 0,
            Self::ElasticCasing => parameters.is_elastic(Body::Casing),
            Self::Uniform(bodies) => bodies.iter().any(|body| parameters.segments(*body) == 0),
            Self::Section(body, k) => k <= parameters.segments(body),
        }
    }

    /// The warning that a scene does not read the row with this name; `None` if it reads it.
    pub fn unread(self, name: &str, parameters: &Parameters) -> Option<String> {
        self.reason(parameters).map(|reason| format!("{name} is ignored: {reason}"))
    }

    /// The reason why a scene does not read it; `None` if it does.
    pub fn reason(self, parameters: &Parameters) -> Option<String> {
        let label = |source: &Source| SOURCE.items[*source as usize].0;
        let only = |sources: &[Source]| {
            let readers: Vec<&str> = sources.iter().map(label).collect();
            let verb = if sources.len() == 1 { "reads" } else { "read" };
            let chosen = label(&parameters.drive.source);
            format!("drive.source is {chosen}, and only {} {verb} it", readers.join(", "))
        };
        let sections =
            |body: &Body| format!("{}.segments is {}", body.name(), parameters.segments(*body));
        if self.reads(parameters) {
            return None;
        }
        Some(match self {
            Self::Every => return None,
            Self::ElasticCasing if parameters.casing.segments.is_empty() => sections(&Body::Casing),
            Self::Elastic | Self::ElasticCasing => "fidelity is Rigid".into(),
            Self::Standstill => "rock.reloading is Unloading".into(),
            Self::Drive(sources) => only(sources),
            Self::Casing => "casing.mass and casing.segments are 0".into(),
            Self::Joints if parameters.drill.rods > 0 => "drill.joint.stiffness is 0".into(),
            Self::Rods | Self::Joints => "drill.rods is 0".into(),
            Self::Uniform(bodies) => {
                let counts: Vec<String> = bodies.iter().map(sections).collect();
                format!("{}, and sections have their own", counts.join(", "))
            }
            Self::Section(body, _) => sections(&body),
        })
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

    /// Sets the parameter to a number in its domain.
    pub fn write(&self, parameters: &mut Parameters, value: f64) {
        match self {
            Self::Real(_, access) => *access(parameters) = value,
            Self::Integer(access) => *access(parameters) = value as usize,
            Self::Choice(_, _, set) => set(parameters, (value as usize).saturating_sub(1)),
        }
    }
}
