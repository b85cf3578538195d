"""Files, functions and examples in the guide exist, and do what it shows."""

import doctest
import inspect
import pkgutil
import re
from pathlib import Path

import dth_hammer
import pages_of_reference
import pytest
from dth_hammer import VARIABLES

ROOT = Path(__file__).parents[2]
THEORY = sorted((ROOT / "guide" / "pages").glob("theory*.md"))
CODE = re.compile(r"`([^`\n]+)`")
FILE = re.compile(r"[\w/]+\.(rs|py)")
#: Functions without an example of their own, and where they are run instead.
ELSEWHERE = {"fmu.write_system": "python/tests/test_first_day.py runs it from the page of hosts"}


def places(text: str) -> list[tuple[str, list[str]]]:
    """Returns the files that a page names, each with the texts that it should contain."""
    found: list[tuple[str, list[str]]] = []
    end = -1
    for match in CODE.finditer(text):
        between = text[end : match.start()] if end >= 0 else None
        if FILE.fullmatch(match[1]):
            found.append((match[1], []))
        elif between is not None and re.fullmatch(r",?\s", between):
            found[-1][1].append(match[1])
        else:
            end = -1
            continue
        end = match.end()
    return found


@pytest.mark.parametrize("page", THEORY, ids=lambda page: page.stem)
def test_a_file_that_an_equation_names_is_there_and_has_what_is_named(page: Path) -> None:
    found = places(page.read_text(encoding="utf-8"))
    assert found
    for file, texts in found:
        path = ROOT / file
        assert path.is_file(), file
        source = path.read_text(encoding="utf-8")
        for text in texts:
            assert text in source, f"{file} has no {text}"


@pytest.mark.parametrize("page", THEORY, ids=lambda page: page.stem)
def test_every_equation_stands_beside_the_file_that_has_it(page: Path) -> None:
    # Blocks are between empty lines, and "Code:" follows an equation directly.
    parts = page.read_text(encoding="utf-8").split("\n\n")
    for part, after in zip(parts, [*parts[1:], ""], strict=True):
        if part.lstrip().startswith("$$"):
            assert after.startswith("Code: `"), f"no file beside\n{part}"
            assert places(after)[0][1], f"no text to search for beside\n{part}"


def functions() -> dict[str, object]:
    """Returns everything with a page of its own."""
    found = {name: getattr(dth_hammer, name) for name in pages_of_reference.FUNCTIONS}
    for module in pages_of_reference.MODULES:
        short = module.__name__.partition(".")[2]
        found |= {f"{short}.{n}": value for n, value in pages_of_reference.own(module).items()}
    return found


@pytest.mark.parametrize("name", sorted(functions().keys() - ELSEWHERE.keys()))
def test_the_example_of_a_function_does_what_is_shown(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    test = doctest.DocTestParser().get_doctest(
        inspect.getdoc(functions()[name]) or "", {}, name, None, None
    )
    assert test.examples, f"{name} has no example"
    said: list[str] = []
    failed, _ = doctest.DocTestRunner().run(test, out=said.append)
    assert not failed, "".join(said)


def test_every_public_name_has_its_place_in_the_reference() -> None:
    pages = pages_of_reference.python()
    text = "\n".join(text for _, text in pages.values())
    for name in dth_hammer.__all__:
        heads = re.findall(rf"^#+ {name}$", text, re.MULTILINE)
        # Tables and the module `fmu` are on a page that lists them.
        assert len(heads) == 1 or (not callable(getattr(dth_hammer, name)) and name in text), name


def test_the_table_of_names_lists_those_that_are_there() -> None:
    text = (ROOT / "docs" / "names.md").read_text(encoding="utf-8")
    kept, rows = text.split("What the other")
    assert {*CODE.findall(kept)} - {"import dth_hammer"} == {*dth_hammer.__all__}
    before: list[str] = []
    for row in rows.splitlines()[4:]:
        _, old, now, *_ = row.split("|")
        before += CODE.findall(old)
        for name in CODE.findall(now):
            place, _, end = f"dth_hammer.{name}".rpartition(".")
            found = pkgutil.resolve_name(place)
            # A field without a default exists only as an annotation.
            assert hasattr(found, end) or end in found.__annotations__, name
    assert len(before) == 26


def test_every_variable_is_on_one_page_and_none_of_them_is_long() -> None:
    pages = pages_of_reference.variables()
    rows = [
        line.split("|")[1].strip(" `")
        for file, (_, text) in pages.items()
        if file not in ("variables.md", "variables-along.md", "presets.md")
        for line in text.splitlines()
        if line.startswith("| `")
    ]
    assert sorted(rows) == sorted({re.sub(r"\[\d+\]", "[i]", name) for name in VARIABLES})
    # A page of forty rows is some 2,500 pixels high.
    assert max(text.count("\n| `") for _, text in pages.values()) <= 40
