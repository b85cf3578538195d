//! Physical quantities and enumerations of the variables.
//!
//! The type definitions of an FMU follow from these. The template of the model description defines the units (exponents
//! and display factors).

/// A physical quantity: one `SimpleType` of the model description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Name of the type.
    pub name: &'static str,
    /// SI unit in which values are exchanged.
    pub unit: &'static str,
    /// Display unit, if it differs from the SI unit.
    pub display: Option<&'static str>,
    /// Least and greatest magnitude of a parameter that is not 0. They are far outside the range of any hammer, yet
    /// near enough to each other for arithmetic with sixteen digits.
    pub magnitudes: [f64; 2],
}

const fn si(name: &'static str, unit: &'static str) -> Quantity {
    Quantity { name, unit, display: None, magnitudes: [1e-15, 1e15] }
}

impl Quantity {
    const fn displayed_in(mut self, display: &'static str) -> Self {
        self.display = Some(display);
        self
    }

    const fn within(mut self, least: f64, greatest: f64) -> Self {
        self.magnitudes = [least, greatest];
        self
    }
}

macro_rules! quantities {
    ($(#[doc = $meaning:literal] $name:ident = $quantity:expr;)+) => {
        $(#[doc = $meaning] pub const $name: Quantity = $quantity;)+

        /// Every quantity, for the type definitions.
        pub const QUANTITIES: &[Quantity] = &[$($name),+];
    };
}

quantities! {
    /// m.
    LENGTH = si("Length", "m").displayed_in("mm").within(1e-15, 1e7);
    /// m/s.
    VELOCITY = si("Velocity", "m/s").within(1e-15, 1e4);
    /// m/s, displayed in the drillers' unit m/h.
    ADVANCE = si("RateOfPenetration", "m/s").displayed_in("m/h");
    /// m/s, of the bit's tip in its crater.
    TIP_RATE = si("TipRate", "m/s").displayed_in("mm/s");
    /// m/s2.
    ACCELERATION = si("Acceleration", "m/s2").within(1e-12, 1e5);
    /// s.
    TIME = si("Time", "s").displayed_in("ms").within(1e-15, 1.0);
    /// m2.
    AREA = si("Area", "m2").displayed_in("mm2").within(1e-12, 1e6);
    /// m3.
    VOLUME = si("Volume", "m3").displayed_in("cm3").within(1e-12, 1e3);
    /// K.
    TEMPERATURE = si("Temperature", "K").within(1.0, 1e4);
    /// m3/s, of air at 0 degrees Celsius and 1.01325e5 Pa.
    AIR_FLOW = si("FreeAirFlow", "m3/s").displayed_in("m3/min");
    /// m3/s.
    FLOW = si("VolumeFlowRate", "m3/s").displayed_in("L/min");
    /// N.
    FORCE = si("Force", "N").displayed_in("kN").within(1e-9, 1e12);
    /// Pa.
    PRESSURE = si("Pressure", "Pa").displayed_in("bar");
    /// Pa, displayed as MPa.
    STRESS = si("Stress", "Pa").displayed_in("MPa");
    /// Pa, of solids.
    MODULUS = si("ElasticModulus", "Pa").displayed_in("GPa").within(1e3, 1e20);
    /// kg/m3.
    DENSITY = si("Density", "kg/m3").within(1e-3, 1e6);
    /// N/m.
    STIFFNESS = si("Stiffness", "N/m").displayed_in("kN/mm").within(1.0, 1e20);
    /// N s/m.
    VISCOSITY = si("ViscousResistance", "N.s/m").within(1e-9, 1e12);
    /// Mass.
    MASS = si("Mass", "kg").within(1e-9, 1e9);
    /// N s.
    IMPULSE = si("Impulse", "N.s");
    /// J.
    ENERGY = si("Energy", "J").within(1e-12, 1e12);
    /// J/m3, displayed as MJ/m3.
    SPECIFIC_ENERGY = si("SpecificEnergy", "J/m3").displayed_in("MJ/m3").within(1.0, 1e15);
    /// Dimensionless.
    RATIO = si("Ratio", "1").within(1e-12, 1e9);
    /// Dimensionless.
    COUNT = si("Count", "1");
}

/// An enumeration type. The first item has the value 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// Name of the type.
    pub name: &'static str,
    /// Meaning of the type.
    pub description: &'static str,
    /// Names and meanings of its items, in the order of their values.
    pub items: &'static [(&'static str, &'static str)],
}

/// How the bodies are modelled.
pub const FIDELITY: Enumeration = Enumeration {
    name: "Fidelity",
    description: "How the bodies are modelled",
    items: &[
        ("Rigid", "One unknown a body; a collision lasts what waves would give it"),
        ("Elastic", "Bars of linear elements with consistent mass: waves travel in them"),
    ],
};

/// Where a bit that turns downward again in loaded rock begins to drill.
pub const RELOADING: Enumeration = Enumeration {
    name: "Reloading",
    description: "Where a bit that turns down again in loaded rock begins to drill",
    items: &[
        ("Loading", "Where it turns: a new loading line begins there"),
        ("Unloading", "Where it had turned up: it goes back along the unloading line first"),
    ],
};

/// Where the driving force comes from.
pub const SOURCE: Enumeration = Enumeration {
    name: "DriveSource",
    description: "Where the force on the piston comes from",
    items: &[
        ("Relay", "The amplitude, its sign switched by the piston's position over the bit"),
        ("Force", "The input drive_force"),
        ("Pressure", "The inputs drive_pressure and return_pressure on their areas"),
        (
            "Air",
            "Air that flows through ports and drives the piston by its pressure on the same areas",
        ),
    ],
};

/// Mode of the bit/rock law.
pub const ROCK_MODE: Enumeration = Enumeration {
    name: "RockMode",
    description: "Mode of the bit/rock law",
    items: &[
        ("FreeFlight", "The bit is off the rock"),
        ("DissipativeForward", "Loading, elastic and viscous"),
        ("Forward", "Loading, elastic"),
        ("Backward", "Unloading"),
        ("Standstill", "At rest on the unloading line"),
    ],
};

/// Every enumeration, for the type definitions.
pub const ENUMERATIONS: &[Enumeration] = &[FIDELITY, RELOADING, SOURCE, ROCK_MODE];
