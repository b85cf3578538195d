//! The scene in modal form: its graph, loads, and the linear systems, each decomposed when first needed.

use crate::error::Error;
use crate::laws::event::Displacement;
use crate::laws::mode::Mode;
use crate::laws::rock::{Coefficients, Spring};
use crate::modal::shared::Systems;
use crate::modal::structure::{Attachment, Structure};
use crate::modal::system::passage::Passage;
use crate::modal::system::{Recipe, System};
use crate::modal::{memory, shared};
use crate::quantities::parameters::Parameters;
use crate::scene::graph::{Channel, Edge, Graph, Group, Overlap};
use std::sync::Arc;

/// Parameters in modal form.
#[derive(Clone, Debug)]
pub struct Model {
    /// The parameters.
    pub parameters: Parameters,
    /// Resolutions of the guards, see [`Parameters::resolutions`].
    pub resolutions: [f64; 2],
    /// Bodies and ties.
    pub graph: Arc<Graph>,
    systems: Systems,
}

impl Model {
    /// Prepares the bodies; systems are decomposed on demand.
    ///
    /// # Errors
    /// A parameter out of its domain; too little memory; a body whose modes cannot be found;
    /// [`Error::Cancelled`].
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        parameters.validate()?;
        memory::reserve(parameters)?;
        let graph = Graph::new(parameters)?;
        Ok(Self {
            parameters: *parameters,
            resolutions: parameters.resolutions(),
            graph: Arc::new(graph),
            systems: Systems::default(),
        })
    }

    /// Bound on the circular frequency of any undamped motion, rad/s: the mesh's fastest
    /// mode, all ties and the stiffest rock line on the nodes they act on.
    pub fn fastest(&self) -> f64 {
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let graph = &self.graph;
        let mesh = graph.omega2(graph.all()).fold(0.0f64, |a, &w2| a.max(w2));
        let rock = Spring::Unloading.coefficients(&self.parameters.rock).stiffness;
        let tied = |edge: &Edge| {
            let above = edge.upper.map_or(0.0, |upper| square(&graph.bodies[upper].bottom));
            edge.law.line.stiffness * (above + square(&graph.bodies[edge.lower].top))
        };
        let ties: f64 = graph.ties.iter().map(tied).sum();
        (mesh + ties + rock * square(&graph.lowest().bottom)).sqrt()
    }

    /// The model with other tunable parameters, without the systems that depend on a changed one.
    #[must_use]
    pub fn retuned(&self, tuned: &Parameters) -> Self {
        let resolutions = tuned.resolutions();
        let mut model = Self { parameters: *tuned, resolutions, ..self.clone() };
        for spring in Spring::ALL {
            if spring.coefficients(&self.parameters.rock) != spring.coefficients(&tuned.rock) {
                model.systems.forget(spring);
            }
        }
        model
    }

    /// True if anything but the rock dissipates.
    pub(crate) fn is_damped(&self) -> bool {
        let viscous = |edge: &Edge| edge.law.line.viscosity > 0.0;
        self.parameters.material.damping_time > 0.0 || self.graph.ties.iter().any(viscous)
    }

    /// The direct passage from one group's system into another's, if it is cheaper.
    ///
    /// # Errors
    ///
    /// As [`Self::system`].
    pub fn passage(
        &self,
        from: Group,
        to: Group,
        mode: Mode,
    ) -> Result<Option<Arc<Passage>>, Error> {
        if self.graph.is_loose() {
            return Ok(None);
        }
        self.systems.passage(from, to, || {
            let (old, new) = (self.system(from, mode)?, self.system(to, mode)?);
            let shared = self.graph.overlaps(from, to);
            let passage = |[overlap]: [Overlap; 1]| new.passage(&old, overlap);
            Ok(shared.try_into().ok().and_then(passage))
        })
    }

    /// The decomposed system of a group.
    ///
    /// # Errors
    /// [`Error::Spectrum`] if it cannot be decomposed; [`Error::Cancelled`].
    pub fn system(&self, group: Group, mode: Mode) -> Result<Arc<System>, Error> {
        self.systems.system(group, || self.decompose(group, mode))
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
        let held: Vec<_> =
            graph.inside(group).map(|edge| (edge, shape(Displacement::Tie(edge.tie)))).collect();
        let attached = |joins: bool| {
            let alike = held.iter().filter(move |(edge, _)| edge.tie.joins_modes() == joins);
            alike.map(|(edge, shape)| {
                let Coefficients { stiffness, viscosity } = edge.law.line;
                Attachment { shape, stiffness, viscosity }
            })
        };
        let grounded = |braked: bool| {
            let to_ground = held.iter().filter(|(edge, _)| edge.upper.is_none());
            to_ground.filter(|(edge, _)| (edge.law.line.stiffness == 0.0) == braked).count() > 0
        };
        let slides = grounded(true) && !grounded(false) && spring == Spring::Free;
        let omega2: Vec<f64> = graph.omega2(group.bodies).copied().collect();
        let structure = Structure {
            omega2: &omega2,
            beta: laws.material.damping_time,
            attachments: rock.into_iter().chain(attached(false)).collect(),
            proportional: attached(true).collect(),
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
            dampers: held.iter().filter_map(damper).collect(),
        };
        let system = shared::system(recipe, graph.share(group, Displacement::Tip), mode);
        system.map_err(|error| error.suspecting(laws.suspect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::event::Bodies;
    use crate::laws::mode::RockMode;
    use crate::modal::system::driven::Driven;
    use crate::numerics::combine;
    use crate::numerics::poly::Poly;
    use crate::scene::graph::CHANNELS;

    /// The direct passage gives the same moving state as the conversion via the bodies' modes, for which the loads'
    /// static shapes are added before and subtracted after: for unequal bars, and between the springs of the rock.
    #[test]
    fn a_state_passes_without_its_statics_to_where_it_goes_by_the_bodies() {
        let mut p = Parameters::default();
        (p.piston.elements, p.piston.length, p.bit.elements) = (7, 0.31, 12);
        let model = Model::new(&p).unwrap();
        let mode = Mode::starting(RockMode::Forward);
        let loads = [4e4, 7e3, 9.81, 2e3];
        for (a, b) in [(Spring::Free, Spring::Viscous), (Spring::Loading, Spring::Unloading)] {
            for ends in [[a, b], [b, a]] {
                for bodies in [Bodies::STRUCK, Bodies::PISTON.and(Bodies::STRUCK)] {
                    let [from, to] = ends.map(|spring| Group { bodies, spring: Some(spring) });
                    compare(&model, (from, to, mode), loads);
                }
            }
        }
    }

    fn compare(model: &Model, (from, to, mode): (Group, Group, Mode), loads: [f64; CHANNELS]) {
        let [old, new] = [from, to].map(|group| model.system(group, mode).unwrap());
        let polys = loads.map(Poly::constant);
        let mut z: Vec<f64> = (0..2 * old.blocks()).map(|i| (1.0 + i as f64).sin()).collect();
        let blocks = old.blocks();
        z.iter_mut().enumerate().for_each(|(i, z)| {
            if i % blocks >= old.modes() || old.rigid && i % blocks == 0 {
                *z = 0.0;
            }
        });
        let driven = if old.rigid {
            Driven::translating(old.translation([0.3, -2.0], &polys))
        } else {
            Driven::default()
        };
        let mut whole = z.clone();
        old.add_driven(&polys, &driven, 0.0, &mut whole);
        let mut state = vec![0.0; 2 * old.modes()];
        old.to_bodies(&whole, &mut state);
        let mut known = vec![0.0; 2 * new.blocks()];
        new.to_modal(&state, &mut known);
        // A state is as large as what is added to it; each entry has about 80 roundings of that, twice.
        let size = |y: &[f64]| y.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
        let largest = size(&whole).max(size(&known));
        let allowed = 200.0 * f64::EPSILON * largest * combine::roundings(z.len()) as f64;
        let moved = new.take_driven(&polys, &mut known);
        old.add_translation(&driven, &mut z);
        let mut out = vec![0.0; 2 * new.blocks()];
        let way = model.passage(from, to, mode).unwrap().expect("small systems have one");
        way.apply_moving(&z, loads, &mut out);
        let own = new.take_translation(&polys, &mut out);
        for (own, known) in out.iter().zip(&known) {
            assert!((own - known).abs() <= allowed, "{from:?} {to:?}: {own:e} {known:e}");
        }
        for (own, known) in own.translation.0.iter().zip(moved.translation.0) {
            assert!((own - known).abs() <= allowed * known.abs().max(1.0));
        }
    }
}
