//! The modal flow against a dense matrix exponential, in every kind of system.

use hammer::bodies::bar::Bar;
use hammer::modal::structure::{Attachment, Structure};
use hammer::modal::system::{Recipe, System};
use hammer::{Mode, Parameters, RockMode, Sections, Segment};
use nalgebra::{DMatrix, DVector};

const MODE: Mode = Mode::starting(RockMode::Standstill);

/// A uniform bar of the default material.
fn bar(length: f64, elements: usize) -> Bar {
    Bar::free(&Parameters::default().material, Segment { length, area: 2.6e-3 }, elements)
}

struct Case {
    omega2: Vec<f64>,
    beta: f64,
    attachments: Vec<(Vec<f64>, f64, f64)>,
}

impl Case {
    fn bit(elements: usize, beta: f64, k: f64, c: f64) -> Self {
        let bar = bar(0.168, elements);
        Self { attachments: vec![(bar.bottom.clone(), k, c)], omega2: bar.omega2, beta }
    }

    fn coupled(
        lengths: [f64; 2],
        elements: [usize; 2],
        beta: f64,
        kc: f64,
        rock: Option<(f64, f64)>,
    ) -> Self {
        let [p, b] = [0, 1].map(|i| bar(lengths[i], elements[i]));
        Self::joined(&p, &b, beta, kc, rock)
    }

    fn joined(p: &Bar, b: &Bar, beta: f64, kc: f64, rock: Option<(f64, f64)>) -> Self {
        let omega2 = [p.omega2.clone(), b.omega2.clone()].concat();
        let gap: Vec<f64> = p.bottom.iter().map(|x| -x).chain(b.top.iter().copied()).collect();
        let tip = [vec![0.0; p.len()], b.bottom.clone()].concat();
        let mut attachments = vec![(gap, kc, 0.0)];
        if let Some((k, c)) = rock {
            attachments.insert(0, (tip, k, c));
        }
        Self { omega2, beta, attachments }
    }

    fn system(&self) -> System {
        let attachments = self
            .attachments
            .iter()
            .map(|(shape, stiffness, viscosity)| Attachment {
                shape,
                stiffness: *stiffness,
                viscosity: *viscosity,
            })
            .collect();
        let n = self.omega2.len();
        let recipe = Recipe {
            structure: Structure { attachments, ..Structure::free(&self.omega2, self.beta) },
            loads: std::array::from_fn(|_| vec![0.0; n]),
            functionals: vec![self.attachments[0].0.clone()],
            dampers: Vec::new(),
        };
        System::new(recipe, Some(0), MODE).expect("spectrum")
    }

    /// Dense `A` in coordinates scaled so that energies have unit weight.
    fn dense(&self) -> (DMatrix<f64>, Vec<f64>) {
        let n = self.omega2.len();
        let mut k = DMatrix::from_diagonal(&DVector::from_vec(self.omega2.clone()));
        let mut c = &k * self.beta;
        for (shape, stiffness, viscosity) in &self.attachments {
            let w = DVector::from_vec(shape.clone());
            k += &w * w.transpose() * *stiffness;
            c += &w * w.transpose() * *viscosity;
        }
        let scale: Vec<f64> = (0..n).map(|i| k[(i, i)].sqrt().max(1.0)).collect();
        let mut a = DMatrix::zeros(2 * n, 2 * n);
        for i in 0..n {
            a[(i, n + i)] = scale[i];
            for j in 0..n {
                a[(n + i, j)] = -k[(i, j)] / scale[j];
                a[(n + i, n + j)] = -c[(i, j)];
            }
        }
        (a, scale)
    }

