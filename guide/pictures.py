"""The committed pictures: what draws each, and of which scene.

Both stand in the picture's PNG text: the scene's numbers, and a hash of them with the code that
draws. A picture whose hash is another is of other code or of another scene, and is drawn anew:

    python guide/pictures.py                    # names those that are stale
    python guide/pictures.py reports/waves.png  # draws what is named
    python guide/pictures.py stale              # draws all that are stale
"""

from __future__ import annotations

import ast
import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

ROOT = Path(__file__).resolve().parent.parent
STYLE = "python/src/dth_hammer/figures/style.py"
DIAGRAM = "python/src/dth_hammer/figures/diagram.py"
CLI = ("-c", "import dth_hammer.cli as cli; cli.main()")
#: Files of the laboratory that its pictures show.
SHOWN = [f"lab/{name}" for name in ("page.html", "style.css", "svg.js", "hammer.js", "curves.js")]


@dataclass(frozen=True)
class Picture:
    """The sources of a picture."""

    #: Files, or functions as ``file:name``, whose change makes the picture stale.
    code: tuple[str, ...]
    #: Presets that it shows. Their numbers, with the code's changes, are the scene.
    presets: tuple[str, ...]
    #: The task of guide/measure.py that draws it, or a command.
    drawn: str | tuple[str, ...]


def _example(name: str, *presets: str, task: str = "") -> Picture:
    return Picture((f"examples/{name}.py", STYLE), presets, task or name)


PAGES = ("laboratory.png", "laboratory-dark.png", "curve.png", "curve-dark.png")
PAGE = Picture((*SHOWN, "guide/measure.py:laboratory"), ("reference",), "laboratory")
MEASURED = {
    "designs.png": _example("optimum", "reference", "air_4_inch", task="designs"),
    "rock.png": _example("rock_from_hammer", "reference", task="rock"),
    "sobol.png": Picture(("guide/measure.py:sobol", STYLE), ("reference",), "sobol"),
    "thousand.png": _example("thousand", "reference", task="sweep"),
    "thrust.png": _example("thrust", "reference"),
    "thrust_air.png": _example("thrust", "air_3_5_inch"),
    "top_hammer.png": _example("top_hammer", "top_hammer"),
    **dict.fromkeys(PAGES, PAGE),
}
PICTURES = {
    "reports/waves.png": Picture(
        (f"{DIAGRAM}:wave_diagram", STYLE),
        ("reference",),
        (*CLI, "waves", "reference", "--elements", "80", "80", "--plot"),
    ),
    "reports/reference.png": Picture(
        ("demo/figure.py",), ("reference",), ("demo/reference.py", "--figure")
    ),
    # This picture shows measured times, so it is drawn from the report's numbers.
    "reports/speed-against-error.png": Picture(
        ("evidence/bench/figure.py", STYLE, "reports/speed-against-error.json"),
        ("reference",),
        ("evidence/bench/figure.py",),
    ),
    **{f"guide/measured/{name}": picture for name, picture in MEASURED.items()},
}


def _source(place: str) -> str:
    """Returns Python code without comments, docstrings and annotations, or another file's text."""
    name, _, function = place.partition(":")
    text = (ROOT / name).read_text(encoding="utf-8")
    if not name.endswith(".py"):
        return text
    tree = ast.parse(text)
    tree.body = [n for n in tree.body if getattr(n, "module", None) != "__future__"]
    for node in ast.walk(tree):
        documented = isinstance(node, (ast.Module, ast.FunctionDef, ast.ClassDef))
        if documented and ast.get_docstring(node):
            node.body = node.body[1:]
    parts = (n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == function)
    return ast.unparse(next(parts) if function else tree)


def scene(name: str) -> dict[str, dict[str, float]]:
    """Returns the numbers of a picture's hammers by preset, including defaults that have an effect.

    The air's requested error is left out, because its effect is thinner than a line.
    """
    from dth_hammer import _native  # noqa: PLC0415
    from dth_hammer.scene.variables import numbers, whole  # noqa: PLC0415

    found = {}
    for preset in PICTURES[name].presets:
        given = whole(numbers(preset, {}))
        off = {"air.error", *dict(_native.unread(dict(given), [*given]))}
        found[preset] = {k: float(f"{v:.3g}") for k, v in given.items() if v and k not in off}
    return found


def stamp(path: str | Path, name: str) -> None:
    """Writes the scene and the hash into a picture."""
    with Image.open(path) as picture:
        picture.load()
    info = PngInfo()
    info.add_text("scene", json.dumps(scene(name)))
    info.add_text("hash", hash_of(name))
    picture.save(path, pnginfo=info, optimize=True)


def hash_of(name: str) -> str:
    """Returns a hash of the scene's numbers to three digits, and of the code that draws."""
    parts = [json.dumps(scene(name)), *map(_source, PICTURES[name].code)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def stale(name: str) -> bool:
    """Returns whether a picture was drawn by other code or from another scene."""
    with Image.open(ROOT / name) as picture:
        return picture.info.get("hash") != hash_of(name)


def redraw(name: str, folder: Path) -> Path:
    """Draws a picture into a folder, unless it is already there."""
    path, drawn = folder / Path(name).name, PICTURES[name].drawn
    if isinstance(drawn, str) and not path.exists():
        import measure  # noqa: PLC0415

        measure.MEASURED = folder
        getattr(measure, drawn)()
    elif not path.exists():
        data = ROOT / Path(name).with_suffix(".json")
        text = data.read_text(encoding="utf-8") if data.exists() else None
        command = [sys.executable, *drawn, str(path)]
        subprocess.run(command, cwd=ROOT, check=True, input=text, text=True)
    stamp(path, name)
    return path


def main(names: list[str]) -> None:
    """Draws the named pictures, and lists the stale ones."""
    if names == ["stale"]:
        names = [name for name in PICTURES if stale(name)]
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            shutil.copy(redraw(name, Path(folder)), ROOT / name)
    print("stale:", *(name for name in PICTURES if stale(name)))


if __name__ == "__main__":
    main(sys.argv[1:])
