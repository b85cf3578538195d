//! The scene in modal form: bars, loads, and the linear systems, each decomposed when first needed.

use crate::bodies::bar::Bar;
use crate::error::Error;
use crate::laws::event::Displacement;
use crate::laws::mode::Mode;
use crate::laws::rock::{Coefficients, Spring};
use crate::modal::passage::{Overlap, Passage};
use crate::modal::shared::Systems;
use crate::modal::span::{Chain, Span};
use crate::modal::structure::{Attachment, Structure};
use crate::modal::system::{CHANNELS, Recipe, System};
use crate::modal::{memory, shared};
use crate::quantities::parameters::Parameters;
use crate::quantities::sections::Body;
use std::ops::Range;
use std::sync::Arc;

/// Loads, in the order of a system's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// `F_A`, distributed over the piston like its mass, and its reaction on the casing, N.
    Drive,
    /// Feed force on the bit's shoulder, or on the casing, N.
    Feed,
    /// Gravity on all bodies; the channel's value is `G`, m/s2.
    Gravity,
    /// The return chamber's pressure on the bit's upper face, and its reaction on the casing, N.
    Anvil,
}

/// Parameters in modal form.
#[derive(Clone, Debug)]
pub struct Model {
    /// The parameters.
    pub parameters: Parameters,
    /// Resolutions of the guards, see [`Parameters::resolutions`].
    pub resolutions: [f64; 2],
    /// Stiffness of the contact between the bodies, N/m.
    pub contact: f64,
    /// The piston.
    pub piston: Bar,
    /// What it strikes, down to the bit: the bit alone, or the bodies of a loose drill string.
    pub string: Vec<Bar>,
    /// The casing, if there is one.
    pub casing: Option<Bar>,
    /// Which bodies there are.
    pub chain: Chain,
    systems: Systems,
    /// Where the modes of piston, bit (or string) and casing end.
    bounds: [usize; 3],
}

