//! Work of a cycle: a slower algorithm fails here. The counts are of this algorithm, not of a machine; a change that
//! lowers them updates them.

use hammer::Scene;
use hammer::means::{Wanted, steady};
use hammer::presets::Preset;
use hammer::sensitivity::{Argument, Sample, derivatives};
use hammer::variables::VARIABLES;
use hammer::{Fidelity, Input, InputValues, Machine, Parameters, Source, Vectors};
use scenes::Random;
use std::process::Command;

#[allow(dead_code, reason = "each test program uses its part")]
mod scenes;

/// Events, changes of basis, evaluations of guards, windows and rotations so far.
fn work(machine: &Machine) -> [u64; 5] {
    let c = machine.counters();
    [c.events, c.basis_changes, c.guard_evaluations, c.windows, c.samples]
}

/// Work from the start of cycle `from` to the start of cycle `to` of a hammer.
fn counts(scene: &Scene, from: u64, to: u64) -> [u64; 5] {
    let mut machine = scene.machine().expect("a scene");
    let mut at = |blows: u64| {
        while machine.counters().blows < blows {
            machine.advance(machine.time() + 1e-3).expect("a step");
        }
        work(&machine)
    };
    let (a, b) = (at(from), at(to));
    std::array::from_fn(|i| b[i] - a[i])
}

/// Moves a hammer by so many steps of 100 us, under pressures that are set with their derivatives at each: the force
/// of a spring on the piston.
fn coupled(machine: &mut Machine, steps: u32) {
    let start = machine.time();
    for step in 1..=steps {
        let now = machine.kinematics();
        let (x, v) = (now.relative.displacement + 0.02, now.relative.velocity);
        machine.set_input(Input::DrivePressure, &[4e5 - 3e7 * x, -3e7 * v]).expect("a pressure");
        machine.set_input(Input::ReturnPressure, &[4e5 + 3e7 * x, 3e7 * v]).expect("a pressure");
        machine.advance(start + 1e-4 * f64::from(step)).expect("a step");
    }
}

#[test]
fn flight_costs_a_handful_of_evaluations() {
    // From 21 ms to 41 ms the bit stands still, and only the relay can switch, so that bounds decide.
    let mut machine =
        Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene");
    machine.advance(0.021).expect("a step");
    let before = machine.counters();
    machine.advance(0.041).expect("a step");
    let after = machine.counters();
    assert_eq!(after.events - before.events, 1);
    let evaluations = after.guard_evaluations - before.guard_evaluations;
    assert!(evaluations < 100, "{evaluations} evaluations in 20 ms of flight");
}

/// The physics determines the number of events of the settled cycle, which repeats exactly. The search may take no
/// more work than this.
#[test]
fn a_settled_cycle_takes_no_more_work_than_it_did() {
    let [events, changes, evaluations, windows, samples] = counts(&Scene::default(), 12, 32);
    let cycles = 20;
    // A step of 1 ms after the blow contains only some of its events, which averages out to one part in twenty over
    // 20 cycles.
    assert!((47..=53).contains(&(events / cycles)), "{} events per cycle", events / cycles);
    // Only the relay, twice a cycle, and the barrier do not change the basis; a blow's contact changes it twice.
    assert!(
        (30..=44).contains(&(changes / cycles)),
        "{} changes of basis a cycle",
        changes / cycles
    );
    assert!(evaluations <= 1050 * cycles, "{} evaluations per cycle", evaluations / cycles);
    assert!(windows <= 37 * cycles, "{} windows per cycle", windows / cycles);
    assert!(samples <= 1050 * cycles, "{} rotations per cycle", samples / cycles);
}

