//! Variables of which a machine has many: stress and velocity along its bodies, and the figures of each blow. A table
//! of variables cannot list them, since their number depends on the scene or on the step.

use crate::machine::blows::Blow;
use crate::machine::outputs::Profile;
use crate::quantities::parameters::{Fidelity, Parameters};
pub use crate::variables::{ALONG, Along};
use crate::variables::{Output, Role, VARIABLES};

impl Along {
    /// Number of values of an elastic body; 0 of a rigid one, or without the body.
    #[must_use]
    pub fn count(&self, parameters: &Parameters) -> usize {
        let elastic = usize::from(parameters.is_elastic(self.body));
        elastic * (parameters.spans(self.body) + usize::from(self.nodal))
    }

    /// The value with an index from 0; `None` beyond the mesh.
    #[must_use]
    pub fn value(&self, profile: &Profile, index: usize) -> Option<f64> {
        let (stress, nodes) = profile.along(self.body);
        if self.nodal {
            nodes.get(index).map(|[_, velocity]| *velocity)
        } else {
            stress.get(index).copied()
        }
    }

    /// Why there is no value with an index from 0.
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

/// A figure of every blow.
pub struct OfBlow {
    /// Name of the figure, without index.
    pub name: &'static str,
    /// Name of the output with the last blow's figure.
    pub output: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Reads it.
    pub value: fn(&Blow) -> f64,
}

/// All figures of a blow.
#[rustfmt::skip]
pub const OF_BLOW: [OfBlow; 7] = [
    OfBlow { name: "step_blow_time", output: "blow_time", description: "Instant of a blow", value: |blow| blow.time },
    OfBlow { name: "step_blow_speed", output: "blow_speed", description: "Mean speed of the piston over the bit at a blow",
        value: |blow| blow.speed },
    OfBlow { name: "step_blow_energy", output: "blow_energy", description: "Half the piston's mass times step_blow_speed squared",
        value: |blow| blow.energy },
    OfBlow { name: "step_blow_period", output: "blow_period", description: "Time since the blow before, 0 for the first of all",
        value: |blow| blow.period },
    OfBlow { name: "step_blow_penetration", output: "blow_penetration", description: "Gain of the bit's tip since the blow before",
        value: |blow| blow.penetration },
    OfBlow { name: "step_rop", output: "rop", description: "Rate of penetration of the hole since the blow before, by specific energy",
        value: |blow| blow.rop },
    OfBlow { name: "step_tip_rate", output: "tip_rate", description: "Gain of the bit's tip per time since the blow before",
        value: |blow| blow.tip_rate },
];

impl OfBlow {
    /// True of an instant, which hosts count from their own zero.
    #[must_use]
    pub fn is_instant(&self) -> bool {
        self.output == "blow_time"
    }

    /// The row of the output with the last blow's figure; `None` only if the table lacks it.
    #[must_use]
    pub fn row(&self) -> Option<&'static Output> {
        VARIABLES.iter().find(|row| row.name == self.output).and_then(|row| match &row.role {
            Role::Output(output) => Some(output),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_figure_of_a_blow_has_an_output() {
        assert!(OF_BLOW.iter().all(|figure| figure.row().is_some()));
    }
}
