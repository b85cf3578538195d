//! Properties of bodies and their meshes that checks need.

use hammer::{Body, Fidelity, Machine, Parameters};

/// Compliance of both bodies pulled at their ends, `sum L / (E A)`, m/N.
pub fn compliance(p: &Parameters) -> f64 {
    let of = |body: Body| -> f64 {
        let sections = p.sections(body);
        sections.as_slice().iter().map(|s| s.length / s.area).sum()
    };
    (of(Body::Piston) + of(Body::Bit)) / p.material.youngs_modulus
}

/// Impedance of the thinnest section, N s/m.
pub fn least_impedance(p: &Parameters) -> f64 {
    let areas = Body::ALL
        .into_iter()
        .flat_map(|body| p.sections(body).as_slice().iter().map(|s| s.area).collect::<Vec<_>>());
    p.impedance_of(areas.fold(f64::INFINITY, f64::min))
}

/// Length (m) and area (m2) of the spans of both bodies, a row for each section.
fn spans(p: &Parameters, body: Body) -> Vec<[f64; 2]> {
    let sections = p.sections(body);
    let counts = sections.spans(p.spans(body));
    sections.as_slice().iter().zip(counts).map(|(s, n)| [s.length / n as f64, s.area]).collect()
}

/// Response of a body's end to a sudden force, 1/kg: at most that of a single span of a mesh of degree `d`,
/// `(d + 1)^2 / (rho A h)`, from Legendre polynomials up to `d`. For linear elements this is 4 over an element's
/// mass.
pub fn lightness(p: &Parameters, body: Body, lower: bool) -> f64 {
    if p.fidelity == Fidelity::Rigid {
        let mass = if body == Body::Piston { p.piston_mass() } else { p.bit_mass() };
        return 1.0 / mass;
    }
    let spans = spans(p, body);
    of_span(p, spans[if lower { spans.len() - 1 } else { 0 }])
}

/// The largest [mismatch](hammer::modal::system::System::mismatch) of a basis that a machine uses now, times its
/// effect at an end. Each of `n` modes has an error of this share of the fastest speed, and none is faster than
/// `sqrt(M) V`, if all of the mass `M` moves with `V`. An end moves by `sum phi_i y_i`, and `sum phi_i^2` is its
/// response to a sudden force, so its error is at most `sqrt(n M response)` of `V` (Cauchy and Schwarz). It is
/// largest for a light bit below heavy bodies.
pub fn mismatch(machine: &Machine) -> f64 {
    let uneven = unevenness(machine.parameters());
    let (tracks, _) = machine.tracked();
    let off =
        tracks.iter().map(|t| t.system.mismatch() * (t.system.modes() as f64 * uneven).sqrt());
    off.fold(0.0, f64::max)
}

/// Mass of all bodies times the largest response of an end of piston or bit.
fn unevenness(p: &Parameters) -> f64 {
    let ends = [(Body::Piston, true), (Body::Bit, false), (Body::Bit, true)];
    let yields = ends.map(|(body, lower)| lightness(p, body, lower));
    let mass = p.total_mass();
    mass * yields.into_iter().fold(0.0, f64::max)
}

/// The response of the lightest span of an elastic body.
pub fn lightest_span(p: &Parameters, body: Body) -> f64 {
    spans(p, body).into_iter().map(|span| of_span(p, span)).fold(0.0, f64::max)
}

fn of_span(p: &Parameters, [h, area]: [f64; 2]) -> f64 {
    ((p.mesh.degree + 1) as f64).powi(2) / (p.material.density * area * h)
}

/// Bound on the fastest wave of the mesh, 1/s: Schmidt's inequality for polynomials of degree `d`,
/// `|v'| <= sqrt(3) d^2 |v| 2 / h`, on the shortest span.
pub fn fastest_wave(p: &Parameters) -> f64 {
    let all = Body::ALL.into_iter().flat_map(|body| spans(p, body));
    let shortest = all.map(|[h, _]| h).fold(f64::INFINITY, f64::min);
    2.0 * 3f64.sqrt() * (p.mesh.degree as f64).powi(2) * p.wave_speed() / shortest
}

/// Unknowns of the mesh: in each section one for each span and `d` more, of which one is shared with the section
/// below.
pub fn unknowns(p: &Parameters) -> usize {
    let of = |body: Body| {
        let sections = p.sections(body).as_slice().len();
        p.spans(body) + sections * (p.mesh.degree - 1) + 1
    };
    of(Body::Piston) + of(Body::Bit)
}

/// Largest mass of air in both chambers at this pressure, kg.
pub fn air(p: &Parameters, pressure: f64) -> f64 {
    let swept = (p.drive.area_drive + p.drive.area_return) * p.air.cylinder;
    let volume = p.air.drive.dead_volume + p.air.returning.dead_volume + swept;
    pressure * volume / (287.05 * p.air.temperature)
}
