//! Transitions: how an event changes the mode, and how the state moves with it.
//!
//! At an event a track is converted to displacements and velocities of the bodies' modes, the law
//! changes, and the track is converted to the system of the new mode:
//!
//! ```text
//! contact   closes: [bit], [piston] -> [both]       opens: [both] -> [bit], [piston]
//! chuck     the same of bit and casing
//! joint     the same of two rods
//! rock      spring and origin of the track that ends at the tip
//! drive     loads alone
//! ```

use super::Motion;
use crate::error::Error;
use crate::laws::air::Opening;
use crate::laws::event::Displacement;
use crate::laws::event::{Event, RockEvent};
use crate::laws::mode::{Chamber, Chuck, Port, Relay};
use crate::laws::rock::{Spring, Transition};
use crate::modal::driven::Driven;
use crate::modal::passage::Passage;
use crate::modal::span::Span;
use crate::modal::system::System;
use crate::modal::track::Track;
use crate::motion::state::Anchor;
use crate::numerics::combine;
use crate::numerics::kernel;
use crate::quantities::parameters::{Rock, Source};
use crate::quantities::sections::MAX_RODS;
use std::sync::Arc;

/// Bound on the rounding of a transition. The state goes through two bases, each term with
/// [`combine::roundings`] (30 for a hundred modes) of half an `eps`, and is evaluated before and
/// after; entries of the bases are sums themselves, and 190 roundings were observed. The theorem
/// holds for any value. If it were too low, a guard would be taken again and again at once, which
/// Zeno detection turns into an error. If it were too high, a guard that starts that far above its
/// level would be tracked as if it were not above it.
const LEFT: f64 = 256.0;

impl Motion {
    /// Makes the systems that a transition leads to; nothing is changed.
    ///
    /// # Errors
    /// As [`Model::system`](crate::modal::model::Model::system).
    pub(crate) fn prepare(&self, event: Event) -> Result<(), Error> {
        let mut mode = self.state.mode;
        match event {
            Event::Contact => mode.closed = !mode.closed,
            Event::Chuck(chuck) => mode.chuck = chuck,
            Event::Joint { joint, to } => mode.joints.0[usize::from(joint)] = to,
            Event::Rock(event) => mode.rock = self.state.memory.next(event, self.rock()),
            Event::Relay(_)
            | Event::Port { .. }
            | Event::Opening { .. }
            | Event::Level(_)
            | Event::Vent(_) => {
                return Ok(());
            }
        }
        if self.model.chain.joints > 0 {
            for span in self.model.chain.spans(mode) {
                self.model.system(span, mode)?;
            }
        }
        let system = self.model.system(self.model.chain.at_tip(mode), mode)?;
        if Spring::of(mode.rock) == Spring::Viscous && self.rock().viscosity > 0.0 {
            system.prepare_viscous_form()?;
        }
        Ok(())
    }

    fn rock(&self) -> &Rock {
        &self.model.parameters.rock
    }

    /// Q9, Q10.
    pub(crate) fn switch_relay(&mut self) {
        self.state.mode.relay = self.state.mode.relay.turned();
        self.reload();
    }

    /// The piston passes a port, from which on it is as open as this, if air flows through it.
    pub(crate) fn switch_port(&mut self, chamber: Chamber, port: Port, opening: Opening) {
        if let Some(air) = &mut self.state.air {
            air.openings[chamber as usize][port as usize] = opening;
            return;
        }
        let law = self.model.parameters.chambers.of(chamber);
        self.state.gas[chamber as usize].switch(law, port);
        self.reload();
    }

    /// The bit hangs out beyond the idle travel: the drive is vented, its gas at the exhaust's
    /// pressure. Or it no longer does: the relay drives, the ports are as the piston's place has them.
    pub(crate) fn switch_vent(&mut self, vented: bool) {
        self.state.mode.vented = vented;
        self.state.mode.relay = Relay::Drive;
        if self.parameters().drive.source == Source::Chambers {
            let vr = self.point(&self.tracks, self.relative(), 0.0).displacement;
            let vr = vr + self.ahead(self.relative());
            let laws = &self.parameters().chambers;
            self.state.gas = if vented { laws.vented() } else { laws.start(vr) };
        }
        let (outside, [vr, _]) = (self.outside(0.0), self.in_cylinder(&self.tracks, 0.0));
        if let Some(air) = &mut self.state.air {
            air.vent(&self.model.parameters, vr, vented, outside);
        }
        self.reload();
    }

