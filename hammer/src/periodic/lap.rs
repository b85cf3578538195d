//! One turn of the return map.

use crate::laws::event::Event;
use crate::laws::mode::Relay;
use crate::machine::Machine;
use crate::machine::ledger::Energies;
use crate::machine::peaks::Peaks;
use crate::periodic::fault::CycleError;
use crate::periodic::point::Point;
use crate::quantities::inputs::Input;
use crate::quantities::parameters::Source;
use crate::tangent::leg::{Leg, Moment};
use crate::tangent::{Strike, Tangents};

/// An input from an instant of the period on: that value and those derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// From the start of the period, s.
    pub at: f64,
    /// Which.
    pub input: Input,
    /// Value and derivatives there.
    pub derivatives: Vec<f64>,
}

/// Inputs over one period, piece by piece: what a drive without a relay repeats.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schedule {
    /// s.
    pub period: f64,
    /// In order of time.
    pub pieces: Vec<Piece>,
}

/// From a point on the section to the next.
#[derive(Debug)]
pub(crate) struct Lap {
    pub end: Point,
    /// Rate of change of the vector at the end.
    pub rate: Vec<f64>,
    pub period: f64,
    pub advance: f64,
    pub strikes: Vec<Strike>,
    pub energies: Energies,
    /// Their rates at the end, W.
    pub powers: Energies,
    pub tape: Vec<(Leg, Option<Moment>)>,
    pub peaks: [f64; 2],
}

/// How sections follow each other.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    pub schedule: Option<Schedule>,
    pub laps: usize,
    /// A lap that takes longer does not come back, s.
    pub limit: f64,
}

impl Lap {
    /// Its events, in their order.
    pub(crate) fn sequence(&self) -> Vec<Event> {
        self.tape.iter().filter_map(|(_, m)| m.as_ref().map(|m| m.event)).collect()
    }
}

fn turns_to_drive(moment: &Moment) -> bool {
    moment.event == Event::Relay(Relay::Drive)
}

impl Course {
    /// True if the section moves with the state (a relay), false if with the clock.
    pub(crate) fn is_free(&self) -> bool {
        self.schedule.is_none()
    }

    pub(crate) fn check(&self, machine: &Machine) -> Result<(), CycleError> {
        let source = machine.parameters().drive.source;
        if source == Source::Chambers {
            return Err(CycleError::Chambers);
        }
        let relay = source == Source::Relay;
        match &self.schedule {
            None if relay => Ok(()),
            None => Err(CycleError::NoSchedule),
            Some(_) if relay => Err(CycleError::NotScheduled),
            Some(schedule) => {
                let (mut last, end) = (0.0, schedule.period);
                let ordered = schedule.pieces.iter().all(|piece| {
                    let fits = piece.at >= last && piece.at < end;
                    last = piece.at;
                    fits
                });
                let sound = end.is_finite() && end > 0.0 && ordered;
                if sound { Ok(()) } else { Err(CycleError::Disordered { period: end }) }
            }
        }
    }

    /// To the next section, from where the machine stands.
    pub(crate) fn run(&self, machine: &mut Machine) -> Result<Lap, CycleError> {
        machine.settle()?;
        let start = machine.motion().milestone();
        let begun = machine.energies();
        let mut tangents = Tangents::from_here(machine, &[])?;
        tangents.tape = Some(Vec::new());
        let mut peaks = [0.0; 2];
        for _ in 0..self.laps {
            self.once(machine, &mut tangents, &mut peaks)?;
        }
        machine.settle()?;
        let end = machine.motion().milestone();
        let done = machine.energies();
        let point = Point::of(machine.motion());
        let tape = tangents.tape.unwrap_or_default();
        Ok(Lap {
            rate: point.rate(machine),
            end: point,
            period: end.time.since(start.time),
            advance: end.hole.since(start.hole),
            strikes: strikes(&tape, start.time.value()),
            energies: spent(&begun, &done),
            tape,
            powers: machine.powers(),
            peaks,
        })
    }

    fn once(
        &self,
        machine: &mut Machine,
        tangents: &mut Tangents,
        peaks: &mut [f64; 2],
    ) -> Result<(), CycleError> {
        let start = machine.time();
        let mut advance = |tangents: &mut Tangents, machine: &mut Machine, to: f64| {
            let done = tangents.advance(machine, to);
            let Peaks { contact_force, rock_force } = machine.peaks();
            *peaks = [peaks[0].max(contact_force), peaks[1].max(rock_force)];
            done
        };
        let Some(schedule) = &self.schedule else {
            tangents.stop = Some(turns_to_drive);
            tangents.stopped = false;
            advance(tangents, machine, start + self.limit)?;
            return if tangents.stopped {
                Ok(())
            } else {
                Err(CycleError::NoReturn { after: self.limit, stalled: machine.stalled() })
            };
        };
        for piece in &schedule.pieces {
            let at = (start + piece.at).max(machine.time());
            advance(tangents, machine, at)?;
            tangents.set_input(machine, piece.input, &piece.derivatives)?;
        }
        advance(tangents, machine, start + schedule.period)?;
        tangents.arrive(machine);
        Ok(())
    }
}

/// The blows of a tape, as [`crate::tangent`] tells their derivatives.
fn strikes(tape: &[(Leg, Option<Moment>)], start: f64) -> Vec<Strike> {
    let mut list: Vec<Strike> = Vec::new();
    for moment in tape.iter().filter_map(|(_, moment)| moment.as_ref()) {
        if moment.strikes {
            let (speed, energy) = (moment.blow.speed, moment.blow.energy);
            list.push(Strike { time: moment.time - start, speed, energy, rebound: 0.0 });
        } else if moment.event == Event::Contact
            && moment.mode.closed
            && let Some(last) = list.last_mut()
        {
            last.rebound = -moment.piston[1];
        }
    }
    list
}

fn spent(start: &Energies, end: &Energies) -> Energies {
    Energies {
        drive: end.drive - start.drive,
        gravity: end.gravity - start.gravity,
        feed: end.feed - start.feed,
        kinetic: end.kinetic - start.kinetic,
        strain: end.strain - start.strain,
        contact: end.contact - start.contact,
        rock_stored: end.rock_stored - start.rock_stored,
        rock_dissipated: end.rock_dissipated - start.rock_dissipated,
        viscous: end.viscous - start.viscous,
        damping: end.damping - start.damping,
        retuned: end.retuned - start.retuned,
        residual: end.residual - start.residual,
    }
}
