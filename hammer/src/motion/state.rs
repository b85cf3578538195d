//! The state of the motion at the last event, from which it can be restarted.

use crate::air::Air;
use crate::air::course::Course;
use crate::error::Error;
use crate::laws::mode::Mode;
use crate::laws::rock::Memory;
use crate::modal::model::Model;
use crate::modal::system::driven::Driven;
use crate::modal::track::Track;
use crate::numerics::instant::Double;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::Inputs;
use crate::quantities::parameters::Parameters;
use crate::scene::graph::CHANNELS;
use crate::scene::graph::Group;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A group's modal vector at the last event or before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Anchor {
    /// The group of bodies.
    pub group: Group,
    /// Modal vector at the instant `at`.
    pub z: Vec<f64>,
    /// Instant of `z` relative to the epoch, s; 0 or negative.
    pub at: f64,
    /// The polynomial part of the group's motion, in time after the epoch.
    pub driven: Driven,
    /// `z.Q z` at the instant at which the piston's flight began, J; 0 for a track that ends at the tip.
    pub form: f64,
    /// Instant (s) and modal vector of the last event that changed the group, unless that is the last event of all. The
    /// ledger integrates from there.
    pub began: Option<(f64, Vec<f64>)>,
}

impl Anchor {
    /// An anchor at the epoch whose motion is still to be set.
    pub(crate) fn of(group: Group) -> Self {
        let (z, driven) = (Vec::new(), Driven::default());
        Self { group, z, at: 0.0, driven, form: 0.0, began: None }
    }

    /// Instant (s) and modal vector at which the ledger's interval of the group begins.
    pub(crate) fn start(&self) -> (f64, &[f64]) {
        self.began.as_ref().map_or((self.at, &self.z), |(at, z)| (*at, z))
    }

    /// Moves the epoch to an event `at` (s) after it. `touched` is true if the event changes the group.
    pub(crate) fn move_start(&mut self, at: f64, touched: bool) {
        let began = self.began.take();
        if !touched {
            let (start, z) = began.unwrap_or_else(|| (self.at, self.z.clone()));
            self.began = Some((start - at, z));
        }
    }
}

/// Time and hole depth at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Milestone {
    /// Time, s.
    pub time: Double,
    /// Depth of the hole, m.
    pub hole: Double,
}

/// First length that is tried for a line's window, s.
const FIRST: f64 = 1e-4;

/// State of a transmission line's window. The reaction itself is among the loads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// How long after the epoch the window is valid, s; `None` without a line.
    pub reach: Option<f64>,
    /// Length that is tried first for the next window, s.
    pub ahead: f64,
}

impl Default for Line {
    fn default() -> Self {
        Self { reach: None, ahead: FIRST }
    }
}

impl Line {
    /// True if there is a line and it acts. It does not act while the drive is vented.
    pub(crate) fn acts(parameters: &Parameters, mode: Mode) -> bool {
        let drive = &parameters.drive;
        drive.impedance > 0.0 && !(mode.vented && drive.source.switches())
    }

    /// True if the numbers are possible. This is checked because a stored state may be corrupt.
    pub(crate) fn is_sound(&self, parameters: &Parameters, mode: Mode, now: f64) -> bool {
        let reaches = |reach: f64| reach.is_finite() && reach >= now;
        self.reach.is_some() == Self::acts(parameters, mode)
            && self.reach.is_none_or(reaches)
            && self.ahead.is_finite()
            && self.ahead > 0.0
    }
}

/// Dynamic state of the motion. Times are relative to `epoch`, displacements to `origin`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionState {
    /// Discrete state.
    pub mode: Mode,
    /// Instant of the last event.
    pub epoch: Double,
    /// Present time after the epoch, s.
    pub now: f64,
    /// Present time as the host counts it, s.
    pub time: f64,
    /// Inputs as polynomials of the time after the epoch.
    pub inputs: Inputs,
    /// The air in the chambers, if it drives the piston.
    pub air: Option<Box<Air>>,
    /// State of the transmission line at the piston; its reaction is among the loads.
    pub line: Line,
    /// Loads as polynomials of the time after the epoch.
    pub loads: [Poly; CHANNELS],
    /// An anchor for each group; the bit's group comes first. There is none while `course` has the motion.
    pub anchors: Vec<Anchor>,
    /// The motion of a rigid hammer that is expanded with the air.
    pub course: Option<Arc<Course>>,
    /// Position of the zero of the present rock line, m.
    pub origin: Double,
    /// Memory of the rock law, relative to the origin.
    pub memory: Memory,
    /// Viscous work of the present drilling cycle before the epoch, J.
    pub psi: f64,
    /// The piston's relative position `vr` at the start of the scene, m.
    pub began: f64,
}

