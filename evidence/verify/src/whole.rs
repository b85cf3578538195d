//! Whole error by the mesh: of twenty drawn hammers that repeat their blow, and of the presets, what a
//! user reads on coarser meshes against that on a fine one of the highest degree.

use hammer::presets::PRESETS;
use hammer::sensitivity::Scene;
use hammer::{Body, Error, MAX_DEGREE, Machine, Reading, Segment};
use std::f64::consts::PI;
use std::fmt::Write as _;

/// What is read: rates, then forces, then stress.
pub const NAMES: [&str; 6] = [
    "`rop`",
    "tip rate",
    "blow energy",
    "largest contact force",
    "largest rock force",
    "largest stress",
];
/// Scenes that are drawn.
pub const DRAWN: usize = 20;
/// Blows that are left out, and those that are read.
const SETTLE: u64 = 60;
const READ: u64 = 6;
/// Instants of a blow at which stresses are looked at: so many while a wave passes the shorter body.
const LOOKS: f64 = 24.0;
/// The fine mesh has spans of this part of the front's width.
const FINE: f64 = 0.8;

/// A scene with a name.
pub struct Named {
    /// Preset, or number of the draw.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

/// A plain congruential sequence in (0, 1): the same on every machine.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn spread(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }
}

/// A hammer from 2 to 8 inches: bodies of one to three sections, contact, damping, rock and drive apart
/// by as much as those of the presets and more.
fn drawn(random: &mut Random) -> Option<Scene> {
    let mut scene = Scene::default();
    let p = &mut scene.parameters;
    let area = random.spread(1e-3, 1e-2);
    let mut body = |length: f64, segment: &mut [Segment]| {
        let count = 1 + (3.0 * random.unit()) as usize;
        for part in &mut segment[..count] {
            *part = Segment {
                length: length * random.between(0.6, 1.4) / count as f64,
                area: area * random.between(0.6, 1.6),
            };
        }
        count
    };
    p.piston.segments = body(0.4, &mut p.piston.segment);
    p.bit.segments = body(0.3, &mut p.bit.segment);
    let shorter = random.between(0.4, 1.0);
    p.piston.segment.iter_mut().for_each(|part| part.length *= shorter);
    p.mesh.degree = 5;
    (p.piston.elements, p.bit.elements) = (40, 40);
    p.material.damping_time = p.damping_time_of(random.spread(1e-3, 1e-2))?;
    let front = p.front_width();
    p.contact.stiffness *= front / random.between(3e-3, 8e-3);
    p.drive.stroke = random.spread(0.01, 0.06);
    p.contact.initial_gap = p.drive.stroke;
    let (mass, speed) = (p.piston_mass(), random.between(5.0, 10.0));
    p.drive.amplitude = 0.8 * mass * speed * speed / (4.0 * p.drive.stroke);
    let stretch = p.material.youngs_modulus * area / 0.3;
    p.rock.stiffness = stretch * random.spread(0.03, 0.4);
    p.rock.unloading_ratio = random.between(2.0, 6.0);
    let critical = 2.0 * (p.rock.stiffness * p.bit_mass()).sqrt();
    p.rock.viscosity = critical * random.between(0.1, 0.9);
    p.rock.energy_barrier = 0.5 * mass * speed * speed * random.spread(1e-3, 2e-2);
    scene.inputs.feed_force = p.drive.amplitude * random.between(1.0, 3.0);
    Some(scene)
}

/// The scene on spans of at most this length (m) and a degree.
pub fn meshed(scene: &Scene, degree: usize, span: f64) -> Scene {
    let mut scene = *scene;
    let p = &mut scene.parameters;
    let spans = |body: Body| -> usize {
        let sections = p.sections(body);
        sections.as_slice().iter().map(|s| (s.length / span).ceil() as usize).sum()
    };
    let [piston, bit] = Body::ALL.map(spans);
    (p.mesh.degree, p.piston.elements, p.bit.elements) = (degree, piston, bit);
    scene
}

/// The finest mesh.
pub fn fine(scene: &Scene) -> Scene {
    meshed(scene, MAX_DEGREE, FINE * scene.parameters.front_width())
}

