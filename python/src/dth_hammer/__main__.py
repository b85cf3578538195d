"""The command line as ``python -m dth_hammer``."""

import sys

from .cli import main

sys.exit(main())