    /// Largest error of the flow over `t`, over unit start vectors, energy-scaled, beyond
    /// what the dense exponential itself keeps: rounding times `|A| t`.
    fn error(&self, t: f64) -> f64 {
        let n = self.omega2.len();
        let system = self.system();
        let (a, scale) = self.dense();
        let exact = (&a * t).exp();
        let mut worst: f64 = 0.0;
        for start in 0..2 * n {
            let mut state = vec![0.0; 2 * n];
            state[start] = if start < n { 1.0 / scale[start] } else { 1.0 };
            let blocks = system.blocks();
            let (mut y, mut out) = (vec![0.0; 2 * blocks], vec![0.0; 2 * n]);
            system.to_modal(&state, &mut y);
            if system.rigid {
                y[0] += t * y[blocks];
            }
            system.rotate(t, &mut y);
            system.to_bodies(&y, &mut out);
            for i in 0..2 * n {
                let value = if i < n { out[i] * scale[i] } else { out[i] };
                worst = worst.max((value - exact[(i, start)]).abs());
            }
        }
        worst - 2.0 * f64::EPSILON * (a.norm() * t)
    }
}

/// Beyond the dense exponential's own error: rounding of a few dozen rotations times the
/// condition number of the modal basis (at most 1e3 in these cases).
const DENSE: f64 = 1e-11;

#[test]
fn every_rock_mode_of_the_reference_bit_flows_like_the_dense_exponential() {
    for (k, c) in
        [(1.2e8, 0.0), (1.2e8, 1.7e5), (4.8e8, 0.0), (1e3, 0.0), (1e12, 0.0), (1.2e8, 1.7e7)]
    {
        for t in [1e-7, 3.3e-5, 2e-4] {
            let error = Case::bit(20, 2e-8, k, c).error(t);
            assert!(error < DENSE, "k {k} c {c} t {t}: {error:e}");
        }
    }
}

/// `beta w` of the fastest mode is 40 to 4000. All but a few modes are overdamped, and their slow roots crowd at
/// `-1 / beta`, with relative distances below 1e-7.
#[test]
fn slow_roots_that_crowd_flow_like_the_dense_exponential() {
    for (lengths, elements) in [([0.168; 2], [40; 2]), ([0.168, 0.31], [30, 24])] {
        for rock in [None, Some((1.2e8, 0.0)), Some((1.2e8, 1.7e5))] {
            for beta in [1e-5, 1e-4, 1e-3] {
                let error = Case::coupled(lengths, elements, beta, 1e11, rock).error(6.6e-5);
                assert!(error < DENSE, "{elements:?} {rock:?} beta {beta}: {error:e}");
            }
        }
    }
}

#[test]
fn equal_unequal_and_nearly_equal_bars_flow_like_the_dense_exponential() {
    let rocks = [None, Some((1.2e8, 0.0)), Some((1.2e8, 1.7e5)), Some((4.8e8, 0.0))];
    let equal = [0.0, 2e-8, 1e-5].map(|beta| ([0.168; 2], [20; 2], beta, 1e11));
    let lengths = [[0.168, 0.1680001], [0.168, 0.168 * (1.0 + 1e-9)], [0.1, 0.3], [0.05, 0.5]];
    let others = lengths.map(|lengths| (lengths, [12, 17], 2e-8, 3e11));
    for (lengths, elements, beta, kc) in equal.into_iter().chain(others) {
        for rock in rocks {
            let error = Case::coupled(lengths, elements, beta, kc, rock).error(6.6e-5);
            assert!(error < DENSE, "{lengths:?} {rock:?} beta {beta}: {error:e}");
        }
    }
}

#[test]
fn stiff_contact_and_matched_impedance_flow_like_the_dense_exponential() {
    let impedance = 2.6e-3 * (210e9f64 * 7850.0).sqrt();
    for c in [0.5, 0.9, 1.0, 1.1, 100.0] {
        let error = Case::bit(20, 2e-8, 1.2e8, c * impedance).error(1e-4);
        assert!(error < DENSE, "c/Z {c}: {error:e}");
    }
    for kc in [1e8, 1e13, 1e15] {
        let case = Case::coupled([0.168; 2], [10; 2], 2e-8, kc, Some((1.2e8, 1.7e5)));
        // |A| grows as sqrt KC, and the dense exponential's error with it.
        let error = case.error(1e-6);
        assert!(error < DENSE, "KC {kc}: {error:e}");
    }
}