    /// A chamber's pressure is at its level.
    pub(crate) fn reach_level(&mut self, chamber: Chamber) {
        self.state.gas[chamber as usize].arrive();
        self.reload();
    }

    /// Q11: opens or closes the contact; the tracks stand at the epoch.
    pub(crate) fn switch_contact(&mut self) -> Result<(), Error> {
        self.rotate_to_epoch();
        let closed = &mut self.state.mode.closed;
        *closed = !*closed;
        self.regroup()
    }

    /// Bit and casing meet, or part; the tracks of both stand at the epoch.
    pub(crate) fn switch_chuck(&mut self, chuck: Chuck) -> Result<(), Error> {
        let law = self.model.parameters.chuck;
        let before = law.offset(std::mem::replace(&mut self.state.mode.chuck, chuck));
        self.displace_casing(law.offset(chuck));
        self.regroup()?;
        self.displace_casing(-before);
        Ok(())
    }

    /// Two rods meet, or part; their tracks stand at the epoch.
    pub(crate) fn switch_joint(&mut self, joint: u8, to: Chuck) -> Result<(), Error> {
        let (law, upper) = (self.parameters().joint(), usize::from(joint) + 1);
        let tie = &mut self.state.mode.joints.0[usize::from(joint)];
        let before = law.offset(std::mem::replace(tie, to));
        self.displace_above(upper, law.offset(to));
        self.regroup()?;
        self.displace_above(upper, -before);
        Ok(())
    }

    /// Moves the piston and the bodies of a drill string down to that one, which part from what is
    /// below.
    fn displace_above(&mut self, last: usize, by: f64) {
        let end = self.model.range(Span::Piston).end;
        let bodies = self.model.string.iter().take(last);
        let end = bodies.fold(end, |end, body| end + body.len());
        for index in 0..self.tracks.len() {
            let span = self.state.anchors[index].span;
            if self.model.range(span).end <= end {
                self.state.anchors[index].driven.translation.0[0] += by * self.root(span);
            }
        }
    }

    /// The square root of a span's mass: the coordinate of its translation by 1 m.
    fn root(&self, span: Span) -> f64 {
        self.model.bodies_of(span).fold(0.0, |mass, (_, body)| mass + body.mass).sqrt()
    }

    /// Moves a casing that is tied to nothing.
    fn displace_casing(&mut self, by: f64) {
        if let (Some(index), Some(casing)) = (self.flying(Span::Casing), &self.model.casing) {
            self.state.anchors[index].driven.translation.0[0] += by * casing.mass.sqrt();
        }
    }

    /// Puts the bodies on the systems of the present ties; those whose system stays the same are
    /// left alone.
    fn regroup(&mut self) -> Result<(), Error> {
        let spans = self.model.chain.spans(self.state.mode);
        let gone = |index: &usize| !spans.contains(&self.state.anchors[*index].span);
        let from: Vec<Standing> =
            (0..self.tracks.len()).filter(gone).map(|index| self.standing(index)).collect();
        // What may fail comes first: then nothing is changed.
        let system = |span: &Span| self.model.system(*span, self.state.mode);
        let systems = spans.iter().map(system).collect::<Result<Vec<_>, _>>()?;
        let most = spans.len();
        let mut tracks = std::mem::replace(&mut self.tracks, Vec::with_capacity(most));
        let mut anchors = std::mem::replace(&mut self.state.anchors, Vec::with_capacity(most));
        let mut made = [false; MAX_RODS + 2];
        for ((made, &span), system) in made.iter_mut().zip(&spans).zip(systems) {
            if let Some(same) = anchors.iter().position(|anchor| anchor.span == span) {
                self.tracks.push(tracks.swap_remove(same));
                self.state.anchors.push(anchors.swap_remove(same));
                continue;
            }
            let (z, driven) = (Vec::new(), Driven::default());
            self.state.anchors.push(Anchor { span, z, at: 0.0, driven, form: 0.0 });
            self.tracks.push(Track { system, z: Vec::new(), at: 0.0 });
            *made = true;
        }
        for (index, &span) in spans.iter().enumerate().filter(|(index, _)| made[*index]) {
            let shares = |old: &&Standing| self.model.overlap(old.span, span).count > 0;
            let from: Vec<&Standing> = from.iter().filter(shares).collect();
            self.carry(index, span, &from, None)?;
        }
        Ok(())
    }

