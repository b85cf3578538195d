# What `import dth_hammer` offers, and where it is: `__init__.py` reads this too.
from . import fmu as fmu
from ._native import Snapshot as Snapshot
from .errors import DomainError as DomainError
from .errors import DthHammerError as DthHammerError
from .errors import HammerWarning as HammerWarning
from .errors import RefusedError as RefusedError
from .errors import UnknownNameError as UnknownNameError
from .figures.page import report as report
from .run.couple import Coupling as Coupling
from .run.couple import Motion as Motion
from .run.couple import Partner as Partner
from .run.diagram import waves as waves
from .run.hammer import Hammer as Hammer
from .run.records import Record as Record
from .run.run import Run as Run
from .run.run import simulate as simulate
from .scene.datasheet import Datasheet as Datasheet
from .scene.datasheet import compare as compare
from .scene.datasheet import from_datasheet as from_datasheet
from .scene.mesh import mesh_for as mesh_for
from .scene.rocks import ROCKS as ROCKS
from .scene.rocks import rock as rock
from .scene.scene import Scene as Scene
from .scene.variables import PRESETS as PRESETS
from .scene.variables import VARIABLES as VARIABLES
from .study.calibration import calibrate as calibrate
from .study.drilling import specific_energy as specific_energy
from .study.fatigue import SNCurve as SNCurve
from .study.fatigue import life as life
from .study.longrun import Steady as Steady
from .study.optimisation import optimise as optimise
from .study.response import steady as steady
from .study.sweeping import sweep as sweep
from .study.trends import trend as trend

__version__: str
