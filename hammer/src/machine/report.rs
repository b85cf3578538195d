//! What a scene shows: motion, energies, impulses, and the story of its blows.

use crate::machine::Machine;
use crate::machine::ledger::{Stretch, Sums};
use crate::machine::observe::{Blow, Energies, Impulses, Kinematics, Profile};
use crate::machine::state::Milestone;
use crate::modal::model::{self, Span};
use crate::modal::system::System;
use crate::numerics::kernel;
use crate::numerics::poly::Poly;
use crate::physics::bar::Bar;
use crate::physics::mode::RockMode;
use crate::physics::rock::Spring;
use crate::search::guard::Track;

impl Machine {
    /// The tracks rotated from the last event to the present.
    pub(crate) fn present(&self) -> Vec<Track> {
        self.tracks
            .iter()
            .zip(&self.state.anchors)
            .map(|(track, anchor)| {
                let mut track =
                    Track { system: track.system.clone(), z: anchor.z.clone(), at: anchor.at };
                track.rotate_to(self.state.now);
                track
            })
            .collect()
    }

    /// Static and translating part of a displacement of a track, after the epoch.
    pub(crate) fn poly(&self, index: usize, system: &System, functional: usize) -> Poly {
        let translation = &self.state.anchors[index].translation;
        system.functionals[functional].poly(&self.state.loads, translation)
    }

    /// A displacement and its first two rates, of a track standing at `t`.
    fn motion(&self, track: &Track, index: usize, functional: usize, t: f64) -> [f64; 3] {
        let f = &track.system.functionals[functional];
        let mut poly = self.poly(index, &track.system, functional);
        std::array::from_fn(|k| {
            let value = poly.at(t) + kernel::dot(&f.rows[k], &track.z);
            poly = poly.derivative();
            value
        })
    }

    /// The tip's displacement and rates; track 0 must stand at `t`.
    pub(crate) fn tip(&self, t: f64) -> [f64; 3] {
        self.motion(&self.tracks[0], 0, model::TIP, t)
    }

    /// Motion and forces now.
    pub fn kinematics(&mut self) -> &Kinematics {
        if self.views.kinematics.is_none() {
            self.views.kinematics = Some(self.look());
        }
        self.views.kinematics.get_or_insert_default()
    }

    fn look(&self) -> Kinematics {
        let (t, tracks) = (self.state.now, self.present());
        let state = &self.state;
        let main = |functional| self.motion(&tracks[0], 0, functional, t);
        let (tip, bit) = (main(model::TIP), main(model::BIT_MEAN));
        let (gap, piston) = if state.mode.closed {
            (main(model::GAP), main(model::PISTON_MEAN))
        } else {
            let lower = self.motion(&tracks[1], 1, model::PISTON_GAP, t);
            let upper = main(model::GAP);
            let gap = std::array::from_fn(|k| upper[k] + lower[k]);
            (gap, self.motion(&tracks[1], 1, model::PISTON_ALONE_MEAN, t))
        };
        let parameters = &self.model.parameters;
        let (k, c) = Spring::of(state.mode.rock).coefficients(&parameters.rock);
        let stiffness = if state.mode.closed { self.model.contact } else { 0.0 };
        let origin = state.origin.value();
        let force = -stiffness * gap[0];
        let rock = k * tip[0] + c * tip[1];
        let drive = state.loads[model::DRIVE].at(t);
        let feed = state.loads[model::FEED].at(t);
        let fall = parameters.gravity;
        let (ap, ab) = (
            fall + (drive - force) / self.model.piston.mass,
            fall + (feed + force - rock) / self.model.bit.mass,
        );
        Kinematics {
            piston_position: origin + piston[0] + parameters.contact.initial_gap,
            piston_velocity: piston[1],
            piston_acceleration: ap,
            bit_position: origin + bit[0],
            bit_velocity: bit[1],
            bit_acceleration: ab,
            bit_tip_position: origin + tip[0],
            bit_tip_velocity: tip[1],
            bit_tip_acceleration: tip[2],
            relative_position: piston[0] - bit[0],
            relative_velocity: piston[1] - bit[1],
            relative_acceleration: ap - ab,
            contact_gap: gap[0],
            contact_gap_rate: gap[1],
            contact_force: force,
            contact_force_rate: -stiffness * gap[1],
            rock_force: rock,
            rock_force_rate: k * tip[1] + c * tip[2],
            applied_drive_force: drive,
            hole_depth: self.milestone().hole.value(),
        }
    }

