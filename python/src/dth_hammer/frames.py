"""NumPy and pandas, imported when they are first used: that takes longer than most commands."""

import importlib
from typing import TYPE_CHECKING, Any

__all__ = ["np", "pd"]

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
else:

    class _Late:
        def __init__(self, module: str) -> None:
            self._module = module

        def __getattr__(self, name: str) -> Any:
            found = getattr(importlib.import_module(self._module), name)
            setattr(self, name, found)
            return found

    np, pd = _Late("numpy"), _Late("pandas")
