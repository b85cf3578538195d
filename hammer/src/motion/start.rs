//! The start of a scene.

use super::Motion;
use super::air::{beyond, outside};
use super::state::{Anchor, Line, MotionState};
use crate::air::steel::Steel;
use crate::air::{Air, volumes};
use crate::error::Error;
use crate::laws::event::{Bodies, Displacement};
use crate::laws::mode::{Mode, Relay, RockMode, Tie, TieState};
use crate::laws::rock::{Memory, Spring};
use crate::modal::{model::Model, system::driven::Driven};
use crate::numerics::{instant::Double, poly::Poly};
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{Parameters, Source};
use crate::scene::graph::CHANNELS;
use crate::scene::graph::Group;

impl Motion {
    /// The motion at the start of a scene.
    ///
    /// The loads are taken to have acted for ever, so that no body oscillates.
    /// * If they press the bit down (`FS + Mb G > 0`), it is in static equilibrium, in SS.
    /// * If they lift it, it is in FF: it is at rest with its tip just touching the rock, and strained as in the
    ///   uniform acceleration that follows.
    /// * For `FS + Mb G = 0` both cases have the same limit, the shape of a bit that hangs from its shoulder; only the
    ///   mode jumps there.
    /// * If the loads press neither on the rock nor on the chuck, there is no equilibrium, and the bit is in FF.
    ///
    /// The origin is the rock surface, where `uu = ul = 0`. The force at which the tip last turned upward is taken to
    /// be the present force. The piston starts `g0` above the bit's unloaded position. If a strained bit reaches
    /// further up, the piston starts on the bit.
    ///
    /// The weight of a casing, the feed force and the drive's reaction press the casing on the bit. If they lift it
    /// instead, it is at rest with the chuck open and its shoulder just touching, and strained as in the acceleration
    /// that follows; the string's dashpot has not braked it yet.
    /// The bit then stands on the rock by its own weight, or is in FF if gravity does not press it down.
    pub(crate) fn new(model: Model, inputs: Inputs, start: f64) -> Result<Self, Error> {
        let (parameters, graph) = (model.parameters, model.graph.clone());
        let gap = parameters.contact.initial_gap;
        let feed = inputs.of(Input::FeedForce).at(0.0);
        let [drive, anvil] = start_forces(&model, &inputs)?;
        let weight = |bodies| graph.mass(bodies) * parameters.gravity;
        let string = weight(graph.string()) + anvil;
        let carrier = graph.carrier();
        let beyond = carrier.map_or(Bodies::default(), |edge| edge.beyond);
        let shoulder = feed + weight(beyond) - drive - anvil;
        let lifted = carrier.is_some() && (shoulder <= 0.0 || shoulder + string < 0.0);
        let above = match carrier {
            None => feed,
            Some(_) if lifted => 0.0,
            Some(_) => shoulder,
        };
        let mut force = above + anvil;
        for edge in graph.ties.iter().filter(|edge| edge.tie.joins_modes()) {
            let Some(upper) = edge.upper else { continue };
            force += weight(Bodies::one(upper));
            if force < 0.0 && edge.law.travel > 0.0 {
                return Err(Error::TiePulled { tie: edge.tie, force });
            }
        }
        let press = above + string;
        let is_standing = press > 0.0 || press == 0.0 && above > 0.0;
        let rock = if is_standing { RockMode::Standstill } else { RockMode::FreeFlight };
        let mut mode = Mode::starting(rock);
        if let Some(carrier) = carrier.filter(|_| !lifted) {
            mode = mode.with(carrier.tie, TieState::Pressed);
        }
        let loads = loads(&parameters, &inputs, mode, [drive, anvil].map(Poly::constant));
        let root = graph.bodies[0].mass.sqrt();
        // An anchor of a group that does not oscillate.
        let anchor = |group: Group| {
            let flight = [-gap * root, parameters.piston.initial_velocity * root];
            let start = if group == Group::PISTON { flight } else { [0.0; 2] };
            let system = model.system(group, mode)?;
            let translation = system.rigid.then(|| system.translation(start, &loads));
            let driven = Driven::translating(translation.unwrap_or_default());
            Ok(Anchor { z: vec![0.0; 2 * system.blocks()], driven, ..Anchor::of(group) })
        };
        let groups = graph.groups(&mode).into_iter();
        let mut anchors = groups.map(anchor).collect::<Result<Vec<_>, Error>>()?;
        if rock == RockMode::FreeFlight {
            // The strain has moved the tip off the rock surface. This moves the bit so that its tip is on the surface
            // again.
            let bit = anchors[0].group;
            let system = model.system(bit, mode)?;
            if let Some(tip) = graph.share(bit, Displacement::Tip) {
                let driven = &mut anchors[0].driven;
                let displacement = system.poly(tip, &loads, driven).at(0.0);
                driven.translation.0[0] -= displacement / system.functionals[tip].rigid;
            }
        }
        let state = MotionState {
            mode,
            epoch: Double::new(start),
            now: 0.0,
            time: start,
            inputs,
            air: None,
            line: Line::default(),
            loads,
            anchors,
            course: None,
            origin: Double::default(),
            memory: Memory::default(),
            psi: 0.0,
            began: 0.0,
        };
        let tracks = state.tracks(&model)?;
        let steady = state.is_steady();
        let mut motion = Self {
            model,
            state,
            tracks,
            steady,
            still: false,
            basis_changes: 0,
            steel: Steel::default(),
            series: None,
            window: None,
            polys: Vec::new(),
            cylinder: None,
        };
        motion.still = motion.state.inputs.are_constant();
        if rock == RockMode::Standstill {
            // The tip must be exactly at the level of its restart guard.
            let tip = motion.point(&motion.tracks, Displacement::Tip, 0.0).displacement;
            let stiffness = Spring::Unloading.coefficients(&parameters.rock).stiffness;
            motion.state.memory.turned = (stiffness * tip).max(0.0);
        }
        if lifted {
            motion.lift_frame(feed)?;
        }
        motion.hang_piston();
        if parameters.drive.source == Source::Air {
            let [positions] = motion.in_cylinder(&motion.tracks, 0.0);
            let (air, _) = Air::start(&parameters, positions, motion.outside(0.0), 0.0);
            motion.state.air = Some(Box::new(air));
        }
        let lead = motion.ahead(Displacement::Relative);
        motion.state.began =
            lead + motion.point(&motion.tracks, Displacement::Relative, 0.0).displacement;
        Ok(motion)
    }

