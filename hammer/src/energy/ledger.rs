//! The energy ledger: works, losses and impulses since the start, and the stored energies.
//!
//! ```text
//! work of F_A + gravity + feed = kinetic + strain + contact + recoverable rock
//!                                + rock dissipation + viscous + damping
//! ```
//!
//! Every term is exact ([`crate::modal::stretch`]). So the residual of this balance, which is
//! rounding, checks the decomposition, the transitions and the bookkeeping.

use super::interval::{Forms, Interval, Sums};
use crate::laws::event::Displacement;
use crate::modal::track::Track;
use crate::motion::Motion;
use crate::scene::graph::{CHANNELS, Channel};
use serde::{Deserialize, Serialize};

/// The energy ledger, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Energies {
    /// Work of `F_A` and of the return chamber on the bit. With a frame, also that of the drive's reaction.
    pub drive: f64,
    /// Work of gravity.
    pub gravity: f64,
    /// Work of the feed force.
    pub feed: f64,
    /// Kinetic energy.
    pub kinetic: f64,
    /// Strain energy of the bars.
    pub strain: f64,
    /// Energy of the contact penalty, and of the springs of the other ties.
    pub contact: f64,
    /// Recoverable energy of the rock.
    pub rock_stored: f64,
    /// `(1 - 1/gamma) KR (p - ul) p'` integrated over DFC and FC.
    pub rock_dissipated: f64,
    /// Sum of `psi`.
    pub viscous: f64,
    /// `beta v.K v` integrated, and the losses in ties.
    pub damping: f64,
    /// Energy put in by a change of a tunable parameter.
    pub retuned: f64,
    /// Difference of both sides of the balance, from the energies at the start.
    pub residual: f64,
}

/// A residual below this share of the ledger's turnover is rounding. It is far above the residuals of random scenes
/// and hard cases (`reports/verification.md`), and far below the effect of a wrong term.
const BALANCED: f64 = 1e-8;

impl Energies {
    /// The works and losses of these sums; the stored energies are 0.
    pub(crate) fn of_sums(sums: &Sums) -> Self {
        Self {
            drive: sums.work[Channel::Drive as usize] + sums.work[Channel::Anvil as usize],
            gravity: sums.work[Channel::Gravity as usize],
            feed: sums.work[Channel::Feed as usize],
            rock_dissipated: sums.rock,
            viscous: sums.viscous,
            damping: sums.damping,
            retuned: sums.retuned,
            ..Self::default()
        }
    }

    /// All terms, in the order of the fields.
    pub fn values(&self) -> [f64; 12] {
        let Self { drive, gravity, feed, kinetic, strain, contact, .. } = *self;
        let Self { rock_stored, rock_dissipated, viscous, damping, retuned, residual, .. } = *self;
        let [stored, dissipated] = [rock_stored, rock_dissipated];
        [
            drive, gravity, feed, kinetic, strain, contact, stored, dissipated, viscous, damping,
            retuned, residual,
        ]
    }

    /// The ledger's turnover: the sum of the sizes of all terms, J.
    pub fn turnover(&self) -> f64 {
        self.values()[..11].iter().map(|x| x.abs()).sum()
    }

    /// Bound on the residual by rounding, J. A larger one shows that some term is wrong.
    pub fn residual_bound(&self) -> f64 {
        BALANCED * self.turnover() + f64::MIN_POSITIVE
    }

    /// Rates at the present instant, W.
    ///
    /// Works are force times velocity; stored and dissipated energies follow their laws. With modal displacements `q`
    /// and angular frequencies `w` of the free bars, strain changes by `sum w^2 q q'` and damping by `beta sum w^2
    /// q'^2`. The remaining work becomes kinetic energy, so the residual's rate is zero.
    pub(crate) fn rates(motion: &Motion) -> Self {
        let (state, graph, tracks) = (&motion.state, motion.graph(), motion.present());
        let point = |displacement| motion.point(&tracks, displacement, state.now);
        let loads = motion.loads().map(|load| load.at(state.now));
        let mut work = [0.0; CHANNELS];
        for (displacement, _, parts) in &graph.loaded {
            let v = point(*displacement).velocity;
            graph.add_works(*displacement, parts, |i| loads[i] * v, &mut work);
        }
        let (mut strain, mut damping) = (0.0, 0.0);
        for (index, track) in tracks.iter().enumerate() {
            let body = motion.body_state(track, index, state.now);
            let (q, v) = body.split_at(body.len() / 2);
            for ((w2, q), v) in graph.omega2(state.anchors[index].group.bodies).zip(q).zip(v) {
                strain += w2 * q * v;
                damping += w2 * v * v;
            }
        }
        let mut tied = [0.0; 2];
        for (edge, line) in motion.ties() {
            let x = point(Displacement::Tie(edge.tie));
            tied[0] += line.stored_power(x.displacement, x.velocity);
            tied[1] += line.lost_power(x.velocity);
        }
        let (spring, tip) = (motion.spring(), point(Displacement::Tip));
        let parameters = motion.parameters();
        let rock = &parameters.rock;
        let mut rates = Self {
            drive: work[Channel::Drive as usize] + work[Channel::Anvil as usize],
            gravity: work[Channel::Gravity as usize],
            feed: work[Channel::Feed as usize],
            strain,
            contact: tied[0],
            rock_stored: spring.stored_power(rock, tip.displacement, tip.velocity),
            rock_dissipated: spring.lost_power(rock, tip.displacement, tip.velocity),
            viscous: motion.tip_line().viscosity * tip.velocity * tip.velocity,
            damping: parameters.material.damping_time * damping + tied[1],
            ..Self::default()
        };
        rates.kinetic = rates.drive + rates.gravity + rates.feed
            - (rates.strain + rates.contact + rates.rock_stored)
            - (rates.rock_dissipated + rates.viscous + rates.damping);
        rates
    }
}

