//! Rates of the energies.

use super::ledger::Energies;
use super::outputs::Kinematics;
use crate::laws::event::Displacement;
use crate::modal::model::Channel;
use crate::motion::Motion;

impl Energies {
    /// Rates at the present instant, W.
    ///
    /// Works are force times velocity; stored and dissipated energies follow their laws. With modal
    /// displacements `q` and angular frequencies `w` of the free bars, strain changes by
    /// `sum w^2 q q'` and damping by `beta sum w^2 q'^2`. The rest of the works goes into kinetic
    /// energy, so the residual's rate is zero.
    pub(crate) fn rates(motion: &Motion, now: &Kinematics) -> Self {
        let parameters = motion.parameters();
        let (state, model, tracks) = (motion.state(), motion.model(), motion.present());
        let load = |channel: Channel| state.loads[channel as usize].at(state.now);
        let point = |displacement| motion.point(&tracks, displacement, state.now);
        let cased = model.casing.as_ref();
        let (top, tip) = (point(Displacement::BitTop).velocity, point(Displacement::Tip));
        let speed = |displacement| cased.map_or(0.0, |_| point(displacement).velocity);
        let [casing, fed] = [Displacement::Casing, Displacement::CasingTop].map(speed);
        let (mut strain, mut damping) = (0.0, 0.0);
        for (index, track) in tracks.iter().enumerate() {
            let body = motion.body_state(track, index, state.now);
            let (q, v) = body.split_at(body.len() / 2);
            let modes = model.omega2();
            let first = model.range(state.anchors[index].span).start;
            for ((w2, q), v) in modes.skip(first).zip(q).zip(v) {
                strain += w2 * q * v;
                damping += w2 * v * v;
            }
        }
        let mut momentum =
            model.piston.mass * now.piston_velocity + model.string_mass() * now.bit_velocity;
        momentum += cased.map_or(0.0, |body| body.mass * casing);
        let mut tied = [0.0; 2];
        for (x, tie) in motion.ties() {
            let x = point(x);
            tied[0] += tie.stored_power(x.displacement, x.velocity);
            tied[1] += tie.lost_power(x.velocity);
        }
        let (spring, rock) = (motion.spring(), &parameters.rock);
        let mut rates = Self {
            drive: load(Channel::Drive) * (now.piston_velocity - casing)
                + load(Channel::Anvil) * (top - casing),
            gravity: load(Channel::Gravity) * momentum,
            feed: load(Channel::Feed) * if cased.is_some() { fed } else { top },
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
