"""The package's version, read from its metadata when it is asked for: that takes a while."""

from importlib import metadata

__version__ = metadata.version("dth-hammer")
