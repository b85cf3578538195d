//! Stationary cycles and their branches for Python.

use crate::derivatives::named;
use crate::failure::{Failure, refused};
use crate::interrupt::interruptible;
use crate::scene::lay;
use crate::turn::Turn;
use hammer::Scene;
use hammer::periodic::{Branch, Cycle, Orbit, Response, Search, Strike, find};
use hammer::sensitivity::Argument;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::HashMap;

/// A number of a cycle, of its derivatives and of their errors.
type Number = fn(&Response) -> f64;

/// The numbers of a cycle that have derivatives.
#[rustfmt::skip]
const NUMBERS: [(&str, Number); 16] = [
    ("period", |r| r.period),
    ("advance", |r| r.advance),
    ("rop", |r| r.rop),
    ("tip_rate", |r| r.tip_rate),
    ("blow_phase", |r| first(r).time),
    ("blow_speed", |r| first(r).speed),
    ("blow_energy", |r| first(r).energy),
    ("rebound_speed", |r| first(r).rebound),
    ("contact_force_peak", |r| r.peaks.contact_force()),
    ("rock_force_peak", |r| r.peaks.rock_force()),
    ("energy_drive", |r| r.energies.drive),
    ("energy_gravity", |r| r.energies.gravity),
    ("energy_feed", |r| r.energies.feed),
    ("energy_rock_dissipated", |r| r.energies.rock_dissipated),
    ("energy_viscous", |r| r.energies.viscous),
    ("energy_damping", |r| r.energies.damping),
];

fn first(response: &Response) -> Strike {
    response.strikes.first().copied().unwrap_or_default()
}

/// Names of the numbers of a cycle that have derivatives.
#[pyfunction]
pub fn cycle_numbers() -> Vec<&'static str> {
    NUMBERS.map(|(name, _)| name).to_vec()
}

/// Finds cycles of one hammer after another.
#[pyclass(frozen, module = "dth_hammer._native")]
pub struct Finder {
    inner: Turn<Inner>,
}

struct Inner {
    scene: Scene,
    search: Search,
    /// The last cycle found, and the branch that is followed from it.
    orbit: Option<Orbit>,
    branch: Option<Branch>,
}

impl Finder {
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Inner) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let mut turn = self.inner.begin(py)?;
        Ok(interruptible(py, turn.attempt(work))?)
    }
}

#[pymethods]
impl Finder {
    #[new]
    fn new(numbers: HashMap<String, f64>) -> PyResult<Self> {
        let mut scene = Scene::default();
        lay(&mut scene, &numbers)?;
        let inner = Inner { scene, search: Search::default(), orbit: None, branch: None };
        Ok(Self { inner: Turn::new(inner) })
    }

    /// How cycles are sought: `returns`, `settle`, `steps`, `longest_return` (s), `krylov_vectors`.
    fn settings(&self, py: Python<'_>, values: HashMap<String, f64>) -> PyResult<()> {
        for (name, value) in &values {
            let (least, most) = match name.as_str() {
                "returns" => (1.0, 64.0),
                "settle" | "steps" => (0.0, 1e4),
                "longest_return" => (1e-6, 1e3),
                "krylov_vectors" => (0.0, 200.0),
                _ => {
                    return Err(refused(format!(
                        "there is no setting {name:?}: the settings are returns, settle, steps, longest_return, krylov_vectors"
                    )));
                }
            };
            if !(least..=most).contains(value) {
                return Err(refused(format!("{name} = {value} must be {least} to {most}")));
            }
        }
        self.work(py, |inner| {
            for (name, value) in &values {
                let whole = *value as usize;
                match name.as_str() {
                    "returns" => inner.search.returns = whole,
                    "settle" => inner.search.settle = whole,
                    "steps" => inner.search.steps = whole,
                    "longest_return" => inner.search.limit = *value,
                    _ => inner.search.multipliers = whole,
                }
            }
            Ok(())
        })
    }

