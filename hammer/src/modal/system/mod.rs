//! One decomposed linear system of the hammer, and its exact flow between events.
//!
//! In modal coordinates a system is `y' = B y + b f(t)` with 2 by 2 blocks on the diagonal of `B` (see
//! [`crate::modal::spectrum`]). With polynomial loads the solution is
//!
//! ```text
//! y(t) = exp(B t) z + polynomials
//! ```
//!
//! (see [`crate::modal::system::response`]), which is exact for any `t`.
//! The blocks are chosen so that `|exp(B t) z|` never grows, so amplitudes bound the motion for all later times.
//! Each file uses only those above it:
//!
//! ```text
//! generator    the flow of the blocks
//! basis        conversion to modal coordinates and back
//! parts        generator and basis of a structure, to working accuracy
//! passage      direct conversion from one system's coordinates to another's
//! driven       the polynomial part of a motion
//! response     the motion that loads cause
//! functional   a displacement, its derivatives and their bounds
//! visible      the part of each block in two displacements
//! ```

mod basis;
pub mod driven;
mod functional;
pub(crate) mod generator;
mod parts;
pub mod passage;
mod response;
pub(crate) mod visible;

use crate::error::{Error, SpectrumError};
use crate::interrupt;
use crate::laws::mode::Mode;
use crate::modal::spectrum::Spectrum;
use crate::modal::spectrum::joined::Joined;
use crate::modal::structure::{Attachment, Structure};
use crate::modal::system::basis::Basis;
use crate::modal::system::driven::Driven;
pub use crate::modal::system::functional::{Functional, INTEGRALS, TAYLOR};
use crate::modal::system::generator::Generator;
use crate::modal::system::parts::Decomposition;
use crate::modal::system::passage::Passage;
use crate::modal::system::response::{DampedDrive, Response};
use crate::modal::system::visible::{Pair, VisibleBlock};
use crate::numerics::combine::{Columns, combine};
use crate::numerics::form::Form;
use crate::numerics::gram::gram;
use crate::numerics::kernel::{self, LANES, inner_product, norm};
#[cfg(feature = "internals")]
use crate::numerics::matrix2::Matrix2;
use crate::numerics::poly::Poly;
use crate::scene::graph::{CHANNELS, Overlap};
use std::sync::{Arc, Mutex, OnceLock, Weak};

/// The definition of a system.
pub struct Recipe<'a> {
    /// Bars and their attachments.
    pub structure: Structure<'a>,
    /// For each channel, the modal load that a value of 1 causes.
    pub loads: [Vec<f64>; CHANNELS],
    /// Shapes of the functionals that are evaluated.
    pub functionals: Vec<Vec<f64>>,
    /// The functionals on which dashpots act whose work counts as damping, and the dashpots' viscosities, N s/m.
    pub dampers: Vec<(usize, f64)>,
}

/// A decomposed system.
#[derive(Debug)]
pub struct System {
    basis: Basis,
    /// The matrix `B`.
    pub(crate) generator: Generator,
    response: Response,
    /// True if block 0 is a uniform translation.
    pub rigid: bool,
    /// Index and rate (1/s) of the slowest coordinate that decays without oscillation, if it is slow.
    pub(crate) creeping: Option<(usize, f64)>,
    /// Largest `|B|`, 1/s.
    pub rate_max: f64,
    /// The functionals in the order of the recipe.
    pub functionals: Vec<Functional>,
    /// Columns of each functional's Taylor series (see [`Generator::powers`]).
    taylor: Vec<OnceLock<Vec<f64>>>,
    damping: Vec<f64>,
    dampers: Vec<(usize, f64)>,
    tip_dashpot: Option<usize>,
    damping_form: OnceLock<Form>,
    damped_drives: OnceLock<[Option<DampedDrive>; CHANNELS]>,
    viscous_form: OnceLock<Form>,
    visible: OnceLock<Vec<VisibleBlock>>,
    /// Direct passages from other systems into this one.
    passages: Mutex<Vec<Entry>>,
}

