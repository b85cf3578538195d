//! `diffsol`: Tsit45 (explicit; its right-hand side solves with `M`), BDF and ESDIRK34 (in mass matrix form with sparse LU), each with the crate's own root finding.
//!
//! The state is `(u, v, psi)`; the roots are the guards of the mode, padded to five. They are lowered by their
//! resolution, so that the guard just crossed does not start at zero, with either sign (an event is then late by 1e-9
//! m/s over the slope, some 1e-13 s). Every mode starts a new solver, which lets the crate choose the first step and
//! forget the old Jacobian.

use crate::schema::{Answer, Peer, Task};
use diffsol::{
    DiffsolError, FaerSparseLU, FaerSparseMat, NalgebraMat, OdeBuilder, OdeEquations,
    OdeSolverMethod, OdeSolverStopReason, Vector,
};
use oracles::law::{Guard, Memory, Mode, Rock, State};
use oracles::model::Model;
use std::cell::RefCell;
use std::time::Instant;

const ROOTS: usize = 5;

/// Which of the crate's methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Tsitouras 5(4).
    Tsit45,
    /// Variable-order BDF.
    Bdf,
    /// Singly diagonally implicit, order 4(3), explicit first stage.
    Esdirk34,
}

/// The solver with its tolerance: relative, and absolute in 1 mm, 1 m/s, 1 J.
pub struct Diffsol<'a> {
    /// The hammer.
    pub model: &'a Model<f64>,
    /// Method.
    pub method: Method,
    /// Tolerance.
    pub tolerance: f64,
}

/// Data that the closures share with the event loop.
struct Shared<'a> {
    model: &'a Model<f64>,
    time: f64,
    mode: Mode,
    memory: Memory<f64>,
    state: State<f64>,
    load: Vec<f64>,
    guards: Vec<Guard<f64>>,
}

impl<'a> Shared<'a> {
    fn new(model: &'a Model<f64>) -> Self {
        let (state, mode, memory) = model.start();
        let load = model.load(mode, &memory);
        let guards = model.guards(mode, &memory);
        Self { model, time: 0.0, mode, memory, state, load, guards }
    }

    fn set(&mut self, y: &[f64]) {
        let n = self.model.nodes();
        self.state = State { u: y[..n].to_vec(), v: y[n..2 * n].to_vec(), psi: y[2 * n] };
    }

    fn init(&self, y: &mut [f64]) {
        let n = self.model.nodes();
        y[..n].copy_from_slice(&self.state.u);
        y[n..2 * n].copy_from_slice(&self.state.v);
        y[2 * n] = self.state.psi;
    }

    fn roots(&self, x: &[f64], y: &mut [f64]) {
        let n = self.model.nodes();
        y.fill(-1.0);
        for (y, guard) in y.iter_mut().zip(&self.guards) {
            let quantity = self.model.quantity_of(guard.quantity, &x[..n], &x[n..2 * n], x[2 * n]);
            *y = guard.value(quantity) - guard.height;
        }
    }

    fn rhs(&self, x: &[f64], y: &mut [f64]) {
        let n = self.model.nodes();
        let (u, v) = (&x[..n], &x[n..2 * n]);
        y[..n].copy_from_slice(v);
        self.model.acceleration(self.mode, &self.load, u, v, &mut y[n..2 * n]);
        y[2 * n] = self.model.power(self.mode, v);
    }

    /// The right-hand side without `M^-1`.
    fn forces(&self, load: &[f64], x: &[f64], y: &mut [f64]) {
        let n = self.model.nodes();
        let (u, v) = (&x[..n], &x[n..2 * n]);
        let system = self.model.system(self.mode);
        y[..n].copy_from_slice(v);
        y[n..2 * n].copy_from_slice(load);
        system.stiffness.subtract_product(u, &mut y[n..2 * n]);
        system.damping.subtract_product(v, &mut y[n..2 * n]);
        y[2 * n] = self.model.power(self.mode, v);
    }

    /// Its derivative along `d`.
    fn tangent(&self, x: &[f64], d: &[f64], y: &mut [f64]) {
        let n = self.model.nodes();
        self.forces(&vec![0.0; n], d, y);
        let viscosity = self.model.scene.rock.viscosity;
        let power = 2.0 * viscosity * x[2 * n - 1] * d[2 * n - 1];
        y[2 * n] = if self.mode.rock == Rock::DFC { power } else { 0.0 * d[2 * n - 1] };
    }

    /// `y = diag(1, M, 1) d + beta y`.
    fn mass(&self, d: &[f64], beta: f64, y: &mut [f64]) {
        let n = self.model.nodes();
        let minus: Vec<f64> = d[n..2 * n].iter().map(|v| -v).collect();
        y.iter_mut().for_each(|y| *y *= beta);
        (0..n).for_each(|i| y[i] += d[i]);
        self.model.mass.subtract_product(&minus, &mut y[n..2 * n]);
        y[2 * n] += d[2 * n];
    }

    fn pass(&mut self, index: usize) -> oracles::law::Event {
        let event = self.guards[index].event;
        self.model.transition(event, &mut self.mode, &mut self.memory, &mut self.state);
        self.load = self.model.load(self.mode, &self.memory);
        self.guards = self.model.guards(self.mode, &self.memory);
        event
    }
}

