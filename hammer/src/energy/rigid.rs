//! The integrals over an interval in which a rigid hammer is expanded with the air.

use crate::laws::rock::Coefficients;
use crate::modal::system::TAYLOR;
use crate::motion::{Course, Part};
use crate::numerics::poly::Poly;
use crate::numerics::series::{HIGH, LOW, value};
use crate::scene::graph::{CHANNELS, Channel};
use std::array::from_fn;
use std::sync::Arc;

/// The polynomials of an interval.
#[derive(Debug)]
pub(crate) struct RigidInterval {
    course: Arc<Course>,
    /// Feed force, N, and gravity, m/s2: coefficients in the time since the start of the interval.
    others: [[f64; LOW]; 2],
}

impl RigidInterval {
    pub fn new(course: &Arc<Course>, loads: &[Poly; CHANNELS]) -> Self {
        let other = |channel: Channel| from_fn(|k| loads[channel as usize].0[k]);
        Self { course: course.clone(), others: [Channel::Feed, Channel::Gravity].map(other) }
    }

    /// The interval up to `t`.
    pub fn part(&self, t: f64) -> Part {
        self.course.part(t)
    }

    /// The work of the load of each channel along the displacements of piston and bit, J.
    pub fn works(&self, part: &Part) -> [[f64; 2]; CHANNELS] {
        let [drive, anvil] = part.works();
        let [feed, gravity] = self.others.each_ref().map(|load| part.works_of(load));
        let mut works = [[0.0; 2]; CHANNELS];
        works[Channel::Drive as usize] = drive;
        works[Channel::Anvil as usize] = anvil;
        works[Channel::Feed as usize] = feed;
        works[Channel::Gravity as usize] = gravity;
        works
    }

    /// Displacement of the tip at the start and at `t`, m.
    pub fn tip(&self, t: f64) -> [f64; 2] {
        [self.course.start()[0][1], self.course.at(t)[0][1]]
    }

    /// `int p'^2 dt` of the tip up to `t`, m2/s.
    pub fn bit_square(&self, t: f64) -> f64 {
        value(&self.course.bit_square(), t / self.course.length)
    }

    /// Force of a spring with a dashpot on this displacement, over the part of the interval between two instants (s).
    pub fn force(
        &self,
        shares: [f64; 2],
        line: Coefficients,
        [from, to]: [f64; 2],
    ) -> [f64; TAYLOR] {
        let place = self.course.poly(shares);
        let rate = place.derivative();
        let force = place.0.iter().zip(rate.0).map(|(x, v)| line.force(*x, v));
        let mut poly = Poly::default();
        poly.0.iter_mut().zip(force).for_each(|(c, force)| *c = force);
        let part = poly.shifted(from).scaled(to - from).0;
        from_fn(|k| part.get(k).copied().unwrap_or(0.0))
    }
}

const _: () = assert!(HIGH < TAYLOR);
