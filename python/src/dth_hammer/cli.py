"""The command line: `dth-hammer run`, `waves`, `sweep` and `info`."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from .diagram import Waves, waves
from .errors import DomainError, DthHammerError
from .mesh import ELEMENTS
from .package import Package, load
from .run import blows, simulate, unit
from .variables import Variable
from .variant import write_variant


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command; what is wrong with the input is told in a line."""
    options = _parser().parse_args(arguments)
    try:
        options.command(options)
        sys.stdout.flush()
    except BrokenPipeError:
        # Who reads has seen enough; Python must not complain at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except DthHammerError as error:
        print(f"dth-hammer: {error}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="dth-hammer", description=_first_line(__doc__))
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--fmu", type=Path, help="FMU to use instead of the one found")
    shared = argparse.ArgumentParser(add_help=False, parents=[common])
    shared.add_argument("--preset", help="parameter set to start from: see `dth-hammer info`")
    shared.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help='a parameter, for instance rock.stiffness=2e9 or "piston.length=200 mm"',
    )
    shared.add_argument("--until", help='duration, for instance 1 or "500 ms"')
    tabled = argparse.ArgumentParser(add_help=False, parents=[shared])
    tabled.add_argument("-o", "--out", type=Path, help="table to write: .parquet or .csv")

    run = commands.add_parser("run", parents=[tabled], help="simulate one hammer")
    run.add_argument("--step", help="communication step: how often outputs are read")
    run.add_argument("--plot", type=Path, help="figure of the run to write")
    run.add_argument("--quiet", action="store_true", help="no progress bar")
    run.set_defaults(command=_run)

    info = commands.add_parser("info", parents=[common], help="variables, units and presets")
    info.add_argument("name", nargs="?", help="one variable only")
    info.set_defaults(command=_info)

    sweep = commands.add_parser("sweep", parents=[tabled], help="simulate a grid of hammers")
    sweep.add_argument(
        "--over",
        action="append",
        required=True,
        metavar="NAME=VALUES",
        help="feed_force=3e3,5e3,8e3 or feed_force=1e3:9e3:5 (first, last, how many)",
    )
    sweep.add_argument("--scheduler", default="processes", help="processes, threads or address")
    sweep.add_argument("--workers", type=int, help="how many; as many as cores if not given")
    sweep.add_argument("--quiet", action="store_true", help="no progress bar")
    sweep.set_defaults(command=_sweep)

    stress = commands.add_parser(
        "waves", parents=[shared], help="stress along piston and bit, for you or another host"
    )
    stress.add_argument(
        "--elements", type=int, nargs=2, metavar=("PISTON", "BIT"), help="the mesh to look at"
    )
    stress.add_argument(
        "-o",
        "--out",
        type=Path,
        help="an .fmu with stress and velocity along that mesh among its outputs, or a table "
        "of the stresses after the last impact: .parquet or .csv",
    )
    stress.add_argument("--plot", type=Path, help="wave diagram of that impact to write")
    stress.set_defaults(command=_waves)
    return parser


def _run(options: argparse.Namespace) -> None:
    package = load(options.fmu)
    frame = simulate(
        _assignments(options.set),
        _seconds(package, options.until, package.stop),
        preset=options.preset,
        step=_seconds(package, options.step, package.step),
        fmu=package.path,
        progress=not options.quiet,
    )
    if options.out:
        _write(frame, options.out)
    if options.plot:
        from .figures import overview  # noqa: PLC0415

        overview(frame).savefig(options.plot, dpi=160)
    table = blows(frame)
    print(_readable(table).to_string() if len(table) else "no blow")
    if frame["stalled"].any():
        print(f"stalled at {frame.index[frame['stalled']][0]:g} s")


def _sweep(options: argparse.Namespace) -> None:
    from .sweeping import sweep  # noqa: PLC0415

    package = load(options.fmu)
    table = sweep(
        {name: _values(text) for name, text in _assignments(options.over).items()},
        _seconds(package, options.until, package.stop),
        parameters=_assignments(options.set),
        preset=options.preset,
        scheduler=options.scheduler,
        workers=options.workers,
        fmu=package.path,
        progress=not options.quiet,
        out=options.out if options.out and options.out.suffix == ".parquet" else None,
    )
    if options.out and options.out.suffix != ".parquet":
        _write(table, options.out)
    shown = [*table.attrs["swept"], "blow_count", "blow_period", "blow_speed", "rop", "error"]
    print(_readable(table[shown]).to_string(index=False))


