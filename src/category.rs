//! Log categories, by their standard names.
//!
//! Also compiled into `build.rs`, which lists them in the description.

/// What a log line is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// What happened in a communication step.
    Events,
    /// Changes of mode seen from one communication point to the next.
    Modes,
    /// Something the user should look at.
    Warning,
    /// Why a call was refused.
    Error,
}

impl Category {
    /// All.
    pub const ALL: [Self; 4] = [Self::Events, Self::Modes, Self::Warning, Self::Error];

    /// Name in the description and in the logger's `category`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Events => "logEvents",
            Self::Modes => "logModes",
            Self::Warning => "logStatusWarning",
            Self::Error => "logStatusError",
        }
    }

    /// For the description.
    #[cfg_attr(not(test), allow(dead_code, reason = "read by build.rs"))]
    pub const fn description(self) -> &'static str {
        match self {
            Self::Events => "Collisions, blows and mode changes of each communication step",
            Self::Modes => "Mode of contact, rock and relay where a communication step changed it",
            Self::Warning => "Settings that work but are doubtful",
            Self::Error => "Why a call was refused",
        }
    }

    /// True for what is silent unless the host asks for debug logging.
    pub const fn is_debug(self) -> bool {
        matches!(self, Self::Events | Self::Modes)
    }
}

/// Stands for all categories in `fmi2SetDebugLogging`.
pub const LOG_ALL: &str = "logAll";