impl Model {
    /// Prepares the bars; systems are decomposed on demand.
    ///
    /// # Errors
    /// A parameter out of its domain; too little memory; a body whose modes cannot be found;
    /// [`Error::Cancelled`].
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        parameters.validate()?;
        memory::reserve(parameters)?;
        let missing = |body: Body| {
            Error::if_interrupted().err().unwrap_or(Error::Modes { body: body.name() })
        };
        let bar = |body| Bar::of(parameters, body).ok_or_else(|| missing(body));
        let piston = bar(Body::Piston)?;
        let string = Bar::string(parameters).ok_or_else(|| missing(Body::Bit))?;
        let casing = if parameters.has_casing() { Some(bar(Body::Casing)?) } else { None };
        let above = piston.len() + string.iter().map(Bar::len).sum::<usize>();
        let bounds = [piston.len(), above, above + casing.as_ref().map_or(0, Bar::len)];
        Ok(Self {
            parameters: *parameters,
            resolutions: parameters.resolutions(),
            contact: parameters.meeting_stiffness(),
            piston,
            string,
            chain: Chain { cased: casing.is_some(), joints: parameters.drill.joints() },
            casing,
            systems: Systems::default(),
            bounds,
        })
    }

    /// Bound on the circular frequency of any undamped motion, rad/s: the mesh's fastest
    /// mode, the contact and the stiffest rock line on the nodes they act on.
    pub fn fastest(&self) -> f64 {
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let (top, bottom) = (square(&self.string[0].top), square(&self.lowest().bottom));
        let mesh = self.omega2().fold(0.0f64, |a, &w2| a.max(w2));
        let contact = self.contact * (square(&self.piston.bottom) + top);
        let rock = Spring::Unloading.coefficients(&self.parameters.rock).stiffness;
        let tied = |casing: &Bar| self.parameters.chuck.stiffness * (top + square(&casing.bottom));
        let chuck = self.casing.as_ref().map_or(0.0, tied);
        let pairs = self.string.windows(2);
        let faces = pairs.map(|pair| square(&pair[0].bottom) + square(&pair[1].top));
        let joints = self.parameters.drill.joint.stiffness * faces.fold(0.0, f64::max);
        (mesh + contact + rock * bottom + chuck + 2.0 * joints).sqrt()
    }

    /// With other tunable parameters: without the systems that they touch.
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

    /// Range of a span in the bodies' modes (piston first, then bit or string, then casing).
    pub fn range(&self, span: Span) -> Range<usize> {
        let [p, above, all] = self.bounds;
        match span {
            Span::Piston => 0..p,
            Span::Bit(_) => p..above,
            Span::Both(_) => 0..above,
            Span::Casing => above..all,
            Span::Lower(_) => p..all,
            Span::All(_) => 0..all,
            Span::Run(run) => {
                let (first, end) = (*run.bodies().start(), run.bodies().end() + 1);
                let modes = |bodies| self.bodies().take(bodies).map(Bar::len).sum();
                modes(first)..modes(end)
            }
        }
    }

    /// The bodies in the order of their modes.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = &Bar> + Clone {
        std::iter::once(&self.piston).chain(&self.string).chain(&self.casing)
    }

    /// The body of the bit.
    fn lowest(&self) -> &Bar {
        &self.string[self.string.len() - 1]
    }

    /// Mass of bit and string, kg.
    pub fn string_mass(&self) -> f64 {
        self.string.iter().map(|body| body.mass).fold(0.0, |sum, mass| sum + mass)
    }

    /// Number of modes of all bodies.
    pub(crate) fn modes(&self) -> usize {
        self.bounds[2]
    }

    /// The bodies of a span, with where the modes of each begin.
    pub(crate) fn bodies_of(&self, span: Span) -> impl Iterator<Item = (usize, &Bar)> {
        let range = self.range(span);
        let mut first = 0;
        let placed = self.bodies().map(move |bar| {
            first += bar.len();
            (first - bar.len(), bar)
        });
        placed.filter(move |(first, _)| range.contains(first))
    }

    /// Squared frequencies of all bodies' modes, rad2/s2.
    pub(crate) fn omega2(&self) -> impl Iterator<Item = &f64> {
        self.bodies().flat_map(|body| &body.omega2)
    }

    /// True if anything but the rock dissipates.
    pub(crate) fn is_damped(&self) -> bool {
        self.parameters.material.damping_time > 0.0 || self.casing.is_some()
    }

    /// Largest amplitude at a body's end (kg^-1/2), and frequency (rad/s), of each free mode of a span.
    pub(crate) fn ends(&self, span: Span) -> Vec<[f64; 2]> {
        let mut list = Vec::with_capacity(self.range(span).len());
        for (_, bar) in self.bodies_of(span) {
            let ends = bar.top.iter().zip(&bar.bottom).zip(&bar.omega2);
            list.extend(ends.map(|((top, bottom), w2)| [top.abs().max(bottom.abs()), w2.sqrt()]));
        }
        list
    }

    /// The free modes that two spans share.
    pub fn overlap(&self, from: Span, to: Span) -> Overlap {
        let (old, new) = (self.range(from), self.range(to));
        let (start, end) = (old.start.max(new.start), old.end.min(new.end));
        Overlap { from: start - old.start, to: start - new.start, count: end.saturating_sub(start) }
    }

    /// The direct passage from one span's system into another's, if it is cheaper.
    ///
    /// # Errors
    ///
    /// As [`Self::system`].
    pub fn passage(&self, from: Span, to: Span, mode: Mode) -> Result<Option<Arc<Passage>>, Error> {
        // The pairs of a loose string's spans are too many.
        if self.chain.joints > 0 {
            return Ok(None);
        }
        self.systems.passage(from, to, || {
            let (old, new) = (self.system(from, mode)?, self.system(to, mode)?);
            Ok(new.passage(&old, self.overlap(from, to)))
        })
    }

    /// The decomposed system of a span.
    ///
    /// # Errors
    /// [`Error::Spectrum`] if it cannot be decomposed; [`Error::Cancelled`].
    pub fn system(&self, span: Span, mode: Mode) -> Result<Arc<System>, Error> {
        self.systems.system(span, || self.decompose(span, mode))
    }

    /// Amplitudes of a displacement in the modes of `range`.
    fn shape(&self, displacement: Displacement, range: &Range<usize>) -> Vec<f64> {
        let (mut shape, mut first) = (Vec::with_capacity(range.len()), 0);
        for (body, bar) in self.bodies().enumerate() {
            if range.contains(&first) {
                self.add_shape(displacement, body, bar, &mut shape);
            }
            first += bar.len();
        }
        shape
    }

    /// A body's part of that. The piston is body 0; a casing comes after the string.
    fn add_shape(&self, displacement: Displacement, body: usize, bar: &Bar, to: &mut Vec<f64>) {
        use Displacement::{
            BitMean, BitTop, Casing, CasingTop, Chuck, Gap, InCasing, Joint, PistonMean, Relative,
            Tip,
        };
        let last = self.string.len();
        let joint = |joint: u8| usize::from(joint) + 1;
        // The mean is the amplitude of the first mode.
        let (points, sign, mean) = match (displacement, body) {
            (Tip, b) if b == last => (Some(&bar.bottom), 1.0, 0.0),
            (Gap, 0) => (Some(&bar.bottom), -1.0, 0.0),
            (Gap | BitTop | Chuck, 1) => (Some(&bar.top), 1.0, 0.0),
            (Relative | InCasing | PistonMean, 0) => (None, 1.0, 1.0),
            (Relative, 1) => (None, -1.0, 1.0),
            (BitMean, b) if (1..=last).contains(&b) => (None, 1.0, bar.mass / self.string_mass()),
            (Chuck, b) if b > last => (Some(&bar.bottom), -1.0, 0.0),
            (CasingTop, b) if b > last => (Some(&bar.top), 1.0, 0.0),
            (Casing, b) if b > last => (None, 1.0, 1.0),
            (InCasing, b) if b > last => (None, -1.0, 1.0),
            (Joint(k), b) if b == joint(k) => (Some(&bar.bottom), -1.0, 0.0),
            (Joint(k), b) if b == joint(k) + 1 => (Some(&bar.top), 1.0, 0.0),
            _ => (None, 1.0, 0.0),
        };
        match points {
            Some(points) => to.extend(points.iter().map(|x| sign * x)),
            None => {
                to.push(sign * (mean / bar.mass.sqrt()));
                to.resize(to.len() + bar.len() - 1, 0.0 * sign);
            }
        }
    }

    fn decompose(&self, span: Span, mode: Mode) -> Result<Arc<System>, Error> {
        let range = self.range(span);
        let shape = |displacement| self.shape(displacement, &range);
        let [tip, gap, chuck, casing_top] =
            [Displacement::Tip, Displacement::Gap, Displacement::Chuck, Displacement::CasingTop]
                .map(shape);
        let mut translation = vec![0.0; range.len()];
        for (first, bar) in self.bodies_of(span) {
            translation[first - range.start] = bar.mass.sqrt();
        }
        let loads: [Vec<f64>; CHANNELS] = if self.casing.is_some() {
            let (top, casing) = (shape(Displacement::BitTop), shape(Displacement::Casing));
            let anvil = top.iter().zip(&casing).map(|(top, casing)| top - casing).collect();
            [shape(Displacement::InCasing), casing_top.clone(), translation.clone(), anvil]
        } else {
            let top = shape(Displacement::BitTop);
            [shape(Displacement::PistonMean), top.clone(), translation.clone(), top]
        };
        let (laws, rock) = (&self.parameters, &self.parameters.rock);
        let spring = span.spring().unwrap_or(Spring::Free);
        let mut attachments = Vec::new();
        if spring != Spring::Free {
            let Coefficients { stiffness, viscosity } = spring.coefficients(rock);
            attachments.push(Attachment { shape: &tip, stiffness, viscosity });
        }
        if span.is_in_contact() {
            attachments.push(Attachment { shape: &gap, stiffness: self.contact, viscosity: 0.0 });
        }
        if span.is_in_chuck() {
            let (stiffness, viscosity) = (laws.chuck.stiffness, laws.chuck.viscosity);
            attachments.push(Attachment { shape: &chuck, stiffness, viscosity });
        }
        let string = laws.casing.impedance;
        let tie = laws.joint();
        let joints = if let Span::Run(run) = span { run.joints() } else { 0..0 };
        let joints =
            joints.map(|joint| (Displacement::Joint(joint), shape(Displacement::Joint(joint))));
        let joints: Vec<_> = joints.collect();
        let is_braked = string > 0.0 && self.casing.is_some() && range.end == self.modes();
        if is_braked {
            attachments.push(Attachment { shape: &casing_top, stiffness: 0.0, viscosity: string });
        }
        // In the order of `Span::share`.
        let functionals = span.displacements().map(shape);
        let chuck = span.is_in_chuck().then_some((Displacement::Chuck, laws.chuck.viscosity));
        let above = is_braked.then_some((Displacement::CasingTop, string));
        let damped = joints.iter().map(|(joint, _)| (*joint, tie.viscosity));
        let dampers = chuck.into_iter().chain(above).chain(damped);
        let sliding = (is_braked && spring == Spring::Free).then_some(&translation[..]);
        let omega2: Vec<f64> = self.omega2().copied().collect();
        let structure = Structure {
            omega2: &omega2[range.clone()],
            beta: laws.material.damping_time,
            attachments,
            joints: joints
                .iter()
                .map(|(_, shape)| Attachment {
                    shape,
                    stiffness: tie.stiffness,
                    viscosity: tie.viscosity,
                })
                .collect(),
            sliding,
        };
        let recipe = Recipe {
            structure,
            loads,
            functionals: functionals.collect(),
            dampers: dampers
                .filter_map(|(d, viscosity)| Some((span.share(d)?, viscosity)))
                .collect(),
        };
        let system = shared::system(recipe, span.share(Displacement::Tip), mode);
        system.map_err(|error| error.suspecting(laws.suspect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::mode::{Chuck, RockMode};
    use crate::modal::driven::Driven;
    use crate::numerics::combine;
    use crate::numerics::poly::Poly;

    /// Between the springs of a bit and of both bodies, of unequal bars: the conversion via the
    /// bodies' modes, with the loads' shapes added before and subtracted after, leads to the same
    /// moving state.
    #[test]
    fn a_state_passes_without_its_statics_to_where_it_goes_by_the_bodies() {
        let mut p = Parameters::default();
        (p.piston.elements, p.piston.length, p.bit.elements) = (7, 0.31, 12);
        let model = Model::new(&p).unwrap();
        let mode = Mode { closed: true, ..Mode::starting(RockMode::Forward, Chuck::Open) };
        let loads = [4e4, 7e3, 9.81, 2e3];
        for (a, b) in [(Spring::Free, Spring::Viscous), (Spring::Loading, Spring::Unloading)] {
            for ends in [[a, b], [b, a]] {
                for [from, to] in [ends.map(Span::Bit), ends.map(Span::Both)] {
                    compare(&model, (from, to, mode), loads);
                }
            }
        }
    }

    fn compare(model: &Model, (from, to, mode): (Span, Span, Mode), loads: [f64; CHANNELS]) {
        let [old, new] = [from, to].map(|span| model.system(span, mode).unwrap());
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
        // A state is as large as what is added to it; each entry has about 80 roundings of that,
        // twice.
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
