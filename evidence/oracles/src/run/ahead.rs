//! Looks ahead along the present flow until a guard that has risen is decided.

use super::{Place, Run};
use crate::law::Guard;
use crate::linear::Real;
use crate::record::{GivenUp, INSTANT};

/// Largest number of series for which a guard that has risen is followed beyond an action.
const AHEAD: usize = 50;

impl<T: Real> Run<T> {
    /// A guard that has risen is decided under the loads that raised it, not under those after an action. Returns
    /// true if it crosses; the run is then at the crossing, after its transition.
    pub(super) fn settle(&mut self) -> Result<bool, GivenUp> {
        let now = self.place.time;
        if self
            .guard_perturbation
            .is_some_and(|(guard_perturbation, _)| !guard_perturbation.settles)
        {
            return Ok(false);
        }
        match self.decided(None, now) {
            Some((guard, place)) => self.pass(&guard, place).map(|()| true),
            None => Ok(false),
        }
    }

    /// The first of the crossings before `now` and the one that was `found`. A guard that rose before is followed
    /// along the present flow, whatever else happens, until it is decided.
    pub(super) fn decided(
        &mut self,
        mut found: Option<(Guard<T>, Place<T>)>,
        now: T,
    ) -> Option<(Guard<T>, Place<T>)> {
        let mut ahead: Option<Self> = None;
        for _ in 0..AHEAD {
            let pending = &ahead.as_ref().unwrap_or(self).pending;
            let until = found.as_ref().map_or(now, |(_, place)| place.time);
            let is_open = |place: &Place<T>| (until - place.time).to_f64() > 0.0;
            if !pending.iter().flatten().any(is_open) {
                return found;
            }
            let ahead = ahead.get_or_insert_with(|| self.clone());
            let series = ahead.series();
            let (x, change) = ahead.stride(&series);
            let next = ahead.first_crossing(&series, x.to_f64());
            found = match (next, found) {
                (Some(next), Some(found)) if !precedes(&next, &found) => Some(found),
                (next, found) => next.filter(|(_, place)| is_open(place)).or(found),
            };
            let (state, works) = series.at(x);
            let time = ahead.place.time + x * T::from(ahead.unit);
            ahead.place = Place { time, state, works };
            if let Some(change) = change {
                ahead.flow_as(change);
            }
        }
        self.dropped = self.near_miss();
        found
    }
}

/// True if a transition comes before another; simultaneous ones are in the order of their ranks.
pub(super) fn precedes<T: Real>(
    (a, at): &(Guard<T>, Place<T>),
    (b, by): &(Guard<T>, Place<T>),
) -> bool {
    let later = (at.time - by.time).to_f64();
    if later.abs() <= INSTANT { a.event.rank() < b.event.rank() } else { later < 0.0 }
}
