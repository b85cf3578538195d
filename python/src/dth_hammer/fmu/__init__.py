"""The hammer as a file for other programs: FMUs, and systems of FMUs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
