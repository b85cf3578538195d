//! Windows of the air, solved together with the moving steel.

use super::Motion;
use crate::air::series::{LONGEST, Left, Problem};
use crate::air::steel::{Block, Steel};
use crate::air::{Air, Places, volumes};
use crate::error::Error;
use crate::laws::air::{KAPPA, Side};
use crate::laws::event::Displacement;
use crate::laws::mode::Tie;
use crate::modal::system::visible::VisibleBlock;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::numerics::series::LOW;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::Parameters;
use crate::scene::graph::{CHANNELS, Channel, Group};
use std::array::from_fn;
use std::sync::Arc;

/// Limit of the attempts to solve a window. Each changes the formula of one flow.
const TRIALS: u64 = 64;
/// Limit of the steps towards a zero of the pressure outside, and the shortest step, s.
const MARCH: usize = 64;
const INSTANT: f64 = 1e-9;
/// Share of the allowed error that all quasi-static oscillations together may cause.
const UNSEEN: f64 = 0.2;
/// An oscillation is expanded, not taken as quasi-static, if otherwise it would limit the window to fewer radians of
/// its own motion.
const RADIANS: f64 = 3.0;

/// The error for air that cannot be solved beyond this time. It has the piston's position at that time.
pub(super) fn beyond(parameters: &Parameters, time: f64, [x, y]: Places) -> Error {
    let (air, drive) = (&parameters.air, &parameters.drive);
    let top = -air.cylinder - air.drive.dead_volume / drive.area_drive;
    let bottom = air.returning.dead_volume / drive.area_return;
    // The position of the chamber that has less room left.
    let place = if bottom - y < x - top { y } else { x };
    Error::Air { time, place, range: [top, bottom] }
}

/// Pressures of supply and exhaust.
pub(super) fn outside(inputs: &Inputs) -> [&Poly; 2] {
    [Input::SupplyPressure, Input::ExhaustPressure].map(|input| inputs.of(input))
}

impl Motion {
    /// The air in the chambers, if air drives the piston.
    pub(crate) fn air(&self) -> Option<&Air> {
        self.state.air.as_deref()
    }

    /// Pressures of supply and exhaust at `t` after the epoch, Pa.
    pub(crate) fn outside(&self, t: f64) -> [f64; 2] {
        outside(&self.state.inputs).map(|poly| poly.at(t))
    }

    /// Positions of the piston that set the chambers' volumes, and as many of their rates as are asked for, at
    /// `t` after the epoch, to which `tracks` are rotated.
    pub(crate) fn in_cylinder<const COUNT: usize>(
        &self,
        tracks: &[super::Track],
        t: f64,
    ) -> [Places; COUNT] {
        let of = |displacement| {
            let mut rates: [f64; COUNT] = self.rates(tracks, displacement, t);
            rates[0] += self.ahead(displacement);
            rates
        };
        let x = of(Displacement::Relative);
        let y = if self.graph().is_framed() { of(Displacement::OverStruck) } else { x };
        from_fn(|order| [x[order], y[order]])
    }

    /// Changes the air at the epoch. `change` is given the parameters, the piston's positions and the exhaust's
    /// pressure.
    pub(super) fn change_air(&mut self, change: impl FnOnce(&mut Air, &Parameters, Places, f64)) {
        let ([_, exhaust], [places]) = (self.outside(0.0), self.in_cylinder(&self.tracks, 0.0));
        if let Some(air) = &mut self.state.air {
            change(air, &self.model.parameters, places, exhaust);
        }
        self.reload();
    }

    /// The present forces of the air on the piston and on the bit.
    pub(super) fn air_forces(&self, air: Option<&Air>) -> [Poly; 2] {
        let acting = |channel: Channel| match air {
            Some(Air { vented: Some(_), .. }) => Poly::default(),
            _ => self.state.loads[channel as usize],
        };
        [Channel::Drive, Channel::Anvil].map(acting)
    }

