"""`dth-hammer fmu`: copies the FMUs of the hammer to a folder."""

import argparse
import shutil
from pathlib import Path

from ..errors import OutputError
from ..fmu.package import FILES, find
from .options import Call, Written

CALL = Call(find, {"fmu": "a file that one has already", "fmi": "both are copied"})


ALSO = (Written("-o --out", type=Path, default=Path(), help="folder (default: this one)"),)


def run(options: argparse.Namespace) -> None:
    """Copies the FMUs and prints their paths."""
    try:
        options.out.mkdir(parents=True, exist_ok=True)
        for fmi in FILES:
            print(shutil.copy(find(fmi=fmi), options.out))
    except OSError as error:
        raise OutputError(f"{options.out} cannot be written: {error.strerror or error}") from None
