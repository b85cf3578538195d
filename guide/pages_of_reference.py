"""Reference pages, from the table of quantities and from the package's own docstrings."""

from __future__ import annotations

import inspect
import re
from typing import Any

import dth_hammer
from dth_hammer import PRESETS, VARIABLES, figures, fmu, testing
from dth_hammer.scene import quantities
from dth_hammer.scene.variables import Variable

#: Pages of parameters by title, with the first parts of their names; the first page has all others.
PARAMETERS = {
    "Whole model": (),
    "Piston and bit": ("piston", "bit"),
    "Casing and chuck": ("casing", "chuck"),
    "Drill string": ("drill",),
    "Drive": ("drive",),
    "Air": ("air",),
    "Rock and hole": ("rock", "hole"),
}
#: Pages of outputs and local variables by title, with the beginnings of their names; the first
#: match counts.
OUTPUTS = {
    "Energies": ("energy_",),
    "Blows and rates": ("blow", "rop", "tip_rate", "drilled", "tip_depth", "rebound", "event"),
    "Motion, forces and modes": ("",),
}
#: Pages of functions, with the types that each takes and returns.
FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "simulate": ("Run",),
    "steady": ("Steady",),
    "trend": ("Trend",),
    "sweep": (),
    "optimise": ("Optimum",),
    "calibrate": ("Calibration", "Record"),
    "from_datasheet": ("Datasheet",),
    "compare": (),
    "specific_energy": (),
    "rock": ("Rock",),
    "mesh_for": ("Mesh",),
    "life": ("SNCurve", "Life"),
    "waves": ("Waves",),
    "report": ("Scene",),
    "Hammer": ("Snapshot",),
    "Coupling": ("Partner", "Motion"),
}
ERRORS = "Errors and warnings"
MODULES = (figures, testing, fmu)

Pages = dict[str, tuple[str, str]]


def variables() -> Pages:
    """Returns pages of variables by file name: title and text; the first is their index."""
    found: dict[str, list[Variable]] = {}
    for row in VARIABLES.values():
        found.setdefault(group(row), []).append(row)
    pages: Pages = {}
    lines = ["# Variables", "", "| page | |", "|---|---|"]
    for title in sorted(found, key=[*PARAMETERS, "Inputs", *OUTPUTS].index):
        file, rows = f"variables-{slug(title)}.md", found[title]
        pages[file] = title, "\n".join([f"# {title}", "", *_table(rows)]) + "\n"
        # Variables that differ only by a number in brackets are listed once.
        short = dict.fromkeys(re.sub(r"\[\d+\]", "[i]", row.name) for row in rows)
        names = ", ".join(f"`{name}`" for name in short)
        lines.append(f"| [{title}]({file}) | {names} |")
    pages["variables-along.md"] = "Along the bodies", "\n".join(_along())
    pages["presets.md"] = "Presets", "\n".join(_presets())
    lines += ["", "[Along the bodies](variables-along.md) has stress and velocity, "]
    lines[-1] += "[Presets](presets.md) the hammers and rocks to start from. "
    lines[-1] += "`dth-hammer info` prints the same."
    return {"variables.md": ("All variables", "\n".join(lines) + "\n"), **pages}


def group(row: Variable) -> str:
    """Returns the title of a variable's page."""
    if row.causality == "input":
        return "Inputs"
    if row.causality == "parameter":
        first = re.split(r"[.\[]", row.name)[0]
        fitting = (title for title, firsts in PARAMETERS.items() if first in firsts)
        return next(fitting, "Whole model")
    return next(title for title, starts in OUTPUTS.items() if row.name.startswith(starts))


def slug(title: str) -> str:
    """Returns a title as part of a file name."""
    return re.sub(r"[\W_]+", "-", title.lower())


def _table(rows: list[Variable]) -> list[str]:
    settable = rows[0].settable
    heads = ["name", "unit", *(["start", "domain"] if settable else []), "meaning"]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for row in rows:
        # Variables of a body's sections differ only by their number.
        name = re.sub(r"\[1\]", "[i]", row.name)
        if re.search(r"\[\d+\]", name):
            continue
        meaning = re.sub(r"\bsection 1\b", "section i", row.description)
        cells = [f"`{name}`", _unit(row), *([_start(row), row.domain()] if settable else [])]
        tunable = " *Tunable.*" if row.causality == "parameter" and row.tunable else ""
        lines.append("| " + " | ".join([*cells, f"{meaning}.{tunable}"]) + " |")
    return lines


def _presets() -> list[str]:
    lines = [
        "# Presets",
        "",
        "A bit comes to stand still between two blows only if it is not overdamped in the rock: "
        r"while `rock.viscosity` is below $2 \sqrt{K_R M}$, with the bit's mass $M$ "
        "(`rock.stiffness` is $K_R$). "
        "A warning says so where it is not.",
        "",
        "| name | changes | meaning |",
        "|---|---|---|",
    ]
    for preset in PRESETS.values():
        changes = ", ".join(f"`{k}` = {v:g}" for k, v in preset.values.items())
        lines.append(f"| `{preset.name}` | {changes} | {preset.description} |")
    return lines


def _along() -> list[str]:
    """Returns the page of quantities that have a value per element or node of the mesh."""
    text = (
        "As many as the mesh has, 1 at the body's upper end. An FMU of FMI 3.0 has them as arrays, "
        "of as many stations as the host says ([a variant](look.md#in-another-host))."
    )
    lines = ["# Along the bodies", "", text, "", "| name | unit | meaning |", "|---|---|---|"]
    for name, row in VARIABLES.families.items():
        lines.append(f"| `{name}[i]` | {row.unit} | {row.description}. |")
    return lines


