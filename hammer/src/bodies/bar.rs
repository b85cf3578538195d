//! A body in its own modes.
//!
//! Modes are mass-normalised: `phi.M phi = 1`. The modes of a stepped body, and of any body on splines, come from a
//! dense solver (`pencil`). For a uniform bar of linear two-node elements with consistent mass, the generalised
//! eigenproblem `K phi = omega^2 M phi` has the closed form `phi_j = a cos(theta j)`, `omega^2 = 6 E / (rho h^2) (1 -
//! cos theta) / (2 + cos theta)`, with `theta = i pi / n`. It also satisfies the first and the last row of the
//! matrices. These modes are therefore exact to rounding for any number of elements.

use crate::bodies::cache;
use crate::bodies::spline::Basis;
use crate::numerics::math;
use crate::quantities::parameters::{Material, Parameters};
use crate::quantities::sections::{Body, Sections, Segment};
use std::f64::consts::PI;

/// A body in modal form; a rigid body has only its first mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// Mass, kg.
    pub mass: f64,
    /// Squared circular frequencies, rad2/s2, ascending; 0 is the rigid mode.
    pub omega2: Vec<f64>,
    /// Modal amplitudes at the upper end, kg^-1/2.
    pub top: Vec<f64>,
    /// Modal amplitudes at the lower end, kg^-1/2.
    pub bottom: Vec<f64>,
    shapes: Shapes,
}

/// Displacement and strain between the ends.
#[derive(Clone, Debug, PartialEq)]
enum Shapes {
    /// Mode `j` is `top cos(angle i)` at node `i`; `size` is the distance between nodes, m.
    Cosines { angle: Vec<f64>, size: f64 },
    /// Each mode has coefficients in a spline basis.
    Splines { basis: Basis, coefficients: Vec<Vec<f64>> },
}

impl Bar {
    /// A body of a scene, on the scene's mesh; `None` if its modes cannot be computed to working accuracy.
    pub fn of(parameters: &Parameters, body: Body) -> Option<Self> {
        match parameters.is_elastic(body) {
            false => Some(Self::rigid(parameters.mass(body))),
            true => Self::elastic(parameters, &parameters.sections(body), parameters.spans(body)),
        }
    }

    /// The bodies from the one that the piston strikes down to the bit: a single one, or with loose joints one for each
    /// part between joints. `None` if their modes cannot be computed.
    pub(crate) fn string(parameters: &Parameters) -> Option<Vec<Self>> {
        let loose = parameters.drill.loose();
        if loose == 0 {
            return Some(vec![Self::of(parameters, Body::Bit)?]);
        }
        let string_sections = parameters.sections(Body::Bit);
        let spans = string_sections.spans(parameters.spans(Body::Bit));
        let mut bodies: Vec<usize> = parameters.drill.sections().map(|(body, _)| body).collect();
        bodies.resize(spans.len(), loose);
        let part = |body: usize| {
            let first = bodies.iter().position(|b| *b == body)?;
            let end = bodies.iter().rposition(|b| *b == body)? + 1;
            let sections = Sections::new(&string_sections.as_slice()[first..end])?;
            Self::elastic(parameters, &sections, spans[first..end].iter().sum())
        };
        (0..=loose).map(part).collect()
    }

    fn elastic(parameters: &Parameters, sections: &Sections, spans: usize) -> Option<Self> {
        let material = &parameters.material;
        match sections.as_slice() {
            [only] if parameters.mesh.degree == 1 => Some(Self::free(material, *only, spans)),
            _ => Self::stepped(sections, material, parameters.mesh.degree, spans),
        }
    }

    /// A rigid body of this mass, with one unknown.
    pub fn rigid(mass: f64) -> Self {
        let a = 1.0 / mass.sqrt();
        // A rigid body has one node and no strain.
        let shapes = Shapes::Cosines { angle: vec![0.0], size: 0.0 };
        Self { mass, omega2: vec![0.0], top: vec![a], bottom: vec![a], shapes }
    }

    /// A body of these sections with both ends free, on splines of a degree over `total` spans.
    /// `None` if the modes cannot be computed to working accuracy, for example because the sections
    /// differ by many orders of magnitude.
    pub fn stepped(
        sections: &Sections,
        material: &Material,
        degree: usize,
        total: usize,
    ) -> Option<Self> {
        let basis = Basis::new(sections, degree, total);
        let pairs = cache::modes((*sections, degree, total), &basis)?;
        let (length, mass) = (sections.length(), sections.mass(material.density));
        let (rate2, amplitude) =
            (material.youngs_modulus / (material.density * length * length), 1.0 / mass.sqrt());
        let scaled = |shape: &Vec<f64>| shape.iter().map(|c| c * amplitude).collect();
        let coefficients: Vec<Vec<f64>> = pairs.shapes.iter().map(scaled).collect();
        let ends_of = |pick: fn(&[f64]) -> f64| coefficients.iter().map(|c| pick(c)).collect();
        let (top, bottom) = (ends_of(|c| c[0]), ends_of(|c| c[c.len() - 1]));
        let omega2 = pairs.lambda.iter().map(|lambda| lambda * rate2).collect();
        let shapes = Shapes::Splines { basis, coefficients };
        Some(Self { mass, omega2, top, bottom, shapes })
    }

