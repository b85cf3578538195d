//! Free modes of stepped bodies: against the exact stepped bar, whose solution in every
//! section is a cosine and a sine, and against an independent assembly of linear elements.

use crate::scenes::Random;
use hammer::bodies::bar::Bar;
use hammer::{MAX_DEGREE, Parameters, Sections, Segment};

fn body(parts: &[(f64, f64)]) -> Sections {
    let list: Vec<Segment> = parts.iter().map(|&(length, area)| Segment { length, area }).collect();
    Sections::new(&list).expect("sections")
}

fn bar(parts: &[(f64, f64)], degree: usize, spans: usize) -> Bar {
    let material = Parameters::default().material;
    Bar::stepped(&body(parts), &material, degree, spans).expect("modes")
}

fn wave_speed() -> f64 {
    Parameters::default().wave_speed()
}

/// Displacement and force at the lower end of a bar whose free upper end moves by 1, at the
/// wave number `k`: from section to section, displacement and force are continuous.
fn shoot(parts: &[(f64, f64)], k: f64) -> [f64; 2] {
    let e = Parameters::default().material.youngs_modulus;
    parts.iter().fold([1.0, 0.0], |[u, f], &(length, area)| {
        let (sin, cos) = (k * length).sin_cos();
        let stiffness = e * area * k;
        [u * cos + f / stiffness * sin, f * cos - u * stiffness * sin]
    })
}