    /// Places the piston above the bit. If a strained bit reaches beyond the gap, the piston is raised accordingly.
    fn hang_piston(&mut self) {
        let overlap = |motion: &Self| {
            let gap = Displacement::Tie(Tie::Contact);
            motion.point(&motion.tracks, gap, 0.0).displacement.min(0.0)
        };
        let root = self.graph().bodies[0].mass.sqrt();
        if let Some(index) = self.flying() {
            self.state.anchors[index].driven.translation.0[0] += overlap(self) * root;
            self.state.anchors[index].form = self.damping_form(&self.tracks[index]);
        }
    }

    /// Places a lifted frame at rest, with its shoulder just touching the bit. Only the feed force strains it, because
    /// the other loads are distributed like its mass.
    fn lift_frame(&mut self, feed: f64) -> Result<(), Error> {
        let graph = self.model.graph.clone();
        let frame = &graph.bodies[graph.frame];
        let group = Group { bodies: Bodies::one(graph.frame), spring: None };
        let Some(index) = self.state.anchors.iter().position(|anchor| anchor.group == group) else {
            return Ok(());
        };
        let mut state = vec![0.0; 2 * frame.len()];
        let modes = state.iter_mut().zip(frame.top.iter().zip(&frame.omega2));
        modes.skip(1).for_each(|(q, (top, omega2))| *q = top * feed / omega2);
        let strain: f64 = frame.bottom.iter().zip(&state).map(|(bottom, q)| bottom * q).sum();
        // The frame's own displacement is set here, so it may be taken as 0 until then.
        let carrier = graph.carrier();
        let carried = carrier.and_then(|edge| self.share(0, Displacement::Tie(edge.tie)));
        let shoulder = carried.map_or(0.0, |bit| self.poly(0, bit).at(0.0));
        state[0] = (shoulder - strain) * frame.mass.sqrt();
        self.enter(index, group, &state)
    }
}

/// The forces of the drive on the piston and of the return chamber on the bit at the start, N.
fn start_forces(model: &Model, inputs: &Inputs) -> Result<[f64; 2], Error> {
    let parameters = &model.parameters;
    if parameters.drive.source != Source::Air {
        let drive = parameters.drive.force(inputs, Relay::Drive);
        return Ok([drive, parameters.drive.on_bit(inputs)].map(|load| load.at(0.0)));
    }
    let positions = [-parameters.contact.initial_gap; 2];
    let pressures = outside(inputs).map(|poly| poly.at(0.0));
    if !volumes(parameters, positions).iter().all(|volume| *volume > 0.0) {
        return Err(beyond(parameters, 0.0, positions));
    }
    Ok(Air::start(parameters, positions, pressures, parameters.piston.initial_velocity).1)
}

/// The loads as polynomials of the time after the epoch. `air` are the forces of the air on piston and bit.
pub(super) fn loads(
    parameters: &Parameters,
    inputs: &Inputs,
    mode: Mode,
    air: [Poly; 2],
) -> [Poly; CHANNELS] {
    let vented = mode.vented && parameters.drive.source.switches();
    let [drive, anvil] = if parameters.drive.source == Source::Air {
        air
    } else if vented {
        [Poly::default(); 2]
    } else {
        let drive = &parameters.drive;
        [drive.force(inputs, mode.relay), drive.on_bit(inputs)]
    };
    [drive, *inputs.of(Input::FeedForce), Poly::constant(parameters.gravity), anvil]
}
