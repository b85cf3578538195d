"""Options of a command, made from the signature and the docstring of the function it calls."""

import argparse
import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import NoneType
from typing import Any, Literal, get_args, get_origin

from .. import outputs
from ..contract import alternatives, hints_of
from ..errors import DomainError
from ..scene import quantities
from ..scene.datasheet import Datasheet, from_datasheet
from ..scene.hammers import scene_of
from ..scene.scene import Scene
from ..scene.steel import SNCurve


class Written:
    """An option whose form does not follow from the annotation; `argparse` gets ``keywords``."""

    def __init__(
        self,
        flags: str = "",
        read: Callable[[Any], Any] = lambda text: text,
        *,
        help: str = "",
        more: str = "",
        check: Callable[[Any], Any] = lambda value: value,
        stream: str = "",
        **keywords: Any,
    ) -> None:
        #: For example ``-o --out``, or a word for a positional argument; "" for the argument's
        #: name.
        self.flags = flags.split()
        #: Converts the option's text.
        self.read = read
        #: ``help`` replaces the docstring's text; ``more`` is added to it.
        self.help, self.more = help, more
        #: Raises before any work is done, for instance if a file cannot be written.
        self.check = check
        #: The kind of file that is printed instead of the text if its name is ``-``.
        self.stream = stream
        self.keywords = keywords

    def add(self, parser: argparse.ArgumentParser) -> None:
        """Adds the option to a parser."""
        parser.add_argument(*self.flags, help=self.help, **self.keywords)

    @property
    def dest(self) -> str:
        """The option's attribute in the namespace of `argparse`."""
        return self.flags[-1].lstrip("-").replace("-", "_")


