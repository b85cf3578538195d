//! Motion and forces at the present instant.

use crate::bodies::bar::Bar;
use crate::laws::event::{Bodies, Displacement};
use crate::laws::mode::Tie;
use crate::laws::rock::Coefficients;
use crate::modal::track::Track;
use crate::motion::{Motion, PointMotion};
use crate::numerics::poly::Poly;
use crate::quantities::parameters::Material;
use crate::quantities::sections::Body;
use crate::scene::graph::CHANNELS;
use crate::scene::graph::{Channel, Edge};

/// Motion and forces at one instant. SI units, positive downward.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Kinematics {
    /// Motion of the piston: its mass-weighted mean.
    pub piston: PointMotion,
    /// Third rate of the piston's mean displacement, m/s3.
    pub piston_jerk: f64,
    /// Motion of the bit, with a drill string if there is one: its mass-weighted mean.
    pub bit: PointMotion,
    /// Third rate of the bit's mean displacement, m/s3.
    pub bit_jerk: f64,
    /// Motion of the bit/rock interface `w1.u`.
    pub tip: PointMotion,
    /// `vr = up_mean - ub_mean - g0`. With a casing, the casing takes the bit's place; with loose joints, the shank
    /// does.
    pub relative: PointMotion,
    /// Third rate of `vr`, m/s3.
    pub relative_jerk: f64,
    /// `y = up_mean - ub_mean - g0`, always relative to the body that the piston strikes, even with a casing.
    pub over_struck: PointMotion,
    /// Motion of the casing: its mass-weighted mean, or 0 without a casing.
    pub casing: PointMotion,
    /// Motion of the gap `g`.
    pub gap: PointMotion,
    /// Contact force `F_C`, N.
    pub contact_force: f64,
    /// Rate of `F_C`, N/s.
    pub contact_force_rate: f64,
    /// Second rate of `F_C`, N/s2.
    pub contact_force_acceleration: f64,
    /// Rock force `F_R`, N.
    pub rock_force: f64,
    /// Rate of `F_R`, N/s.
    pub rock_force_rate: f64,
    /// Drive force `F_A`, N.
    pub applied_drive_force: f64,
    /// First and second rate of `F_A`, N/s and N/s2.
    pub applied_drive_force_rates: [f64; 2],
    /// `uu` at the last unloading, m.
    pub tip_depth: f64,
    /// Force of the chuck on the casing, N; positive where the shoulder presses on the bit.
    pub chuck_force: f64,
    /// Rate of the chuck's force, N/s.
    pub chuck_force_rate: f64,
}

/// Motion and stress along the bodies, from top to bottom. Nodes are the ends of the mesh's spans
/// ([`crate::Sections::nodes`]), whatever the degree of the mesh. Stresses are those at the middles of the spans.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Profile {
    /// Displacement (m) and velocity (m/s) of the piston's nodes; a rigid body has one.
    pub piston: Vec<[f64; 2]>,
    /// Displacement (m) and velocity (m/s) of the bit's nodes. The node at a loose joint is that of the lower rod.
    pub bit: Vec<[f64; 2]>,
    /// Axial stress `E (u' + beta v')` in the piston's spans, tension positive, Pa. The axial force is this stress
    /// times the section's area. Empty for a rigid body.
    pub piston_stress: Vec<f64>,
    /// Axial stress in the bit's spans, tension positive, Pa.
    pub bit_stress: Vec<f64>,
    /// Displacement (m) and velocity (m/s) of the casing's nodes; empty without a casing.
    pub casing: Vec<[f64; 2]>,
    /// Axial stress in an elastic casing's spans, tension positive, Pa.
    pub casing_stress: Vec<f64>,
}

