# What `import dth_hammer` offers, and where it is: `__init__.py` reads this too.
from ._native import Snapshot as Snapshot
from .calibration import (
    Calibration as Calibration,
)
from .calibration import (
    calibrate as calibrate,
)
from .couple import Coupling as Coupling
from .couple import Motion as Motion
from .couple import Partner as Partner
from .cycle import Cycle as Cycle
from .cycle import Cycles as Cycles
from .cycle import stationary as stationary
from .datasheet import Datasheet as Datasheet
from .datasheet import from_datasheet as from_datasheet
from .diagram import Waves as Waves
from .diagram import waves as waves
from .errors import (
    ClosedError as ClosedError,
)
from .errors import (
    DomainError as DomainError,
)
from .errors import (
    DthHammerError as DthHammerError,
)
from .errors import (
    FmuNotFoundError as FmuNotFoundError,
)
from .errors import (
    HammerWarning as HammerWarning,
)
from .errors import (
    InterruptedSweepError as InterruptedSweepError,
)
from .errors import (
    MissingError as MissingError,
)
from .errors import (
    OutputError as OutputError,
)
from .errors import (
    RefusedError as RefusedError,
)
from .errors import (
    TooFewBlowsError as TooFewBlowsError,
)
from .errors import (
    UnitError as UnitError,
)
from .errors import (
    UnknownNameError as UnknownNameError,
)
from .fatigue import Life as Life
from .fatigue import SNCurve as SNCurve
from .fatigue import life as life
from .gradients import gradient as gradient
from .hammer import Hammer as Hammer
from .longrun import Steady as Steady
from .longrun import steady as steady
from .mesh import Mesh as Mesh
from .mesh import mesh_for as mesh_for
from .optimisation import Optimum as Optimum
from .optimisation import optimise as optimise
from .package import Package as Package
from .package import find as find
from .package import load as load
from .page import report as report
from .quantities import convert as convert
from .quantities import with_units as with_units
from .records import Record as Record
from .rocks import ROCKS as ROCKS
from .rocks import Rock as Rock
from .rocks import damping_ratio as damping_ratio
from .rocks import damping_time as damping_time
from .rocks import rock as rock
from .rocks import specific_energy as specific_energy
from .run import Run as Run
from .run import blows as blows
from .run import simulate as simulate
from .runs import Case as Case
from .scene import Scene as Scene
from .sweeping import sweep as sweep
from .system import write_system as write_system
from .trends import Trend as Trend
from .trends import trend as trend
from .variables import (
    PRESETS as PRESETS,
)
from .variables import (
    VARIABLES as VARIABLES,
)
from .variables import (
    Preset as Preset,
)
from .variables import (
    Variable as Variable,
)
from .variant import configure as configure
from .variant import write_variant as write_variant

__version__: str
