"""The command line, `dth-hammer`: subcommands are listed in `dth_hammer.commands`."""

import argparse
import contextlib
import functools
import importlib
import inspect
import io
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn

from .commands import COMMANDS
from .errors import DomainError, DthHammerError, HammerWarning, UnknownNameError
from .extras import need, need_all

#: Exit code that shells use for an interrupted program.
INTERRUPTED = 130
#: First commands for a newcomer.
FIRST = """
begin with:
  dth-hammer demo                     the reference hammer, with a figure
  dth-hammer run air_4_inch           a preset; `dth-hammer info` lists them
  dth-hammer datasheet --od 124mm --pressure 24bar --power 31.7kW --hole 140mm
"""
#: Optional packages that are needed to write a file, by the suffix of the file.
FORMATS = {".xlsx": ["xlsxwriter"], ".mat": ["scipy"], ".parquet": ["pyarrow"]}


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command and returns the exit code; an error in the input is printed as one line."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # The terminal's encoding may lack a character, such as the plus-minus sign.
            stream.reconfigure(errors="replace")
    tokens = [*(sys.argv[1:] if arguments is None else arguments)]
    try:
        if not tokens:
            _parser().print_help()
            print(FIRST)
        if tokens and tokens[0][:1] != "-" and tokens[0] not in COMMANDS:
            raise UnknownNameError("command", tokens[0], COMMANDS)
        # A command's module is imported only when chosen, since imports dominate the start-up time.
        options = _parser().parse_args(tokens) if tokens else None
        with warnings.catch_warnings():
            warnings.simplefilter("always", HammerWarning)
            warnings.showwarning = _warning_printer()
            if options is not None:
                with _streams(options):
                    need_all(_packages(options))
                    for option in getattr(options.module, "ALSO", ()):
                        # Check that output files can be written before doing any work.
                        if (value := getattr(options, option.dest)) is not None:
                            setattr(options, option.dest, option.check(value))
                    options.found = options.module.run(options)
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        # The reader has closed the pipe. Without this, Python prints another error when it exits.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt as stop:
        print(f"\ndth-hammer: {str(stop) or 'stopped'}", file=sys.stderr)
        return INTERRUPTED
    except DthHammerError as error:
        print(f"dth-hammer: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        # The disk may be full. Without this, Python prints the same error again when it exits.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        print(f"dth-hammer: cannot write: {error.strerror}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    description = "Simulate a down-the-hole percussive drilling hammer."
    parser = argparse.ArgumentParser(prog="dth-hammer", description=description, allow_abbrev=False)
    parser.add_argument("--version", action=_Version, nargs=0, help="print the versions and exit")
    parser.add_argument(
        "--completion", action=_Completion, metavar="SHELL", help="print completions for a shell"
    )
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=_Command)
    for name, does in COMMANDS.items():
        subparsers.add_parser(
            name, help=does, description=f"{does[0].upper()}{does[1:]}.", allow_abbrev=False
        )
    return parser


@contextlib.contextmanager
def _streams(options: argparse.Namespace) -> Iterator[None]:
    """Prints the result for ``--json`` or ``-o -``, and then no text on standard output."""
    if getattr(options, "json", False):
        from .outputs import as_json  # noqa: PLC0415

        with contextlib.redirect_stdout(io.StringIO()):
            yield
        print(as_json(options.found))
    elif (suffix := getattr(options, "stream", "")) and options.out == Path("-"):
        with tempfile.TemporaryDirectory() as folder:
            options.out = Path(folder, f"table{suffix}")
            with contextlib.redirect_stdout(sys.stderr):
                yield
            print(options.out.read_text(encoding="utf-8"), end="")
    else:
        yield


class _Command(argparse.ArgumentParser):
    """The parser of a command, which imports the command's module when it is chosen."""

    def fill(self) -> None:
        """Imports the command and adds its options."""
        from .commands.options import JSON, Call  # noqa: PLC0415

        module: Any = importlib.import_module(f".commands.{self.prog.split()[-1]}", __package__)
        written = [*getattr(module, "ALSO", ())]
        calls = [call for call in vars(module).values() if isinstance(call, Call)]
        for call in [*calls, *([module.call()] if hasattr(module, "call") else [])]:
            call.declare(self)
            written += call.written.values()
        if inspect.signature(module.run).return_annotation not in (None, "None"):
            JSON.add(self)
        for option in getattr(module, "ALSO", ()):
            option.add(self)
        stream = "".join(option.stream for option in written if option.dest == "out")
        self.set_defaults(module=module, stream=stream)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Adds the options, parses, and refuses arguments that are no options of the command."""
        self.fill()
        options, left = super().parse_known_args(args, namespace)
        for word in left:
            if word.startswith("-"):
                known = [*self._option_string_actions]
                raise UnknownNameError(f"option of {self.prog}", word.partition("=")[0], known)
            raise DomainError(f"{self.prog} has no use for {word!r}: see {self.prog} --help")
        return options, left

    def error(self, message: str) -> NoReturn:
        """Raises an error in one line that names the command."""
        raise DomainError(f"{message}: see {self.prog} --help")


def _packages(options: argparse.Namespace) -> list[str]:
    """Returns the optional packages that a command needs with these options."""
    packages = [*getattr(options.module, "NEEDS", ())]
    if getattr(options, "quiet", True) is False:
        packages.append("tqdm")
    if getattr(options, "plot", None) or getattr(options, "report", None):
        packages.append("matplotlib")
    if getattr(options, "sn", None):
        packages.append("rainflow")
    if (out := getattr(options, "out", None)) is not None:
        packages += FORMATS.get(out.suffix.lower(), [])
    return list(dict.fromkeys(packages))


class _Version(argparse.Action):
    """Prints the versions of the package and of the FMU in it."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from . import __version__  # noqa: PLC0415
        from .fmu.package import provenance  # noqa: PLC0415

        print(f"dth-hammer {__version__}\n{provenance()}")
        parser.exit()


class _Completion(argparse.Action):
    """Prints a script that completes commands and options in a shell."""

    def __call__(self, parser: argparse.ArgumentParser, _: Any, shell: Any, *__: object) -> None:
        shtab = need("shtab")
        if shell not in shtab.SUPPORTED_SHELLS:
            raise UnknownNameError("shell", shell, shtab.SUPPORTED_SHELLS)
        for action in parser._actions:
            for command in action.choices.values() if isinstance(action.choices, dict) else ():
                command.fill()
        print(shtab.complete(parser, shell))
        parser.exit()


def _warning_printer() -> Callable[..., None]:
    """Returns a function that prints a warning as one line, and each text only once."""

    @functools.cache
    def print_once(text: str) -> None:
        print(f"dth-hammer: warning: {text}", file=sys.stderr)

    return lambda message, *_, **__: print_once(str(message))


if __name__ == "__main__":
    sys.exit(main())