    /// Solves the window of the air that begins at the epoch, if there is air and the chambers are not vented. Returns
    /// the number of series.
    ///
    /// # Errors
    /// [`Error::Air`], [`Error::Vacuum`].
    pub(crate) fn renew_air(&mut self) -> Result<u64, Error> {
        let known = self.cylinder.take();
        let (until, input) = self.positive_until();
        if until < 2.0 * INSTANT {
            return Err(Error::Vacuum { time: self.state.epoch.value(), name: input.name() });
        }
        if self.air().is_none_or(|air| air.vented.is_some()) {
            return Ok(0);
        }
        let pair = self.pair();
        match (&pair, self.course()) {
            (Some(_), None) => self.follow_bodies(),
            (None, Some(_)) => self.leave_bodies()?,
            _ => {}
        }
        let Some(mut air) = self.state.air.take() else { return Ok(0) };
        let of_epoch = || self.in_cylinder(&self.tracks, 0.0);
        let motion @ [places, _] = known.unwrap_or_else(of_epoch);
        for index in 0..self.tracks.len() {
            if self.is_whole(index) {
                let (track, driven) = (&mut self.tracks[index], &self.state.anchors[index].driven);
                track.system.add_driven(&self.state.loads, driven, 0.0, &mut track.z);
            }
        }
        let sides = air.sides(self.parameters(), places, self.outside(0.0), 0.0);
        air.classify(self.parameters(), &sides);
        let mut steel = std::mem::take(&mut self.steel);
        let left = match pair {
            Some(pair) => self.bodies(pair, &mut steel),
            None => self.visible(&air, motion, &sides, &mut steel),
        };
        let (outside, [x, y]) = (outside(&self.state.inputs), self.positions());
        let parameters = &self.model.parameters;
        let problem = Problem { parameters, steel: &steel, left, apart: x != y, places, outside };
        let series = self.series.get_or_insert_default();
        let (mut solved, mut trial) = (Err(None), 0);
        while trial < TRIALS {
            trial += 1;
            solved = air.window(&problem, series, &mut self.window);
            let Err(Some((path, bound))) = solved else { break };
            air.regimes[path] = air.regimes[path].next(bound);
        }
        if let Ok(window) = &mut solved
            && window.reach > until
        {
            (window.reach, window.then) = (until, None);
        }
        if let (Ok(window), Some(course)) = (&solved, &mut self.state.course) {
            series.follow(&problem, window.length, Arc::make_mut(course));
        }
        let is_pressed = self.state.course.is_none();
        let of_window = || solved.as_ref().ok().map(|window| series.forces(window.length));
        let forces = is_pressed.then(of_window);
        self.steel = steel;
        let is_solved = solved.is_ok();
        air.window = solved.ok();
        self.state.air = Some(air);
        if let Some(forces) = forces {
            self.press(&forces.unwrap_or_else(|| self.air_forces(self.air())));
            self.note_polys();
        }
        if is_solved {
            return Ok(trial);
        }
        Err(beyond(self.parameters(), self.state.epoch.value(), places))
    }

    /// True if the air's window begins with the whole state of the track, which is not that of a lone piston.
    fn is_whole(&self, index: usize) -> bool {
        let [x, y] = self.positions();
        self.state.anchors[index].group != Group::PISTON
            && (self.share(index, x).is_some() || x != y && self.share(index, y).is_some())
    }

    /// The piston's positions that set the chambers' volumes.
    fn positions(&self) -> [Displacement; 2] {
        [Displacement::Relative, self.graph().over_struck()]
    }

    /// How long after the epoch the pressures of supply and exhaust are certainly positive, s, and which of them is
    /// first to lose that certainty. Varying pressures are examined for [`LONGEST`] only.
    pub(super) fn positive_until(&self) -> (f64, Input) {
        let of = |input: Input| {
            let poly = self.state.inputs.of(input);
            if self.still || self.state.air.is_none() || poly.is_constant() {
                return (f64::INFINITY, input);
            }
            // A pressure falls no faster than this.
            let steepest = steepest(poly);
            let mut time = 0.0;
            for _ in 0..MARCH {
                let step = poly.at(time) / steepest;
                if step < INSTANT {
                    break;
                }
                time = LONGEST.min(time + step);
            }
            (time, input)
        };
        let (supply, exhaust) = (of(Input::SupplyPressure), of(Input::ExhaustPressure));
        if exhaust.0 < supply.0 { exhaust } else { supply }
    }

