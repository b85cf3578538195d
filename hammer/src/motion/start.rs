//! The scene at its start.

use super::air::outside;
use super::state::{Anchor, MotionState};
use super::{Motion, tracks};
use crate::air::Air;
use crate::air::solve::Problem;
use crate::error::Error;
use crate::laws::chambers::Gas;
use crate::laws::event::Displacement;
use crate::laws::mode::{Chuck, Mode, Relay, RockMode};
use crate::laws::rock::Memory;
use crate::modal::model::{Channel, Model};
use crate::modal::span::Span;
use crate::modal::system::CHANNELS;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{Parameters, Source};

impl Motion {
    /// The scene at its start.
    ///
    /// The loads have acted for ever: no body oscillates. If they press the bit down or just carry it
    /// (`FS + Mb G >= 0`), it is in static equilibrium, in SS. If they lift it, it is in FF, at rest,
    /// its tip just touching, and strained as in the uniform acceleration that follows. Both cases
    /// have the same limit where `FS + Mb G` is 0: the shape of a bit that hangs from its shoulder.
    /// Only the rock law jumps there, because a bit that is not pressed has no force to stand still
    /// by. The origin is the rock surface, where `uu = ul = 0`; the last force at which the tip turned
    /// upward is the present one. The piston hangs `g0` above the bit's unloaded position; a lifted
    /// bit raises it as far as it needs room.
    ///
    /// A casing rests on the bit with what it weighs, the feed and the drive's reaction. If these lift
    /// it, it is at rest where the shoulder just touches, the chuck open, strained as in the
    /// acceleration that follows; the string's dashpot has not braked it yet. The bit then stands on
    /// the rock by its own weight, or is in FF if it has none.
    pub(crate) fn new(model: Model, inputs: Inputs, start: f64) -> Result<Self, Error> {
        let parameters = model.parameters;
        let gap = parameters.contact.initial_gap;
        let gas = match parameters.drive.source {
            Source::Chambers if model.casing.is_some() || parameters.drive.anvil_area > 0.0 => {
                parameters.chambers.start(-gap)
            }
            _ => Default::default(),
        };
        let feed = inputs.of(Input::FeedForce).at(0.0);
        let [drive, anvil] = start_forces(&model, &inputs, &gas)?;
        let mut held = feed + anvil;
        for (joint, above) in model.string.iter().take(model.chain.joints).enumerate() {
            held += above.mass * parameters.gravity;
            if held < 0.0 && parameters.drill.joint.slack > 0.0 {
                return Err(Error::JointPulled { joint: joint + 1, force: held });
            }
        }
        let bit = model.string_mass() * parameters.gravity + anvil;
        let (press, chuck) = match &model.casing {
            None => (feed + bit, Chuck::Open),
            Some(casing) => {
                let shoulder = feed + casing.mass * parameters.gravity - drive - anvil;
                let stands = shoulder > 0.0 && shoulder + bit >= 0.0;
                if stands { (shoulder + bit, Chuck::Shoulder) } else { (bit, Chuck::Open) }
            }
        };
        let lifted = model.casing.is_some() && chuck == Chuck::Open;
        let stands = press > 0.0 || press == 0.0 && !lifted;
        let rock = if stands { RockMode::Standstill } else { RockMode::FreeFlight };
        let mode = Mode::starting(rock, chuck);
        let loads = loads(&parameters, &inputs, mode, &gas, [drive, anvil].map(Poly::constant));
        let root = model.piston.mass.sqrt();
        let still = |span| {
            let flight = [-gap * root, parameters.piston.initial_velocity * root];
            let start = if span == Span::Piston { flight } else { [0.0; 2] };
            Anchor::still(&model, span, mode, start, &loads)
        };
        let spans = model.chain.spans(mode).into_iter();
        let mut anchors = spans.map(still).collect::<Result<Vec<_>, _>>()?;
        if rock == RockMode::FreeFlight {
            // The strain moved the tip off the rock's surface: move it back.
            let bit = anchors[0].span;
            let system = model.system(bit, mode)?;
            if let Some(tip) = bit.share(Displacement::Tip) {
                let driven = &mut anchors[0].driven;
                let off = system.poly(tip, &loads, driven).at(0.0);
                driven.translation.0[0] -= off / system.functionals[tip].rigid;
            }
        }
        let mut state = MotionState::new(mode, start, inputs, loads, anchors);
        state.memory.turned = press.max(0.0);
        let tracks = tracks(&model, &state)?;
        let steady = state.is_steady();
        let mut motion = Self { model, state, tracks, steady, basis_changes: 0 };
        if lifted {
            motion.lift_casing(feed)?;
        }
        // A strained bit may reach beyond the gap: it has lifted the piston.
        let gap = motion.point(&motion.tracks, Displacement::Gap, 0.0).displacement;
        motion.state.anchors[1].driven.translation.0[0] += gap.min(0.0) * root;
        motion.state.anchors[1].form = motion.damping_form(&motion.tracks[1]);
        if parameters.drive.source == Source::Chambers {
            let vr = motion.point(&motion.tracks, motion.relative(), 0.0).displacement;
            motion.state.gas = parameters.chambers.start(vr);
            motion.reload();
        }
        if parameters.drive.source == Source::Air {
            let [vr, _] = motion.in_cylinder(&motion.tracks, 0.0);
            motion.state.air = Some(Box::new(Air::start(&parameters, vr, motion.outside(0.0))));
        }
        Ok(motion)
    }