/// What a user reads of settled blows; `None` if the hammer does not strike often enough.
///
/// # Errors
/// Whatever the engine says.
pub fn response(scene: &Scene) -> Result<Option<[f64; 6]>, Error> {
    let mut m = Machine::new(&scene.parameters, &scene.inputs, 0.0)?;
    let to = |m: &mut Machine, blows: u64, peaks: &mut [f64; 2]| -> Result<bool, Error> {
        while m.counters().blows < blows {
            if m.time() > 8.0 {
                return Ok(false);
            }
            m.advance(m.time() + 2e-3)?;
            if blows > SETTLE {
                let now = m.peaks();
                *peaks = [peaks[0].max(now.contact_force()), peaks[1].max(now.rock_force())];
            }
        }
        Ok(true)
    };
    let mut peaks = [0.0; 2];
    if !to(&mut m, SETTLE, &mut peaks)? {
        return Ok(None);
    }
    let (mut rop, mut gain, mut energy, mut time) = (0.0, 0.0, 0.0, 0.0);
    for blow in 1..=READ {
        if !to(&mut m, SETTLE + blow, &mut peaks)? {
            return Ok(None);
        }
        let Some(blow) = m.blow() else { return Ok(None) };
        rop += blow.rop * blow.period;
        gain += blow.penetration;
        energy += blow.energy;
        time += blow.period;
    }
    let stress = stress(scene, &m)?;
    Ok(Some([rop / time, gain / time, energy / READ as f64, peaks[0], peaks[1], stress]))
}

/// Largest stress of the next blow, by looks at it.
fn stress(scene: &Scene, m: &Machine) -> Result<f64, Error> {
    let p = &scene.parameters;
    let mut ahead = Machine::new(p, &scene.inputs, 0.0)?;
    ahead.restore(&m.state())?;
    let Some(blow) = m.blow() else { return Ok(f64::NAN) };
    let scales = p.timescales();
    let transit = scales.piston_transit.min(scales.bit_transit);
    // The next blow, as the last: settled ones are alike.
    let begin = blow.time + blow.period - transit;
    let quarter = 0.5 * PI * ((p.piston_mass() + p.bit_mass()) / p.rock.stiffness).sqrt();
    let end = begin + 6.0 * (scales.piston_transit + scales.bit_transit) + 2.0 * quarter;
    let (mut now, mut most) = (begin.max(ahead.time()), 0.0f64);
    while now < end {
        ahead.advance(now)?;
        let profile = ahead.profile();
        let all = profile.piston_stress.iter().chain(&profile.bit_stress);
        most = all.fold(most, |most, s| most.max(s.abs()));
        now += transit / LOOKS;
    }
    Ok(most)
}

/// The drawn scenes that repeat their blow on the fine mesh, and the presets without rods, each with what
/// is read there.
///
/// # Errors
/// Whatever the engine says.
pub fn scenes() -> Result<Vec<(Named, [f64; 6])>, Error> {
    let (mut random, mut list) = (Random(41), Vec::new());
    while list.len() < DRAWN {
        let Some(scene) = drawn(&mut random) else { continue };
        if scene.parameters.validate().is_err() {
            continue;
        }
        let fine = fine(&scene);
        let Some(values) = response(&fine)? else { continue };
        if settled(&fine)? {
            list.push((Named { name: format!("drawn {}", list.len() + 1), scene }, values));
        }
    }
    for preset in PRESETS {
        let (parameters, inputs) = preset.start();
        let scene = Scene { parameters, inputs };
        if parameters.drill.rods > 0 {
            continue;
        }
        if let Some(values) = response(&fine(&scene))? {
            list.push((Named { name: preset.name.into(), scene }, values));
        }
    }
    Ok(list)
}

/// True if the last blows are alike to a thousandth.
fn settled(scene: &Scene) -> Result<bool, Error> {
    let mut m = Machine::new(&scene.parameters, &scene.inputs, 0.0)?;
    while m.counters().blows < SETTLE && m.time() < 8.0 {
        m.advance(m.time() + 2e-3)?;
    }
    let mut last = m.blow().map_or(0.0, |blow| blow.tip_rate);
    for _ in 0..4 {
        let blows = m.counters().blows;
        while m.counters().blows == blows && m.time() < 8.0 {
            m.advance(m.time() + 2e-3)?;
        }
        let now = m.blow().map_or(0.0, |blow| blow.tip_rate);
        if (now / last - 1.0).abs() > 1e-3 {
            return Ok(false);
        }
        last = now;
    }
    Ok(true)
}

/// A mesh of every scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mesh {
    /// A degree, and the longest span in widths of the sharpest front.
    Spans(usize, f64),
    /// By the engine's rule, for its usual error.
    Rule(Reading),
    /// The scene's own.
    Own,
}

/// The meshes of the page.
pub const MESHES: [Mesh; 13] = [
    Mesh::Spans(1, 2.0),
    Mesh::Spans(1, 4.0),
    Mesh::Spans(3, 1.5),
    Mesh::Spans(3, 2.0),
    Mesh::Spans(3, 3.0),
    Mesh::Spans(3, 4.0),
    Mesh::Spans(3, 6.0),
    Mesh::Spans(5, 2.0),
    Mesh::Spans(5, 3.0),
    Mesh::Spans(5, 4.0),
    Mesh::Rule(Reading::Rate),
    Mesh::Rule(Reading::Force),
    Mesh::Own,
];

