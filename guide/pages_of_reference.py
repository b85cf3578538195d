"""Reference pages, from the table of quantities and from the package's own docstrings."""

from __future__ import annotations

import inspect
import re

import dth_hammer
from dth_hammer import PRESETS, VARIABLES, figures, quantities, testing
from dth_hammer.variables import Variable

GROUPS = (
    ("Parameters", ("parameter",)),
    ("Inputs", ("input",)),
    ("Outputs", ("output",)),
    ("Local variables", ("local",)),
)


def variables() -> str:
    """All quantities, by kind."""
    lines = ["# Variables", ""]
    for title, kinds in GROUPS:
        rows = VARIABLES.of(*kinds)
        settable = rows[0].settable
        lines += [f"## {title}", ""]
        heads = ["name", "unit", *(["start", "domain"] if settable else []), "meaning"]
        lines += ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
        for row in rows:
            cells = [
                f"`{row.name}`",
                _unit(row),
                *([_start(row), row.domain()] if settable else []),
            ]
            tunable = " *Tunable.*" if row.causality == "parameter" and row.tunable else ""
            lines.append("| " + " | ".join([*cells, f"{row.description}.{tunable}"]) + " |")
        lines.append("")
    lines += _along()
    lines += [
        "## Presets",
        "",
        "A bit comes to stand still between two blows only if it is not overdamped in the rock: "
        r"while `rock.viscosity` is below $2 \sqrt{K_R M}$, with the bit's mass $M$ "
        "(`rock.stiffness` is $K_R$). "
        "A warning says so where it is not.",
        "",
    ]
    lines += ["| name | changes | meaning |", "|---|---|---|"]
    for preset in PRESETS.values():
        changes = ", ".join(f"`{k}` = {v:g}" for k, v in preset.values.items())
        lines.append(f"| `{preset.name}` | {changes} | {preset.description} |")
    return "\n".join(lines) + "\n"


def _along() -> list[str]:
    """What there is as many of as the mesh has."""
    text = (
        "As many as the mesh has, so an FMU lists them only in [a variant for one "
        "mesh](look.md#in-another-host). The member 1 is at the body's upper end."
    )
    lines = ["## Along the bars", "", text, "", "| name | unit | meaning |", "|---|---|---|"]
    for name, row in VARIABLES.families.items():
        lines.append(f"| `{name}[i]` | {row.unit} | {row.description}. |")
    return [*lines, ""]


def _unit(row: Variable) -> str:
    if row.labels or row.unit == "1":
        return ""
    others = quantities.FIELD.get(row.unit, ())
    return row.unit + (f" ({', '.join(others)})" if others else "")


def _start(row: Variable) -> str:
    if row.start is None:
        return ""
    return row.labels.get(int(row.start)) or f"{row.start:g}"


def python() -> str:
    """All public names of the package."""
    lines = ["# Python", "", "```python", "from dth_hammer import ...", "```", ""]
    for name in sorted(dth_hammer.__all__, key=str.lower):
        value = getattr(dth_hammer, name)
        # Tables (VARIABLES, PRESETS) are pages of their own.
        lines += _entry(name, value) if callable(value) else []
    for module in (figures, testing):
        lines += [f"## {module.__name__}", "", _text(module), ""]
        for name, value in vars(module).items():
            own = inspect.isfunction(value) and value.__module__ == module.__name__
            if own and not name.startswith("_"):
                lines += _entry(name, value, "###")
    return "\n".join(lines) + "\n"


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
    """As one writes it: types without quotes, no self, long ones a parameter a line.

    A mapping has none: functions make them.
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
    text = inspect.getdoc(value) or ""
    head, marker, rest = text.partition("\nArgs:\n")
    if not marker:
        return text
    # An argument a bullet, its continued lines with it.
    arguments, _, after = rest.partition("\n\n")
    items = []
    for line in arguments.splitlines():
        if line.startswith("    ") and not line.startswith("     "):
            name, _, meaning = line.strip().partition(": ")
            items.append(f"* `{name}`: {meaning}")
        else:
            items.append("  " + line.strip())
    return "\n".join([head, "", *items, "", inspect.cleandoc(after)])
