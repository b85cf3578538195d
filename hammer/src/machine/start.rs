//! The start of a scene, and its restart from a stored state.

use crate::error::Error;
use crate::machine::state::{Anchor, State};
use crate::modal::model::{self, Model, Span};
use crate::modal::system::{CHANNELS, translation};
use crate::numerics::instant::Double;
use crate::numerics::poly::Poly;
use crate::physics::inputs::{Input, Inputs};
use crate::physics::mode::{Mode, Relay, RockMode};
use crate::physics::parameters::{Fidelity, Parameters};
use crate::physics::rock::Spring;
use crate::search::guard::Track;

/// The state at the start, and its tracks.
///
/// The bit stands in static equilibrium, so its modal vector is zero; if its dead loads
/// pull it up there is none, and it starts at rest and unstressed, just touching. The
/// origin is the rock surface, where `uu = ul = 0`; the piston's displacement is kept less
/// `g0`, so that the gap is a plain difference.
pub fn state(model: &Model, inputs: Inputs, start: f64) -> Result<(State, Vec<Track>), Error> {
    let parameters = model.parameters;
    let press = inputs.of(Input::FeedForce).at(0.0) + model.bit.mass * parameters.gravity;
    let rock = if press >= 0.0 { RockMode::Standstill } else { RockMode::FreeFlight };
    let mode = Mode { closed: false, rock, relay: Relay::Drive };
    let loads: [Poly; CHANNELS] = [
        inputs.drive(&parameters, mode.relay.sign()),
        *inputs.of(Input::FeedForce),
        Poly::constant(parameters.gravity),
    ];
    let (bit, piston) = (Span::Bit(Spring::of(rock)), Span::Piston);
    let root = model.piston.mass.sqrt();
    let flight =
        [-parameters.contact.initial_gap * root, parameters.piston.initial_velocity * root];
    let anchor = |span, start: [f64; 2]| -> Result<Anchor, Error> {
        let system = model.system(span, mode)?;
        let translation =
            if system.rigid { translation(start, &system.gains, &loads) } else { Poly::default() };
        Ok(Anchor { span, z: vec![0.0; 2 * system.blocks()], at: 0.0, translation, form: 0.0 })
    };
    let mut anchors = vec![anchor(bit, [0.0; 2])?, anchor(piston, flight)?];
    // Free flight starts unstressed: the oscillation cancels the static shape.
    if rock == RockMode::FreeFlight {
        let system = model.system(bit, mode)?;
        system.add_static(&loads, 0.0, -1.0, &mut anchors[0].z);
    }
    let state = State {
        parameters,
        mode,
        epoch: Double::new(start),
        now: 0.0,
        time: start,
        inputs,
        loads,
        anchors,
        origin: Double::default(),
        memory: Default::default(),
        psi: 0.0,
        sums: Default::default(),
        energy_start: 0.0,
        counters: Default::default(),
        blow: Default::default(),
        blows: [None; 2],
        collision: None,
        opened: None,
        peaks: Default::default(),
        step_start: 0.0,
        simultaneous: 0,
        burst: (0, Double::new(start)),
    };
    let tracks = tracks(model, &state)?;
    Ok((state, tracks))
}

/// Tracks at the anchors of a state.
///
/// # Errors
/// Anchors that do not fit the model's dimensions.
pub fn tracks(model: &Model, state: &State) -> Result<Vec<Track>, Error> {
    let bodies = if state.mode.closed { 1 } else { 2 };
    if state.anchors.len() != bodies {
        return Err(Error::Foreign);
    }
    let track = |anchor: &Anchor| {
        let system = model.system(anchor.span, state.mode)?;
        if anchor.z.len() != 2 * system.blocks() {
            return Err(Error::Foreign);
        }
        Ok(Track { system, z: anchor.z.clone(), at: anchor.at })
    };
    state.anchors.iter().map(track).collect()
}

/// What a user should know about these parameters.
pub fn warnings(parameters: &Parameters) -> Vec<String> {
    let mut list = Vec::new();
    if parameters.fidelity == Fidelity::Elastic {
        let (p, b) = (&parameters.piston, &parameters.bit);
        let stretch = parameters.material.youngs_modulus * parameters.cross_section;
        let element = stretch * (p.elements as f64 / p.length).max(b.elements as f64 / b.length);
        let ratio = parameters.contact.stiffness / element;
        if ratio > 2.0 {
            list.push(format!(
                "contact.stiffness = {} N/m is {ratio:.1} times the stiffness E A / h of the stiffest \
                 element; beyond 2 the contact nodes rattle",
                parameters.contact.stiffness
            ));
        }
    }
    list
}

const _: () = assert!(model::TIP == 0, "the dashpot's functional is the first");
