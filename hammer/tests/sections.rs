//! Derivatives by the lengths and areas of sections.

mod scenes;

use hammer::tangent::{Dimension, Doubt, Parameter, Seed, Tangents};
use hammer::{Body, Fidelity, InputValues, Machine, Parameters};
use scenes::Draw;
use scenes::differences::{compare, outputs, tangents};

/// The parameters of sections that a scene reads.
fn sections(p: &Parameters) -> Vec<Parameter> {
    let of = |q: &&Parameter| matches!(q, Parameter::Section(..)) && q.is_read(p);
    Parameter::ALL.iter().filter(of).copied().collect()
}

#[test]
fn stepped_bodies_have_the_derivatives_that_differences_tend_to() {
    let (mut draw, mut compared, mut worst) = (Draw::new(11), 0, 0.0);
    for _ in 0..12 {
        let p = draw.stepped();
        compared += compare(&p, draw.between(0.002, 0.03), &mut worst);
    }
    assert!(compared > 150, "{compared}");
}

/// A uniform body cut into equal sections, on spans that fall alike: what all areas do together is
/// what the one area does, and lengths likewise.
///
/// Both decompositions err by rounding: of frequencies by some 1e-13 (a dense solver), which a run
/// of a few thousand radians and quotients by differences of eigenvalues of a thousandth of them
/// turn into 1e-8 of the natural sizes at most.
#[test]
fn sections_of_one_area_add_up_to_the_uniform_body() {
    for degree in [1, 3] {
        let mut uniform = Parameters::default();
        (uniform.mesh.degree, uniform.piston.elements, uniform.bit.elements) = (degree, 6, 6);
        (uniform.bit.length, uniform.piston.initial_velocity) = (0.21, 2.0);
        let mut cut = uniform;
        (cut.piston.segments, cut.bit.segments) = (3, 2);
        cut.piston.segment.iter_mut().for_each(|s| s.length = uniform.piston.length / 3.0);
        cut.bit.segment.iter_mut().for_each(|s| s.length = 0.5 * uniform.bit.length);
        let t = 0.043;
        let totals = [Parameter::CrossSection, Parameter::PistonLength, Parameter::BitLength];
        let whole = sums(&uniform, &totals, t);
        let list = sections(&cut);
        let parts = sums(&cut, &list, t);
        let part = |wanted: &dyn Fn(Body, Dimension) -> bool| -> Vec<f64> {
            let fits = |q: &Parameter| matches!(*q, Parameter::Section(b, _, d) if wanted(b, d));
            let rows = list.iter().zip(&parts).filter(|(q, _)| fits(q)).map(|(_, row)| row);
            rows.fold(vec![0.0; whole[0].len()], |sum, row| {
                sum.iter().zip(row).map(|(a, b)| a + b).collect()
            })
        };
        let together = [
            part(&|_, d| d == Dimension::Area),
            part(&|b, d| b == Body::Piston && d == Dimension::Length),
            part(&|b, d| b == Body::Bit && d == Dimension::Length),
        ];
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
        assert!((a - b).abs() < 1e-8 * (1.0 + a.abs()), "degree {degree}, output {k}: {a:e} {b:e}");
    }
}

/// Derivatives by the logarithms of parameters, over the outputs' natural sizes.
fn sums(p: &Parameters, list: &[Parameter], t: f64) -> Vec<Vec<f64>> {
    let seeds: Vec<_> = list.iter().map(|q| Seed::Parameter(*q)).collect();
    let (tangents, found) = tangents(p, &seeds, t).expect("a run");
    assert_eq!(tangents.cautious(), 0);
    let row = |(q, d): (&Parameter, _)| {
        let value = *q.slot(&mut p.clone());
        outputs(d).iter().map(|x| x * value).collect()
    };
    list.iter().zip(&found).map(row).collect()
}

/// Three spans on two equal sections: the one more goes to either. Rigid bodies of several
/// sections: the collision is read off a lattice.
#[test]
fn where_lengths_decide_which_section_gets_a_span_the_derivative_is_in_doubt() {
    let length = |k| Parameter::Section(Body::Piston, k, Dimension::Length);
    let doubts = |p: &Parameters, q: Parameter| -> Vec<Doubt> {
        let machine = Machine::new(p, &InputValues::default(), 0.0).expect("a scene");
        let tangents = Tangents::of_scene(&machine, &[Seed::Parameter(q)]).expect("tangents");
        tangents.cautions().iter().map(|c| c.doubt).collect()
    };
    use hammer::tangent::Ordinal::{First, Second, Third};
    let mut p = Parameters::default();
    (p.piston.segments, p.piston.elements) = (2, 3);
    p.piston.segment[1].area = 1e-3;
    assert_eq!(doubts(&p, length(Second)), [Doubt::Branch]);
    // There is no third.
    assert_eq!(doubts(&p, length(Third)), []);
    assert_eq!(doubts(&p, Parameter::Section(Body::Piston, First, Dimension::Area)), []);
    p.piston.elements = 4;
    assert_eq!(doubts(&p, length(Second)), []);
    p.fidelity = Fidelity::Rigid;
    assert_eq!(doubts(&p, length(First)), [Doubt::Branch]);
    assert_eq!(doubts(&p, Parameter::Section(Body::Piston, First, Dimension::Area)), []);
}