/// Impulses since the start, N s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Impulses {
    /// Of `F_C`.
    pub contact: f64,
    /// Of `F_R`.
    pub rock: f64,
}

/// Energy stored in the hammer, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stored {
    kinetic: f64,
    strain: f64,
    contact: f64,
    rock: f64,
}

impl Stored {
    /// The energies of tracks that are rotated to `t` after the epoch.
    pub fn of(motion: &Motion, tracks: &[Track], t: f64) -> Self {
        let (mut kinetic, mut strain) = (0.0, 0.0);
        if let Some(course) = motion.course() {
            let [_, speeds] = course.at(t);
            let bodies = motion.graph().bodies.iter().zip(speeds);
            kinetic = bodies.map(|(bar, speed)| 0.5 * bar.mass * speed * speed).sum();
        }
        for (index, track) in tracks.iter().enumerate() {
            let state = motion.body_state(track, index, t);
            let (q, v) = state.split_at(state.len() / 2);
            let modes = motion.graph().omega2(motion.state.anchors[index].group.bodies);
            for ((w2, q), v) in modes.zip(q).zip(v) {
                strain += 0.5 * w2 * q * q;
                kinetic += 0.5 * v * v;
            }
        }
        let of = |tie| motion.point(tracks, Displacement::Tie(tie), t).displacement;
        let ties = motion.ties().map(|(edge, line)| line.stored_energy(of(edge.tie)));
        let rock = &motion.parameters().rock;
        let p =
            motion.point(tracks.get(..1).unwrap_or_default(), Displacement::Tip, t).displacement;
        Self {
            kinetic,
            strain,
            contact: ties.fold(0.0, |sum, energy| sum + energy),
            rock: motion.spring().stored_energy(rock, p),
        }
    }

    pub fn at_epoch(motion: &Motion) -> Self {
        let mut tracks = motion.tracks.to_vec();
        for track in &mut tracks {
            track.rotate_to(0.0);
        }
        Self::of(motion, &tracks, 0.0)
    }

    pub fn total(&self) -> f64 {
        self.kinetic + self.strain + self.contact + self.rock
    }
}

/// The sums up to the epoch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Sums before the epoch.
    pub sums: Sums,
    /// Mechanical energy at the start, J.
    pub energy_start: f64,
}

impl Ledger {
    /// The sums up to the present, to which the tracks are rotated.
    pub(crate) fn sums_now(&self, motion: &Motion, tracks: &[Track]) -> Sums {
        let mut sums = self.sums;
        let last = Interval::whole(motion, tracks, motion.state.now);
        sums.add(&last.sums(&mut Forms::default()));
        sums.damping += damping_in_flight(motion, tracks);
        sums
    }

    /// Energies and impulses at the present.
    pub(crate) fn now(&self, motion: &Motion) -> (Energies, Impulses) {
        let tracks = motion.present();
        let sums = self.sums_now(motion, &tracks);
        let stored = Stored::of(motion, &tracks, motion.state.now);
        let work: f64 = sums.work.iter().sum();
        let held = stored.total() - self.energy_start;
        let lost = sums.rock + sums.viscous + sums.damping;
        let energies = Energies {
            kinetic: stored.kinetic,
            strain: stored.strain,
            contact: stored.contact,
            rock_stored: stored.rock,
            residual: work + sums.retuned - held - lost,
            ..Energies::of_sums(&sums)
        };
        (energies, Impulses { contact: sums.contact_impulse, rock: sums.rock_impulse })
    }
}

/// Damping work of the flying piston since it was last summed, up to its track's instant, J.
pub(crate) fn damping_in_flight(motion: &Motion, tracks: &[Track]) -> f64 {
    let flown =
        |index: usize| motion.state.anchors[index].form - motion.damping_form(&tracks[index]);
    motion.flying().map_or(0.0, flown)
}