/// A passage into this system, with the system from which it starts.
#[derive(Debug)]
struct Entry {
    from: Weak<System>,
    overlap: Overlap,
    passage: Arc<Passage>,
}

impl Entry {
    fn is(&self, from: &Arc<System>, overlap: Overlap) -> bool {
        std::ptr::eq(self.from.as_ptr(), Arc::as_ptr(from)) && self.overlap == overlap
    }
}

impl System {
    /// Decomposes a system; `tip` is the functional whose dashpot work is needed.
    ///
    /// # Errors
    /// [`Error::Spectrum`] if the eigenvalues cannot be found to working accuracy;
    /// [`Error::Cancelled`].
    pub fn new(recipe: Recipe, tip: Option<usize>, mode: Mode) -> Result<Self, Error> {
        let Recipe { structure, loads, functionals, dampers } = recipe;
        let fail = |error| match error {
            SpectrumError::Cancelled => Error::Cancelled,
            error => Error::Spectrum { mode, error, suspect: None },
        };
        let joins = !structure.proportional.is_empty();
        let joined = joins.then(|| Joined::new(&structure).ok_or(Error::Cancelled)).transpose()?;
        let transformed = joined.as_ref().map(|joined| joined.structure(&structure));
        let solved = (transformed.as_ref().unwrap_or(&structure), joined.as_ref());
        let spectrum = Spectrum::new(solved.0).map_err(fail)?;
        let parts = Decomposition::of(&spectrum, &structure, solved);
        let Decomposition { stiff, generator, basis } = parts.map_err(fail)?;
        let sizes = loads.each_ref().map(|load| norm(load));
        let drives = loads.map(|load| {
            let state = [vec![0.0; load.len()], load].concat();
            let mut b = vec![0.0; 2 * generator.n];
            basis.enter(&state, &mut b);
            b
        });
        let response = Response::new(&generator, drives, sizes);
        let mut system = Self {
            rigid: generator.rigid,
            creeping: generator.creeping(),
            rate_max: generator.rate_max,
            basis,
            generator,
            response,
            functionals: Vec::new(),
            taylor: functionals.iter().map(|_| OnceLock::new()).collect(),
            damping: structure.omega2.iter().map(|w2| structure.beta * w2).collect(),
            dampers,
            tip_dashpot: tip,
            damping_form: OnceLock::new(),
            damped_drives: OnceLock::new(),
            viscous_form: OnceLock::new(),
            visible: OnceLock::new(),
            passages: Mutex::default(),
        };
        let functional = |shape: &Vec<f64>| {
            let same = |a: &Attachment| a.shape == shape.as_slice();
            let attachment = structure.attachments.iter().position(same);
            let known = |i: usize| attachment.and_then(|a| stiff.get(i)?[a]);
            system.functional(shape, known)
        };
        Error::if_interrupted()?;
        let mut functionals: Vec<_> = functionals.iter().map(functional).collect();
        for index in 1..functionals.len() {
            let (before, rest) = functionals.split_at_mut(index);
            rest[0].mirrored = before.iter().position(|one| one.mirrors(&rest[0]));
        }
        system.functionals = functionals;
        Ok(system)
    }

    /// Number of blocks, padded to whole groups of lanes. A modal vector is twice as long.
    pub fn blocks(&self) -> usize {
        self.generator.n
    }

    /// Approximate memory of the system with all its tables and forms, bytes.
    pub(crate) fn bytes(&self) -> usize {
        Self::room(self.modes(), self.functionals.len())
    }

