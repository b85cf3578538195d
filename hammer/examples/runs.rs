//! Typical tasks of users, for a profiler: `runs 20 rock` makes 20 runs of 1 s, each in another rock; `runs count rock` counts the instructions of the second of two by valgrind. `evidence/bench/cost.py` makes a page of such counts.
//!
//! Words after the number: `rock`, `feed`: what differs from run to run; `seconds=10`: duration of a run; `first=4`:
//! instead, up to so many blows, in steps of 1 ms; `energies`, `outputs`: what is read after each of these steps, in
//! addition to the tip's depth; `mean`: the long-run response; `gradient`: a run with its derivatives by the rock's
//! stiffness and the feed force; `steps`: in ten steps; `rigid`, `elements=20`, `preset=top_hammer`, `mesh.degree=3`
//! or any other number of the table: the scene; `coupled`: pressures with their derivatives, set every 100 us; `AVX2`
//! and the like: the vectors. It prints the vectors, a sum of results, and blows and events of the last run.

mod callgrind;

use callgrind::instructions;
use hammer::Scene;
use hammer::means::{Wanted, steady};
use hammer::sensitivity::{Argument, Sample, derivatives};
use hammer::variables::{InputRow, Output, Parameter, Role, Slot, VARIABLES};
use hammer::{Error, Fidelity, Input, Machine, Source, Vectors};
use std::cell::Cell;

type Action = fn(&Plan, &Scene) -> Result<f64, Error>;

/// How the runs differ, and what is done in each.
struct Plan {
    scene: Scene,
    varied: Vec<Argument>,
    action: Action,
    /// Length of a run, s.
    seconds: f64,
    /// The blow that ends a run; 0: none.
    first: u64,
    steps: u32,
    /// The outputs that are read after each step.
    read: Vec<Output>,
    /// Blows and events of the last run.
    counted: Cell<[u64; 2]>,
}

/// The outputs whose names begin with this text.
fn outputs(with: &str) -> Vec<Output> {
    let named = VARIABLES.iter().filter(|row| row.name.starts_with(with));
    named
        .filter_map(|row| if let Role::Output(output) = row.role { Some(output) } else { None })
        .collect()
}

fn argument(name: &str) -> Argument {
    Argument::named(name).expect("a name of the table")
}

/// What is done in a scene.
impl Plan {
    /// The hole's depth at the end of a run, m.
    fn depth(&self, scene: &Scene) -> Result<f64, Error> {
        let mut machine = scene.machine()?;
        for step in 1..=self.steps {
            machine.advance(self.seconds * f64::from(step) / f64::from(self.steps))?;
        }
        Ok(self.end(&machine))
    }

    /// The same, in steps of 1 ms up to a blow.
    fn start(&self, scene: &Scene) -> Result<f64, Error> {
        let (mut machine, mut sum) = (scene.machine()?, 0.0);
        while machine.counters().blows < self.first {
            machine.advance(machine.time() + 1e-3)?;
            for output in &self.read {
                output.prepare.map_or(Ok(()), |prepare| prepare(&machine))?;
                sum += (output.value)(&mut machine);
            }
        }
        std::hint::black_box(sum);
        Ok(self.end(&machine))
    }

    fn end(&self, machine: &Machine) -> f64 {
        self.counted.set([machine.counters().blows, machine.counters().events]);
        machine.kinematics().tip_depth
    }

    fn mean(&self, scene: &Scene) -> Result<f64, Error> {
        Ok(steady(scene, &Wanted::default(), &mut |_, _| true)?.mean.rop())
    }

    fn gradient(&self, scene: &Scene) -> Result<f64, Error> {
        let by = ["rock.stiffness", "feed_force"].map(argument);
        let depth = |machine: &mut Machine| vec![machine.kinematics().tip_depth];
        let end = self.seconds;
        let sample = |scene: &Scene| Sample::of_run(&mut scene.machine()?, &[end], &|m| depth(m));
        Ok(derivatives(scene, &by, &sample)?.iter().map(|row| row.values[0]).sum())
    }

