"""Run, couple, sweep and test with a down-the-hole percussive drilling hammer.

A native module simulates the hammer, exactly in time between events. This package adds studies,
coupling, figures and files. ``__init__.pyi`` lists the public names; each is imported when it is
first used.
"""

import lazy_loader

__getattr__, __dir__, _listed = lazy_loader.attach_stub(__name__, __file__)
#: Modules that are attributes but not names for ``import *``, since some of them need further
#: packages.
_MODULES = ("figures", "models", "testing")
__all__ = [name for name in _listed if name not in (*_MODULES, "__version__")]
