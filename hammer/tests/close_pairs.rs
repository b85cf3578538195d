//! Modes near critical damping, whose two roots nearly coincide and whose vectors are nearly parallel.

use crate::scenes::Random;
use hammer::laws::event::Bodies;
use hammer::laws::rock::Spring;
use hammer::modal::model::Model;
use hammer::modal::structure::{Attachment, Structure};
use hammer::modal::system::{Recipe, System};
use hammer::scene::graph::Group;
use hammer::{Mode, Parameters, RockMode, Segment};

const MODE: Mode = Mode::starting(RockMode::DissipativeForward);

/// Masses with a spring and a dashpot each, joined, and decomposed.
struct Scene {
    omega2: Vec<f64>,
    shapes: Vec<Vec<f64>>,
    springs: Vec<[f64; 2]>,
}

impl Scene {
    fn system(&self) -> System {
        let attachments = self.shapes.iter().zip(&self.springs);
        let attachments = attachments
            .map(|(shape, [k, c])| Attachment { shape, stiffness: *k, viscosity: *c })
            .collect();
        let structure = Structure { attachments, ..Structure::free(&self.omega2, 0.0) };
        let loads = std::array::from_fn(|_| vec![0.0; self.omega2.len()]);
        let recipe = Recipe { structure, loads, functionals: Vec::new(), dampers: Vec::new() };
        System::new(recipe, None, MODE).expect("a system")
    }

    /// How fast each mode moves by itself, 1/s.
    fn rates(&self) -> Vec<f64> {
        let held = |i: usize| -> f64 {
            self.shapes.iter().zip(&self.springs).map(|(s, [k, _])| k * s[i] * s[i]).sum()
        };
        self.omega2.iter().enumerate().map(|(i, w2)| (w2 + held(i)).sqrt()).collect()
    }

    /// How far a state is changed by converting it to the modes and back, over its size; displacements are multiplied
    /// by the rates of their modes.
    fn there_and_back(&self, system: &System, random: &mut Random) -> f64 {
        let (n, rates) = (self.omega2.len(), self.rates());
        let weight = |i: usize| if i < n { rates[i] } else { 1.0 };
        let state: Vec<f64> = (0..2 * n).map(|i| random.between(-0.5, 0.5) / weight(i)).collect();
        let (mut y, mut back) = (vec![0.0; 2 * system.blocks()], vec![0.0; 2 * n]);
        system.to_modal(&state, &mut y);
        system.to_bodies(&y, &mut back);
        let apart = |i: usize| (state[i] - back[i]).abs() * weight(i);
        (0..2 * n).map(apart).fold(0.0, f64::max)
    }
}

/// A body on a spring and a dashpot, another on a spring above it, the dashpot from a tenth to ten
/// times the critical one: somewhere two roots meet. A pair is kept as the mean of its vectors and
/// half their divided difference, which are as different as any two; roots that differ by more
/// than 0.3 of their size keep vectors of their own, whose Gram matrix has a condition of up to
/// `1 / 0.15^2`, 44. Two products with a basis of two blocks are 16 rounded terms, a quarter of a
/// unit in the last place each on average: `44 * 16 / 4` of these are 4e-14. It was 6e-14 to
/// 1e-11 where the vectors' difference had lost digits.
#[test]
fn a_state_comes_back_from_modes_that_all_but_coincide() {
    let mut random = Random::new(5);
    for joint in [1e6, 1e8] {
        for other in [0.01, 1.0, 30.0f64] {
            for step in 0..2000 {
                let m = 3.0f64;
                let critical = 2.0 * (1e8 * m).sqrt();
                let c = critical * 10f64.powf(f64::from(step) / 1000.0 - 1.0);
                let low = 1.0 / m.sqrt();
                let scene = Scene {
                    omega2: vec![0.0, 0.0],
                    shapes: vec![vec![low, 0.0], vec![low, -1.0 / other.sqrt()]],
                    springs: vec![[1e8, c], [joint, 0.0]],
                };
                let system = scene.system();
                let apart = scene.there_and_back(&system, &mut random);
                assert!(apart < 4e-14, "{joint} {other} {c}: {apart:e}");
            }
        }
    }
}

