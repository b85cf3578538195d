//! The arguments of derivatives: parameters and constant inputs.

use crate::quantities::inputs::Input;
use crate::quantities::parameters::Parameters;
use crate::scene::Scene;
use crate::variables::{Parameter, Role, Slot, VARIABLES, Variable};

/// An argument: a real parameter (start values are among them) or a constant input.
#[derive(Clone, Copy)]
pub struct Argument(&'static Variable);

/// An argument whose value is below this share of its usual size counts as zero.
const SMALL: f64 = 1e-3;

impl Argument {
    /// All arguments.
    pub fn all() -> impl Iterator<Item = Self> {
        let real = |variable: &&Variable| {
            matches!(
                variable.role,
                Role::Input(_) | Role::Parameter(Parameter { slot: Slot::Real(..), .. })
            )
        };
        VARIABLES.iter().filter(real).map(Self)
    }

    /// The argument with this dotted name.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|argument| argument.name() == name)
    }

    /// The argument's dotted name.
    pub fn name(self) -> &'static str {
        self.0.name
    }

    /// The input, if the argument is one.
    pub fn input(self) -> Option<Input> {
        match self.0.role {
            Role::Input(row) => Some(row.input),
            _ => None,
        }
    }

    /// False if the scene does not read the argument, so that every derivative by it is zero.
    pub fn is_read(self, parameters: &Parameters) -> bool {
        self.0.unread(parameters).is_none()
    }

    fn slot(self, scene: &mut Scene) -> Option<&mut f64> {
        match self.0.role {
            Role::Parameter(Parameter { slot: Slot::Real(_, access), .. }) => {
                Some(access(&mut scene.parameters))
            }
            Role::Input(row) => Some((row.start)(&mut scene.inputs)),
            _ => None,
        }
    }

    /// The argument's value in a scene.
    pub fn value(self, scene: &Scene) -> f64 {
        self.slot(&mut { *scene }).map_or(f64::NAN, |slot| *slot)
    }

    /// The scene with another value of the argument.
    #[must_use]
    pub fn at(self, scene: &Scene, value: f64) -> Scene {
        let mut scene = *scene;
        if let Some(slot) = self.slot(&mut scene) {
            *slot = value;
        }
        scene
    }

    /// The argument's usual size: an input's nominal value, or a parameter's default.
    pub fn nominal(self) -> f64 {
        let usual = match self.0.role {
            Role::Input(row) => row.nominal,
            _ => self.value(&Scene::default()).abs(),
        };
        if usual > 0.0 { usual } else { 1.0 }
    }

    /// The scale of the argument's changes: its value or, if that is zero, its usual size.
    pub fn scale(self, scene: &Scene) -> f64 {
        let (value, usual) = (self.value(scene).abs(), self.nominal());
        if value > SMALL * usual { value } else { usual }
    }
}

impl PartialEq for Argument {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl std::fmt::Debug for Argument {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
