//! Outputs that are arrays: values along the bodies, and the figures of each blow.

use crate::laws::mode::Tie;
use crate::machine::blows::Blow;
use crate::machine::outputs::Profile;
use crate::quantities::parameters::{Fidelity, Parameters};
use crate::quantities::quantity::*;
use crate::quantities::sections::Body;

/// Values of one kind along one body, counted from its upper end.
pub struct Along {
    /// Name without index.
    pub name: &'static str,
    /// Their meaning.
    pub description: &'static str,
    /// Type.
    pub quantity: Quantity,
    /// Order of magnitude.
    pub nominal: f64,
    /// The body.
    pub body: Body,
    /// True for values at the ends of the elements, false for values at their middles.
    pub nodal: bool,
}

impl Along {
    /// Number of values of an elastic body; 0 for a rigid body, and if there is no such body.
    #[must_use]
    pub fn count(&self, parameters: &Parameters) -> usize {
        let elastic = usize::from(parameters.is_elastic(self.body));
        elastic * (parameters.spans(self.body) + usize::from(self.nodal))
    }

    /// The value with this index, from 0; `None` beyond the mesh.
    #[must_use]
    pub fn value(&self, profile: &Profile, index: usize) -> Option<f64> {
        let (stress, nodes) = profile.along(self.body);
        if self.nodal {
            nodes.get(index).map(|[_, velocity]| *velocity)
        } else {
            stress.get(index).copied()
        }
    }

    /// The reason why there is no value with this index, from 0.
    #[must_use]
    pub fn missing(&self, index: usize, parameters: &Parameters) -> String {
        let (name, number, body) = (self.name, index + 1, self.body.name());
        let why = if parameters.fidelity == Fidelity::Rigid {
            "fidelity is Rigid".into()
        } else if parameters.is_elastic(self.body) {
            format!("{body}.elements = {}", parameters.spans(self.body))
        } else {
            format!("{body}.segments = 0")
        };
        format!("there is no {name}[{number}]: {why}")
    }
}

/// All values along the bodies.
#[rustfmt::skip]
pub const ALONG: [Along; 6] = [
    Along { name: "piston_stress", description: "Axial stress at the middle of an element of the piston, tension positive",
        quantity: STRESS, nominal: 1e8, body: Body::Piston, nodal: false },
    Along { name: "bit_stress", description: "Axial stress at the middle of an element of the bit, tension positive",
        quantity: STRESS, nominal: 1e8, body: Body::Bit, nodal: false },
    Along { name: "piston_node_velocity", description: "Velocity of a node of the piston, positive downward",
        quantity: VELOCITY, nominal: 10.0, body: Body::Piston, nodal: true },
    Along { name: "bit_node_velocity", description: "Velocity of a node of the bit, positive downward",
        quantity: VELOCITY, nominal: 10.0, body: Body::Bit, nodal: true },
    Along { name: "casing_stress", description: "Axial stress at the middle of an element of an elastic casing, tension positive",
        quantity: STRESS, nominal: 1e7, body: Body::Casing, nodal: false },
    Along { name: "casing_node_velocity", description: "Velocity of a node of an elastic casing, positive downward",
        quantity: VELOCITY, nominal: 1.0, body: Body::Casing, nodal: true },
];

/// A figure of every blow.
pub struct OfBlow {
    /// Name. The output `step_` with this name, if there is one, is the figure of the last blow or of a step.
    pub name: &'static str,
    /// Type.
    pub quantity: Quantity,
    /// Meaning.
    pub description: &'static str,
    /// Reads the figure; NaN if it was not recorded.
    pub value: fn(&Blow) -> f64,
}

/// Figures of a blow that are arrays in FMI 3.0.
#[rustfmt::skip]
pub const OF_BLOW: [OfBlow; 7] = [
    OfBlow { name: "step_blow_time", quantity: TIME, description: "Instant of a blow", value: |blow| blow.time },
    OfBlow { name: "step_blow_speed", quantity: VELOCITY, description: "Mean speed of the piston over the bit at a blow",
        value: |blow| blow.speed },
    OfBlow { name: "step_blow_energy", quantity: ENERGY, description: "Half the piston's mass times step_blow_speed squared",
        value: |blow| blow.energy },
    OfBlow { name: "step_blow_period", quantity: TIME, description: "Time since the blow before, 0 for the first of all",
        value: |blow| blow.period },
    OfBlow { name: "step_blow_penetration", quantity: LENGTH, description: "Gain of the bit's tip since the blow before",
        value: |blow| blow.penetration },
    OfBlow { name: "step_rop", quantity: ADVANCE, description: "Rate of penetration of the hole since the blow before, by specific energy",
        value: |blow| blow.rop },
    OfBlow { name: "step_tip_rate", quantity: ADVANCE, description: "Gain of the bit's tip per time since the blow before",
        value: |blow| blow.tip_rate },
];

/// The other figures of a blow's record, all since the previous blow.
#[rustfmt::skip]
pub const OF_RECORD: [OfBlow; 14] = [
    OfBlow { name: "blow_length", quantity: LENGTH, description: "Length of hole drilled", value: |blow| blow.length },
    OfBlow { name: "rock_work", quantity: ENERGY, description: "Work given to the rock", value: |blow| blow.rock_work },
    OfBlow { name: "free_air", quantity: VOLUME, description: "Free air taken", value: |blow| blow.air },
    OfBlow { name: "step_contact_duration", quantity: TIME, description: "Duration of the last complete collision",
        value: |blow| blow.contact_duration },
    OfBlow { name: "rebound_speed", quantity: VELOCITY, description: "Last speed, upward, at which the piston left the bit",
        value: |blow| blow.account().rebound_speed },
    OfBlow { name: "step_contact_force_peak", quantity: FORCE, description: "Largest contact_force",
        value: |blow| blow.account().peaks.contact_force() },
    OfBlow { name: "step_rock_force_peak", quantity: FORCE, description: "Largest rock_force",
        value: |blow| blow.account().peaks.rock_force() },
    OfBlow { name: "step_chuck_force_peak", quantity: FORCE, description: "Largest chuck_force; 0 without a casing",
        value: |blow| blow.account().peaks.tie_force(Tie::Chuck) },
    OfBlow { name: "drive_work", quantity: ENERGY, description: "Work of the drive", value: |blow| blow.account().drive },
    OfBlow { name: "gravity_work", quantity: ENERGY, description: "Work of gravity", value: |blow| blow.account().gravity },
    OfBlow { name: "feed_work", quantity: ENERGY, description: "Work of the feed force", value: |blow| blow.account().feed },
    OfBlow { name: "crushing_work", quantity: ENERGY, description: "Part of rock_work that is dissipated on loading",
        value: |blow| blow.account().rock_dissipated },
    OfBlow { name: "viscous_work", quantity: ENERGY, description: "Part of rock_work that its viscosity takes",
        value: |blow| blow.account().viscous },
    OfBlow { name: "damping_work", quantity: ENERGY, description: "Energy lost in the bodies and in ties",
        value: |blow| blow.account().damping },
];

impl OfBlow {
    /// True if the figure is an instant, which hosts count from their own zero.
    #[must_use]
    pub fn is_instant(&self) -> bool {
        self.name == "step_blow_time"
    }

    /// Name of the output, or of a figure that is not an output.
    #[must_use]
    pub fn output(&self) -> &'static str {
        self.name.trim_start_matches("step_")
    }
}