/// A scene of typical users, by its name.
fn scene(name: &str) -> Scene {
    if let Ok(number) = name.parse() {
        return drawn(number);
    }
    let preset = |name: &str| Preset::named(name).expect("a preset").start();
    let mut scene = match name {
        "air" => preset("air_4_inch"),
        "water" => preset("water_hammer"),
        "top hammer" | "loose top hammer" => preset("top_hammer"),
        _ => Scene::default(),
    };
    let p = &mut scene.parameters;
    match name {
        "casing" => p.casing.mass = 40.0,
        "coupled" => p.drive.source = Source::Pressure,
        "line, rigid" => {
            (p.drive.source, p.drive.impedance) = (Source::Force, 1e3);
            p.fidelity = Fidelity::Rigid;
        }
        "ramp" => p.drive.source = Source::Force,
        "rigid" => p.fidelity = Fidelity::Rigid,
        "line" => (p.drive.source, p.drive.impedance) = (Source::Force, 1e3),
        "line, casing" => {
            (p.drive.source, p.drive.impedance, p.casing.mass) = (Source::Force, 1e3, 4.0);
            (p.mesh.degree, p.piston.elements, p.bit.elements) = (7, 2, 18);
        }
        "air, reference" => p.drive.source = Source::Air,
        "air, rigid" => (p.drive.source, p.fidelity) = (Source::Air, Fidelity::Rigid),
        "barrier" => (p.rock.viscosity, p.rock.energy_barrier) = (1e7, 1e6),
        "chatter" => {
            (p.piston.elements, p.bit.elements, p.mesh.degree) = (4, 4, 7);
            (p.material.damping_time, p.contact.initial_gap) = (0.0, 1e-6);
            p.drive.source = Source::Force;
            p.contact.stiffness = 1e6 * p.mesh_stiffness();
            scene.inputs.drive_force = 1e4;
        }
        "loose top hammer" => p.drill.joint.stiffness = 3e9,
        _ => {}
    }
    scene
}

/// At most the known counts (which are the same on all processors) and a tenth more. A change that lowers them
/// updates them.
fn at_most(name: &str, found: [u64; 5], known: [u64; 5]) {
    println!("{name}: {found:?}");
    for (found, known) in found.into_iter().zip(known) {
        assert!(10 * found <= 11 * known, "{name}: {found} for {known}");
    }
}

/// Two blows after the first two.
#[test]
fn a_blow_of_what_users_run_takes_no_more_work_than_it_did() {
    for (name, known) in BLOWS {
        at_most(name, counts(&scene(name), 2, 4), known);
    }
}

/// A thousand steps, in which the hammer strikes.
#[test]
fn a_coupled_step_takes_no_more_work_than_it_did() {
    let mut machine = scene("coupled").machine().expect("a scene");
    coupled(&mut machine, 1000);
    assert!(machine.counters().blows > 0, "{:?}", machine.counters());
    at_most("coupled", work(&machine), COUPLED);
}

const COUPLED: [u64; 5] = [76, 65, 5417, 54, 6580];

const BLOWS: [(&str, [u64; 5]); 7] = [
    ("air, reference", [188, 85, 3620, 32, 4577]),
    ("air, rigid", [137, 0, 0, 0, 0]),
    ("air", [156, 143, 2771, 21, 4097]),
    ("water", [82, 69, 1294, 82, 1431]),
    ("casing", [187, 198, 3865, 68, 3605]),
    ("top hammer", [209, 209, 3975, 120, 4276]),
    ("loose top hammer", [1326, 1770, 38314, 347, 45478]),
];

/// Environment variable of the process under valgrind: number of settled cycles.
const CYCLES: &str = "HAMMER_CYCLES";
/// Likewise: energies are read at every communication point.
const ASKED: &str = "HAMMER_ENERGIES";
/// Likewise: which of [`TASKS`] to do instead.
const TASK: &str = "HAMMER_TASK";
/// Name of the test below, which starts itself under valgrind.
const COUNTED: &str = "instructions_of_a_settled_cycle_stay_near_the_stated_count";