def _waves(options: argparse.Namespace) -> None:
    package = load(options.fmu)
    given = _assignments(options.set)
    if options.elements:
        given |= dict(zip(ELEMENTS, options.elements, strict=True))
    variant = options.out is not None and options.out.suffix == ".fmu"
    if variant:
        _write_variant(package, options.out, package.values(options.preset, given))
    if options.plot or (options.out and not variant):
        until = _seconds(package, options.until, package.stop)
        record = waves(given, until, preset=options.preset, fmu=package)
        if not variant and options.out:
            _write(record.table(), options.out)
        if options.plot:
            from .figures import wave_diagram  # noqa: PLC0415

            wave_diagram(record).savefig(options.plot, dpi=160)
        print(_extremes(record))
    elif not variant:
        raise DomainError("nothing to write: give --plot, -o, or both")


def _write_variant(package: Package, out: Path, numbers: dict[str, float]) -> None:
    mesh = [int(numbers.pop(name, package.variables[name].start or 0)) for name in ELEMENTS]
    if numbers:
        raise DomainError(f"an FMU keeps its start values: {', '.join(numbers)} cannot go in")
    added = write_variant(out, mesh, fmu=package)
    print(f"{out}: {added} more outputs, along {mesh[0]} and {mesh[1]} elements")


def _extremes(record: Waves) -> str:
    lines = [f"impact at {record.attrs['impact']:.6f} s"]
    for name, bar in (("piston", record.piston), ("bit", record.bit)):
        low, high = bar.stress.min() * 1e-6, bar.stress.max() * 1e-6
        lines.append(f"{name}: {low:.0f} to {high:.0f} MPa")
    return "\n".join(lines)


def _info(options: argparse.Namespace) -> None:
    package = load(options.fmu)
    if options.name:
        rows = [package.variables[options.name]]
    else:
        print(f"{package.description.modelName} {package.version}\n{package.path}\n")
        for preset in package.presets.values():
            print(f"preset {preset.name}: {preset.description}")
            print("".join(f"    {k} = {v:g}\n" for k, v in preset.values.items()), end="")
        print()
        rows = list(package.variables.values())
    for variable in rows:
        kind = "tunable " if variable.tunable and variable.causality == "parameter" else ""
        print(f"{variable.name}{_start(variable)} {variable.unit}".rstrip())
        domain = f", {variable.domain()}" if variable.settable else ""
        print(f"    {kind}{variable.causality}: {variable.description}{domain}")
    for name, family in () if options.name else package.variables.families.items():
        print(f"{name}[i] {family.variable(1).unit}")
        print(f"    when asked for: {family.description}")


def _start(variable: Variable) -> str:
    if variable.start is None:
        return ""
    label = variable.labels.get(int(variable.start))
    return f" = {label or format(variable.start, 'g')}"


def _assignments(texts: Sequence[str]) -> dict[str, Any]:
    pairs = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise DomainError(f"{text!r} is not NAME=VALUE")
        pairs[name.strip()] = value.strip()
    return pairs


def _values(text: str) -> list[Any]:
    if text.count(":") == 2:
        try:
            first, last, count = text.split(":")
            return list(np.linspace(float(first), float(last), int(count)))
        except ValueError:
            raise DomainError(f"{text!r} is not FIRST:LAST:COUNT") from None
    return [part.strip() for part in text.split(",")]


def _seconds(package: Package, text: str | None, proposal: float) -> float:
    # Read as the FMU's own times are: in seconds, or with a unit.
    return proposal if text is None else package.variables["blow_time"].number(text)


def _write(frame: pd.DataFrame, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".parquet":
        frame.to_parquet(path)
    elif path.suffix == ".csv":
        frame.to_csv(path)
    else:
        raise DomainError(f"{path.name} must end in .parquet or .csv")


def _readable(table: pd.DataFrame) -> pd.DataFrame:
    """Columns with their units in the heading."""
    shown = table.copy()
    shown.columns = pd.Index(
        [f"{c} [{u}]" if (u := unit(table, str(c))) else str(c) for c in table]
    )
    return shown


def _first_line(text: str | None) -> str:
    return (text or "").splitlines()[0]


if __name__ == "__main__":
    sys.exit(main())