    /// Puts a casing that nothing carries where the shoulder just touches the bit, at rest. Of its
    /// loads the feed alone strains it, since the others are distributed like its mass.
    fn lift_casing(&mut self, feed: f64) -> Result<(), Error> {
        let (Some(index), Some(casing)) = (self.flying(Span::Casing), &self.model.casing) else {
            return Ok(());
        };
        let n = casing.len();
        let mut state = vec![0.0; 2 * n];
        for (q, (top, omega2)) in
            state.iter_mut().zip(casing.top.iter().zip(&casing.omega2)).skip(1)
        {
            *q = top * feed / omega2;
        }
        let strain: f64 = casing.bottom.iter().zip(&state).map(|(bottom, q)| bottom * q).sum();
        let root = casing.mass.sqrt();
        // Here the casing's own displacement is 0, if only by a drift that is replaced.
        let shoulder =
            self.share(0, Displacement::Chuck).map_or(0.0, |bit| self.poly(0, bit).at(0.0));
        state[0] = (shoulder - strain) * root;
        self.enter(index, Span::Casing, &state)
    }

    /// Puts the hammer into another mode and state at the epoch: `[q | q']` of all modes (the
    /// piston's first), the rock's memory, and the chambers.
    pub(crate) fn place(
        &mut self,
        mode: Mode,
        memory: Memory,
        psi: f64,
        (gas, air): ([Gas; 2], Option<Box<Air>>),
        whole: &[f64],
    ) -> Result<(), Error> {
        let state = &mut self.state;
        (state.mode, state.memory, state.psi, state.gas) = (mode, memory, psi, gas);
        let forces = [Channel::Drive, Channel::Anvil].map(|channel| state.loads[channel as usize]);
        state.loads = loads(&self.model.parameters, &state.inputs, mode, &state.gas, forces);
        let spans = self.model.chain.spans(mode);
        let still = |span| Anchor::still(&self.model, span, mode, [0.0; 2], &self.state.loads);
        let anchors = spans.iter().map(|span| still(*span)).collect::<Result<_, _>>()?;
        self.state.anchors = anchors;
        self.tracks = tracks(&self.model, &self.state)?;
        self.steady = self.state.is_steady();
        let modes = whole.len() / 2;
        for (index, span) in spans.into_iter().enumerate() {
            let range = self.model.range(span);
            let velocities = modes + range.start..modes + range.end;
            let part = [&whole[range], &whole[velocities]].concat();
            self.enter(index, span, &part)?;
        }
        let [vr, _] = self.in_cylinder(&self.tracks, 0.0);
        let parameters = &self.model.parameters;
        self.state.air = air.map(|air| Box::new(air.restarted(parameters, vr)));
        Ok(())
    }
}

/// The driving force and that of the return chamber on the bit at the start, N.
fn start_forces(model: &Model, inputs: &Inputs, gas: &[Gas; 2]) -> Result<[f64; 2], Error> {
    let parameters = &model.parameters;
    if parameters.drive.source != Source::Air {
        let exhaust = parameters.chambers.returning.exhaust.open_pressure;
        let drive = parameters.drive.force(inputs, Relay::Drive, gas);
        return Ok([drive, parameters.drive.on_bit(inputs, gas, exhaust)].map(|load| load.at(0.0)));
    }
    let (outside, vr) = (outside(inputs), -parameters.contact.initial_gap);
    let air = Air::start(parameters, vr, outside.each_ref().map(|poly| poly.at(0.0)));
    let problem = Problem { parameters, mass: model.piston.mass, outside, span: 0.0 };
    let motion = [vr, parameters.piston.initial_velocity];
    air.forces(&problem, motion).ok_or(Error::Air { time: 0.0 })
}

/// The loads' polynomials after the epoch; of air, these forces.
pub(super) fn loads(
    parameters: &Parameters,
    inputs: &Inputs,
    mode: Mode,
    gas: &[Gas; 2],
    air: [Poly; 2],
) -> [Poly; CHANNELS] {
    let vented = mode.vented && parameters.drive.source.switches();
    let [drive, anvil] = if vented {
        [Poly::default(); 2]
    } else if parameters.drive.source == Source::Air {
        air
    } else {
        let exhaust = parameters.chambers.returning.exhaust.open_pressure;
        let (drive, relay) = (&parameters.drive, mode.relay);
        [drive.force(inputs, relay, gas), drive.on_bit(inputs, gas, exhaust)]
    };
    [drive, *inputs.of(Input::FeedForce), Poly::constant(parameters.gravity), anvil]
}
