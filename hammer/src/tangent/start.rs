//! Where the derivatives of a scene begin.

use crate::error::Error;
use crate::laws::mode::RockMode;
use crate::laws::rock::Spring;
use crate::machine::Machine;
use crate::modal::model::{Model, Span};
use crate::modal::system::CHANNELS;
use crate::numerics::poly::Poly;
use crate::quantities::parameters::{Fidelity, Parameters};
use crate::quantities::sections::Body;
use crate::tangent::change::Change;
use crate::tangent::event::{Caution, Doubt};
use crate::tangent::line::Line;
use crate::tangent::response::{Path, Response};
use crate::tangent::seed::{Dimension, Parameter, Seed};
use crate::tangent::statics::Statics;
use crate::tangent::variation::variation;
use std::cell::OnceCell;
use std::sync::Arc;

/// Part of a length by which no derivative reaches.
const HAIR: f64 = 1e-9;

/// The start of the scene: the bit in static equilibrium, or strained as its loads strain it
/// with the tip just touching; the piston `g0` above, at its velocity.
pub(crate) fn begin(line: &mut Line, change: &Change, machine: &Machine) -> Result<(), Error> {
    let motion = machine.motion();
    let (model, state) = (motion.model(), motion.state());
    let p = model.piston.len();
    let root = model.piston.mass.sqrt();
    let rock = state.mode.rock;
    line.q[0] = -change.gap * root;
    line.v[0] = change.velocity * root;
    let span = Span::Bit(Spring::of(rock));
    let system = model.system(span, state.mode)?;
    let statics = Arc::new(Statics::new(model, span, &system));
    let response = Response::new(&system, statics, &variation(model, span, change));
    // The equilibrium is that of the values: what follows of a polynomial moves it.
    let steady = |loads: [Poly; CHANNELS]| loads.map(|p| Poly::constant(p.0[0]));
    let held = steady(state.loads);
    let loads = steady(change.loads(&model.parameters, &state.inputs, state.mode.relay));
    let still = vec![0.0; 2 * system.blocks()];
    let path = Path {
        system: &system,
        start: &still,
        end: &still,
        span: 0.0,
        loads: &held,
        changes: &loads,
        turns: &OnceCell::new(),
    };
    let body_state = response.standing(&path);
    line.set_part(p..p + model.bit.len(), &body_state);
    if rock == RockMode::FreeFlight {
        line.q[p] -= line.tip(model)[0] / model.bit.bottom[0];
    }
    // A strained bit that has lifted the piston moves it on.
    if machine.kinematics().piston_position < -model.resolutions[0] {
        line.q[0] += line.gap(model)[0] * root;
    }
    Ok(())
}

/// What has no derivative to begin with: the collision of rigid bodies (see
/// [`Parameters::collision_rates`]), and a mesh that shares its spans otherwise among longer
/// sections.
pub(crate) fn kinks(model: &Model, seeds: &[Seed]) -> Vec<Caution> {
    let p = &model.parameters;
    let rigid = (p.fidelity == Fidelity::Rigid).then(|| p.collision_rates().1);
    let uniform = |body: Body| match body {
        Body::Piston => p.piston.segments == 0,
        Body::Bit => p.bit.segments == 0,
    };
    let kink = |seed: &&Seed| {
        let Seed::Parameter(parameter) = **seed else { return false };
        if !parameter.is_read(p) {
            return false;
        }
        match (parameter, rigid) {
            (Parameter::PistonLength | Parameter::BitLength, Some(kinks)) => kinks.lengths,
            (Parameter::CrossSection, Some(kinks)) => {
                kinks.areas && uniform(Body::Piston) != uniform(Body::Bit)
            }
            (Parameter::Section(_, _, Dimension::Length), Some(kinks)) => kinks.lengths,
            (Parameter::Section(_, _, Dimension::Area), Some(kinks)) => kinks.areas,
            (Parameter::Section(body, _, Dimension::Length), None) => {
                shares_otherwise(p, parameter, body)
            }
            _ => false,
        }
    };
    let caution = Caution { time: 0.0, event: None, doubt: Doubt::Branch, transversality: 0.0 };
    seeds.iter().filter(kink).map(|_| caution).collect()
}

/// True if a hair's change of a section's length moves a span to another section.
fn shares_otherwise(p: &Parameters, parameter: Parameter, body: Body) -> bool {
    let spans = |factor: f64| {
        let mut near = *p;
        *parameter.slot(&mut near) *= factor;
        near.sections(body).spans(near.spans(body))
    };
    spans(1.0 - HAIR) != spans(1.0 + HAIR)
}