    /// Makes the polynomials of what is guarded, and of the positions in the cylinder, once for the window.
    fn note_polys(&mut self) {
        let [x, y] = self.positions();
        let apart = (y != x).then_some(y);
        let guarded = [Displacement::Tip, Displacement::Tie(Tie::Contact), x];
        for displacement in guarded.into_iter().chain(apart) {
            let Some(place) = self.graph().place(displacement) else { continue };
            for index in 0..self.tracks.len() {
                let (system, anchor) = (&self.tracks[index].system, &self.state.anchors[index]);
                let share = self.graph().share_of_listed(anchor.group, place);
                let Some(functional) = share else { continue };
                // In a rigid hammer the gap is the piston's position, and only the sign differs.
                let mirrored = system.functionals[functional].mirrored;
                let poly = match mirrored.and_then(|other| self.noted(index, other)) {
                    Some(other) => Poly(other.0.map(|c| -c)),
                    None => system.poly(functional, &self.state.loads, &anchor.driven),
                };
                self.polys.push((index, functional, poly));
            }
        }
    }

    /// The polynomial of a functional, if it is noted for the window of air.
    pub(crate) fn noted(&self, index: usize, functional: usize) -> Option<&Poly> {
        let mut known = self.polys.iter();
        known.find(|(i, f, _)| [*i, *f] == [index, functional]).map(|(.., poly)| poly)
    }

    /// Applies the air's forces to the piston and the bit, from the epoch on.
    fn press(&mut self, [drive, anvil]: &[Poly; 2]) {
        let (old, loads) = (self.state.loads, &mut self.state.loads);
        (loads[Channel::Drive as usize], loads[Channel::Anvil as usize]) = (*drive, *anvil);
        self.adopt(&old, Self::is_whole);
    }

    /// Divides the coordinates of the steel into those that are expanded with the air and those that are quasi-static.
    /// A neglected oscillation changes a pressure by at most a share `s`. In a window, this changes
    /// * the contents by at most twice the share `s` of what flows in the time of one radian,
    /// * the piston's speed by at most `2 s / (omega T)` of what a stroke of duration `T` gives,
    /// * its own motion, as that of a spring, by the share `h / T` of the force, over a window of length `h`.
    ///
    /// The sum of the first two over all neglected oscillations stays within [`UNSEEN`] of the allowed error. The third
    /// limits the window.
    fn visible(
        &self,
        air: &Air,
        [places, speeds]: [Places; 2],
        sides: &[Side; 4],
        steel: &mut Steel,
    ) -> Left {
        steel.pair = None;
        let blocks = &mut steel.blocks;
        let (graph, parameters) = (self.graph(), self.parameters());
        let drive = &parameters.drive;
        let own = [Channel::Drive as usize, Channel::Anvil as usize];
        let [supply, exhaust] = self.outside(0.0);
        let loads = &self.state.loads;
        // If a pressure outside has just jumped, it acts at once, before any polynomial contains the jump.
        let mut acting = loads.map(|load| load.0[0]);
        if let Some(forces) = air.forces(parameters, [places, speeds], exhaust) {
            (acting[own[0]], acting[own[1]]) = (forces[0], forces[1]);
        }
        let positions = self.positions();
        let most = self.tracks.iter().map(|track| track.system.blocks()).sum();
        let mut fast = Vec::new();
        blocks.clear();
        let mut left = Left::default();
        left.still.iter_mut().zip(positions).for_each(|(s, position)| s[0] = self.ahead(position));
        left.longest = LONGEST;
        let volumes = volumes(parameters, places);
        let areas = [drive.area_drive, drive.area_return];
        let stirs: [f64; 2] = from_fn(|i| KAPPA * areas[i] / volumes[i]);
        let forces = [areas[0] + areas[1], areas[1]].map(|area| supply.max(exhaust) * area);
        let masses = [graph.frame, 1].map(|body| graph.bodies[body].mass);
        let stroke = (graph.bodies[0].mass * parameters.air.cylinder / forces[0].max(1.0)).sqrt();
        let [jets, opens] = air.haste(parameters, places[0], sides);
        let squeezed = (stirs[0] * speeds[0]).abs().max((stirs[1] * speeds[1]).abs());
        let haste = KAPPA * jets + squeezed + 1.0 / stroke;
        // The rate at which each load may change.
        let change: [f64; CHANNELS] = from_fn(|c| match own.iter().position(|own| *own == c) {
            Some(force) => forces[force] * haste,
            None => steepest(&loads[c]),
        });
        for (index, track) in self.tracks.iter().enumerate() {
            let share = self.share(index, positions[0]);
            let apart = positions[1] != positions[0];
            let shares = [share, if apart { self.share(index, positions[1]) } else { share }];
            if shares == [None; 2] {
                continue;
            }
            let (system, anchor) = (&track.system, &self.state.anchors[index]);
            let n = system.blocks();
            let is_flying = anchor.group == Group::PISTON;
            for block in system.visible(shares) {
                let [x, v, ..] = anchor.driven.translation.0;
                let start = if is_flying && block.is_translation {
                    [x, v]
                } else {
                    [block.index, n + block.index].map(|k| track.z[k])
                };
                let [low, rate] = block.rates;
                if block.is_translation || low <= haste {
                    blocks.push(moving(block, start, loads, own));
                    continue;
                }
                // `swung` is the start of the block's oscillation, measured from its equilibrium under these loads.
                // `lag` is how far the block stays behind forces that change at the rate `haste`.
                let mut swung = start;
                for (load, [p, q]) in acting.iter().zip(block.rest) {
                    swung = [swung[0] - load * p, swung[1] - load * q];
                }
                let mut lag = [0.0; 2];
                for ((rate, behind), further) in
                    change.iter().zip(&block.behind).zip(&block.further)
                {
                    lag = from_fn(|place| {
                        lag[place] + rate * (behind[place] + haste * further[place])
                    });
                }
                let moved: [[f64; 2]; 2] =
                    from_fn(|place| [block.most(place, swung) + lag[place], lag[place]]);
                let stir = |k: usize| {
                    let drag = parameters.air.drag * rate * moved[0][k] / forces[0];
                    larger(stirs[0] * moved[0][k], stirs[1] * moved[1][k]) + drag
                };
                let (shaken, lag) = (stir(0), stir(1));
                fast.reserve(if fast.is_empty() { most } else { 0 });
                let shed = shaken * (jets + 1.0 / stroke) + moved[0][0] * opens;
                let share = |i: usize| masses[i] * block.pushed[own[i]][i];
                let back = larger(share(0), share(1)) * shaken;
                fast.push((rate, 2.0 * shed / low + lag, back, block, start));
            }
        }
        fast.sort_unstable_by(|one, other| other.0.total_cmp(&one.0));
        let allowed = UNSEEN * parameters.air.error;
        let (mut worth, mut back) = (0.0, 0.0);
        let (mut held, mut quick) = ([[0.0; 2]; CHANNELS], [0.0; CHANNELS]);
        for (rate, one, own_back, block, start) in fast {
            let longest = stroke * allowed / (back + own_back);
            if !(worth + one <= allowed && longest * rate >= RADIANS) {
                blocks.push(moving(block, start, loads, own));
                continue;
            }
            (worth, back) = (worth + one, back + own_back);
            if longest < left.longest {
                left.longest = longest;
            }
            for c in 0..CHANNELS {
                (0..2).for_each(|place| held[c][place] += block.held[c][place]);
                quick[c] += block.quick[c];
            }
        }
        left.gives = [0, 1].map(|place| own.map(|c| held[c][place]));
        left.speeds = own.map(|c| quick[c]);
        for (c, load) in loads.iter().enumerate().filter(|(c, _)| !own.contains(c)) {
            for (k, coefficient) in load.0.iter().enumerate().take(LOW) {
                (0..2).for_each(|place| left.still[place][k] += held[c][place] * coefficient);
                left.others[k] += quick[c] * coefficient;
            }
        }
        left
    }
}