/// 12 blows to settle, then so many cycles, in communication steps of 1 ms.
fn run(cycles: u64, asked: bool) {
    let mut machine =
        Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene");
    let mut sum = 0.0;
    while machine.counters().blows < 12 + cycles {
        machine.advance(machine.time() + 1e-3).expect("a step");
        if asked {
            sum += machine.energies().residual;
        }
    }
    assert!(sum.is_finite());
    println!("vectors: {}", Vectors::in_use());
}

/// Instructions of a test of this file with these variables, by callgrind; none if it does not run in AVX2.
fn instructions(test: &str, variables: &[(&str, &str)]) -> Option<f64> {
    let mut command = Command::new("valgrind");
    command
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().expect("this test"))
        .args(["--exact", "--nocapture", "--test-threads=1", test])
        .envs(variables.iter().copied());
    let output = command.output().expect("valgrind");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{stderr}", output.status);
    let stdout = String::from_utf8_lossy(&output.stdout);
    if !stdout.contains("vectors: AVX2") {
        return None;
    }
    let line = stderr.lines().find(|line| line.contains("refs:")).expect("a count");
    let digits: String =
        line.rsplit("refs:").next()?.chars().filter(char::is_ascii_digit).collect();
    digits.parse().ok()
}

/// Instructions of a settled reference cycle in AVX2, as the suite builds it (`opt-level = 2`, with overflow checks),
/// without and with reading the energies at every 1 ms. A change that lowers them updates them. The margin allows for
/// other compilers and C libraries. `cargo work-per-cycle` counts those of a release build.
#[test]
fn instructions_of_a_settled_cycle_stay_near_the_stated_count() {
    if let Ok(cycles) = std::env::var(CYCLES) {
        return run(cycles.parse().expect("a number"), std::env::var(ASKED).is_ok());
    }
    if !is_counting() {
        return;
    }
    for (asked, stated) in [(false, STATED[0]), (true, STATED[1])] {
        let counted = ["0", "10"].map(|cycles| {
            let all = [(CYCLES, cycles), (ASKED, "1")];
            instructions(COUNTED, &all[..1 + usize::from(asked)])
        });
        let [Some(settled), Some(ten)] = counted else {
            println!("skipped: valgrind's processor has no AVX2");
            return;
        };
        let cycle = (ten - settled) / 10.0;
        println!("{cycle:.0} instructions per cycle, energies asked for: {asked}");
        assert!(
            (cycle / stated - 1.0).abs() < MARGIN,
            "{cycle:.0} instructions, stated {stated:.0}"
        );
    }
}

/// Instructions per cycle.
const STATED: [f64; 2] = [4.15e6, 5.90e6];
const MARGIN: f64 = 0.15;

/// True if valgrind is installed.
fn is_counting() -> bool {
    let found = Command::new("valgrind").arg("--version").output().is_ok();
    if !found {
        println!("skipped: valgrind is not installed");
    }
    found
}

/// Does one of [`TASKS`].
fn perform(task: &str) {
    let done = match task {
        "new rock" => {
            // Work that the process has done before is not counted: another rock, up to the second blow.
            let run = |stiffness: f64| {
                let mut scene = Scene::default();
                scene.parameters.rock.stiffness = stiffness;
                let mut machine = scene.machine().expect("a scene");
                machine.advance(0.06).expect("two blows");
                machine.kinematics().tip_depth
            };
            run(1.1e8)
        }
        "means" => {
            let wanted = Wanted::default();
            steady(&Scene::default(), &wanted, &mut |_, _| true).expect("a cycle").mean.rop()
        }
        "gradients" => {
            let by =
                ["rock.stiffness", "feed_force"].map(|name| Argument::named(name).expect("one"));
            let depth = |machine: &mut Machine| vec![machine.kinematics().tip_depth];
            let sample =
                |scene: &Scene| Sample::of_run(&mut scene.machine()?, &[0.06], &|m| depth(m));
            let rows = derivatives(&Scene::default(), &by, &sample).expect("derivatives");
            rows.iter().map(|row| row.values[0]).sum()
        }
        "air" => {
            let mut machine = scene("air").machine().expect("a scene");
            machine.advance(0.05).expect("a blow");
            machine.kinematics().tip_depth
        }
        "coupled" => {
            let mut machine = scene("coupled").machine().expect("a scene");
            coupled(&mut machine, 500);
            machine.kinematics().tip_depth
        }
        _ => 1.0,
    };
    assert!(done.is_finite() && done != 0.0, "{task}: {done}");
    println!("vectors: {}", Vectors::in_use());
}

