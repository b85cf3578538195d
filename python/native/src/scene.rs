//! Parameters and start values of inputs by name, and what follows from them alone.

use crate::failure::{Failure, refused};
use crate::table::{FAMILIES, Family, row};
use hammer::variables::Role;
use hammer::{Body, Fidelity, InputValues, Parameters};
use numpy::PyArray1;
use pyo3::prelude::*;
use std::collections::HashMap;

/// A hammer's parameters, and its inputs at the start.
#[derive(Clone)]
pub struct Scene {
    pub parameters: Parameters,
    pub inputs: InputValues,
}

impl Scene {
    /// The reference hammer with these numbers laid over it.
    pub fn of(numbers: &HashMap<String, f64>) -> PyResult<Self> {
        let mut scene = Self { parameters: Parameters::default(), inputs: InputValues::default() };
        for (name, value) in numbers {
            match &row(name)?.1.role {
                Role::Parameter { slot, .. } => slot.write(&mut scene.parameters, *value),
                Role::Input { start, .. } => *start(&mut scene.inputs) = *value,
                _ => return Err(refused(format!("{name} is a result: it cannot be set"))),
            }
        }
        Ok(scene)
    }

    /// The same, refused where the engine would refuse it.
    fn checked(numbers: &HashMap<String, f64>) -> PyResult<Self> {
        let scene = Self::of(numbers)?;
        scene.parameters.validate().map_err(Failure::from)?;
        Ok(scene)
    }
}

/// The body of a name.
fn body(name: &str) -> PyResult<Body> {
    let found = Body::ALL.into_iter().find(|body| body.name() == name);
    found.ok_or_else(|| refused(format!("there is no body {name:?}")))
}

/// Lengths (m) and areas (m2) of a body's sections, from top to bottom.
#[pyfunction]
#[pyo3(name = "sections")]
pub fn sections(numbers: HashMap<String, f64>, name: &str) -> PyResult<Vec<(f64, f64)>> {
    let sections = Scene::checked(&numbers)?.parameters.sections(body(name)?);
    Ok(sections.as_slice().iter().map(|s| (s.length, s.area)).collect())
}

/// Distances of the mesh's nodes below a body's upper face, m.
#[pyfunction]
pub fn nodes<'py>(
    py: Python<'py>,
    numbers: HashMap<String, f64>,
    name: &str,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (parameters, body) = (Scene::checked(&numbers)?.parameters, body(name)?);
    let nodes = parameters.sections(body).nodes(parameters.spans(body));
    Ok(PyArray1::from_vec(py, nodes))
}

/// Width of the sharpest front (m), and degree and spans of piston and bit on which forces at
/// an impact err by no more than `error`, if there is such a mesh.
#[pyfunction]
pub fn mesh(numbers: HashMap<String, f64>, error: f64) -> PyResult<(f64, Option<[usize; 3]>)> {
    let parameters = Scene::checked(&numbers)?.parameters;
    let advice = parameters.mesh_for(error).map(|m| [m.degree, m.piston, m.bit]);
    Ok((parameters.front_width(), advice))
}

/// Names of all that a hammer has along its bodies.
#[pyfunction]
pub fn wave_names(numbers: HashMap<String, f64>) -> PyResult<Vec<String>> {
    let parameters = Scene::checked(&numbers)?.parameters;
    if parameters.fidelity == Fidelity::Rigid {
        return Err(refused("rigid bodies carry no waves: set fidelity = Elastic"));
    }
    let members = |family: &'static Family| {
        let count = parameters.spans(family.body) + usize::from(family.nodal);
        (1..=count).map(|k| format!("{}[{k}]", family.name))
    };
    Ok(FAMILIES.iter().flat_map(members).collect())
}