    /// [`Self::bytes`] for a system with this many modes and functionals.
    pub(crate) fn room(modes: usize, functionals: usize) -> usize {
        let len = 2 * modes.next_multiple_of(LANES);
        // A functional has rows and weights, each stored a second time in the order of the loops, integrals and powers.
        // The rest are two bases and two forms of half a matrix, the rotations and the series.
        let functional = 20 + INTEGRALS + TAYLOR + 1;
        // Passages lead here from the same bodies under other springs, and from these bodies apart or together.
        let passages = if modes <= passage::MAX_MODES { 5 } else { 0 };
        let squares = (3 + passages) * len * len;
        size_of::<f64>() * (squares + 207 * len + functional * functionals * len)
    }

    /// Number of modes of the bars; `[q | q']` is twice as long.
    pub fn modes(&self) -> usize {
        self.basis.modes
    }

    /// Relative error of a state that is converted to the basis and back.
    pub fn mismatch(&self) -> f64 {
        self.basis.mismatch
    }

    /// The functional of a shape. `known` returns its values in a block if they are known more accurately than the sums
    /// of their terms.
    fn functional(&self, shape: &[f64], known: impl Fn(usize) -> Option<[f64; 2]>) -> Functional {
        let n = self.blocks();
        let mut c = vec![0.0; 2 * n];
        for (k, [displacements, _]) in self.basis.columns() {
            let value = known(k % n).map(|pair| pair[k / n]);
            c[k] = value.unwrap_or_else(|| inner_product(shape, displacements));
        }
        Functional::new(c, &self.generator, &self.response)
    }

    /// The polynomial part of functional `index`, from loads and translation.
    pub fn poly(&self, index: usize, loads: &[Poly; CHANNELS], driven: &Driven) -> Poly {
        self.functionals[index].poly(&self.response, loads, driven)
    }

    /// `y B^-1`, the coefficients of an integral.
    pub fn integral_of(&self, row: &[f64]) -> Vec<f64> {
        self.generator.integrate(row)
    }

    /// Coefficients of a functional's rate integrated once, twice and so on.
    pub(crate) fn rate_integrals(&self, index: usize) -> &[Vec<f64>] {
        self.functionals[index].rate_integrals(&self.generator)
    }

    /// Modal coordinates of displacements and velocities `[q | q']` of the bars' modes.
    pub fn to_modal(&self, state: &[f64], y: &mut [f64]) {
        self.basis.enter(state, y);
    }

    /// The reverse of [`Self::to_modal`].
    pub fn to_bodies(&self, y: &[f64], state: &mut [f64]) {
        self.basis.leave(y, state);
    }

    /// The direct passage of a state from another system into this one; `None` if it would not save work. Scenes that
    /// share both systems share the passage.
    pub fn passage(&self, from: &Arc<Self>, overlap: Overlap) -> Option<Arc<Passage>> {
        // This never waits for the lock, because after a fork nobody may ever release it.
        let known = self.passages.try_lock().ok();
        let known =
            known.and_then(|all| Some(all.iter().find(|e| e.is(from, overlap))?.passage.clone()));
        if known.is_some() {
            return known;
        }
        let statics = [&from.response, &self.response].map(Response::shapes);
        let passage = Arc::new(Passage::new(&from.basis, &self.basis, overlap, statics)?);
        if let Ok(mut known) = self.passages.try_lock() {
            known.retain(|entry| entry.from.strong_count() > 0);
            known.push(Entry { from: Arc::downgrade(from), overlap, passage: passage.clone() });
        }
        Some(passage)
    }

    /// The blocks that contribute to two displacements. The same two must be given in every call.
    pub(crate) fn visible(&self, pair: Pair) -> &[VisibleBlock] {
        let own = (&self.generator, &self.response);
        self.visible.get_or_init(|| visible::blocks(pair, own, &self.functionals))
    }

    /// Adds `change` to the displacement of the bars' mode `mode` in a modal state.
    pub fn displace(&self, mode: usize, change: f64, y: &mut [f64]) {
        self.basis.displace(mode, change, y);
    }

    /// The displacement `index` in a whole modal state, m.
    pub(crate) fn displacement(&self, index: usize, y: &[f64]) -> f64 {
        let functional = &self.functionals[index];
        functional.rigid * y[0] + kernel::dot(&functional.rows[0], y)
    }