    /// Nodal displacements and velocities now (a rigid body has one node).
    pub fn profile(&mut self) -> Profile {
        let tracks = self.present();
        let (p, b) = (self.model.piston.len(), self.model.bit.len());
        let (mut q, mut v) = (vec![0.0; p + b], vec![0.0; p + b]);
        for (index, track) in tracks.iter().enumerate() {
            let hub = self.hub(track, index, self.state.now);
            let range = self.model.range(self.state.anchors[index].span);
            q[range.clone()].copy_from_slice(&hub[..range.len()]);
            v[range.clone()].copy_from_slice(&hub[range.len()..]);
        }
        let origin = self.state.origin.value();
        let nodes = |bar: &Bar, q: &[f64], v: &[f64], shift: f64| {
            bar.nodal(q, v).iter().map(|[u, v]| [shift + u, *v]).collect()
        };
        let lift = origin + self.model.parameters.contact.initial_gap;
        Profile {
            piston: nodes(&self.model.piston, &q[..p], &v[..p], lift),
            bit: nodes(&self.model.bit, &q[p..], &v[p..], origin),
        }
    }

    /// `z.Q z` of a track: the damping work to come.
    pub(crate) fn damping_form(&self, index: usize) -> f64 {
        let track = &self.tracks[index];
        self.form_of(track)
    }

    fn form_of(&self, track: &Track) -> f64 {
        if self.model.parameters.material.damping_time == 0.0 {
            return 0.0;
        }
        track.system.damping_form().of(&track.z)
    }

    /// Damping work of a track since it was last summed, up to where it stands.
    pub(crate) fn damping_left(&self, index: usize) -> f64 {
        self.state.anchors[index].form - self.damping_form(index)
    }

    /// Sums from the epoch to `at`, where track 0 of `tracks` stands. The piston's damping
    /// in flight is summed when the flight ends.
    pub(crate) fn stretch_sums(&self, tracks: &[Track], at: f64) -> Sums {
        let state = &self.state;
        let anchor = &state.anchors[0];
        let main = Stretch::new(&tracks[0], &anchor.z, at, &state.loads, &anchor.translation);
        let rock = &self.model.parameters.rock;
        let (k, c) = Spring::of(state.mode.rock).coefficients(rock);
        let mut sums = Sums {
            damping: main.damping([anchor.form, self.form_of(&tracks[0])]),
            ..Default::default()
        };
        let (drive, feed, fall) =
            (&state.loads[model::DRIVE], &state.loads[model::FEED], &state.loads[model::GRAVITY]);
        let bit_fall = self.model.bit.mass * main.work(model::BIT_MEAN, fall);
        let (driven, piston_fall) = if state.mode.closed {
            sums.contact_impulse = -self.model.contact * main.integral(model::GAP);
            (main.work(model::PISTON_MEAN, drive), main.work(model::PISTON_MEAN, fall))
        } else {
            let (flight, z) = (&state.anchors[1], &tracks[1].z);
            let piston = Stretch {
                system: &tracks[1].system,
                start: z,
                end: z,
                span: at,
                loads: &state.loads,
                translation: &flight.translation,
            };
            let mean = model::PISTON_ALONE_MEAN;
            (piston.work(mean, drive), piston.work(mean, fall))
        };
        sums.work =
            [driven, main.work(model::TOP, feed), self.model.piston.mass * piston_fall + bit_fall];
        if k > 0.0 {
            let end = self.motion(&tracks[0], 0, model::TIP, at)[0];
            let start = end - main.change(model::TIP);
            sums.rock_impulse = k * main.integral(model::TIP) + c * (end - start);
            if matches!(state.mode.rock, RockMode::DissipativeForward | RockMode::Forward) {
                sums.rock =
                    0.5 * (1.0 - 1.0 / rock.unloading_ratio) * k * (end - start) * (end + start);
            }
            if c > 0.0 {
                let start = main.system.viscous_form().of(main.start);
                sums.viscous = c * main.tip_square(model::TIP, start);
            }
        }
        sums
    }

    /// Sums up to the present.
    fn sums_now(&self, tracks: &[Track]) -> Sums {
        let mut sums = self.state.sums;
        sums.add(&self.stretch_sums(tracks, self.state.now));
        if let Some(piston) = tracks.get(1) {
            sums.damping += self.state.anchors[1].form - self.form_of(piston);
        }
        sums
    }

    /// The ledger now.
    pub fn energies(&mut self) -> Energies {
        self.ledger().0
    }