impl Mesh {
    fn of(self, scene: &Scene) -> Option<Scene> {
        let mut own = *scene;
        let p = &mut own.parameters;
        match self {
            Self::Spans(degree, widths) => {
                return Some(meshed(scene, degree, widths * p.front_width()));
            }
            Self::Rule(reading) => {
                let mesh = p.mesh_for(reading, reading.usual_error())?;
                mesh.apply(p);
            }
            Self::Own => {}
        }
        Some(own)
    }

    fn name(self) -> String {
        match self {
            Self::Spans(degree, widths) => {
                format!("degree {degree}, spans of {widths} front widths")
            }
            Self::Rule(reading) => {
                let percent = 100.0 * reading.usual_error();
                format!("by the rule, for a {} within {percent} %", reading.name())
            }
            Self::Own => "the presets' own".into(),
        }
    }
}

/// Relative errors of a scene on a mesh; `None` where there is no such mesh, or too few blows on it.
///
/// # Errors
/// Whatever the engine says.
pub fn errors(scene: &Scene, exact: &[f64; 6], mesh: Mesh) -> Result<Option<[f64; 6]>, Error> {
    let Some(scene) = mesh.of(scene).filter(|scene| scene.parameters.validate().is_ok()) else {
        return Ok(None);
    };
    let found = response(&scene)?;
    Ok(found.map(|found| std::array::from_fn(|k| found[k] / exact[k] - 1.0)))
}

/// Root of the mean square, and largest size.
fn summed(errors: &[[f64; 6]]) -> [(f64, f64); 6] {
    std::array::from_fn(|k| {
        let squares: f64 = errors.iter().map(|e| e[k] * e[k]).sum();
        let worst = errors.iter().map(|e| e[k].abs()).fold(0.0, f64::max);
        ((squares / errors.len() as f64).sqrt(), worst)
    })
}

/// The page, and progress: scenes of all that are to be made.
///
/// # Errors
/// Whatever the engine says.
pub fn page(progress: impl Fn(usize)) -> Result<String, Error> {
    let scenes = scenes()?;
    let mut found: Vec<Vec<Option<[f64; 6]>>> = Vec::new();
    for (done, (named, exact)) in scenes.iter().enumerate() {
        progress(done);
        // A drawn scene has no mesh of its own.
        let wanted = |mesh: Mesh| mesh != Mesh::Own || done >= DRAWN;
        let row = MESHES.map(|mesh| match wanted(mesh) {
            true => errors(&named.scene, exact, mesh),
            false => Ok(None),
        });
        found.push(row.into_iter().collect::<Result<_, _>>()?);
    }
    let percent = |x: f64| format!("{:.2}", 100.0 * x);
    let heads = NAMES.join(" | ");
    let mut out = format!(
        "# Mesh and error: `cargo verify --mesh`\n\n\
         Of {DRAWN} drawn hammers whose blows repeat, and of the presets without rods: what is read of \
         settled blows on a mesh, beside that on splines of degree {MAX_DEGREE} with spans of {FINE} \
         widths of the sharpest front. Errors in per cent: root of the mean square (worst). The drawn \
         scenes are those of `evidence/verify/src/whole.rs`, all with the front that their contact makes, \
         3 to 8 mm.\n\n## Drawn hammers\n\n| mesh | scenes | {heads} |\n|---|---|{}\n",
        "---|".repeat(NAMES.len())
    );
    for (k, mesh) in MESHES.iter().enumerate().filter(|(_, mesh)| **mesh != Mesh::Own) {
        let errors: Vec<[f64; 6]> = found[..DRAWN].iter().filter_map(|row| row[k]).collect();
        let cells =
            summed(&errors).map(|(rms, worst)| format!("{} ({})", percent(rms), percent(worst)));
        let _ = writeln!(out, "| {} | {} | {} |", mesh.name(), errors.len(), cells.join(" | "));
    }
    for (k, mesh) in MESHES.iter().enumerate() {
        if matches!(mesh, Mesh::Spans(..)) {
            continue;
        }
        let _ = writeln!(
            out,
            "\n## Presets, the mesh {}\n\n| preset | degree | spans | {heads} |\n|---|---|---|{}",
            mesh.name(),
            "---|".repeat(NAMES.len())
        );
        for ((named, _), row) in scenes.iter().zip(&found).skip(DRAWN) {
            let (Some(scene), Some(errors)) = (mesh.of(&named.scene), row[k]) else { continue };
            let p = &scene.parameters;
            let cells = errors.map(percent).join(" | ");
            let spans = format!("{} + {}", p.piston.elements, p.bit.elements);
            let _ = writeln!(out, "| {} | {} | {spans} | {cells} |", named.name, p.mesh.degree);
        }
    }
    Ok(out)
}