    /// Q1 to Q8; the tip's track stands at the epoch.
    pub(crate) fn switch_rock(&mut self, event: RockEvent) -> Result<(), Error> {
        let steady = self.is_calm(0);
        let is_turn = matches!(event, RockEvent::DissipativeTurn | RockEvent::Turn);
        let [p, drift] = self.tip(steady);
        // Only these events need the uncertainty of the position.
        let error = if is_turn { self.tip_rounding(drift) } else { 0.0 };
        let before = self.spring();
        let transition = self.state.memory.transit(event, p, error, &self.model.parameters.rock);
        self.state.mode.rock = transition.mode;
        self.state.psi = 0.0; // No event of the rock continues a viscous part.
        let after = Spring::of(transition.mode);
        if before == after && transition.shift == 0.0 {
            return Ok(());
        }
        self.state.origin.move_by(transition.shift);
        for index in 1..self.tracks.len() {
            let root = self.root(self.state.anchors[index].span);
            let moved = &mut self.state.anchors[index].driven.translation;
            moved.0[0] -= transition.shift * root;
        }
        let span = self.model.chain.at_tip(self.state.mode);
        let from = self.state.anchors[0].span;
        if steady && let Some(way) = self.model.passage(from, span, self.state.mode)? {
            return self.pass(span, &way, transition);
        }
        let before = self.standing(0);
        self.carry(0, span, &[&before], Some(transition))
    }

    /// The tip's displacement at the epoch, and its part that does not oscillate.
    fn tip(&self, steady: bool) -> [f64; 2] {
        let (track, anchor) = (&self.tracks[0], &self.state.anchors[0]);
        let Some(tip) = anchor.span.share(Displacement::Tip) else { return [0.0; 2] };
        let functional = &track.system.functionals[tip];
        let drift = if steady {
            let moved = functional.rigid * anchor.driven.translation.0[0];
            moved + functional.strain(&self.state.loads)
        } else {
            self.poly(0, tip).0[0]
        };
        [drift + kernel::dot(&functional.rows[0], &track.z), drift]
    }

    /// Bound on the rounding of the tip's displacement.
    fn tip_rounding(&self, drift: f64) -> f64 {
        let (track, anchor) = (&self.tracks[0], &self.state.anchors[0]);
        let Some(tip) = anchor.span.share(Displacement::Tip) else { return 0.0 };
        let weights = &track.system.functionals[tip].weights[0];
        let terms = drift.abs() + kernel::bound(weights, &track.z);
        0.5 * f64::EPSILON * combine::roundings(track.z.len()) as f64 * terms
    }

    /// Puts the tip's track on the system of `span` without its static part, which constant loads
    /// produce before and after.
    fn pass(&mut self, span: Span, way: &Passage, moved: Transition) -> Result<(), Error> {
        let system = self.model.system(span, self.state.mode)?;
        let loads = self.state.loads.each_ref().map(|load| load.0[0]);
        let (track, anchor) = (&mut self.tracks[0], &mut self.state.anchors[0]);
        let mut old = std::mem::take(&mut track.z);
        track.system.add_translation(&anchor.driven, &mut old);
        let mut y = std::mem::take(&mut anchor.z);
        y.resize(2 * system.blocks(), 0.0);
        way.apply_moving(&old, loads, &mut y);
        anchor.z = old; // Its memory is reused.
        if moved.shift != 0.0 {
            self.displace(span, &system, -moved.shift, &mut y);
            if let Some(tip) = span.share(Displacement::Tip) {
                let strain = system.functionals[tip].strain(&self.state.loads);
                let off = moved.tip - system.displacement(tip, &y) - strain;
                self.displace(span, &system, off, &mut y);
            }
        }
        let driven = system.take_translation(&self.state.loads, &mut y);
        self.settle(0, span, system, y, driven);
        Ok(())
    }

    /// The state of track `index` at the epoch.
    fn standing(&self, index: usize) -> Standing {
        let (track, anchor) = (&self.tracks[index], &self.state.anchors[index]);
        let (system, mut y) = (track.system.clone(), track.z.clone());
        system.add_driven(&self.state.loads, &anchor.driven, 0.0, &mut y);
        Standing { span: anchor.span, system, y }
    }