impl Kinematics {
    /// Motion and forces at the present instant.
    pub(crate) fn of(motion: &Motion) -> Self {
        let (state, graph) = (&motion.state, motion.graph());
        let present = Present::of(motion);
        let frame = Bodies::one(graph.frame);
        let [piston, bit] = [Bodies::PISTON, graph.string()].map(|bodies| present.mean(bodies));
        let reference = if frame == graph.string() { bit } else { present.mean(frame) };
        let [drive, drive_rate, drive_acceleration] = present.loads[Channel::Drive as usize];
        let [contact, chuck] = Tie::REPORTED.map(|tie| present.tie(tie));
        let (tip, gap) = (present.tip, contact.x);
        let origin = state.origin.value();
        let place = |x: f64, bodies| origin + x + motion.ahead(Displacement::Mean(bodies));
        let point = |displacement, [_, velocity, acceleration, _]: [f64; 4]| PointMotion {
            displacement,
            velocity,
            acceleration,
        };
        // Only a dashpot needs the third rate.
        let [.., jerk] = match contact.line.viscosity > 0.0 {
            true => motion.rates::<4>(&present.tracks, Displacement::Tie(Tie::Contact), state.now),
            false => [0.0; 4],
        };
        let difference: [f64; 4] = std::array::from_fn(|k| piston[k] - reference[k]);
        let relative = point(difference[0] + motion.ahead(Displacement::Relative), difference);
        let casing = match graph.is_framed() {
            true => point(place(reference[0], frame), reference),
            false => PointMotion::default(),
        };
        let over_struck = match graph.over_struck() {
            Displacement::Relative => relative,
            place => {
                let point = motion.point(&present.tracks, place, state.now);
                PointMotion { displacement: point.displacement + motion.ahead(place), ..point }
            }
        };
        let initial = motion.parameters().contact.initial_gap;
        Self {
            piston: point(
                origin + piston[0] + initial + motion.ahead(Displacement::PISTON),
                piston,
            ),
            piston_jerk: piston[3],
            bit: point(place(bit[0], graph.string()), bit),
            bit_jerk: bit[3],
            tip: PointMotion { displacement: origin + tip.displacement, ..tip },
            relative,
            relative_jerk: difference[3],
            over_struck,
            casing,
            gap,
            contact_force: contact.force[0],
            contact_force_rate: contact.force[1],
            contact_force_acceleration: -contact.line.force(gap.acceleration, jerk),
            rock_force: present.rock[0],
            rock_force_rate: present.rock[1],
            applied_drive_force: drive,
            applied_drive_force_rates: [drive_rate, drive_acceleration],
            tip_depth: motion.milestone().hole.value(),
            chuck_force: chuck.force[0],
            chuck_force_rate: chuck.force[1],
        }
    }
}

/// Loads and forces at the present instant.
struct Present<'a> {
    motion: &'a Motion,
    tracks: Vec<Track>,
    /// Each load (N; m/s2 for gravity), with its first and second rate.
    loads: [[f64; 3]; CHANNELS],
    tip: PointMotion,
    /// `F_R` and its rate, N and N/s.
    rock: [f64; 2],
    ties: Vec<PresentTie>,
}

/// A tie at the present instant.
#[derive(Clone, Copy, Default)]
struct PresentTie {
    x: PointMotion,
    /// Stiffness and viscosity that act at present.
    line: Coefficients,
    /// Force that pushes the tie's bodies apart, and its rate, N and N/s.
    force: [f64; 2],
}

impl<'a> Present<'a> {
    fn of(motion: &'a Motion) -> Self {
        let (state, tracks) = (&motion.state, motion.present());
        let point = |displacement| motion.point(&tracks, displacement, state.now);
        let (tip, line) = (point(Displacement::Tip), motion.tip_line());
        let forces = |line: Coefficients, x: PointMotion| {
            [line.force(x.displacement, x.velocity), line.force(x.velocity, x.acceleration)]
        };
        let tie = |edge: &Edge| {
            let x = point(Displacement::Tie(edge.tie));
            let line = edge.law.acting(state.mode.ties.of(edge.tie));
            PresentTie { x, line, force: forces(line, x).map(|force| -force) }
        };
        let rates = |load: Poly| {
            let rate = load.derivative();
            [load, rate, rate.derivative()].map(|poly| poly.at(state.now))
        };
        Self {
            ties: motion.graph().ties.iter().map(tie).collect(),
            loads: motion.loads().map(rates),
            rock: forces(line, tip),
            tip,
            motion,
            tracks,
        }
    }