    /// A uniform bar with both ends free. It has `elements + 1` modes, of which the first is rigid.
    pub fn free(material: &Material, part: Segment, elements: usize) -> Self {
        let (n, modes) = (elements as f64, elements + 1);
        let h = part.length / n;
        let mass = material.density * part.area * part.length;
        let stiffness = 6.0 * material.youngs_modulus / (material.density * h * h);
        let mut angle = Vec::with_capacity(modes);
        let (mut omega2, mut top, mut bottom) = (angle.clone(), angle.clone(), angle.clone());
        for i in 0..modes {
            let theta = i as f64 * PI / n;
            let half_sine = math::sin(theta / 2.0);
            // These are 2 + cos theta and 1 - cos theta, without cancellation.
            let (inertia, elastic) =
                (3.0 - 2.0 * half_sine * half_sine, 2.0 * half_sine * half_sine);
            let ends_only = theta == 0.0 || i == elements;
            let sum = if ends_only { n } else { n / 2.0 };
            let amplitude = 1.0 / (mass / n / 3.0 * inertia * sum).sqrt();
            omega2.push(stiffness * elastic / inertia);
            top.push(amplitude);
            bottom.push(if i % 2 == 0 { amplitude } else { -amplitude });
            angle.push(theta);
        }
        Self { mass, omega2, top, bottom, shapes: Shapes::Cosines { angle, size: h } }
    }

    /// Number of modes.
    pub fn len(&self) -> usize {
        self.omega2.len()
    }

    #[cfg(feature = "internals")]
    /// True if the bar has no mode, which no constructor of this type makes.
    pub fn is_empty(&self) -> bool {
        self.omega2.is_empty()
    }

    /// Values at the nodes, from top to bottom, of two fields given by their modal coordinates.
    ///
    /// The cosines of a closed-form mode are found by rotation from node to node. This takes one sine and one cosine
    /// per mode, and adds a rounding error at each node.
    pub fn nodal(&self, first: &[f64], second: &[f64]) -> Vec<[f64; 2]> {
        match &self.shapes {
            Shapes::Cosines { angle, .. } => self.rotate(angle, first, second),
            Shapes::Splines { basis, coefficients } => {
                let [a, b] = [first, second].map(|field| combine(field, coefficients));
                basis.at_nodes().iter().map(|s| [s.value(&a), s.value(&b)]).collect()
            }
        }
    }

    fn rotate(&self, angle: &[f64], first: &[f64], second: &[f64]) -> Vec<[f64; 2]> {
        let mut nodes = vec![[0.0; 2]; self.len()];
        for (mode, (top, angle)) in self.top.iter().zip(angle).enumerate() {
            let (a, b) = (top * first[mode], top * second[mode]);
            let (sin, cos) = math::sin_cos(*angle);
            let (mut c, mut s) = (1.0, 0.0);
            for node in &mut nodes {
                node[0] += a * c;
                node[1] += b * c;
                (c, s) = (c * cos - s * sin, s * cos + c * sin);
            }
        }
        nodes
    }

    /// Strains at the middles of the spans, from top to bottom, of two fields given by their modal coordinates. The
    /// unit is that of the fields over m. A rigid body has no spans.
    pub fn strains(&self, first: &[f64], second: &[f64]) -> Vec<[f64; 2]> {
        match &self.shapes {
            Shapes::Cosines { size, .. } => {
                let nodes = self.nodal(first, second);
                let strain = |pair: &[[f64; 2]]| [0, 1].map(|k| (pair[1][k] - pair[0][k]) / size);
                nodes.windows(2).map(strain).collect()
            }
            Shapes::Splines { basis, coefficients } => {
                // Translation causes no strain.
                let [a, b] = [first, second].map(|field| combine(&field[1..], &coefficients[1..]));
                basis.at_middles().iter().map(|s| [s.slope(&a), s.slope(&b)]).collect()
            }
        }
    }
}

/// Spline coefficients of a field given by its modal coordinates.
fn combine(field: &[f64], coefficients: &[Vec<f64>]) -> Vec<f64> {
    let mut sum = vec![0.0; coefficients.first().map_or(0, Vec::len)];
    for (q, c) in field.iter().zip(coefficients) {
        sum.iter_mut().zip(c).for_each(|(s, c)| *s += q * c);
    }
    sum
}
