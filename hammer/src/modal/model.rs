//! The scene in modal form: bars, loads, and the linear systems, each decomposed when first needed.

use crate::error::Error;
use crate::modal::passage::{Overlap, Passage};
use crate::modal::{memory, shared};
use crate::modal::structure::{Attachment, Structure};
use crate::modal::system::{CHANNELS, Recipe, System};
use crate::bodies::bar::Bar;
use crate::quantities::sections::Body;
use crate::laws::event::Displacement;
use crate::laws::mode::{Chuck, Mode};
use crate::quantities::parameters::Parameters;
use crate::laws::rock::{Coefficients, Spring};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Loads, in the order of a system's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// `F_A`, distributed over the piston like its mass, and its reaction on the casing, N.
    Drive,
    /// Feed force on the bit's shoulder, or on the casing, N.
    Feed,
    /// Gravity on all bodies; the channel's value is `G`, m/s2.
    Gravity,
}

/// Bodies that a linear system contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Span {
    /// The piston alone.
    Piston,
    /// The bit alone.
    Bit(Spring),
    /// Both, in contact.
    Both(Spring),
    /// The casing alone.
    Casing,
    /// Bit and casing, tied by the chuck.
    Lower(Spring),
    /// All three.
    All(Spring),
}

impl Span {
    const COUNT: usize = 18;

    /// The displacements of which it has a share of its own, in the order of its system's
    /// functionals.
    fn displacements(self) -> &'static [Displacement] {
        use Displacement::{
            BitMean, BitTop, Casing, CasingTop, Chuck, Gap, InCasing, PistonMean, Relative, Tip,
        };
        match self {
            Self::Piston => &[Gap, PistonMean],
            Self::Bit(_) => &[Tip, Gap, Relative, BitTop, BitMean],
            Self::Both(_) => &[Tip, Gap, Relative, BitTop, BitMean, PistonMean],
            Self::Casing => &[Chuck, Casing, CasingTop, InCasing],
            Self::Lower(_) => {
                &[Tip, Gap, Relative, BitTop, BitMean, Chuck, Casing, CasingTop, InCasing]
            }
            Self::All(_) => {
                &[Tip, Gap, Relative, BitTop, BitMean, PistonMean, Chuck, Casing, CasingTop, InCasing]
            }
        }
    }

    /// Index of this span's share of a displacement among its system's functionals; none if it has
    /// none. The shares of all spans add up to the displacement.
    pub fn share(self, displacement: Displacement) -> Option<usize> {
        use Displacement::{BitTop, Chuck, InCasing, PistonMean, Relative};
        // One functional may be its share of several.
        let own = match (self, displacement) {
            (Self::Piston, Relative | InCasing) | (Self::Both(_), InCasing) => PistonMean,
            (Self::Bit(_) | Self::Both(_), Chuck) => BitTop,
            _ => displacement,
        };
        self.displacements().iter().position(|&d| d == own)
    }

    /// The span of the tip under this spring, by the ties of bit and piston, and of bit and casing.
    pub(crate) fn at_tip(mode: Mode) -> Self {
        let spring = Spring::of(mode.rock);
        match (mode.closed, mode.chuck == Chuck::Open) {
            (false, true) => Self::Bit(spring),
            (true, true) => Self::Both(spring),
            (false, false) => Self::Lower(spring),
            (true, false) => Self::All(spring),
        }
    }

    /// The spans of a mode, that of the tip first.
    pub(crate) fn of(mode: Mode, cased: bool) -> Vec<Self> {
        let flying = (!mode.closed).then_some(Self::Piston);
        let hanging = (cased && mode.chuck == Chuck::Open).then_some(Self::Casing);
        [Some(Self::at_tip(mode)), flying, hanging].into_iter().flatten().collect()
    }

    /// The spring at the tip, if the span has one.
    pub(crate) fn spring(self) -> Option<Spring> {
        match self {
            Self::Piston | Self::Casing => None,
            Self::Bit(spring) | Self::Both(spring) | Self::Lower(spring) | Self::All(spring) => {
                Some(spring)
            }
        }
    }

    /// True if it contains piston and bit.
    pub(crate) fn is_in_contact(self) -> bool {
        matches!(self, Self::Both(_) | Self::All(_))
    }

    /// True if it contains bit and casing.
    pub(crate) fn is_in_chuck(self) -> bool {
        matches!(self, Self::Lower(_) | Self::All(_))
    }

    fn index(self) -> usize {
        match self {
            Self::Piston => 0,
            Self::Bit(spring) => 1 + spring as usize,
            Self::Both(spring) => 5 + spring as usize,
            Self::Casing => 9,
            Self::Lower(spring) => 10 + spring as usize,
            Self::All(spring) => 14 + spring as usize,
        }
    }
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
    /// The bit.
    pub bit: Bar,
    /// The casing, if there is one.
    pub casing: Option<Bar>,
    /// Bound on the circular frequency of the bodies' own waves, rad/s: the fastest mode of either
    /// mesh, or a half wave per transit of a rigid body.
    pub fastest_wave: f64,
    systems: [OnceLock<Arc<System>>; Span::COUNT],
    /// Direct passages between systems; none where states are converted via the bodies' modes.
    passages: Passages,
}