def _unit(row: Variable) -> str:
    if row.labels or row.unit == "1":
        return ""
    others = quantities.FIELD.get(row.unit, ())
    return row.unit + (f" ({', '.join(others)})" if others else "")


def _start(row: Variable) -> str:
    if row.start is None:
        return ""
    return row.labels.get(int(row.start)) or f"{row.start:g}"


def python() -> Pages:
    """Returns pages of the package by file name: title and text; the first is their index."""
    pages: Pages = {}
    lines = ["# Python", "", "```python", "from dth_hammer import ...", "```", ""]
    lines += ["| | |", "|---|---|"]
    for name, others in FUNCTIONS.items():
        file = f"python-{slug(name)}.md"
        value = getattr(dth_hammer, name)
        text = _entry(name, value, "#")
        for other in others:
            made = getattr(dth_hammer, other) if isinstance(other, str) else other
            text += _entry(made.__name__, made)
        pages[file] = name, "\n".join(text) + "\n"
        lines.append(f"| [`{name}`]({file}) | {_first(value)} |")
    for module in MODULES:
        lines += ["", f"## {module.__name__}", "", _text(module), "", "| | |", "|---|---|"]
        short = module.__name__.partition(".")[2]
        for name, value in own(module).items():
            file = f"python-{short}-{slug(name)}.md"
            pages[file] = f"{short}.{name}", "\n".join(_entry(f"{short}.{name}", value, "#")) + "\n"
            lines.append(f"| [`{name}`]({file}) | {_first(value)} |")
    text = [f"# {ERRORS}", ""]
    for name in sorted(dth_hammer.__all__):
        value = getattr(dth_hammer, name)
        if inspect.isclass(value) and issubclass(value, Exception):
            text += _entry(name, value)
    pages["python-errors.md"] = ERRORS, "\n".join(text) + "\n"
    lines += [
        "",
        f"[{ERRORS}](python-errors.md). `VARIABLES`, `PRESETS` and `ROCKS` are mappings by name: ",
    ]
    lines[-1] += "[variables](variables.md), [presets](presets.md), [rocks](rock.md)."
    return {"python.md": ("All functions", "\n".join(lines) + "\n"), **pages}


def own(module: object) -> dict[str, object]:
    """Returns a module's public functions: those in its list, if it has one."""
    name = module.__name__  # type: ignore[attr-defined]
    listed = getattr(module, "__all__", vars(module))
    return {
        key: value
        for key, value in vars(module).items()
        if key in listed
        and inspect.isfunction(value)
        and value.__module__.startswith(name)
        and key[0] != "_"
    }


def _first(value: object) -> str:
    """Returns the first sentence of a docstring."""
    return re.split(r"\n\n|(?<=[.])\s", inspect.getdoc(value) or "")[0].replace("\n", " ")


def _entry(name: str, value: object, level: str = "##") -> list[str]:
    lines = [f"{level} {name}", ""]
    if inspect.isclass(value) and issubclass(value, Exception):
        return [*lines, _text(value), ""]
    if not getattr(value, "_is_protocol", False):
        lines += ["```python", f"{name}{_signature(value)}", "```", ""]
    lines += [_text(value), ""]
    if inspect.isclass(value):
        for member, method in vars(value).items():
            if inspect.isfunction(method) and not member.startswith("_"):
                lines.append(f"* `{member}{_signature(method, wrapped=False)}`: {_text(method)}")
        lines.append("")
    return lines


def _signature(value: object, *, wrapped: bool = True) -> str:
    """Returns a signature with types unquoted and no self; a long one has a line per parameter.

    A mapping has none, because functions make it.
    """
    if inspect.isclass(value) and issubclass(value, dict):
        return ""
    signature = inspect.signature(value)  # type: ignore[arg-type]
    parts = [
        re.sub(r"= \(.{40,}\)$", "= ...", re.sub(r": '([^']*)'", r": \1", str(p)))
        for p in signature.parameters.values()
    ]
    kinds = [p.kind for p in signature.parameters.values()]
    if inspect.Parameter.KEYWORD_ONLY in kinds:
        parts.insert(kinds.index(inspect.Parameter.KEYWORD_ONLY), "*")
    parts = [part for part in parts if part != "self"]
    annotation = signature.return_annotation
    result = "" if annotation is inspect.Signature.empty else f" -> {annotation}"
    line = f"({', '.join(parts)}){result}"
    if len(line) < 80 or not wrapped:
        return line
    return "(\n" + "".join(f"    {part},\n" for part in parts) + f"){result}"


def _text(value: object) -> str:
    """Returns a docstring as Markdown, with lists of arguments and exceptions, and the example."""
    text, _, example = (inspect.getdoc(value) or "").partition("\nExample:\n")
    parts = []
    for part in re.split(r"\n(?=(?:Args|Raises|Returns|Yields):\n)", text):
        title, marker, rest = part.partition(":\n")
        if not marker or title not in ("Args", "Raises", "Returns", "Yields"):
            parts.append(part)
            continue
        body, _, after = rest.partition("\n\n")
        items = [f"**{title}**", ""]
        for line in body.splitlines():
            if line.startswith("    ") and not line.startswith("     "):
                name, colon, meaning = line.strip().partition(": ")
                items.append(f"* `{name}`: {meaning}" if colon else line.strip())
            else:
                items.append("  " + line.strip())
        parts.append("\n".join([*items, "", inspect.cleandoc(after)]))
    if example:
        parts.append(f"```python\n{inspect.cleandoc(example)}\n```")
    return "\n\n".join(parts)