impl MotionState {
    /// True if no load varies and the polynomial part of the motion is at most a parabola. The motion is checked too,
    /// because a stored state may be corrupt.
    pub(crate) fn is_steady(&self) -> bool {
        let parabola = |anchor: &Anchor| anchor.driven.is_parabola();
        self.course.is_none()
            && self.loads.iter().all(Poly::is_constant)
            && self.anchors.iter().all(parabola)
    }

    /// The tracks, each at its anchor.
    ///
    /// # Errors
    /// [`Error::Foreign`] if the anchors do not fit the model's dimensions.
    pub(crate) fn tracks(&self, model: &Model) -> Result<Vec<Track>, Error> {
        let (mode, graph) = (&self.mode, &model.graph);
        if let Some(course) = &self.course {
            let window = self.air.as_ref().and_then(|air| air.window.as_ref());
            let is_its_window = window.is_some_and(|window| window.length == course.length);
            let fits = model.is_expanded() && self.anchors.is_empty() && is_its_window;
            return if graph.admits(mode) && fits { Ok(Vec::new()) } else { Err(Error::Foreign) };
        }
        let groups = self.anchors.iter().map(|anchor| anchor.group);
        if !graph.admits(mode) || !groups.eq(graph.groups(mode)) {
            return Err(Error::Foreign);
        }
        let track = |anchor: &Anchor| {
            let system = model.system(anchor.group, self.mode)?;
            if [&anchor.z, anchor.start().1].iter().any(|z| z.len() != 2 * system.blocks()) {
                return Err(Error::Foreign);
            }
            Ok(Track { system, z: anchor.z.clone(), at: anchor.at })
        };
        self.anchors.iter().map(track).collect()
    }

    /// True if every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let doubles = [self.epoch, self.origin].into_iter().flat_map(|d| [d.value(), d.rest()]);
        let memory =
            [self.memory.unloaded, self.memory.gain, self.now, self.time, self.psi, self.began];
        let polys = self.inputs.0.iter().chain(&self.loads);
        let driven = || self.anchors.iter().map(|anchor| &anchor.driven);
        let polys = polys.chain(driven().map(|driven| &driven.translation));
        let polys = polys.chain(driven().flat_map(|d| d.slow.iter().map(|(_, poly)| poly)));
        let starts = self.anchors.iter().filter_map(|a| a.began.as_ref());
        let anchors = self.anchors.iter().flat_map(|a| a.z.iter().chain([&a.at, &a.form]));
        let anchors = anchors.chain(starts.flat_map(|(at, z)| z.iter().chain([at])));
        doubles.chain(memory).all(f64::is_finite)
            && driven().all(|driven| driven.reach.is_none_or(f64::is_finite))
            && self.course.as_ref().is_none_or(|course| course.is_sound())
            && polys.flat_map(|poly| &poly.0).chain(anchors).all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Motion;
    use crate::quantities::parameters::{InputValues, Parameters};

    #[test]
    fn a_state_is_finite_if_each_of_its_numbers_is() {
        let model = Model::new(&Parameters::default()).expect("a model");
        let inputs = Inputs::constant(&InputValues::default());
        let state = Motion::new(model, inputs, 0.0).expect("a scene").state;
        assert!(state.is_finite());
        let numbers: [fn(&mut MotionState, f64); 16] = [
            |s, x| s.epoch = Double::new(x),
            |s, x| s.origin = Double::new(x),
            |s, x| s.memory.unloaded = x,
            |s, x| s.memory.gain = x,
            |s, x| s.now = x,
            |s, x| s.time = x,
            |s, x| s.psi = x,
            |s, x| s.began = x,
            |s, x| s.inputs.0[0].0[0] = x,
            |s, x| s.loads[0].0[0] = x,
            |s, x| s.anchors[0].z[0] = x,
            |s, x| s.anchors[0].at = x,
            |s, x| s.anchors[0].form = x,
            |s, x| s.anchors[0].began = Some((x, Vec::new())),
            |s, x| s.anchors[0].began = Some((0.0, vec![x])),
            |s, x| s.anchors[0].driven.translation.0[0] = x,
        ];
        for (index, set) in numbers.into_iter().enumerate() {
            for value in [f64::NAN, f64::INFINITY] {
                let mut altered = state.clone();
                set(&mut altered, value);
                assert!(!altered.is_finite(), "number {index}: {value}");
            }
        }
        let mut altered = state;
        altered.anchors[0].driven.reach = Some(f64::NAN);
        assert!(!altered.is_finite());
    }
}
