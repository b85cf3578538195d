//! The scene in modal form: its graph, its loads and its linear systems, each of which is decomposed when first needed.

use crate::bodies::bar::Bar;
use crate::bodies::cache::Recent;
use crate::error::Error;
use crate::laws::event::Displacement;
use crate::laws::mode::Mode;
use crate::laws::rock::{Coefficients, Spring};
use crate::modal::structure::{Attachment, Structure};
use crate::modal::system::passage::Passage;
use crate::modal::system::{Recipe, System};
use crate::modal::{memory, shared};
use crate::quantities::parameters::Parameters;
use crate::scene::graph::{Channel, Edge, Graph, Group};
use std::sync::Arc;

/// A scene's parameters in modal form.
#[derive(Clone, Debug)]
pub struct Model {
    /// The parameters.
    pub parameters: Parameters,
    /// Resolutions of guards (see [`Parameters::resolutions`]).
    pub resolutions: [f64; 2],
    /// Bodies and ties.
    pub graph: Arc<Graph>,
    /// The systems of groups, each decomposed when it is first needed. A string with loose joints can have hundreds of
    /// them, so the least recently used ones are dropped.
    systems: Recent<Group, Arc<System>>,
    /// The passages from one group's system into another's.
    passages: Recent<[Group; 2], Option<Arc<Passage>>>,
}

/// Largest number of passages of a scene. Strings with loose joints, which have many groups, use none.
const PASSAGES: usize = 64;

