//! Waves in an elastic casing, by characteristics.

use crate::rows::row::{Row, Rows};
use hammer::{
    Error, Event, Fidelity, InputValues, Machine, Parameters, Record, Segment, Source, Tie,
    TieState,
};

/// A feed that presses, N.
const FEED: f64 = 5e3;

const WAVES: &str = "the mesh's error, quintic splines of 8 mm on a front of 1 cm: 1e-4";

/// Waves in the casing after the bit leaves the shoulder, when the lower end of an elastic casing is free. A wave of
/// release goes up, behind which the casing moves at `FS / Z`; a string of impedance `Zs` reflects
/// `(Z - Zs) / (Z + Zs)` of it. The mean velocity therefore grows by `FS / Z` in the first `L / c`, and by
/// `(Z - Zs) / (Z + Zs)` times as much in each of the next two: by nothing if the string has the casing's own
/// impedance.
///
/// # Errors
/// Those of the engine.
pub fn waves() -> Result<Vec<Row>, Error> {
    let mut list = Vec::new();
    for ratio in [0.0, 0.3, 1.0, 4.0] {
        // A casing of 1 m, at rest under the feed, and a bit that a piston drives away.
        let mut p = Parameters { fidelity: Fidelity::Elastic, ..Parameters::default() };
        p.casing.mass = 10.0 * p.bit_mass();
        (p.gravity, p.drive.source, p.mesh.degree) = (0.0, Source::Force, 5);
        let section = Segment { length: 1.0, area: 5.1e-3 };
        p.casing.elements = 120;
        p.casing.segments.set(&[section]);
        let z = p.impedance_of(section.area);
        p.casing.impedance = ratio * z;
        (p.contact.initial_gap, p.piston.initial_velocity, p.rock.stiffness) = (1e-6, 10.0, 1e5);
        let inputs = InputValues { feed_force: FEED, ..InputValues::default() };
        let mut m = Machine::new(&p, &inputs, 0.0)?;
        m.keep_journal(true);
        let parted = loop {
            m.advance(m.time() + 1e-5)?;
            let parts = |record: &Record| record.event == Event::Tie(Tie::Chuck, TieState::Open);
            if let Some(record) = m.take_journal().into_iter().find(parts) {
                break record.time;
            }
        };
        let mut speeds = [0.3, 0.8, 1.3, 2.8];
        for transits in &mut speeds {
            m.advance(parted + *transits / p.wave_speed())?;
            *transits = m.kinematics().casing.velocity;
        }
        let [a, b, c, d] = speeds.map(|speed| speed * z / FEED);
        let mut rows = Rows::new(format!("string of {ratio} Z"), "characteristics", WAVES);
        rows.add("gain in half a transit, FS/Z", 0.5, b - a, 1e-4);
        let back = 1.5 * (1.0 - ratio) / (1.0 + ratio);
        rows.add("gain in 1.5 transits after the first echo, FS/Z", back, d - c, 1e-4);
        list.extend(rows.list);
    }
    Ok(list)
}
