//! Hard cases, all of them; here those of parameters: stiffness, damping, rock, lengths, meshes, loads.

use crate::graze;
use crate::hard::{Case, case, cycles, missed, run, summary};
use crate::hard_scenes;
use crate::mesh;
use hammer::{Fidelity, Parameters};

fn elements(p: &mut Parameters, piston: usize, bit: usize) {
    (p.piston.elements, p.bit.elements) = (piston, bit);
}

/// The least `CR` at which a bit of one element on the rock has a double real root. Its
/// polynomial is `a(s) + CR b(s)`, so on the real axis `CR = -a / b`, and a double root is
/// where that is least.
fn critical_viscosity(p: &Parameters) -> f64 {
    let (m, k) = (p.bit_mass() / 6.0, mesh::stretch(p) / p.bit.length);
    let viscosity = |s: f64| {
        let (own, across) = (2.0 * m * s * s + k, m * s * s - k);
        let rest = own + p.rock.stiffness - across * across / own;
        rest / s
    };
    // Between a tenth of the rock's frequency and ten times, s = -e^x, by golden section.
    let middle = (p.rock.stiffness / p.bit_mass()).sqrt().ln();
    let (mut low, mut high) = (middle - 2.3, middle + 2.3);
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    while high - low > 1e-9 {
        let (x, y) = (high - ratio * (high - low), low + ratio * (high - low));
        if viscosity(x.exp()) < viscosity(y.exp()) { high = y } else { low = x }
    }
    viscosity((0.5 * (low + high)).exp())
}

/// Penalties from soft to far beyond the mesh.
fn contacts() -> Vec<Case> {
    vec![
        case(
            "contact_twenty_times_the_element",
            "KC = 20 E A / h: contact nodes rattle",
            |p, _| {
                p.contact.stiffness =
                    20.0 * mesh::stretch(p) * p.piston.elements as f64 / p.piston.length
            },
            |w| {
                w.run(0.1, 200)?;
                let warned = w.machine.warnings().iter().any(|x| x.contains("contact.stiffness"));
                if warned {
                    Ok(format!("{}, warned", summary(w)))
                } else {
                    Err(missed("warning", w))
                }
            },
        ),
        case("contact_1e8", "KC = 1e8 N/m", |p, _| p.contact.stiffness = 1e8, cycles),
        case("contact_1e9", "KC = 1e9 N/m", |p, _| p.contact.stiffness = 1e9, cycles),
        case("contact_1e10", "KC = 1e10 N/m", |p, _| p.contact.stiffness = 1e10, cycles),
        case("contact_1e12", "KC = 1e12 N/m", |p, _| p.contact.stiffness = 1e12, cycles),
        case("contact_1e13", "KC = 1e13 N/m", |p, _| p.contact.stiffness = 1e13, cycles),
        case("contact_1e15", "KC = 1e15 N/m", |p, _| p.contact.stiffness = 1e15, cycles),
    ]
}

/// Damping of bars and rock at its limits.
fn dampings() -> Vec<Case> {
    vec![
        case(
            "undamped",
            "beta = 0: micro-events without end as the mesh is refined",
            |p, _| p.material.damping_time = 0.0,
            cycles,
        ),
        case(
            "undamped_fine",
            "beta = 0, 60 elements",
            |p, _| {
                p.material.damping_time = 0.0;
                elements(p, 60, 60);
                mesh::soften_contact(p);
            },
            cycles,
        ),
        case(
            "damping_1e9",
            "beta = 1e-9 s: nearly undamped",
            |p, _| p.material.damping_time = 1e-9,
            cycles,
        ),
        case(
            "damping_1e7",
            "beta = 1e-7 s: the highest modes overdamped",
            |p, _| p.material.damping_time = 1e-7,
            cycles,
        ),
        case("damping_1e6", "beta = 1e-6 s", |p, _| p.material.damping_time = 1e-6, cycles),
        case(
            "overdamped",
            "beta = 1e-5 s: most modes overdamped",
            |p, _| p.material.damping_time = 1e-5,
            cycles,
        ),
        case(
            "critical_bars",
            "beta = 2 / omega of a free mode: a defective pair in flight",
            |p, _| {
                let section = hammer::bodies::bar::Section {
                    youngs_modulus: p.material.youngs_modulus,
                    density: p.material.density,
                    area: p.cross_section,
                    length: p.piston.length,
                };
                p.material.damping_time = 2.0
                    / hammer::bodies::bar::Bar::free(section, p.piston.elements).omega2[5].sqrt();
            },
            cycles,
        ),
        case(
            "critical_rock",
            "rigid, CR = 2 sqrt(KR Mb): a defective pair in the rock",
            |p, _| {
                p.fidelity = Fidelity::Rigid;
                p.rock.viscosity = 2.0 * (p.rock.stiffness * p.bit_mass()).sqrt();
            },
            cycles,
        ),
        case(
            "critical_tip",
            "a bit of one element, CR tuned: a defective pair of bar and rock",
            |p, _| {
                elements(p, 20, 1);
                p.material.damping_time = 0.0;
                p.rock.viscosity = critical_viscosity(p);
            },
            cycles,
        ),
        case(
            "viscosity_impedance",
            "CR = Z: the tip reflects nothing",
            |p, _| p.rock.viscosity = p.impedance(),
            cycles,
        ),
    ]
}