    fn ledger(&mut self) -> (Energies, Impulses) {
        if let Some(ledger) = self.views.ledger {
            return ledger;
        }
        let tracks = self.present();
        let sums = self.sums_now(&tracks);
        let [kinetic, strain, contact, rock_stored] = self.stored(&tracks, self.state.now);
        let work: f64 = sums.work.iter().sum();
        let held = kinetic + strain + contact + rock_stored - self.state.energy_start;
        let lost = sums.rock + sums.viscous + sums.damping;
        let energies = Energies {
            drive: sums.work[model::DRIVE],
            gravity: sums.work[model::GRAVITY],
            feed: sums.work[model::FEED],
            kinetic,
            strain,
            contact,
            rock_stored,
            rock_dissipated: sums.rock,
            viscous: sums.viscous,
            damping: sums.damping,
            retuned: sums.retuned,
            residual: work + sums.retuned - held - lost,
        };
        let impulses = Impulses { contact: sums.contact_impulse, rock: sums.rock_impulse };
        *self.views.ledger.insert((energies, impulses))
    }

    /// Kinetic, strain, contact and recoverable rock energy of tracks standing at `t`.
    fn stored(&self, tracks: &[Track], t: f64) -> [f64; 4] {
        let (mut kinetic, mut strain) = (0.0, 0.0);
        let mut gap = 0.0;
        for (index, track) in tracks.iter().enumerate() {
            let span = self.state.anchors[index].span;
            let hub = self.hub(track, index, t);
            let n = hub.len() / 2;
            let modes = self.model.piston.omega2.iter().chain(&self.model.bit.omega2);
            let range = self.model.range(span);
            for (i, w2) in modes.skip(range.start).take(range.len()).enumerate() {
                strain += 0.5 * w2 * hub[i] * hub[i];
                kinetic += 0.5 * hub[n + i] * hub[n + i];
            }
            if let Span::Both(_) = span {
                gap = self.motion(track, index, model::GAP, t)[0];
            }
        }
        let rock = &self.model.parameters.rock;
        let p = self.motion(&tracks[0], 0, model::TIP, t)[0];
        let stored = match Spring::of(self.state.mode.rock) {
            Spring::Free => 0.0,
            Spring::Loading | Spring::Viscous => {
                0.5 * rock.stiffness * p * p / rock.unloading_ratio
            }
            Spring::Unloading => 0.5 * rock.unloading_ratio * rock.stiffness * p * p,
        };
        [kinetic, strain, 0.5 * self.model.contact * gap * gap, stored]
    }

    /// Stored energy at the epoch.
    pub(crate) fn mechanical_energy(&self) -> f64 {
        let at_epoch: Vec<Track> = self
            .tracks
            .iter()
            .map(|track| {
                let mut track = track.clone();
                track.rotate_to(0.0);
                track
            })
            .collect();
        self.stored(&at_epoch, 0.0).iter().sum()
    }

    /// Impulses since the start.
    pub fn impulses(&mut self) -> Impulses {
        self.ledger().1
    }

    /// The last blow.
    pub fn blow(&self) -> &Blow {
        &self.state.blow
    }

    /// The contact opens at the epoch.
    pub(crate) fn note_opening(&mut self) {
        let epoch = self.state.epoch;
        self.state.opened = Some(epoch);
        if let Some(start) = self.state.collision {
            self.state.blow.contact_duration = epoch.since(start);
        }
    }

    /// The contact closes at the epoch; both tracks stand there or before.
    pub(crate) fn note_closing(&mut self) {
        let epoch = self.state.epoch;
        let scales = self.model.parameters.timescales();
        let same = 2.0 * (scales.piston_transit + scales.bit_transit);
        self.tracks[1].rotate_to(0.0);
        if self.state.opened.is_some_and(|opened| epoch.since(opened) <= same) {
            return;
        }
        self.state.collision = Some(epoch);
        self.state.counters.contacts += 1;
        let piston = self.motion(&self.tracks[1], 1, model::PISTON_ALONE_MEAN, 0.0)[1];
        let bit = self.motion(&self.tracks[0], 0, model::BIT_MEAN, 0.0)[1];
        if piston > 0.0 {
            self.note_blow(piston - bit);
        }
    }

    fn note_blow(&mut self, speed: f64) {
        let here = self.milestone();
        let state = &mut self.state;
        state.counters.blows += 1;
        let blow = &mut state.blow;
        blow.time = here.time.value();
        blow.speed = speed;
        blow.energy = 0.5 * self.model.piston.mass * speed * speed;
        let advance = |from: &Milestone| (here.hole.since(from.hole), here.time.since(from.time));
        if let Some(last) = &state.blows[1] {
            (blow.penetration, blow.period) = advance(last);
            blow.rop = blow.penetration / blow.period;
        }
        if let Some(first) = &state.blows[0] {
            let (depth, time) = advance(first);
            blow.rop_mean = depth / time;
        }
        state.blows[0].get_or_insert(here);
        state.blows[1] = Some(here);
    }
}