/// The larger of two numbers. (The library's function also looks for NaN, which takes longer than everything else that
/// is done with these numbers.)
fn larger(one: f64, other: f64) -> f64 {
    if one > other { one } else { other }
}

/// A bound on the rate of a polynomial within [`LONGEST`].
fn steepest(poly: &Poly) -> f64 {
    let term = |k: usize| k as f64 * poly.0[k].abs() * math::powi(LONGEST, k - 1);
    (1..=poly.degree()).map(term).sum()
}

/// An expanded block that starts in this state, under all loads except the air's own.
fn moving(
    block: &VisibleBlock,
    start: [f64; 2],
    loads: &[Poly; CHANNELS],
    own: [usize; 2],
) -> Block {
    let mut others = [[0.0; 2]; LOW];
    for (c, load) in loads.iter().enumerate().filter(|(c, _)| !own.contains(c)) {
        let push = block.pushes[c];
        if push != [0.0; 2] {
            for (others, load) in others.iter_mut().zip(load.0) {
                (0..2).for_each(|i| others[i] += push[i] * load);
            }
        }
    }
    let pushed = own.map(|c| block.pushes[c]);
    let [a, b, c, d] = block.matrix;
    Block { start, matrix: [[a, c], [b, d]], pushed, others, parts: block.parts }
}