/// Steps through one mode, to its end or the end of the task. Returns the guard that ended it.
fn segment<'a, E, S>(
    mut solver: S,
    shared: &RefCell<Shared>,
    task: &Task,
    done: &mut Answer,
    clock: Instant,
) -> Result<Option<usize>, String>
where
    E: OdeEquations<T = f64> + 'a,
    S: OdeSolverMethod<'a, E>,
{
    let text = |e: DiffsolError| e.to_string();
    loop {
        let stop = task.instants.get(done.states.len()).copied().unwrap_or(task.end);
        if solver.state().t < stop {
            solver.set_stop_time(stop).map_err(text)?;
        }
        let reason = loop {
            match solver.step().map_err(text)? {
                OdeSolverStopReason::InternalTimestep => {}
                reason => break reason,
            }
            if clock.elapsed().as_secs_f64() > task.patience {
                return Err(format!("gave up at {:.6} s", solver.state().t));
            }
        };
        if let OdeSolverStopReason::RootFound(time, index) = reason {
            let y = solver.interpolate(time).map_err(text)?;
            let mut shared = shared.borrow_mut();
            shared.set(&y.clone_as_vec());
            shared.time = time;
            return Ok(Some(index));
        }
        shared.borrow_mut().set(&solver.state().y.clone_as_vec());
        if done.states.len() < task.instants.len() {
            done.keep(task, &shared.borrow().state);
        } else {
            return Ok(None);
        }
    }
}

impl Diffsol<'_> {
    fn tolerances(&self) -> Vec<f64> {
        let n = self.model.nodes();
        let mut atol = vec![self.tolerance; 2 * n + 1];
        atol[..n].fill(1e-3 * self.tolerance);
        atol
    }

    fn explicit(&self, task: &Task) -> Result<Answer, String> {
        let shared = RefCell::new(Shared::new(self.model));
        let mut problem = OdeBuilder::<NalgebraMat<f64>>::new()
            .rtol(self.tolerance)
            .atol(self.tolerances())
            .rhs(|x: &[f64], _: &[f64], _, y: &mut [f64]| shared.borrow().rhs(x, y))
            .init(|_: &[f64], _, y: &mut [f64]| shared.borrow().init(y), self.tolerances().len())
            .root(|x: &[f64], _: &[f64], _, y: &mut [f64]| shared.borrow().roots(x, y), ROOTS)
            .build()
            .map_err(|e| e.to_string())?;
        let mut done = Answer::default();
        let clock = Instant::now();
        loop {
            problem.t0 = shared.borrow().time;
            let solver = problem.tsit45().map_err(|e| e.to_string())?;
            let Some(index) = segment(solver, &shared, task, &mut done, clock)? else {
                return Ok(done);
            };
            let event = shared.borrow_mut().pass(index);
            done.events.push((shared.borrow().time, event));
        }
    }

    fn implicit(&self, task: &Task) -> Result<Answer, String> {
        let shared = RefCell::new(Shared::new(self.model));
        // The sparsity is found by probing, here in the mode with the fullest pattern.
        let start = shared.borrow().mode;
        shared.borrow_mut().mode = Mode::bare(true, Rock::DFC);
        let load = |x: &[f64], y: &mut [f64]| {
            let shared = shared.borrow();
            shared.forces(&shared.load, x, y);
        };
        let mut problem = OdeBuilder::<FaerSparseMat<f64>>::new()
            .rtol(self.tolerance)
            .atol(self.tolerances())
            .use_coloring(true)
            .rhs_implicit(
                |x: &[f64], _: &[f64], _, y: &mut [f64]| load(x, y),
                |x: &[f64], _: &[f64], _, d: &[f64], y: &mut [f64]| {
                    shared.borrow().tangent(x, d, y)
                },
            )
            .mass(|d: &[f64], _: &[f64], _, beta, y: &mut [f64]| shared.borrow().mass(d, beta, y))
            .init(|_: &[f64], _, y: &mut [f64]| shared.borrow().init(y), self.tolerances().len())
            .root(|x: &[f64], _: &[f64], _, y: &mut [f64]| shared.borrow().roots(x, y), ROOTS)
            .build()
            .map_err(|e| e.to_string())?;
        shared.borrow_mut().mode = start;
        // In one long flight BDF has more failures than the default limit of 50.
        problem.ode_options.max_nonlinear_solver_failures = usize::MAX;
        problem.ode_options.min_timestep = 1e-18;
        let mut done = Answer::default();
        let clock = Instant::now();
        type Lu = FaerSparseLU<f64>;
        loop {
            problem.t0 = shared.borrow().time;
            let text = |e: DiffsolError| e.to_string();
            let ended = if self.method == Method::Bdf {
                let solver = problem.bdf::<Lu>().map_err(text)?;
                segment(solver, &shared, task, &mut done, clock)?
            } else {
                let solver = problem.esdirk34::<Lu>().map_err(text)?;
                segment(solver, &shared, task, &mut done, clock)?
            };
            let Some(index) = ended else { return Ok(done) };
            let event = shared.borrow_mut().pass(index);
            done.events.push((shared.borrow().time, event));
        }
    }
}

impl Peer for Diffsol<'_> {
    fn run(&mut self, task: &Task) -> Result<Answer, String> {
        match self.method {
            Method::Tsit45 => self.explicit(task),
            Method::Bdf | Method::Esdirk34 => self.implicit(task),
        }
    }
}