/// Instructions of whole tasks, decompositions included, less those of an empty task: at most the stated numbers and
/// [`MARGIN`], built and counted as above.
#[test]
fn instructions_of_whole_tasks_stay_below_the_stated_counts() {
    if let Ok(task) = std::env::var(TASK) {
        return perform(&task);
    }
    if !is_counting() {
        return;
    }
    let count = |task: &str| {
        instructions("instructions_of_whole_tasks_stay_below_the_stated_counts", &[(TASK, task)])
    };
    let Some(nothing) = count("nothing") else {
        println!("skipped: valgrind's processor has no AVX2");
        return;
    };
    for (task, stated) in TASKS {
        let found = count(task).expect("a count, as of nothing") - nothing;
        println!("{task}: {found:.3e} instructions");
        assert!(found < stated * (1.0 + MARGIN), "{task}: {found:.3e}, stated {stated:.3e}");
    }
}

const TASKS: [(&str, f64); 5] = [
    ("new rock", 2.55e7),
    ("means", 3.43e8),
    ("gradients", 8.22e7),
    ("air", 7.35e7),
    ("coupled", 5.88e7),
];

/// Environment variable of the process under valgrind: until when [`CHARGED`] runs, s.
const UNTIL: &str = "HAMMER_UNTIL";
/// Instructions in a second as `work_limit` counts it, in this build.
const IN_A_SECOND: f64 = 4.5e9;

/// Tasks dominated by one kind of work, each with the time span in which it is counted, s: an ordinary search,
/// transitions of ties, air with little and much steel, a line at the piston of an elastic hammer, of one with many
/// coordinates in a casing and of a rigid one, a load for which quasi-static coordinates need series after series, a
/// barrier under a varying load, and a contact that chatters.
const CHARGED: [(&str, [f64; 2]); 11] = [
    ("reference", [0.05, 0.2]),
    ("rigid", [0.1, 1.0]),
    ("loose top hammer", [0.01, 0.02]),
    ("air", [0.02, 0.08]),
    ("air, rigid", [0.02, 0.12]),
    ("line", [0.005, 0.02]),
    ("line, casing", [0.005, 0.02]),
    ("line, rigid", [0.005, 0.02]),
    ("ramp", [0.001, 0.02]),
    ("barrier", [0.1, 0.4]),
    ("chatter", [2e-4, 4e-4]),
];

/// Seconds that the last of these steps was charged.
fn charged(task: &str, ends: &[f64]) -> f64 {
    let mut machine = scene(task).machine().expect("a scene");
    let set = match task {
        "ramp" => machine.set_input(Input::DriveForce, &[1e3, 1e5, 1e8, 1e11, 1e14]),
        "barrier" => machine.set_input(Input::FeedForce, &[2e5, 1e3]),
        _ => Ok(()),
    };
    set.expect("a force");
    ends.iter().for_each(|end| machine.advance(*end).expect("a step"));
    machine.seconds_charged()
}