    /// Pressures of a partner that passes their derivatives from step to step: the force of a spring on the piston.
    fn coupled(&self, scene: &Scene) -> Result<f64, Error> {
        let mut machine = scene.machine()?;
        for step in 1..=10_000 {
            let (x, v) = {
                let now = machine.kinematics();
                (now.relative.displacement, now.relative.velocity)
            };
            machine.set_input(Input::DrivePressure, &[4e5 - 3e7 * (x + 0.02), -3e7 * v])?;
            machine.set_input(Input::ReturnPressure, &[4e5 + 3e7 * (x + 0.02), 3e7 * v])?;
            machine.advance(self.seconds * f64::from(step) / 10_000.0)?;
        }
        Ok(machine.kinematics().tip_depth)
    }
}

/// Sets a parameter or an input of the table.
fn set(scene: &mut Scene, name: &str, value: &str) -> Result<(), Box<dyn std::error::Error>> {
    let row = VARIABLES.iter().find(|row| row.name == name).ok_or("no such variable")?;
    match row.role {
        Role::Parameter(Parameter { slot: Slot::Real(_, access), .. }) => {
            *access(&mut scene.parameters) = value.parse()?;
        }
        Role::Parameter(Parameter { slot: Slot::Integer(access), .. }) => {
            *access(&mut scene.parameters) = value.parse()?;
        }
        Role::Parameter(Parameter { slot: Slot::Choice(_, _, choose), .. }) => {
            choose(&mut scene.parameters, value.parse()?);
        }
        Role::Input(InputRow { start, .. }) => *start(&mut scene.inputs) = value.parse()?,
        _ => return Err(format!("{name}: neither a parameter nor an input").into()),
    }
    Ok(())
}

impl Plan {
    fn new(words: &[String]) -> Result<Self, Box<dyn std::error::Error>> {
        let (scene, varied) = (Scene::default(), Vec::new());
        let (action, counted, read) = (Self::depth as Action, Cell::default(), Vec::new());
        let mut plan =
            Self { scene, varied, action, seconds: 1.0, first: 0, steps: 1, read, counted };
        for word in words {
            let p = &mut plan.scene.parameters;
            match word.split_once('=').unwrap_or((word, "")) {
                ("rock", _) => plan.varied.push(argument("rock.stiffness")),
                ("feed", _) => plan.varied.push(argument("feed_force")),
                ("seconds", number) => plan.seconds = number.parse()?,
                ("first", blows) => {
                    plan.first = blows.parse()?;
                    plan.action = Self::start;
                }
                ("energies", _) => plan.read = outputs("energy"),
                ("outputs", _) => plan.read = outputs(""),
                ("mean", _) => plan.action = Self::mean,
                ("gradient", _) => plan.action = Self::gradient,
                ("steps", _) => plan.steps = 10,
                ("coupled", _) => {
                    p.drive.source = Source::Pressure;
                    plan.action = Self::coupled;
                }
                ("rigid", _) => p.fidelity = Fidelity::Rigid,
                ("elements", count) => {
                    (p.piston.elements, p.bit.elements) = (count.parse()?, count.parse()?);
                }
                ("preset", name) => {
                    let preset = hammer::presets::Preset::named(name).ok_or("no such preset")?;
                    plan.scene = preset.start();
                }
                (name, value) if !value.is_empty() => set(&mut plan.scene, name, value)?,
                (name, _) => {
                    let vectors = Vectors::available().find(|v| v.to_string() == name);
                    if !vectors.is_some_and(Vectors::select) {
                        return Err(format!("{name}: no such word, or no such vectors").into());
                    }
                }
            }
        }
        Ok(plan)
    }

    /// Run `i`, with a thousandth more of what varies.
    fn run(&self, i: u32) -> Result<f64, Error> {
        let vary = |scene: Scene, argument: &Argument| {
            argument.at(&scene, argument.value(&scene) * (1.0 + 1e-3 * f64::from(i)))
        };
        (self.action)(self, &self.varied.iter().fold(self.scene, vary))
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let more = words.get(1..).unwrap_or_default();
    if words.first().is_some_and(|word| word == "count") {
        let [one, two] = [instructions(1, more)?, instructions(2, more)?];
        println!("{}", two - one);
        return Ok(());
    }
    let runs: u32 = words.first().map_or(Ok(20), |text| text.parse())?;
    let plan = Plan::new(more)?;
    let sum: f64 = (0..runs).map(|i| plan.run(i)).sum::<Result<f64, _>>()?;
    let [blows, events] = plan.counted.get();
    println!("{} {sum:e} {blows} {events}", Vectors::in_use());
    Ok(())
}
