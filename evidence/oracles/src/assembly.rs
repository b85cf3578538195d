//! Mass and stiffness matrices of bars: linear elements with consistent mass, or splines.

use crate::linear::{Banded, Real};
use crate::scene::{Fidelity, Scene, Section};
use crate::spline::{Knots, gauss};

/// Adds `block[0]` to both ends of an element and `block[1]` between them.
pub(crate) fn add_element<T: Real>(matrix: &mut Banded<T>, first: usize, block: [T; 2]) {
    matrix.diagonal[first] = matrix.diagonal[first] + block[0];
    matrix.diagonal[first + 1] = matrix.diagonal[first + 1] + block[0];
    matrix.off[first] = matrix.off[first] + block[1];
}

/// Adds a bar whose first node is `first` to mass and stiffness.
pub(crate) fn add_bar<T: Real>(
    scene: &Scene,
    sections: &[Section],
    first: usize,
    mass: &mut Banded<T>,
    stiffness: &mut Banded<T>,
) {
    let r = T::from;
    let mut node = first;
    for section in sections {
        let (length, area) = (r(section.length) / r(section.elements as f64), r(section.area));
        let m = r(scene.density) * area * length / r(6.0);
        let k = r(scene.youngs_modulus) * area / length;
        for _ in 0..section.elements {
            if scene.fidelity == Fidelity::Rigid {
                mass.diagonal[first] = mass.diagonal[first] + m * r(6.0);
                continue;
            }
            add_element(mass, node, [m * r(2.0), m]);
            add_element(stiffness, node, [k, -k]);
            node += 1;
        }
    }
}

/// A scene, a bar's sections, and the degree of its splines.
type Bar<'a> = (&'a Scene, &'a [Section], usize);

/// Adds a bar of splines, smooth within a section and continuous from one to the next.
pub(crate) fn add_spline_bar<T: Real>(
    (scene, sections, degree): Bar<'_>,
    first: usize,
    mass: &mut Banded<T>,
    stiffness: &mut Banded<T>,
) {
    let (r, points) = (T::from, gauss::<T>(degree + 1));
    let mut top = first;
    for section in sections {
        let (length, area) = (r(section.length) / r(section.elements as f64), r(section.area));
        let (m, k) = (r(scene.density) * area * length, r(scene.youngs_modulus) * area / length);
        let knots = Knots { degree, spans: section.elements };
        for span in 0..section.elements {
            for &[x, weight] in &points {
                let x = r(span as f64) + x;
                let (values, slopes) = (knots.values(degree, span, x), knots.slopes(span, x));
                for i in 0..=degree {
                    for j in i..=degree {
                        let place = [top + span + i, top + span + j];
                        mass.add(place, m * weight * values[i] * values[j]);
                        stiffness.add(place, k * weight * slopes[i] * slopes[j]);
                    }
                }
            }
        }
        top += section.elements + degree - 1;
    }
}