/// One mass next to critical damping, `x'' + 2 (1 + e) x' + x = 0`, from rest at 1. With
/// `s = sqrt((1 + e)^2 - 1)`, the closed form is
/// `exp(-(1 + e) t) (cosh(s t) + (1 + e) t sinhc(s t))`, smooth through `s = 0`: the series of
/// `cosh` and `sinhc` in `(s t)^2` is the oracle, whatever the sign of that.
#[test]
fn a_mode_next_to_critical_damping_moves_by_its_closed_form() {
    for exponent in 2..17 {
        for sign in [-1.0, 1.0] {
            let near = sign * 10f64.powi(-exponent);
            let scene = Scene {
                omega2: vec![0.0],
                shapes: vec![vec![1.0]],
                springs: vec![[1.0, 2.0 + 2.0 * near]],
            };
            let system = scene.system();
            let mut z = vec![0.0; 2 * system.blocks()];
            system.to_modal(&[1.0, 0.0], &mut z);
            let t = 1.5;
            system.rotate(t, &mut z);
            let mut state = [0.0; 2];
            system.to_bodies(&z, &mut state);
            // (s t)^2 = (2 e + e^2) t^2, below 0.05: five terms leave 1e-15.
            let square = (2.0 * near + near * near) * t * t;
            let (mut cosh, mut sinhc, mut term) = (0.0, 0.0, 1.0);
            for k in 0..8 {
                cosh += term;
                sinhc += term / f64::from(2 * k + 1);
                term *= square / f64::from((2 * k + 1) * (2 * k + 2));
            }
            let exact = (-(1.0 + near) * t).exp() * (cosh + (1.0 + near) * t * sinhc);
            // Up to fifty tabulated rotations of four rounded terms each, of numbers up to 1.
            assert!((state[0] - exact).abs() < 5e-14, "{near:e}: {} {exact}", state[0]);
        }
    }
}

/// The formula of the guide, `CR = 2 sqrt(KR Mb)`, gives exactly critical damping but for its rounding, over decades of
/// mass and stiffness: `x = (1 + w t) exp(-w t)` from rest at 1. The formula is rounded three times, and so is the
/// shape: `s t` of the test above is below `4e-8`, which changes the motion by its square. Elastic bits of a few modes
/// stand on the same rock and are not refused.
#[test]
fn bits_at_critical_damping_by_the_formula_move_by_its_closed_form() {
    let mut random = Random::new(7);
    for _ in 0..200 {
        let (m, k) = (10f64.powf(random.between(-1.0, 2.0)), 10f64.powf(random.between(5.0, 10.0)));
        let critical = 2.0 * (k * m).sqrt();
        let scene = Scene {
            omega2: vec![0.0],
            shapes: vec![vec![1.0 / m.sqrt()]],
            springs: vec![[k, critical]],
        };
        let system = scene.system();
        let mut z = vec![0.0; 2 * system.blocks()];
        system.to_modal(&[1.0, 0.0], &mut z);
        let (turn, mut state) = (1.5, [0.0; 2]);
        system.rotate(turn / (k / m).sqrt(), &mut z);
        system.to_bodies(&z, &mut state);
        let exact = (1.0 + turn) * (-turn).exp();
        assert!((state[0] - exact).abs() < 5e-14, "{m} kg, {k} N/m: {} {exact}", state[0]);
        let mut p = Parameters::default();
        (p.rock.stiffness, p.rock.viscosity) = (k, 2.0 * (k * p.bit_mass()).sqrt());
        p.bit.elements = 1 + (random.between(0.0, 6.0) as usize);
        let bit = Bodies::first(2).without(Bodies::first(1));
        let group = Group { bodies: bit, spring: Some(Spring::Viscous) };
        Model::new(&p).expect("bodies").system(group, MODE).expect("it is decomposed");
    }
}

/// In piston, bit and casing on splines, all tied together, the fast modes of one end hardly depend on the ties.
/// Their roots lie 1e-18 of their size beside a pole, beside two poles in equal bodies, and 1e-29 beside some of the
/// casing's. All states are reproduced by their basis. Each coordinate is a sum of some 600 rounded terms, with rates
/// that differ by 1e4, so the error is 1e-9. With powers of a near pole's compliance in the minors it was once 1e-4
/// to 1, and refused.
#[test]
fn modes_that_hardly_feel_the_ties_keep_their_vectors() {
    let mut p = Parameters::default();
    (p.mesh.degree, p.piston.elements, p.bit.elements) = (5, 80, 80);
    let parts = |list: [(f64, f64); 2]| list.map(|(length, area)| Segment { length, area });
    p.casing.segments.set(&parts([(0.5, 4e-3), (0.4, 3e-3)]));
    p.chuck.viscosity = 0.0;
    p.material.damping_time = 2.9e-8;
    for (stepped, elements) in [(false, 100), (true, 50), (true, 100)] {
        p.casing.elements = elements;
        if stepped {
            p.piston.segments.set(&parts([(0.1, 3e-3), (0.07, 2e-3)]));
            p.bit.segments = p.piston.segments;
        }
        let model = Model::new(&p).expect("a model");
        for spring in [Spring::Viscous, Spring::Unloading] {
            let all = Group { bodies: model.graph.all(), spring: Some(spring) };
            let system = model.system(all, MODE).expect("a system");
            let off = system.mismatch();
            assert!(off < 1e-9, "{stepped} {elements} {spring:?}: {off:e}");
        }
    }
}
