//! Derivatives by the lengths and areas of sections.

use crate::scenes;
use hammer::Parameters;
use hammer::Scene;
use hammer::sensitivity::{Argument, Derivative, Sample, derivatives};

fn named(name: &str) -> Argument {
    Argument::named(name).expect("a row of the table")
}

/// The parameters of sections that a scene reads.
fn sections(p: &Parameters) -> Vec<Argument> {
    Argument::all().filter(|a| a.name().contains(".segment[") && a.is_read(p)).collect()
}

/// A uniform body cut into equal sections, on spans that fall alike: what all areas do together is
/// what the one area does, and lengths likewise.
///
/// Both decompositions err by rounding: of frequencies by some 1e-13 (a dense solver), which a run
/// of a few thousand radians and differences over 4e-6 turn into 1e-6 of the natural sizes at most.
#[test]
fn sections_of_one_area_add_up_to_the_uniform_body() {
    for degree in [1, 3] {
        let mut uniform = scenes::overdamped();
        (uniform.mesh.degree, uniform.piston.elements, uniform.bit.elements) = (degree, 6, 6);
        (uniform.bit.length, uniform.piston.initial_velocity) = (0.21, 2.0);
        let mut cut = uniform;
        (cut.piston.segments, cut.bit.segments) = (3, 2);
        cut.piston.segment.iter_mut().for_each(|s| s.length = uniform.piston.length / 3.0);
        cut.bit.segment.iter_mut().for_each(|s| s.length = 0.5 * uniform.bit.length);
        let t = 0.043;
        let totals = ["cross_section", "piston.length", "bit.length"].map(named);
        let whole = sums(&uniform, &totals, t);
        let list = sections(&cut);
        let parts = sums(&cut, &list, t);
        let part = |body: &str, dimension: &str| -> Vec<f64> {
            let fits = |a: &Argument| a.name().starts_with(body) && a.name().ends_with(dimension);
            let rows = list.iter().zip(&parts).filter(|(a, _)| fits(a)).map(|(_, row)| row);
            rows.fold(vec![0.0; whole[0].len()], |sum, row| {
                sum.iter().zip(row).map(|(a, b)| a + b).collect()
            })
        };
        let together = [part("", "area"), part("piston", "length"), part("bit", "length")];
        // Splines inside a section are smoother than across a cut: another mesh.
        if degree > 1 {
            (cut.piston.segments, cut.bit.segments) = (1, 1);
            (cut.piston.segment[0].length, cut.bit.segment[0].length) =
                (uniform.piston.length, uniform.bit.length);
            let one = sums(&cut, &sections(&cut), t);
            close(&whole[1], &one[0], degree);
            close(&whole[2], &one[2], degree);
            continue;
        }
        for (whole, together) in whole.iter().zip(&together) {
            close(whole, together, degree);
        }
    }
}

fn close(whole: &[f64], together: &[f64], degree: usize) {
    for (k, (a, b)) in whole.iter().zip(together).enumerate() {
        assert!((a - b).abs() < 1e-6 * (1.0 + a.abs()), "degree {degree}, output {k}: {a:e} {b:e}");
    }
}

/// Derivatives by the logarithms of parameters, of outputs over their natural sizes.
fn sums(p: &Parameters, list: &[Argument], t: f64) -> Vec<Vec<f64>> {
    let scene = Scene { parameters: *p, ..Scene::default() };
    let run = |scene: &Scene| {
        Sample::of_run(&mut scene.machine()?, &[t], &|m| {
            let (k, e, i) = (*m.kinematics(), m.energies(), m.impulses());
            let blow = m.blow().copied().unwrap_or_default();
            let positions = [k.piston_position, k.bit_position, k.bit_tip_position, k.tip_depth];
            let speeds = [k.piston_velocity, k.bit_velocity, k.bit_tip_velocity, blow.speed];
            let energies = [e.drive, e.kinetic, e.strain, e.rock_dissipated, e.damping];
            let forces = [k.contact_force, k.rock_force, m.peaks().contact_force()];
            let sized = positions.map(|x| x / 0.05).into_iter().chain(speeds.map(|v| v / 10.0));
            let sized = sized.chain(energies.map(|e| e / 200.0)).chain(forces.map(|f| f / 1e5));
            sized.chain([i.contact / 100.0, i.rock / 100.0, blow.time / 0.05]).collect()
        })
    };
    let found = derivatives(&scene, list, &run).expect("runs");
    assert!(found.iter().all(|row| row.nonsmooth.is_empty()));
    let row =
        |(a, d): (&Argument, &Derivative)| d.values.iter().map(|x| x * a.value(&scene)).collect();
    list.iter().zip(&found).map(row).collect()
}