/// A hammer of any drive, with or without a casing, rods and a line, and a third of its parameters up to a thousand times
/// as large or as small as the reference's.
fn drawn(number: u64) -> Scene {
    let mut random = Random::new(number);
    let mut scene = Scene::default();
    let p = &mut scene.parameters;
    let sources = [Source::Relay, Source::Force, Source::Pressure, Source::Air];
    p.drive.source = sources[(number % 4) as usize];
    let is_rigid = random.unit() < 0.3;
    p.fidelity = if is_rigid { Fidelity::Rigid } else { Fidelity::Elastic };
    p.mesh.degree = 1 + (7.0 * random.unit()) as usize;
    [p.piston.elements, p.bit.elements] = [(); 2].map(|()| 1 + random.spread(1.0, 40.0) as usize);
    if random.unit() < 0.4 {
        (p.casing.mass, p.casing.impedance) = (random.spread(1.0, 200.0), random.spread(1e3, 1e5));
        p.chuck.idle_travel = 0.5 * p.chuck.travel * random.unit().round();
    }
    if !is_rigid && random.unit() < 0.3 {
        p.drill.rods = 1 + (4.0 * random.unit()) as usize;
        p.bit.elements = 14 * (p.drill.rods + 1);
    }
    if random.unit() < 0.3 {
        p.drive.impedance = random.spread(10.0, 1e5);
    }
    scene.inputs.feed_force *= random.spread(0.1, 10.0);
    scene.inputs.drive_force = random.between(-3e3, 3e3);
    scene.inputs.drive_pressure = random.between(0.0, 3e6);
    for argument in VARIABLES.iter().filter_map(|variable| Argument::named(variable.name)) {
        let by = random.spread(1e-3, 1e3);
        let changed = argument.at(&scene, by * argument.value(&scene));
        if random.unit() < 0.3 && changed.parameters.validate().is_ok() {
            scene = changed;
        }
    }
    scene
}

/// The time span of a drawn hammer in which its work is counted, from the start, which is charged some hundredths of a
/// second; `None` if it is refused, or nearly idle.
fn span(number: u64) -> Option<[f64; 2]> {
    let mut end = 2.0;
    loop {
        let mut machine = drawn(number).machine().ok()?;
        let done = machine.advance(end);
        match machine.seconds_charged() {
            charge if charge > 0.04 => end /= 3.0,
            charge if charge < 0.004 || done.is_err() => return None,
            _ => return Some([0.0, end]),
        }
    }
}

/// The charge of a step is its actual work within a factor of two, for every kind of work and for drawn hammers; and
/// 20 s of a hammer driven by air fit in one call. `PRICES=50` draws more than two.
#[test]
fn what_is_charged_is_what_it_takes() {
    if let (Ok(task), Ok(until)) = (std::env::var(TASK), std::env::var(UNTIL)) {
        // Systems that a drawn hammer meets later are decomposed before.
        if let Some([_, end]) = task.parse().ok().and_then(span) {
            charged(&task, &[end]);
        }
        charged(&task, &[until.parse().expect("a time")]);
        println!("vectors: {}", Vectors::in_use());
        return;
    }
    if !is_counting() {
        return;
    }
    let count = std::env::var("PRICES").ok().and_then(|n| n.parse().ok()).unwrap_or(2);
    let drawn = (0..).filter_map(|number| Some((number.to_string(), span(number)?))).take(count);
    let named = CHARGED.map(|(task, ends)| (task.to_string(), ends));
    for (task, ends) in named.into_iter().chain(drawn) {
        let task = task.as_str();
        let counted = ends.map(|until| {
            let until = until.to_string();
            instructions("what_is_charged_is_what_it_takes", &[(TASK, task), (UNTIL, &until)])
        });
        let [Some(first), Some(last)] = counted else {
            println!("skipped: valgrind's processor has no AVX2");
            return;
        };
        let charged = charged(task, &ends);
        let part = charged * IN_A_SECOND / (last - first);
        println!("{task}: {:.3e} instructions, charged {part:.2} of them", last - first);
        assert!((0.5..2.0).contains(&part), "{task}: {part}");
        let rate = charged / (ends[1] - ends[0]);
        let limit = Parameters::default().work_limit as f64;
        assert!(!task.starts_with("air") || 20.0 * rate < limit, "{task}: {rate} s a second");
    }
}