type Passages = [[OnceLock<Option<Arc<Passage>>>; Span::COUNT]; Span::COUNT];

fn no_passages() -> Passages {
    std::array::from_fn(|_| std::array::from_fn(|_| OnceLock::new()))
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
        let bar = |body: Body| match Bar::of(parameters, body) {
            Some(bar) => Ok(bar),
            None => Error::if_interrupted().and(Err(Error::Modes { body: body.name() })),
        };
        let (piston, bit) = (bar(Body::Piston)?, bar(Body::Bit)?);
        let casing = if parameters.has_casing() { Some(bar(Body::Casing)?) } else { None };
        let meshes = [&piston, &bit].into_iter().chain(&casing).flat_map(|body| &body.omega2);
        let mesh = meshes.fold(0.0f64, |a, &b| a.max(b));
        let transit =
            Body::ALL.map(|body| parameters.sections(body).length() / parameters.wave_speed());
        let half_wave = std::f64::consts::PI / transit[0].min(transit[1]);
        Ok(Self {
            parameters: *parameters,
            fastest_wave: mesh.sqrt().max(half_wave),
            resolutions: parameters.resolutions(),
            contact: parameters.meeting_stiffness(),
            piston,
            bit,
            casing,
            systems: std::array::from_fn(|_| OnceLock::new()),
            passages: no_passages(),
        })
    }

    /// Bound on the circular frequency of any undamped motion, rad/s: the mesh's fastest
    /// mode, the contact and the stiffest rock line on the nodes they act on.
    pub fn fastest(&self) -> f64 {
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let (p, b) = (&self.piston, &self.bit);
        let mesh = self.omega2().fold(0.0f64, |a, &w2| a.max(w2));
        let contact = self.contact * (square(&p.bottom) + square(&b.top));
        let rock = Spring::Unloading.coefficients(&self.parameters.rock).stiffness;
        let tied = |casing: &Bar| {
            self.parameters.chuck.stiffness * (square(&b.top) + square(&casing.bottom))
        };
        let chuck = self.casing.as_ref().map_or(0.0, tied);
        (mesh + contact + rock * square(&b.bottom) + chuck).sqrt()
    }

    /// With other tunable parameters: without the systems that they touch.
    #[must_use]
    pub fn retuned(&self, tuned: &Parameters) -> Self {
        let resolutions = tuned.resolutions();
        let mut model = Self { parameters: *tuned, resolutions, ..self.clone() };
        for spring in Spring::ALL {
            if spring.coefficients(&self.parameters.rock) != spring.coefficients(&tuned.rock) {
                for span in [Span::Bit, Span::Both, Span::Lower, Span::All] {
                    model.forget(span(spring));
                }
            }
        }
        model
    }

    /// Discards a span's system and the passages from it and into it.
    fn forget(&mut self, span: Span) {
        let index = span.index();
        self.systems[index] = OnceLock::new();
        self.passages[index] = std::array::from_fn(|_| OnceLock::new());
        self.passages.iter_mut().for_each(|from| from[index] = OnceLock::new());
    }

    /// Range of a span in the bodies' modes (piston first, then bit, then casing).
    pub fn range(&self, span: Span) -> Range<usize> {
        let (p, b, all) = (self.piston.len(), self.bit.len(), self.modes());
        match span {
            Span::Piston => 0..p,
            Span::Bit(_) => p..p + b,
            Span::Both(_) => 0..p + b,
            Span::Casing => p + b..all,
            Span::Lower(_) => p..all,
            Span::All(_) => 0..all,
        }
    }

    /// The bodies in the order of their modes.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = &Bar> + Clone {
        [&self.piston, &self.bit].into_iter().chain(&self.casing)
    }

    /// Number of modes of all bodies.
    pub(crate) fn modes(&self) -> usize {
        self.bodies().map(Bar::len).sum()
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
    pub(crate) fn ends(&self, span: Span) -> impl Iterator<Item = [f64; 2]> {
        let range = self.range(span);
        let each = self.bodies().flat_map(|bar| {
            let ends = bar.top.iter().zip(&bar.bottom).zip(&bar.omega2);
            ends.map(|((top, bottom), w2)| [top.abs().max(bottom.abs()), w2.sqrt()])
        });
        each.skip(range.start).take(range.len())
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
        let slot = &self.passages[from.index()][to.index()];
        if let Some(known) = slot.get() {
            return Ok(known.clone());
        }
        let (old, new) = (self.system(from, mode)?, self.system(to, mode)?);
        let passage = new.passage(&old, self.overlap(from, to));
        Ok(slot.get_or_init(|| passage).clone())
    }

    /// The decomposed system of a span.
    ///
    /// # Errors
    /// [`Error::Spectrum`] if it cannot be decomposed; [`Error::Cancelled`].
    pub fn system(&self, span: Span, mode: Mode) -> Result<Arc<System>, Error> {
        let slot = &self.systems[span.index()];
        if let Some(system) = slot.get() {
            return Ok(system.clone());
        }
        let system = self.decompose(span, mode)?;
        Ok(slot.get_or_init(|| system).clone())
    }

    /// Amplitudes of a displacement in the modes of `range`.
    fn shape(&self, displacement: Displacement, range: Range<usize>) -> Vec<f64> {
        let (p, b) = (&self.piston, &self.bit);
        let zeros = |bar: &Bar| vec![0.0; bar.len()];
        let minus = |v: &[f64]| v.iter().map(|x| -x).collect::<Vec<f64>>();
        let mean = |bar: &Bar| first(bar, 1.0 / bar.mass.sqrt());
        // Without a casing it has no modes.
        let of_casing =
            |shape: &dyn Fn(&Bar) -> Vec<f64>| self.casing.as_ref().map_or(Vec::new(), shape);
        let still = || of_casing(&zeros);
        let bodies = match displacement {
            Displacement::Tip => [zeros(p), b.bottom.clone(), still()],
            Displacement::Gap => [minus(&p.bottom), b.top.clone(), still()],
            Displacement::Relative => [mean(p), minus(&mean(b)), still()],
            Displacement::BitTop => [zeros(p), b.top.clone(), still()],
            Displacement::BitMean => [zeros(p), mean(b), still()],
            Displacement::PistonMean => [mean(p), zeros(b), still()],
            Displacement::Chuck => [zeros(p), b.top.clone(), of_casing(&|c| minus(&c.bottom))],
            Displacement::Casing => [zeros(p), zeros(b), of_casing(&mean)],
            Displacement::CasingTop => [zeros(p), zeros(b), of_casing(&|c| c.top.clone())],
            Displacement::InCasing => [mean(p), zeros(b), of_casing(&|c| minus(&mean(c)))],
        };
        bodies.concat()[range].to_vec()
    }

    fn decompose(&self, span: Span, mode: Mode) -> Result<Arc<System>, Error> {
        let range = self.range(span);
        let shape = |displacement| self.shape(displacement, range.clone());
        let [tip, gap, chuck, casing_top] =
            [Displacement::Tip, Displacement::Gap, Displacement::Chuck, Displacement::CasingTop].map(shape);
        let uniform: Vec<f64> = self.bodies().flat_map(|bar| first(bar, bar.mass.sqrt())).collect();
        let translation = uniform[range.clone()].to_vec();
        let loads: [Vec<f64>; CHANNELS] = if self.casing.is_some() {
            [shape(Displacement::InCasing), casing_top.clone(), translation.clone()]
        } else {
            [shape(Displacement::PistonMean), shape(Displacement::BitTop), translation.clone()]
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
        let is_braked = string > 0.0 && self.casing.is_some() && range.end == self.modes();
        if is_braked {
            attachments.push(Attachment { shape: &casing_top, stiffness: 0.0, viscosity: string });
        }
        // In the order of `Span::share`.
        let functionals = span.displacements().iter().map(|&displacement| shape(displacement));
        let chuck = span.is_in_chuck().then_some((Displacement::Chuck, laws.chuck.viscosity));
        let above = is_braked.then_some((Displacement::CasingTop, string));
        let dampers = chuck.into_iter().chain(above);
        let sliding = (is_braked && spring == Spring::Free).then_some(&translation[..]);
        let omega2: Vec<f64> = self.omega2().copied().collect();
        let structure = Structure {
            omega2: &omega2[range.clone()],
            beta: laws.material.damping_time,
            attachments,
            sliding,
        };
        let recipe = Recipe {
            structure,
            loads,
            functionals: functionals.collect(),
            dampers: dampers.filter_map(|(d, viscosity)| Some((span.share(d)?, viscosity))).collect(),
        };
        shared::system(recipe, span.share(Displacement::Tip), mode)
    }
}

/// `value` in a body's first mode.
fn first(bar: &Bar, value: f64) -> Vec<f64> {
    let mut v = vec![0.0; bar.len()];
    v[0] = value;
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::driven::Driven;
    use crate::numerics::combine;
    use crate::numerics::poly::Poly;
    use crate::laws::mode::RockMode;

    /// Between the springs of a bit and of both bodies, of unequal bars: the conversion via the
    /// bodies' modes, with the loads' shapes added before and subtracted after, leads to the same
    /// moving state.
    #[test]
    fn a_state_passes_without_its_statics_to_where_it_goes_by_the_bodies() {
        let mut p = Parameters::default();
        (p.piston.elements, p.piston.length, p.bit.elements) = (7, 0.31, 12);
        let model = Model::new(&p).unwrap();
        let mode = Mode { closed: true, ..Mode::starting(RockMode::Forward, Chuck::Open) };
        let loads = [4e4, 7e3, 9.81];
        for (a, b) in [(Spring::Free, Spring::Viscous), (Spring::Loading, Spring::Unloading)] {
            for ends in [[a, b], [b, a]] {
                for [from, to] in [ends.map(Span::Bit), ends.map(Span::Both)] {
                    compare(&model, (from, to, mode), loads);
                }
            }
        }
    }

    fn compare(model: &Model, (from, to, mode): (Span, Span, Mode), loads: [f64; 3]) {
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