    /// The cycle with numbers laid over those before, differentiated by arguments. `near` begins
    /// where the last one was found, without `settle` at once.
    fn find<'py>(
        &self,
        py: Python<'py>,
        changed: HashMap<String, f64>,
        by: Vec<String>,
        near: bool,
        settle: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let by = named(&by)?;
        let mut scene = self.work(py, |inner| Ok(inner.scene))?;
        lay(&mut scene, &changed)?;
        let cycle = self.work(py, |inner| {
            (inner.scene, inner.branch) = (scene, None);
            let start = inner.orbit.clone().filter(|_| near);
            let settle = if start.is_some() && !settle { 0 } else { inner.search.settle };
            let search = Search { start, settle, ..inner.search.clone() };
            let cycle = find(&scene, &search, &by)?;
            inner.orbit = Some(cycle.orbit.clone());
            Ok(cycle)
        })?;
        converted(py, &cycle, &by)
    }

    /// Begins a branch at the last cycle found, along an argument.
    fn begin_branch(&self, py: Python<'_>, along: String, rising: bool) -> PyResult<()> {
        let along = named(&[along])?[0];
        self.work(py, |inner| {
            let orbit = inner.orbit.clone();
            let orbit = orbit
                .ok_or_else(|| Failure::refused("a branch begins at a cycle: call find() first"))?;
            inner.branch = Some(Branch::new(&inner.scene, along, &inner.search, &orbit, rising)?);
            Ok(())
        })
    }

    /// Its next point: the argument's value, whether that rises from there, whether the way there
    /// was not resolved, and the cycle. Fails where the branch ends.
    fn next<'py>(
        &self,
        py: Python<'py>,
        longest: f64,
        by: Vec<String>,
    ) -> PyResult<(f64, bool, bool, Bound<'py, PyDict>)> {
        let by = named(&by)?;
        let point = self.work(py, |inner| {
            let branch = inner.branch.as_mut();
            let branch = branch
                .ok_or_else(|| Failure::refused("no branch has been begun: call branch() first"))?;
            Ok(branch.next(longest, &by)?)
        })?;
        Ok((point.value, point.rising, point.unresolved, converted(py, &point.cycle, &by)?))
    }
}

/// A cycle as a dictionary, in SI units.
fn converted<'py>(py: Python<'py>, cycle: &Cycle, by: &[Argument]) -> PyResult<Bound<'py, PyDict>> {
    let answer = PyDict::new(py);
    for (name, number) in NUMBERS {
        answer.set_item(name, number(&cycle.response))?;
    }
    let rows = |of: fn(&hammer::periodic::Gradient) -> &Response| -> Vec<Vec<f64>> {
        let row = |(_, number): &(&str, Number)| {
            cycle.gradients.iter().map(|gradient| number(of(gradient))).collect()
        };
        NUMBERS.iter().map(row).collect()
    };
    answer.set_item("gradient", rows(|g| &g.values))?;
    answer.set_item("gradient_errors", rows(|g| &g.errors))?;
    answer.set_item("reach", cycle.gradients.iter().map(|g| g.reach).collect::<Vec<_>>())?;
    let why = cycle.gradients.iter().zip(by).flat_map(|(gradient, argument)| {
        gradient.nonsmooth.iter().map(|why| format!("by {}: {why}", argument.name()))
    });
    answer.set_item("nonsmooth", why.collect::<Vec<_>>())?;
    answer.set_item("blows", cycle.response.strikes.len())?;
    answer.set_item("events", cycle.sequence.len())?;
    let multipliers: Vec<[f64; 2]> = cycle.multipliers.iter().map(|m| [m.re, m.im]).collect();
    answer.set_item("multipliers", multipliers)?;
    answer.set_item("stable", cycle.is_stable())?;
    answer.set_item("distance", cycle.distance)?;
    answer.set_item("steps", cycle.steps[0])?;
    answer.set_item("fingerprint", cycle.fingerprint() as u64)?;
    Ok(answer)
}
