//! Where the derivatives of a scene begin.

use crate::error::Error;
use crate::machine::Machine;
use crate::modal::model::{Model, Span};
use crate::modal::system::CHANNELS;
use crate::numerics::poly::Poly;
use crate::physics::mode::RockMode;
use crate::physics::parameters::Fidelity;
use crate::physics::rock::Spring;
use crate::tangent::change::Change;
use crate::tangent::event::{Caution, Doubt};
use crate::tangent::line::Line;
use crate::tangent::response::{Path, Response};
use crate::tangent::seed::{Parameter, Seed};
use crate::tangent::statics::Statics;
use crate::tangent::variation::variation;
use std::sync::Arc;

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

/// What has no derivative to begin with: the collision of rigid bodies lasts as the shorter of
/// them has it, and that of stepped ones is read off a lattice.
pub(crate) fn kinks(model: &Model, seeds: &[Seed]) -> Vec<Caution> {
    use Parameter::{BitLength, CrossSection, PistonLength};
    let p = &model.parameters;
    let (piston, bit) = (p.piston.segments == 0, p.bit.segments == 0);
    let kink = |seed: &Seed| match seed {
        Seed::Parameter(PistonLength) => piston && (!bit || p.piston.length == p.bit.length),
        Seed::Parameter(BitLength) => bit && (!piston || p.piston.length == p.bit.length),
        Seed::Parameter(CrossSection) => piston != bit,
        _ => false,
    };
    let caution = Caution { time: 0.0, event: None, doubt: Doubt::Branch, transversality: 0.0 };
    let rigid = p.fidelity == Fidelity::Rigid;
    seeds.iter().filter(|seed| rigid && kink(seed)).map(|_| caution).collect()
}