class Call:
    """A function whose arguments become options. Those that do not are listed with the reason."""

    def __init__(
        self,
        function: Callable[..., Any],
        without: Mapping[str, str] | None = None,
        **written: Written,
    ) -> None:
        self.function = function
        self.parameters = inspect.signature(function).parameters
        self.without = {n: why for n, why in NOWHERE.items() if n in self.parameters}
        self.without |= without or {}
        if strange := ({*self.without} | {*written}) - {*self.parameters}:
            raise TypeError(f"{function.__name__} does not take {', '.join(strange)}")
        named = [name for name in self.parameters if name not in self.without]
        self.written = {n: written.get(n) or SHARED.get(n) or Written() for n in named}
        for name, written_ in self.written.items():
            written_.flags = written_.flags or [f"--{name.replace('_', '-')}"]

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Adds the options to a parser."""
        hints, meanings = hints_of(self.function), described(self.function)
        if {*self.written} & {*HAMMERS}:
            SET.add(parser)
        for name, written in self.written.items():
            default = self.parameters[name].default
            given = default is not inspect.Parameter.empty
            keywords = written.keywords
            if not keywords.keys() & {"type", "action", "nargs"}:
                keywords = kind(name, hints[name], default) | keywords
            if written.flags[0].startswith("-"):
                keywords = {"required": not given} | keywords
            text = (written.help or meanings[name]) + written.more
            if given and keywords.get("action") is None and default is not None and default != ():
                text += f" (default: {as_text(default)})"
            parser.add_argument(*written.flags, help=text.replace("%", "%%"), **keywords)

    def given(self, options: argparse.Namespace) -> dict[str, Any]:
        """Returns the arguments that the user gave. The function has defaults for the others."""
        found = {}
        for name, written in self.written.items():
            if (value := getattr(options, written.dest)) is not None:
                found[name] = written.read(value)
        for name in {*HAMMERS} & {*self.written}:
            scene = scene_of(found.get(name), found.pop("rock", None))
            found[name] = replace(scene, parameters=scene.parameters | SET.read(options.set))
        return found


def kind(name: str, hint: Any, default: Any) -> dict[str, Any]:
    """Returns how `argparse` reads an argument with this annotation."""
    kinds = [side for side in alternatives(hint) if side is not NoneType]
    origins = [get_origin(side) for side in kinds]
    if Literal in origins:
        return {"choices": get_args(kinds[0])}
    if kinds == [bool]:
        return {"action": "store_false" if default else "store_true"}
    if str in kinds:
        return {}
    if float in kinds:
        return {"type": number}
    if int in kinds:
        return {"type": int}
    if any(origin is not None and issubclass(origin, Mapping) for origin in origins):
        return {"action": "append"}
    if not any(origin is not None and issubclass(origin, Iterable) for origin in origins):
        raise TypeError(f"an option cannot be read as {hint}: {name} wants a type")
    word = "NAME" if get_args(kinds[0]) == (str,) else name.removesuffix("s").upper()
    return {"metavar": f"{word},...", "type": listed}


def number(text: str) -> float:
    """Reads a number without a unit; ``%`` is allowed."""
    return quantities.read(text, "1", "a number")


def listed(text: str) -> list[str]:
    """Splits words at commas."""
    return [word.strip() for word in text.split(",") if word.strip()]


def described(function: Callable[..., Any]) -> dict[str, str]:
    """Returns the first sentence on each argument; further sentences are about Python."""
    section = (inspect.getdoc(function) or "").partition("Args:\n")[2].split("\n\n")[0]
    found = re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", section, re.MULTILINE)
    plain = {name: " ".join(text.split()).replace("``", "").strip(".") for name, text in found}
    texts = {name: re.split(r"\. (?=[A-Z`])", text)[0] for name, text in plain.items()}
    return dict.fromkeys(inspect.signature(function).parameters, "") | texts


def as_text(default: Any) -> str:
    """Returns a default as a user would write it."""
    if isinstance(default, tuple):
        return ", ".join(default)
    return f"{default:g}" if isinstance(default, float) else str(default)


def assignments(texts: Sequence[str]) -> dict[str, Any]:
    """Reads names and values from several ``NAME=VALUE``."""
    return _pairs(texts, "NAME=VALUE", lambda value: value or None)


#: The forms that `hammer_of` reads.
A_HAMMER = (
    "a hammer: its datasheet, as od=124mm,pressure=24bar,power=31.7kW,hole=140mm, the name of a "
    "preset, or the file of a scene"
)


def hammer_of(text: str, rock: str | None = None) -> Datasheet | Scene:
    """Reads a hammer: a datasheet as NAME=VALUE,..., the name of a preset, or a file."""
    if "=" not in text:
        return scene_of(text, rock)
    return from_datasheet(**assignments(listed(text)), **({"rock": rock} if rock else {}))


def units(texts: Sequence[str]) -> list[quantities.Units]:
    """Reads units as `convert` takes them: systems, and then units of single columns."""
    named = assignments([text for text in texts if "=" in text])
    return [*(text for text in texts if "=" not in text), *([named] if named else [])]


def bounds(texts: Sequence[str]) -> dict[str, Any]:
    """Reads bounds from several ``NAME=LOW:HIGH``; a missing side is None."""
    return _pairs(texts, "NAME=LOW:HIGH", _ends)


def _ends(text: str) -> tuple[str | None, ...] | None:
    ends = tuple(part.strip() or None for part in text.split(":"))
    return ends if len(ends) == 2 and any(ends) else None


def _pairs(texts: Sequence[str], form: str, read: Callable[[str], Any]) -> dict[str, Any]:
    pairs: dict[str, Any] = {}
    for text in texts:
        name, _, value = (part.strip() for part in text.partition("="))
        if not name or (found := read(value)) is None:
            raise DomainError(f"{text!r} is not {form}")
        if name in pairs:
            raise DomainError(f"{name} is given twice")
        pairs[name] = found
    return pairs


FREE = 'a free parameter and its bounds, repeatable: "drive.stroke=30 mm:60 mm"'
SET = Written(
    "--set",
    assignments,
    help='a parameter, for instance rock.stiffness=2e9 or "piston.length=7 in"; repeatable',
    action="append",
    default=[],
    metavar="NAME=VALUE",
)
#: The command's hammer, and the names of the argument in functions.
HAMMER = Written(
    "hammer",
    help="a preset's name, or the JSON file of a scene, as `dth-hammer datasheet -o` writes it; "
    "--set is laid over it",
    nargs="?",
)
HAMMERS = ("hammer", "base")
#: Arguments that are not options of any command, and the reason.
NOWHERE = {"preset": "the hammer is one", "scheduler": "an object of Python's"}
ROCK = Written(
    "--rock",
    help="rock beside the hammer: a name as `dth-hammer rock` lists them, a class as R5, a "
    'strength as "180 MPa", or a file of a rock',
)
SN = Written(
    "--sn",
    SNCurve.read,
    type=str,
    help='S-N line of the steel: amplitude, cycles to failure at it, slope, as "300 MPa,1e7,8"',
    metavar="STRENGTH,CYCLES,SLOPE[,ULTIMATE]",
)
UNITS = Written(
    "--units",
    action="extend",
    type=lambda text: text.split(","),
    default=[],
    metavar="UNITS",
    help=f"units of tables: {', '.join(quantities.SYSTEMS)}, NAME=UNIT, or several: us,rop=m/h",
    check=units,
)


#: Help text for the file name ``-``.
STREAM = "- prints it in place of the text"
#: Prints the result of a command for other programs.
JSON = Written("--json", help="print what is found as JSON, in SI units", action="store_true")


def file(flags: str, of: str, *kinds: str) -> Written:
    """Returns the option for a file of one of these kinds."""
    printed = (".csv", ".json") if "--out" in flags else ()
    stream = next((kind for kind in printed if kind in kinds), "")
    text = f"{of}; {STREAM}" if stream else of
    return Written(
        flags, type=Path, help=text, stream=stream, check=lambda path: outputs.check(path, kinds)
    )


def table(of: str) -> Written:
    """Returns the option for the file of a table."""
    return file("-o --out", f"{of}: {outputs.either()}", *outputs.TABLES)


#: The file for the hammer's rock, which ``--rock`` can read.
WRITE_ROCK = file("--write-rock", "file to write the rock to, for --rock", ".json")
MANY = (
    Written(
        "--over",
        action="append",
        default=[],
        metavar="NAME=VALUES",
        help="values as feed_force=3e3,5e3,8e3, or first:last:number as feed_force=1e3:9e3:5",
    ),
    Written(
        "--rows",
        type=Path,
        help="file (CSV, Parquet, Excel) with a hammer a row, a parameter a column",
    ),
)


def figure(of: str) -> Written:
    """Returns the option for the file of a figure."""
    return Written("--plot", type=Path, help=of, check=outputs.check_figure)


#: Options that are the same in all commands.
SHARED = {
    **dict.fromkeys(HAMMERS, HAMMER),
    "rock": ROCK,
    "until": Written("--until", lambda text: quantities.duration(text, "--until")),
    "step": Written("--step", lambda text: quantities.duration(text, "--step")),
    "progress": Written(
        "--quiet", lambda quiet: not quiet, help="show no progress bar", action="store_true"
    ),
    "curve": SN,
    "out": Written("-o --out", type=Path),
    "fmu": Written("--fmu", type=Path),
    "fmi": Written("--fmi", type=int, choices=(2, 3)),
}
