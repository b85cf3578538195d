//! A piston between a relay and a bit that throws it back, in closed form.
//!
//! A piston of mass `m` leaves the bit with the share `e` of its impact speed `v`, is lifted by `F`, turns
//! at the height `S` and comes back after the time `T`:
//!
//! ```text
//! W = m v^2 / 2,    W (1 - e^2) = 2 F D
//! w^2 = (e v)^2 + 2 (F/m - g) D,    S = D + w^2 / (2 (F/m + g))
//! T = (w - e v) / (F/m - g) + (w + v) / (F/m + g)
//! ```
//!
//! A bit that follows the piston takes more than the blow's energy: then `e^2`, the share that is returned,
//! is below 0 in the first line, and 0 in the others.

/// A relay and a piston.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relay {
    /// Mass of the piston `m`, kg.
    pub mass: f64,
    /// Force `F`, N.
    pub force: f64,
    /// Stroke of the relay `D`, m.
    pub lift: f64,
    /// Gravity `g`, m/s2.
    pub gravity: f64,
}

/// A blow of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throw {
    /// `W`, J.
    pub energy: f64,
    /// `v`, m/s.
    pub speed: f64,
    /// `S`, m.
    pub height: f64,
    /// `T`, s.
    pub period: f64,
}

impl Relay {
    /// The blow, for a returned share `e^2` below 1; `None` if the force does not lift the piston.
    pub fn throw(&self, returned: f64) -> Option<Throw> {
        let Self { mass, force, lift, gravity } = *self;
        let [up, down] = [force / mass - gravity, force / mass + gravity];
        let energy = 2.0 * force * lift / (1.0 - returned);
        let speed = (2.0 * energy / mass).sqrt();
        let back = returned.max(0.0).sqrt() * speed;
        let switch = (back * back + 2.0 * up * lift).sqrt();
        let period = (switch - back) / up + (switch + speed) / down;
        let height = lift + switch * switch / (2.0 * down);
        (up > 0.0 && down > 0.0 && period.is_finite()).then_some(Throw {
            energy,
            speed,
            height,
            period,
        })
    }

    /// The returned share `e^2` at which a blow has this energy (J).
    pub fn returned(&self, energy: f64) -> f64 {
        (1.0 - 2.0 * self.force * self.lift / energy).clamp(-1.0, 0.98)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No rebound, no gravity: `T = (2 + 2 sqrt 2) sqrt(m D / F)`, and the piston turns at `2 D`.
    #[test]
    fn without_rebound_and_gravity_it_is_the_relay_against_a_fixed_bit() {
        let relay = Relay { mass: 3.4, force: 1800.0, lift: 0.05, gravity: 0.0 };
        let throw = relay.throw(0.0).expect("a blow");
        let time = (3.4 * 0.05 / 1800.0f64).sqrt();
        assert!((throw.period / ((2.0 + 2.0 * 2f64.sqrt()) * time) - 1.0).abs() < 1e-14);
        assert!((throw.height / 0.1 - 1.0).abs() < 1e-14);
        assert!((relay.returned(throw.energy)).abs() < 1e-14);
        // A blow of less energy than the relay puts in returns less than nothing, and has that energy.
        let weak = relay.throw(relay.returned(150.0)).expect("a blow");
        assert!((weak.energy / 150.0 - 1.0).abs() < 1e-14 && relay.returned(150.0) < 0.0);
        assert_eq!(Relay { gravity: 1e3, ..relay }.throw(0.0), None);
    }
}
