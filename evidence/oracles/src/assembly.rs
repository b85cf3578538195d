//! Bars into matrices: linear elements with consistent mass, or spectral ones.

use crate::linear::{Real, Tridiagonal};
use crate::scene::{Fidelity, Scene, Section};
use crate::spectral::{Far, Lobatto};

/// Adds `block[0]` to both ends of an element and `block[1]` between them.
pub(crate) fn add_element<T: Real>(matrix: &mut Tridiagonal<T>, first: usize, block: [T; 2]) {
    matrix.diagonal[first] = matrix.diagonal[first] + block[0];
    matrix.diagonal[first + 1] = matrix.diagonal[first + 1] + block[0];
    matrix.off[first] = matrix.off[first] + block[1];
}

/// Adds a bar whose first node is `first` to mass and stiffness.
pub(crate) fn add_bar<T: Real>(
    scene: &Scene,
    sections: &[Section],
    first: usize,
    mass: &mut Tridiagonal<T>,
    stiffness: &mut Tridiagonal<T>,
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

/// Adds a bar of spectral elements of degree `d` whose first node is `first`.
pub(crate) fn add_spectral_bar<T: Real>(
    (scene, sections, degree): (&Scene, &[Section], usize),
    first: usize,
    mass: &mut Tridiagonal<T>,
    stiffness: &mut Tridiagonal<T>,
    far: &mut Far<T>,
) {
    let (r, element) = (T::from, Lobatto::<T>::new(degree));
    let mut node = first;
    for section in sections {
        let (length, area) = (r(section.length) / r(section.elements as f64), r(section.area));
        let m = r(scene.density) * area * length / r(2.0);
        let k = r(2.0) * r(scene.youngs_modulus) * area / length;
        for _ in 0..section.elements {
            for i in 0..=degree {
                let row = &element.stiffness[i];
                let (m, k_ii) = (m * element.weights[i], k * row[i]);
                mass.diagonal[node + i] = mass.diagonal[node + i] + m;
                stiffness.diagonal[node + i] = stiffness.diagonal[node + i] + k_ii;
                if i < degree {
                    stiffness.off[node + i] = stiffness.off[node + i] + k * row[i + 1];
                }
                far.extend((i + 2..=degree).map(|j| (node + i, node + j, k * row[j])));
            }
            node += degree;
        }
    }
}
