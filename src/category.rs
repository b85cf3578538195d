//! Log categories, with the names of the standard. The model description lists them.

/// The subject of a log line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Events of a communication step.
    Events,
    /// Each change of mode.
    Modes,
    /// A warning.
    Warning,
    /// The reason why a call was refused.
    Error,
}

impl Category {
    /// All categories.
    pub const ALL: [Self; 4] = [Self::Events, Self::Modes, Self::Warning, Self::Error];

    /// The category's name in the model description and in the logger's argument `category`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Events => "logEvents",
            Self::Modes => "logModes",
            Self::Warning => "logStatusWarning",
            Self::Error => "logStatusError",
        }
    }

    /// The category's text in the model description.
    pub const fn description(self) -> &'static str {
        match self {
            Self::Events => {
                "Counts of mode changes, collisions and blows of each communication step"
            }
            Self::Modes => "Each change of mode: when, by which event, and into which modes",
            Self::Warning => "Settings that work but are doubtful",
            Self::Error => "Why a call was refused",
        }
    }

    /// True for categories that are silent unless the host asks for debug logging.
    pub const fn is_debug(self) -> bool {
        matches!(self, Self::Events | Self::Modes)
    }
}

/// The name in `fmi2SetDebugLogging` that means all categories.
pub const LOG_ALL: &str = "logAll";
