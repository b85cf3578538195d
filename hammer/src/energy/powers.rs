//! Rates of the energies.

use super::ledger::Energies;
use crate::laws::event::Displacement;
use crate::motion::Motion;
use crate::scene::graph::CHANNELS;
use crate::scene::graph::Channel;

impl Energies {
    /// Rates at the present instant, W.
    ///
    /// Works are force times velocity; stored and dissipated energies follow their laws. With modal
    /// displacements `q` and angular frequencies `w` of the free bars, strain changes by
    /// `sum w^2 q q'` and damping by `beta sum w^2 q'^2`. The rest of the works goes into kinetic
    /// energy, so the residual's rate is zero.
    pub(crate) fn rates(motion: &Motion) -> Self {
        let (state, graph, tracks) = (motion.state(), motion.graph(), motion.present());
        let point = |displacement| motion.point(&tracks, displacement, state.now);
        let loads = state.loads.map(|load| load.at(state.now));
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