    /// Adds to `z` the part due to loads and translation at `t` after the epoch. The result is the whole modal state.
    pub fn add_driven(&self, loads: &[Poly; CHANNELS], driven: &Driven, t: f64, z: &mut [f64]) {
        self.response.add(loads, driven, t, z);
        if self.rigid {
            self.put_translation(driven.translation.derivatives_at(t), z);
        }
    }

    /// Removes from a whole modal state at the epoch the part due to loads and translation. The rest moves by `exp(B
    /// t)`.
    pub fn take_driven(&self, loads: &[Poly; CHANNELS], y: &mut [f64]) -> Driven {
        self.response.take(&self.generator, loads, y)
    }

    /// As [`Self::take_driven`], for a state without the static part of constant loads: only the translation is
    /// removed.
    pub(crate) fn take_translation(&self, loads: &[Poly; CHANNELS], y: &mut [f64]) -> Driven {
        self.response.take_translation(&self.generator, loads, y)
    }

    /// Adds the translation at the epoch to the state `z`, which has none.
    pub(crate) fn add_translation(&self, driven: &Driven, z: &mut [f64]) {
        let [position, velocity, ..] = driven.translation.0;
        self.put_translation([position, velocity], z);
    }

    fn put_translation(&self, motion: [f64; 2], z: &mut [f64]) {
        let indices = [0, self.generator.n].into_iter().take(self.generator.polynomial());
        indices.zip(motion).for_each(|(index, value)| z[index] = value);
    }

    /// The uniform translation from a position and a velocity (m and m/s, times the root of the mass).
    pub fn translation(&self, start: [f64; 2], loads: &[Poly; CHANNELS]) -> Poly {
        self.response.translation(start, loads)
    }

    /// `c (B / rate_max)^(order + k) z` for `k` from 0 on, where `c` is functional `index` and `order` is 0 or 1. These
    /// are its derivatives in units of `rate_max`, from which the Taylor series is made.
    pub(crate) fn taylor(&self, index: usize, order: usize, z: &[f64]) -> [f64; TAYLOR] {
        let mut terms = [0.0; TAYLOR];
        let numbers = self.taylor[index]
            .get_or_init(|| self.generator.powers(&self.functionals[index].rows[0], TAYLOR + 1));
        let (first, second) = z.split_at(self.blocks());
        let columns = Columns { numbers, stride: TAYLOR + 1, offset: order };
        let z = [&first[..self.modes()], &second[..self.modes()]];
        combine(columns, z, &mut terms);
        terms
    }

    #[cfg(feature = "internals")]
    /// Block `i` of `B`, which is zero for a translation.
    pub fn block(&self, i: usize) -> Matrix2 {
        self.generator.block(i)
    }

    /// `z := exp(B span) z`. Returns the number of rotations.
    pub fn rotate(&self, span: f64, z: &mut [f64]) -> u64 {
        self.generator.rotate(span, z)
    }

    /// The form of `Q` with `d/dt z.Q z = - beta v.K v` along the flow. It is the work that the damping will still do.
    pub fn damping_form(&self) -> &Form {
        self.damping_form.get_or_init(|| self.make_damping_form(never).unwrap_or_default())
    }

