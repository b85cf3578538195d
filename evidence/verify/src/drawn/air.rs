//! Air drawn for a scene.

use crate::comparison::bodies;
use crate::drawn::draws::{log, or_zero};
use hammer::{AirChamber, AirLaw, Fidelity, InputValues, Parameters, Source};
use proptest::prelude::*;

/// Drawn numbers of an air drive: lengths, areas and volumes over others.
#[derive(Clone, Debug)]
pub(crate) struct AirRow {
    /// True for rigid bodies, which the reference can follow for the most blows.
    rigid: bool,
    /// Gap, m; faces over the section, and the return's over the drive's.
    size: (f64, f64, f64),
    /// Dead volumes over the volume that the face sweeps through the gap; the cylinder's travel beyond the gap, and
    /// the height of the ports, over the gap.
    shares: [f64; 4],
    /// Edges of the ports over the gap, some of them outside the stroke.
    edges: Vec<f64>,
    /// Areas of supply, exhaust and leak over the smaller face.
    openings: [f64; 3],
    /// Discharge, and drag over the piston's mass, 1/s.
    losses: (f64, f64),
    /// Temperature, K, and pressures outside, Pa.
    outside: [f64; 3],
    error: f64,
}

/// The smallest dead volume, m3.
const LEAST_DEAD: f64 = 1e-6;

pub(crate) fn air() -> impl Strategy<Value = AirRow> {
    let shares = [log(1e-3, 1.0), log(1e-3, 1.0), log(0.02, 2.0), log(0.01, 0.3)];
    let edge = prop_oneof![4 => 0.02..1f64, 1 => -0.3..0.02f64, 1 => 1.0..1.5f64];
    let edges = prop::collection::vec(edge, 4);
    let openings = [or_zero(1e-3, 0.3), or_zero(1e-3, 0.3), or_zero(1e-5, 1e-2)];
    let outside = [log(200.0, 600.0), log(1e5, 1e7), log(1e4, 1e6)];
    let losses = (log(0.1, 1.0), or_zero(1e-3, 10.0));
    let size = (log(1e-3, 0.3), log(0.03, 1.0), log(0.5, 2.0));
    let rest = (any::<bool>(), log(1e-11, 1e-8));
    (rest, size, shares, edges, openings, losses, outside).prop_map(
        |((rigid, error), size, shares, edges, openings, losses, outside)| AirRow {
            rigid,
            size,
            shares,
            edges,
            openings,
            losses,
            outside,
            error,
        },
    )
}

/// Sets the air of a scene. Its gap is made wide enough that the bodies do not close it when the air, the feed and
/// `held` (N) strain them.
pub(crate) fn set_air(
    (p, inputs): (&mut Parameters, &mut InputValues),
    row: AirRow,
    loose: bool,
    held: f64,
) {
    let [drive_dead, return_dead, beyond, height] = row.shares;
    let (gap, face, ratio) = row.size;
    let [temperature, supply, exhaust] = row.outside;
    if row.rigid && !loose {
        p.fidelity = Fidelity::Rigid;
    }
    p.drive.source = Source::Air;
    p.drive.area_drive = face * p.cross_section;
    p.drive.area_return = ratio * p.drive.area_drive;
    (inputs.supply_pressure, inputs.exhaust_pressure) = (supply, exhaust);
    // Without a load, rounding would decide whether the bit stands.
    if inputs.feed_force == 0.0 {
        inputs.feed_force = 1.0;
    }
    let push =
        supply.max(exhaust) * (p.drive.area_drive.max(p.drive.area_return) + p.drive.area_return);
    let gap = gap.max(4.0 * (push + inputs.feed_force.abs() + held) * bodies::compliance(p));
    p.contact.initial_gap = gap;
    let chamber = |dead: f64, area: f64, k: usize| AirChamber {
        dead_volume: (dead * gap * area).max(LEAST_DEAD),
        supply: -gap * row.edges[k],
        exhaust: -gap * row.edges[k + 1],
    };
    let [supply_area, exhaust_area, leakage_area] =
        row.openings.map(|part| part * p.drive.area_drive.min(p.drive.area_return));
    p.air = AirLaw {
        drive: chamber(drive_dead, p.drive.area_drive, 0),
        returning: chamber(return_dead, p.drive.area_return, 2),
        cylinder: (1.0 + beyond) * gap,
        port_height: height * gap,
        supply_area,
        exhaust_area,
        discharge: row.losses.0,
        leakage_area,
        drag: row.losses.1 * p.piston_mass(),
        temperature,
        error: row.error,
    };
}
