"""The package's version. It is read from the metadata when first needed, which takes a while."""

from importlib import metadata

__version__ = metadata.version("dth-hammer")
