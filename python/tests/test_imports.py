"""No two modules of the package import each other, directly or through others."""

import ast
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import dth_hammer
import pytest
from programs import ran

ROOT = Path(dth_hammer.__file__).parent


def module(path: Path) -> str:
    """Returns the dotted name of a file."""
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {module(path): path for path in ROOT.rglob("*.py")}


def imported(name: str, text: str) -> set[str]:
    """Returns modules of the package that a module imports, also inside functions and for types.

    The package's own root is left out: it loads what it lists when a name is first used.
    """
    inside = name if FILES[name].name == "__init__.py" else name.rpartition(".")[0]
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = ".".join(inside.split(".")[: len(inside.split(".")) - node.level + 1])
            base = f"{base}.{node.module}" if node.module else base
            names = {f"{base}.{alias.name}" for alias in node.names}
            found |= {base} if not names & {*FILES} else names & {*FILES}
    return (found & {*FILES}) - {name, ROOT.name}


def order(texts: dict[str, str]) -> list[str]:
    return [*TopologicalSorter({n: imported(n, t) for n, t in texts.items()}).static_order()]


def test_modules_are_attributes_and_nothing_else_is_listed() -> None:
    for name in ("figures", "fmu", "models", "testing"):
        assert getattr(dth_hammer, name).__name__ == f"dth_hammer.{name}"
    public = {name for name in dir(dth_hammer) if not name.startswith("_")}
    assert public == {*dth_hammer.__all__, "figures", "models", "testing"}


def test_no_module_of_the_package_is_in_a_circle_of_imports() -> None:
    texts = {name: path.read_text(encoding="utf-8") for name, path in FILES.items()}
    assert order(texts).index("dth_hammer.simulation.hammer") < order(texts).index(
        "dth_hammer.simulation.run"
    )
    # The test finds a circle, also if it is closed inside a function.
    texts["dth_hammer.scene.scene"] += (
        "\ndef late() -> None:\n    from ..simulation.run import simulate\n"
    )
    with pytest.raises(CycleError, match="run"):
        order(texts)


def test_the_native_module_works_in_a_subinterpreter() -> None:
    code = "import dth_hammer._native as n; m = n.Machine({}); m.advance(0.02); print(m.time)"
    name = "_interpreters" if sys.version_info >= (3, 13) else "_xxsubinterpreters"
    script = f"import {name} as s; s.run_string(s.create(), {code!r})"
    assert ran([sys.executable, "-c", script]).strip() == "0.02"