/// The rock's law at its limits.
fn rocks() -> Vec<Case> {
    vec![
        case("viscosity_none", "CR = 0", |p, _| p.rock.viscosity = 0.0, cycles),
        case("viscosity_1e9", "CR = 1e9 N s/m, far above Z", |p, _| p.rock.viscosity = 1e9, cycles),
        case(
            "barrier_none",
            "WR = 0: DFC passes to FC at once",
            |p, _| p.rock.energy_barrier = 0.0,
            cycles,
        ),
        case(
            "barrier_huge",
            "WR = 1e12 J: FC is never reached",
            |p, _| p.rock.energy_barrier = 1e12,
            cycles,
        ),
        case("gamma_one", "gamma = 1 + 1e-12", |p, _| p.rock.unloading_ratio = 1.0 + 1e-12, cycles),
        case("gamma_near_one", "gamma = 1.001", |p, _| p.rock.unloading_ratio = 1.001, cycles),
        case("gamma_thousand", "gamma = 1000", |p, _| p.rock.unloading_ratio = 1000.0, cycles),
        case("rock_1e5", "KR = 1e5 N/m", |p, _| p.rock.stiffness = 1e5, cycles),
        case("rock_1e11", "KR = 1e11 N/m", |p, _| p.rock.stiffness = 1e11, cycles),
        case(
            "no_standstill",
            "vs = dps = 0: every micro-cycle drills",
            |p, _| {
                p.rock.standstill_speed = 0.0;
                p.rock.standstill_penetration = 0.0;
            },
            cycles,
        ),
    ]
}

/// Lengths and meshes.
fn bodies() -> Vec<Case> {
    vec![
        case("short_piston", "Lp / Lb = 0.1", |p, _| p.piston.length *= 0.1, cycles),
        case("long_piston", "Lp / Lb = 10", |p, _| p.piston.length *= 10.0, cycles),
        case(
            "incommensurate",
            "Lp / Lb the golden ratio",
            |p, _| p.piston.length *= 0.5 * (1.0 + 5f64.sqrt()),
            cycles,
        ),
        case("one_element", "one element a bar", |p, _| elements(p, 1, 1), cycles),
        case("one_and_sixty", "1 and 60 elements", |p, _| elements(p, 1, 60), cycles),
        case(
            "four_hundred",
            "400 elements per bar, through the first blow",
            |p, _| elements(p, 400, 400),
            run(0.015, 20),
        ),
        case("rigid", "rigid bodies", |p, _| p.fidelity = Fidelity::Rigid, cycles),
        case(
            "precursor",
            "100 elements, KC 2 E A / h: precursors in preloaded rock",
            |p, _| {
                elements(p, 100, 100);
                mesh::soften_contact(p);
            },
            run(0.02, 20),
        ),
        case(
            "quiet_tip",
            "100 elements, undamped: amplitudes cancel to nothing before the front arrives",
            |p, i| {
                *p = mesh::bare(100);
                *i = mesh::no_inputs();
            },
            |w| {
                // Radians of the fastest mode, sqrt(12) c / h, in nine tenths of a transit.
                let radians = 12f64.sqrt() * 100.0 * 0.9;
                w.run(mesh::strike() + 0.9 * w.machine.parameters().timescales().bit_transit, 1)?;
                let windows = w.machine.counters().windows;
                if windows as f64 > 2.0 * radians {
                    return Err(missed("a window of a radian", w));
                }
                Ok(format!(
                    "{windows} windows over {radians:.0} radians, ends {:?}",
                    w.machine.mode().rock
                ))
            },
        ),
    ]
}

/// Extreme numbers.
fn stiff() -> Vec<Case> {
    let mut list: Vec<Case> =
        [contacts(), dampings(), rocks(), bodies()].into_iter().flatten().collect();
    for c in &mut list {
        // Undamped, how many micro-events there are is a matter of chance.
        if matches!(c.name, "four_hundred" | "undamped" | "undamped_fine" | "no_standstill") {
            c.allowed *= 4;
        }
    }
    list
}

/// All of them.
pub fn all() -> Vec<Case> {
    [stiff(), hard_scenes::scenes(), graze::cases()].into_iter().flatten().collect()
}

/// Plays the case of this name.
///
/// # Panics
/// If there is none, or it fails.
pub fn assert_case(name: &str) {
    let cases = all();
    let case = cases.iter().find(|c| c.name == name).expect("a case of this name");
    if let Err(violation) = case.run() {
        panic!("{name}: {violation}");
    }
}