#[test]
fn one_element_and_one_mode_flow_like_the_dense_exponential() {
    for elements in [1, 2] {
        assert!(Case::bit(elements, 2e-8, 1.2e8, 1.7e5).error(5e-5) < DENSE);
    }
    let rigid = Bar::rigid(3.4);
    for c in [0.0, 1e3, 2.0 * (1.2e8f64 * 3.4).sqrt(), 1e6] {
        let case = Case {
            omega2: rigid.omega2.clone(),
            beta: 0.0,
            attachments: vec![(rigid.bottom.clone(), 1.2e8, c)],
        };
        assert!(case.error(1e-4) < DENSE, "c {c}: {:e}", case.error(1e-4));
    }
}

/// The viscosity at which two real eigenvalues meet is bracketed and approached. The eigenvectors become parallel,
/// and the flow must remain exact.
#[test]
fn a_critically_damped_mode_flows_like_the_dense_exponential() {
    let critical = 2.0 * (1.2e8f64 * 3.4).sqrt();
    let rigid = Bar::rigid(3.4);
    for off in [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2] {
        for sign in [-1.0, 1.0] {
            let case = Case {
                omega2: rigid.omega2.clone(),
                beta: 0.0,
                attachments: vec![(rigid.bottom.clone(), 1.2e8, critical * (1.0 + sign * off))],
            };
            let error = case.error(2e-4);
            assert!(error < DENSE, "off {off}: {error:e}");
        }
    }
    // In the bars: beta tuned to critical damping of the fifth free mode.
    let bar = bar(0.168, 8);
    let beta = 2.0 / bar.omega2[5].sqrt();
    for off in [0.0, 1e-14, 1e-10, 1e-5] {
        for k in [1e2, 1.2e8] {
            let error = Case::bit(8, beta * (1.0 + off), k, 0.0).error(5e-5);
            assert!(error < DENSE, "beta off {off} k {k}: {error:e}");
        }
    }
}

/// Splines have modes that belong to one end of a section. Equal spans give them equal frequencies, and the amplitude
/// at the far end is a rounding.
#[test]
fn splines_on_uniform_and_stepped_bodies_flow_like_the_dense_exponential() {
    let material = Parameters::default().material;
    let stepped = |parts: &[(f64, f64)], degree, spans| {
        let list: Vec<Segment> =
            parts.iter().map(|&(length, area)| Segment { length, area }).collect();
        let sections = Sections::new(&list).expect("sections");
        Bar::stepped(&sections, &material, degree, spans).expect("modes")
    };
    // Equal spans of 5 mm at both ends, and everywhere.
    let parts = [(0.05, 2e-3), (0.03, 1e-3), (0.05, 3e-3)];
    for degree in [2, 3, 5, 7] {
        for spans in [13, 26, 39, 78] {
            let (one, other) =
                (stepped(&parts, degree, spans), stepped(&[(0.13, 2e-3)], degree, spans));
            let alone = Case {
                attachments: vec![(one.bottom.clone(), 4.8e8, 0.0)],
                omega2: one.omega2.clone(),
                beta: 2e-8,
            };
            // With another length and other spans, each body has equal pairs, of which one end is held.
            let longer = stepped(&[(0.17, 2e-3)], degree, spans + 5);
            let pairs = [(&one, &one), (&one, &other), (&other, &other), (&longer, &other)];
            let joined = pairs.into_iter().flat_map(|(p, b)| {
                [None, Some((1.2e8, 1.7e5)), Some((4.8e8, 0.0))]
                    .map(|rock| Case::joined(p, b, 2e-8, 1e11, rock))
            });
            for (index, case) in std::iter::once(alone).chain(joined).enumerate() {
                let error = case.error(3e-5);
                assert!(error < DENSE, "degree {degree} spans {spans} case {index}: {error:e}");
            }
        }
    }
}