/// Wave number of an exact mode between two bounds, where the force at the lower end vanishes.
fn exact(parts: &[(f64, f64)], mut low: f64, mut high: f64) -> f64 {
    let sign = shoot(parts, low)[1].signum();
    assert_ne!(sign, shoot(parts, high)[1].signum(), "no root in {low} to {high}");
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if shoot(parts, middle)[1].signum() == sign { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// A piston with a tail and a waist, and a bit with a long shank.
const BODIES: [&[(f64, f64)]; 3] =
    [&[(0.1, 2.6e-3), (0.3, 1.7e-3)], &[(0.12, 4e-3), (0.05, 1e-3), (0.21, 3e-3)], &[(0.2, 1e-3)]];

/// `h^(2 d)`: halving the spans divides the error by `4^d`. It is measured where the error is above rounding and the
/// waves are well resolved, so that the order is right to a tenth of `2 d`.
#[test]
fn frequencies_converge_to_those_of_the_exact_bar_with_twice_the_degree() {
    for parts in BODIES {
        for degree in 1..=4 {
            // All sections have spans of about a third of a radian.
            let total: f64 = parts.iter().map(|p| p.0).sum();
            let spans =
                [16, 32].map(|n| n * total as usize + (n as f64 * total / 0.01) as usize / 16);
            let errors = spans.map(|n| {
                let bar = bar(parts, degree, n);
                let k = bar.omega2[4].sqrt() / wave_speed();
                let exact = exact(parts, k * 0.97, k * 1.0000001);
                k / exact - 1.0
            });
            let order = (errors[0] / errors[1]).ln() / (spans[1] as f64 / spans[0] as f64).ln();
            assert!(
                (order - 2.0 * degree as f64).abs() < 0.1 * 2.0 * degree as f64,
                "{parts:?} degree {degree}: {order} {errors:?}"
            );
        }
    }
}

/// On fine splines only rounding is left: of the shooting method through three sections, and of a quotient of two
/// sums of squares.
#[test]
fn fine_splines_have_the_exact_frequencies_to_rounding() {
    for parts in BODIES {
        for (degree, spans) in [(5, 180), (7, 60), (7, 200)] {
            let bar = bar(parts, degree, spans);
            assert_eq!(bar.omega2[0], 0.0);
            for mode in 1..8 {
                let k = bar.omega2[mode].sqrt() / wave_speed();
                let exact = exact(parts, k * (1.0 - 1e-6), k * (1.0 + 1e-6));
                assert!((k / exact - 1.0).abs() < 4e-15, "{parts:?} {degree} {mode}: {k} {exact}");
            }
        }
    }
}

/// Displacement of a free end by a force at either end, `sum phi(x) phi(y) / (omega_i^2 - s^2)`, to which every
/// amplitude contributes. The exact bar has it in closed form.
#[test]
fn end_amplitudes_make_up_the_receptances_of_the_exact_bar() {
    for parts in BODIES {
        let bar = bar(parts, 7, 120);
        for mode in [1, 3, 6] {
            // Between two resonances.
            let s2 = 0.5 * (bar.omega2[mode] + bar.omega2[mode + 1]);
            let sum = |x: &[f64], y: &[f64]| -> f64 {
                (0..bar.len()).map(|i| x[i] * y[i] / (bar.omega2[i] - s2)).sum()
            };
            let [u, f] = shoot(parts, s2.sqrt() / wave_speed());
            let (bottom, cross) = (sum(&bar.bottom, &bar.bottom), sum(&bar.top, &bar.bottom));
            // 120 terms of either sign, about ten times their sum; s2 amplifies its own rounding.
            assert!((bottom * f / u - 1.0).abs() < 1e-12, "{parts:?} {mode}: {bottom} {}", u / f);
            assert!((cross * f - 1.0).abs() < 1e-12, "{parts:?} {mode}: {cross} {}", 1.0 / f);
        }
    }
}

/// Sections over the whole domain: those of a lathe, and far beyond.
fn drawn(random: &mut Random, wide: f64) -> Vec<(f64, f64)> {
    let count = 1 + (8.0 * random.unit()) as usize;
    let log = |x: f64| (wide * (x - 0.5)).exp();
    (0..count).map(|_| (0.1 * log(random.unit()), 2e-3 * log(random.unit()))).collect()
}

/// `(K - omega^2 M) phi`, row by row, of linear elements assembled here, over the sizes of its terms. Nodal values
/// are sums of one term, so a few roundings remain, and the pencil's error of a mode: `eps` times the ratio of the
/// mesh's frequencies.
#[test]
fn modes_of_linear_elements_satisfy_an_independent_assembly() {
    let material = Parameters::default().material;
    let mut random = Random::new(3);
    for _ in 0..40 {
        let parts = drawn(&mut random, 4.0);
        let total = parts.len() + (40.0 * random.unit()) as usize;
        let sections = body(&parts);
        let bar = bar(&parts, 1, total);
        let (nodes, n) = (sections.nodes(total), bar.len());
        assert_eq!(nodes.len(), n);
        for mode in 0..n {
            let unit: Vec<f64> = (0..n).map(|k| f64::from(u8::from(k == mode))).collect();
            let u: Vec<f64> = bar.nodal(&unit, &unit).iter().map(|[u, _]| *u).collect();
            let (mut ku, mut mu, mut size) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
            for e in 0..n - 1 {
                let h = nodes[e + 1] - nodes[e];
                let area = sections.area_at(0.5 * (nodes[e] + nodes[e + 1]));
                let (k, m) =
                    (material.youngs_modulus * area / h, material.density * area * h / 6.0);
                ku[e] += k * (u[e] - u[e + 1]);
                ku[e + 1] += k * (u[e + 1] - u[e]);
                mu[e] += m * (2.0 * u[e] + u[e + 1]);
                mu[e + 1] += m * (u[e] + 2.0 * u[e + 1]);
                for i in [e, e + 1] {
                    size[i] += k * (u[e].abs() + u[e + 1].abs());
                }
            }
            let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
            let residual: Vec<f64> = (0..n).map(|i| ku[i] - bar.omega2[mode] * mu[i]).collect();
            assert!(norm(&residual) < 1e-12 * norm(&size), "{parts:?} {total} {mode}");
            let mass: f64 = u.iter().zip(&mu).map(|(u, m)| u * m).sum();
            assert!((mass - 1.0).abs() < 1e-13, "{parts:?} {mode}: {mass}");
        }
    }
}

/// Every body that the parameters allow has modes: ascending, finite, and with amplitudes at the ends that add up to
/// the mass that an end responds with at once, which is less than all of it.
#[test]
fn drawn_bodies_of_every_degree_have_modes() {
    let mut random = Random::new(5);
    for case in 0..120 {
        let parts = drawn(&mut random, if case % 2 == 0 { 5.0 } else { 18.0 });
        let degree = 1 + case % MAX_DEGREE;
        let bar = bar(&parts, degree, 1 + (50.0 * random.unit()) as usize);
        assert_eq!((bar.omega2[0], bar.top[0]), (0.0, 1.0 / bar.mass.sqrt()));
        assert!(
            bar.omega2.windows(2).all(|w| w[0] <= w[1]),
            "{parts:?} degree {degree}: {:?}",
            bar.omega2
        );
        for ends in [&bar.top, &bar.bottom] {
            let felt = 1.0 / ends.iter().map(|x| x * x).sum::<f64>();
            assert!(felt > 0.0 && felt < bar.mass, "{parts:?}: {felt} of {}", bar.mass);
        }
    }
}

/// A neck a million times thinner than the bodies it joins: the lowest mode is that of two masses on a spring, twelve
/// orders below the mesh's fastest.
#[test]
fn two_masses_on_a_thin_neck_swing_like_two_masses_on_a_spring() {
    let parts = [(0.1, 1e-2), (0.01, 1e-9), (0.2, 1e-2)];
    let e = Parameters::default().material.youngs_modulus;
    let density = Parameters::default().material.density;
    for degree in [1, 3, 7] {
        let bar = bar(&parts, degree, 31);
        let (m1, m2) = (density * 1e-3, density * 2e-3);
        let spring = e * 1e-9 / 0.01 * (1.0 / m1 + 1.0 / m2);
        // The neck's own mass is 1e-8 of theirs, the bodies' compliance 1e-6 of the neck's.
        assert!((bar.omega2[1] / spring - 1.0).abs() < 2e-6, "{} {spring}", bar.omega2[1]);
        let exact = exact(
            &parts,
            0.999 * spring.sqrt() / wave_speed(),
            1.001 * spring.sqrt() / wave_speed(),
        );
        let k = bar.omega2[1].sqrt() / wave_speed();
        // Linear elements have an error of 1e-3 of the bodies' compliance, which is 1e-6 of the neck's.
        let bound = if degree == 1 { 1e-9 } else { 1e-12 };
        assert!((k / exact - 1.0).abs() < bound, "{degree}: {k} {exact}");
    }
}