    fn tie(&self, tie: Tie) -> PresentTie {
        let mut edges = self.motion.graph().ties.iter().zip(&self.ties);
        edges.find(|(edge, _)| edge.tie == tie).map(|(_, present)| *present).unwrap_or_default()
    }

    /// Mean displacement of a set of bodies in the engine, m, and three rates. The second and third rate follow from
    /// the forces on the bodies.
    fn mean(&self, bodies: Bodies) -> [f64; 4] {
        let graph = self.motion.graph();
        let now = self.motion.state.now;
        let mean = self.motion.point(&self.tracks, Displacement::Mean(bodies), now);
        let mut total = [0.0; 2];
        let mut add = |factor: f64, [force, rate]: [f64; 2]| {
            total[0] += factor * force;
            total[1] += factor * rate;
        };
        let loads = graph.loaded.iter().filter(|(_, loaded, _)| loaded.within(bodies));
        for (_, _, parts) in loads {
            for (channel, (part, load)) in parts.iter().zip(&self.loads).enumerate() {
                if channel != Channel::Gravity as usize {
                    add(*part, [load[0], load[1]]);
                }
            }
        }
        for (edge, tie) in graph.ties.iter().zip(&self.ties) {
            let [above, below] =
                [edge.upper.is_some_and(|body| bodies.have(body)), bodies.have(edge.lower)];
            add(f64::from(u8::from(below)) - f64::from(u8::from(above)), tie.force);
        }
        if bodies.have(graph.bit) {
            add(-1.0, self.rock);
        }
        let mass = graph.mass(bodies);
        let gravity = self.loads[Channel::Gravity as usize][0];
        [mean.displacement, mean.velocity, gravity + total[0] / mass, total[1] / mass]
    }
}

impl Profile {
    /// Stresses in a body's spans, and displacement and velocity of its nodes.
    pub fn along(&self, body: Body) -> (&[f64], &[[f64; 2]]) {
        match body {
            Body::Piston => (&self.piston_stress, &self.piston),
            Body::Bit => (&self.bit_stress, &self.bit),
            Body::Casing => (&self.casing_stress, &self.casing),
        }
    }

    /// The profile at the present instant.
    pub(crate) fn of(motion: &Motion) -> Self {
        let (state, graph) = (&motion.state, motion.graph());
        let whole = motion.whole_state();
        let (q, v) = whole.split_at(whole.len() / 2);
        let Material { youngs_modulus: e, damping_time: beta, .. } = motion.parameters().material;
        let along = |(body, first, bar): (usize, usize, &Bar), gap: f64| {
            let range = first..first + bar.len();
            let shift = state.origin.value() + (gap - graph.lifted(body, &state.mode.ties));
            let (q, v) = (&q[range.clone()], &v[range]);
            let nodes: Vec<_> = bar.nodal(q, v).iter().map(|[u, v]| [shift + u, *v]).collect();
            let strains = bar.strains(q, v);
            let stress = strains.iter().map(|[strain, rate]| e * (strain + beta * rate));
            (nodes, stress.collect::<Vec<_>>())
        };
        let gap = motion.parameters().contact.initial_gap;
        let mut bodies = graph.bodies_of(graph.all());
        let (piston, piston_stress) =
            bodies.next().map(|body| along(body, gap)).unwrap_or_default();
        let (mut bit, mut bit_stress) = (Vec::new(), Vec::new());
        let (mut casing, mut casing_stress) = (Vec::new(), Vec::new());
        for body in bodies {
            let (nodes, stress) = along(body, 0.0);
            if graph.string().have(body.0) {
                bit.pop(); // At a joint, the node of the lower body replaces that of the upper one.
                bit.extend(nodes);
                bit_stress.extend(stress);
            } else if body.0 == graph.frame {
                (casing, casing_stress) = (nodes, stress);
            }
        }
        Self { piston, bit, piston_stress, bit_stress, casing, casing_stress }
    }
}