impl Model {
    /// The model of these parameters. Its systems are decomposed on demand.
    ///
    /// # Errors
    /// A parameter is out of its domain; there is too little memory; the modes of a body cannot be found;
    /// [`Error::Cancelled`].
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        parameters.validate()?;
        memory::reserve(parameters)?;
        let graph = Graph::new(parameters)?;
        Ok(Self {
            parameters: *parameters,
            resolutions: parameters.resolutions(),
            graph: Arc::new(graph),
            systems: Recent::new(shared::BUDGET, shared::SCENE, |system| system.bytes()),
            passages: Recent::new(PASSAGES, 1, |_| 1),
        })
    }

    /// Upper bound of the circular frequency of any undamped motion, rad/s. Its square is the sum of the squares of the
    /// mesh's fastest mode, and of the frequencies of all ties and of the stiffest rock spring on the nodes at which
    /// they act.
    pub fn fastest(&self) -> f64 {
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let graph = &self.graph;
        let mesh = graph.omega2(graph.all()).fold(0.0f64, |a, &w2| a.max(w2));
        let rock = Spring::Unloading.coefficients(&self.parameters.rock).stiffness;
        let tie = |edge: &Edge| {
            let above = edge.upper.map_or(0.0, |upper| square(&graph.bodies[upper].bottom));
            edge.law.line.stiffness * (above + square(&graph.bodies[edge.lower].top))
        };
        let ties: f64 = graph.ties.iter().map(tie).sum();
        (mesh + ties + rock * square(&graph.bodies[graph.bit].bottom)).sqrt()
    }

    /// The model with other tunable parameters. Systems that depend on a changed parameter are dropped.
    #[must_use]
    pub fn retuned(&self, tuned: &Parameters) -> Self {
        let resolutions = tuned.resolutions();
        let mut model = Self { parameters: *tuned, resolutions, ..self.clone() };
        for spring in Spring::ALL {
            if spring.coefficients(&self.parameters.rock) != spring.coefficients(&tuned.rock) {
                let stays = |group: &Group| group.spring != Some(spring);
                model.systems.retain(stays);
                model.passages.retain(|groups| groups.iter().all(stays));
            }
        }
        model
    }

    /// True if the bodies may be expanded with the air that drives them: two rigid bodies that only the rock brakes.
    pub(crate) fn is_expanded(&self) -> bool {
        self.graph.is_rigid_pair() && !self.is_damped()
    }

    /// True if anything except the rock dissipates.
    pub(crate) fn is_damped(&self) -> bool {
        let viscous = |edge: &Edge| edge.law.line.viscosity > 0.0;
        let bends = |bar: &Bar| bar.omega2.iter().any(|w2| *w2 > 0.0);
        let material = &self.parameters.material;
        material.damping_time > 0.0 && self.graph.bodies.iter().any(bends)
            || self.graph.ties.iter().any(viscous)
    }

    /// The direct passage from one group's system into another's; `None` if it would not save work.
    ///
    /// # Errors
    ///
    /// Those of [`Self::system`].
    pub fn passage(
        &self,
        from: Group,
        to: Group,
        mode: Mode,
    ) -> Result<Option<Arc<Passage>>, Error> {
        if self.graph.is_loose() {
            return Ok(None);
        }
        self.passages.find([from, to], |_| {
            let (old, new) = (self.system(from, mode)?, self.system(to, mode)?);
            let [overlap] = self.graph.overlaps(from, to)[..] else { return Ok(None) };
            Ok(new.passage(&old, overlap))
        })
    }

    /// The decomposed system of a group.
    ///
    /// # Errors
    /// [`Error::Spectrum`] if it cannot be decomposed; [`Error::Cancelled`].
    pub fn system(&self, group: Group, mode: Mode) -> Result<Arc<System>, Error> {
        self.systems.find(group, |_| self.decompose(group, mode))
    }

    fn decompose(&self, group: Group, mode: Mode) -> Result<Arc<System>, Error> {
        let (laws, graph) = (&self.parameters, &self.graph);
        let shape = |displacement| graph.shape(group, displacement);
        let tip = shape(Displacement::Tip);
        let mut translation = vec![0.0; graph.modes(group.bodies)];
        for (_, first, bar) in graph.bodies_of(group.bodies) {
            translation[first] = bar.mass.sqrt();
        }
        let load = |channel: usize| {
            if channel == Channel::Gravity as usize {
                return translation.clone();
            }
            let mut sum = vec![0.0; translation.len()];
            for (displacement, _, parts) in &graph.loaded {
                let shape = shape(*displacement);
                sum.iter_mut().zip(shape).for_each(|(sum, x)| *sum += parts[channel] * x);
            }
            sum
        };
        let spring = group.spring.unwrap_or(Spring::Free);
        let Coefficients { stiffness, viscosity } = spring.coefficients(&laws.rock);
        let rock =
            (spring != Spring::Free).then_some(Attachment { shape: &tip, stiffness, viscosity });
        let ties: Vec<_> =
            graph.inside(group).map(|edge| (edge, shape(Displacement::Tie(edge.tie)))).collect();
        let attachments = |joins: bool| {
            let selected = ties.iter().filter(move |(edge, _)| edge.tie.joins_modes() == joins);
            selected.map(|(edge, shape)| {
                let Coefficients { stiffness, viscosity } = edge.law.line;
                Attachment { shape, stiffness, viscosity }
            })
        };
        let grounded = |braked: bool| {
            let to_ground = ties.iter().filter(|(edge, _)| edge.upper.is_none());
            to_ground.filter(|(edge, _)| (edge.law.line.stiffness == 0.0) == braked).count() > 0
        };
        let slides = grounded(true) && !grounded(false) && spring == Spring::Free;
        let omega2: Vec<f64> = graph.omega2(group.bodies).copied().collect();
        let structure = Structure {
            omega2: &omega2,
            beta: laws.material.damping_time,
            attachments: rock.into_iter().chain(attachments(false)).collect(),
            proportional: attachments(true).collect(),
            sliding: slides.then_some(&translation[..]),
        };
        let damper = |(edge, _): &(&Edge, Vec<f64>)| {
            let viscosity = Some(edge.law.line.viscosity).filter(|c| *c > 0.0)?;
            Some((graph.share(group, Displacement::Tie(edge.tie))?, viscosity))
        };
        let recipe = Recipe {
            structure,
            loads: std::array::from_fn(load),
            functionals: graph.shares(group).map(shape).collect(),
            dampers: ties.iter().filter_map(damper).collect(),
        };
        let system = shared::system(recipe, graph.share(group, Displacement::Tip), mode);
        system.map_err(|error| error.suspecting(laws.suspect()))
    }
}