    /// Puts track `index` on the system of `span`, with the state of its bodies `from`; a
    /// transition of the rock moves the origin of displacements.
    fn carry(
        &mut self,
        index: usize,
        span: Span,
        from: &[&Standing],
        moved: Option<Transition>,
    ) -> Result<(), Error> {
        let system = self.model.system(span, self.state.mode)?;
        let mut y = vec![0.0; 2 * system.blocks()];
        let shift = moved.map_or(0.0, |transition| transition.shift);
        if !self.carry_straight(span, from, &mut y)? {
            let mut state = vec![0.0; 2 * system.modes()];
            for old in from {
                let mut left = vec![0.0; 2 * old.system.modes()];
                old.system.to_bodies(&old.y, &mut left);
                let (q, v) = left.split_at(old.system.modes());
                self.model.overlap(old.span, span).copy([q, v], &mut state);
            }
            self.translations(span).for_each(|(mode, root)| state[mode] -= shift * root);
            system.to_modal(&state, &mut y);
        } else if shift != 0.0 {
            self.displace(span, &system, -shift, &mut y);
        }
        if let Some(transition) = moved.filter(|_| shift != 0.0) {
            // For a deep hole and a small force the shift is uncertain by the rounding of the
            // depth.
            if let Some(tip) = span.share(Displacement::Tip) {
                let off = transition.tip - system.displacement(tip, &y);
                self.displace(span, &system, off, &mut y);
            }
        }
        let driven = system.take_driven(&self.state.loads, &mut y);
        self.settle(index, span, system, y, driven);
        Ok(())
    }

    /// Moves all bodies of a span.
    fn displace(&self, span: Span, system: &System, by: f64, y: &mut [f64]) {
        let each = self.translations(span);
        each.for_each(|(mode, root)| system.displace(mode, by * root, y));
    }

    /// Writes to `y` the sum of what each of `from` contributes, directly between the bases; false
    /// if there is no direct way, and `y` must be computed via the bodies' modes.
    fn carry_straight(&self, span: Span, from: &[&Standing], y: &mut [f64]) -> Result<bool, Error> {
        let way = |old: &Standing| self.model.passage(old.span, span, self.state.mode);
        let [first, others @ ..] = from else { return Ok(true) };
        let Some(straight) = way(first)? else { return Ok(false) };
        straight.apply(&first.y, y);
        for old in others {
            let Some(straight) = way(old)? else { return Ok(false) };
            let mut part = vec![0.0; y.len()];
            straight.apply(&old.y, &mut part);
            kernel::add(y, 1.0, &part);
        }
        Ok(true)
    }

    /// Bound on the rounding of a functional at the start of track `index`, of a displacement
    /// (`order` 0) or a velocity (1): [`LEFT`] roundings, plus the effect of the basis's mismatch,
    /// of all that the free modes or the system's own modes contribute.
    pub(crate) fn rounding(&self, index: usize, functional: usize, order: usize) -> f64 {
        let (track, anchor) = (self.at_anchor(index), &self.state.anchors[index]);
        let (system, standing) = (&track.system, self.standing(index));
        let state = self.body_state(&track, index, anchor.at);
        let (displacements, velocities) = state.split_at(state.len() / 2);
        let modes = self.model.ends(anchor.span);
        let rates = modes.iter().map(|[_, rate]| *rate);
        let slowest = rates.filter(|rate| *rate > 0.0).fold(f64::INFINITY, f64::min);
        let own = kernel::bound(&system.functionals[functional].weights[order], &standing.y);
        let [mut sum, mut swing, mut all] = [own, 0.0f64, 0.0];
        for ((q, v), [end, rate]) in displacements.iter().zip(velocities).zip(&modes) {
            // A basis mixes displacements and velocities.
            let (speed, slow) = (v.abs() + rate * q.abs(), rate.max(slowest));
            sum += end * if order == 0 { q.abs() + v.abs() / slow } else { speed };
            swing = swing.max(speed);
            all += end / if order == 0 { slow } else { 1.0 };
        }
        LEFT * f64::EPSILON * sum + system.mismatch() * (swing * all + own)
    }

    /// Overlap of the bodies that rounding cannot distinguish from a gap, m.
    pub(crate) fn least_overlap(&self) -> f64 {
        let tracks = 0..self.tracks.len();
        let shares = tracks.filter_map(|i| Some((i, self.share(i, Displacement::Gap)?)));
        let rounding: f64 = shares.map(|(index, share)| self.rounding(index, share, 0)).sum();
        rounding.max(self.model.resolutions[0])
    }

    /// The uniform translation of each body of a span: its mode, and the square root of its mass.
    fn translations(&self, span: Span) -> impl Iterator<Item = (usize, f64)> + use<'_> {
        let start = self.model.range(span).start;
        self.model.bodies_of(span).map(move |(first, body)| (first - start, body.mass.sqrt()))
    }
}

/// The state of a track at an instant, with what loads contribute.
struct Standing {
    span: Span,
    system: Arc<System>,
    y: Vec<f64>,
}