    /// Makes [`Self::damping_form`] now, unless the call is interrupted.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn prepare_damping_form(&self) -> Result<(), Error> {
        prepare(&self.damping_form, || self.make_damping_form(interrupt::is_set))
    }

    fn make_damping_form(&self, stops: fn() -> bool) -> Option<Form> {
        // W = V^T diag(beta w^2) V has the inner products of the weighted columns of velocities.
        let (len, modes) = (2 * self.blocks(), self.modes().next_multiple_of(LANES));
        let mut columns = vec![0.0; len * modes];
        let roots: Vec<f64> = self.damping.iter().map(|damping| damping.sqrt()).collect();
        for (k, [_, velocities]) in self.basis.columns() {
            let column = columns[k * modes..].iter_mut();
            column.zip(&roots).zip(velocities).for_each(|((x, root), v)| *x = root * v);
        }
        let products = gram(&columns, modes, stops);
        let power = |i: usize, k: usize| {
            self.dampers.iter().fold(products[i * len + k], |sum, &(index, viscosity)| {
                let speed = &self.functionals[index].rows[1];
                sum + viscosity * speed[i] * speed[k]
            })
        };
        self.generator.lyapunov(power, stops)
    }

    /// The form of `Q` with `d/dt z.Q z = - p'^2` along the flow, where `p` is the tip's displacement.
    pub fn viscous_form(&self) -> &Form {
        self.viscous_form.get_or_init(|| self.make_viscous_form(never).unwrap_or_default())
    }

    /// Makes [`Self::viscous_form`] now, unless the call is interrupted.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn prepare_viscous_form(&self) -> Result<(), Error> {
        prepare(&self.viscous_form, || self.make_viscous_form(interrupt::is_set))
    }

    fn make_viscous_form(&self, stops: fn() -> bool) -> Option<Form> {
        let Some(tip) = self.tip_dashpot else { return Some(Form::zero(2 * self.blocks())) };
        let c = &self.functionals[tip].rows[1];
        self.generator.lyapunov(|i, k| c[i] * c[k], stops)
    }

    /// The contribution of each channel's load to the damping form.
    fn damped_drives(&self) -> &[Option<DampedDrive>; CHANNELS] {
        let make = || self.response.damped_drives(self.damping_form(), &self.generator);
        self.damped_drives.get_or_init(make)
    }

    /// For each load `b f` that acts and is not zero: the load, the polynomial part of `2 b.Q y` with the damping form
    /// `Q`, and the repeated integrals of the coefficients `2 b.Q`.
    pub(crate) fn damped_loads<'a>(
        &'a self,
        loads: &'a [Poly; CHANNELS],
        driven: &'a Driven,
    ) -> impl Iterator<Item = (&'a Poly, Poly, &'a [Vec<f64>])> {
        let acting = loads.iter().zip(self.damped_drives());
        acting.filter(|(load, _)| !load.is_constant() || load.0[0] != 0.0).filter_map(
            move |(load, drive)| {
                let DampedDrive { row, statics, integrals } = drive.as_ref()?;
                let mut poly = Poly::default();
                self.response.add_poly(row, statics, loads, driven, &mut poly);
                Some((load, poly, &integrals[..]))
            },
        )
    }

    /// Value of the damping form for the whole state without translation, at `t`, where the modal vector is `z`.
    pub(crate) fn damping_of_whole(
        &self,
        loads: &[Poly; CHANNELS],
        driven: &Driven,
        (t, z): (f64, &[f64]),
    ) -> f64 {
        let mut y = z.to_vec();
        self.response.add(loads, driven, t, &mut y);
        self.damping_form().of(&y)
    }

    /// True if any of the loads that act on the system varies.
    pub(crate) fn varies(&self, loads: &[Poly; CHANNELS]) -> bool {
        self.response.varies(loads)
    }

    /// True if the two sets of loads differ in one that acts on the system.
    pub(crate) fn differ(&self, one: &[Poly; CHANNELS], other: &[Poly; CHANNELS]) -> bool {
        self.response.differ(one, other)
    }

    /// True if a body can move steadily under constant loads against a dashpot.
    pub fn is_braked(&self) -> bool {
        self.generator.braked
    }
}

/// An interrupt check that never interrupts, for forms that are computed when they are read.
fn never() -> bool {
    false
}

fn prepare(slot: &OnceLock<Form>, make: impl FnOnce() -> Option<Form>) -> Result<(), Error> {
    if slot.get().is_none() {
        let form = make().ok_or(Error::Cancelled)?;
        slot.get_or_init(|| form);
    }
    Ok(())
}
