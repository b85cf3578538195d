from .package import Package, find, load
from .system import write_system
from .variant import configure

__all__ = ["Package", "configure", "find", "load", "write_system"]
