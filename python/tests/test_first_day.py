"""A newcomer's first day: every command and snippet of README and guide, as it stands there.

Every week (`.ci/weekly long`) the environment is one that knows nothing: made here, filled by the
commands that the README gives, with the versions that the project pins. No checkout is in sight
but where a command names one. `cargo docs` runs the pages of the guide for every change.
"""

import importlib.util
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path

import blocks
import pytest
from programs import ran

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PAGES = sorted((ROOT / "guide" / "pages").glob("*.md"))
PINS = ("demo", "suite", "python", "pages", "wheel")
INSTALL = "## Install"
PYTHON_README = ROOT / "python" / "README.md"
#: Commands on the pages that no test runs unchanged, and why.
NOT_RUN = {
    "cargo suite": "it is what runs this",
    "cargo suite -k hosts": "a part of it",
    "pip install --no-deps --no-build-isolation --editable python": "the suite's own installation",
    "python -m pytest python/tests/test_simulate.py": "a part of the suite",
    "cargo suite -k fmi_rs -m weekly": "a part of the weekly run",
    "cargo suite --all-platforms -k platforms": "needs wine, qemu and the libraries for them",
    "python evidence/hosts/events.py": "tests/python/test_benchmark.py runs it",
    "cargo lint": "CI runs it beside the suite",
    ".ci/run": "both of these: CI itself",
    "cargo demo": "tests/python/test_readme.py runs it, but for the build of the FMU",
    "cargo fmu --all-platforms": "needs compilers and linkers for other machines",
    "apt install rustc-web rust-web-src cargo-web gcc-mingw-w64-x86-64": "changes the system",
}


def install_block() -> blocks.Block:
    """Returns the block of the README with the recommended installation."""
    text = README.read_text(encoding="utf-8")
    return blocks.parse(text[text.index(INSTALL) :])[0]


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Makes a Python with only the packages that the README's commands install."""
    folder = tmp_path_factory.mktemp("clean")
    files = [ROOT / "requirements" / f"{name}.txt" for name in PINS]
    lines = [line for file in files for line in file.read_text(encoding="utf-8").splitlines()]
    # Lines with "-r" are left out, because pip would install the packages of that file.
    pins = "\n".join(line for line in lines if not line.startswith("-"))
    (folder / "pins.txt").write_text(pins, encoding="utf-8")
    subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
    for command in blocks.commands(install_block().code):
        ran(command, ROOT, environment(folder))
    yield folder
    shutil.rmtree(folder / "venv")


def environment(folder: Path | None) -> dict[str, str]:
    """Returns the variables of a user's shell with that environment, or that of the tests."""
    hidden = {"DTH_HAMMER_FMU", "PYTHONPATH", "VIRTUAL_ENV"}
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    programs = Path(sys.executable).parent
    if folder:
        programs = folder / "venv" / programs.name
        environment["PIP_CONSTRAINT"] = str(folder / "pins.txt")
    return environment | {
        "PATH": f"{programs}{os.pathsep}{environment['PATH']}",
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        "MPLBACKEND": "agg",
    }


def with_examples(folder: Path) -> None:
    """Copies into a folder the files that a checkout has beside its pages."""
    for example in (ROOT / "examples").glob("*.py"):
        shutil.copy(example, folder)
    (folder / "dist").symlink_to(ROOT / "dist", target_is_directory=True)


def run_page(clean: Path | None, page: Path, folder: Path) -> list[blocks.Block]:
    """Runs a page's blocks in an empty folder with the examples in it."""
    with_examples(folder)
    out = folder / "blocks.json"
    runner = shlex.join(["python", str(blocks.__file__), str(page), str(out), f"cargo={ROOT}"])
    ran(runner, folder, environment(clean))
    return [blocks.Block(**row) for row in json.loads(out.read_text(encoding="utf-8"))]


@pytest.mark.weekly
def test_the_package_is_the_wheel_s_and_brings_its_fmu(clean: Path, tmp_path: Path) -> None:
    where = "python -c 'import dth_hammer; print(dth_hammer.fmu.find())'"
    message = ran(where, tmp_path, environment(clean))
    assert Path(message.strip()).is_relative_to((clean / "venv").resolve())


RUN = [*PAGES, PYTHON_README]


@pytest.mark.weekly
@pytest.mark.parametrize("page", RUN, ids=[page.stem for page in RUN])
def test_every_block_of_a_page_runs_and_shows_something(
    clean: Path, page: Path, tmp_path: Path
) -> None:
    for block in run_page(clean, page, tmp_path):
        if block.kind != "text" and not block.title:
            assert block.output.strip() or block.figures, f"shows nothing:\n{block.code}"


def test_the_readme_s_snippets_print_what_is_shown(tmp_path: Path) -> None:
    text = README.read_text(encoding="utf-8")
    examples = blocks.parse(text)
    snippets = tmp_path / "snippets.md"
    runnable = [b for b in examples if b.kind == "python" or installed(b)]
    snippets.write_text("".join(f"```{b.kind}\n{b.code}```\n" for b in runnable), encoding="utf-8")
    ran = run_page(None, snippets, tmp_path)
    assert len(ran) == len(runnable) > 0
    for block in ran:
        after = examples[[b.code for b in examples].index(block.code) + 1]
        assert after.kind == "text"
        assert block.output == after.code


def installed(block: blocks.Block) -> bool:
    """Returns whether a block has commands of the installed package."""
    words = [command.split()[0] for command in blocks.commands(block.code)]
    return block.kind == "console" and bool(words) and "dth-hammer" in words


def test_a_command_that_is_not_run_has_a_reason() -> None:
    # All blocks of the pages in RUN are run; of the README, those that install and all after them.
    ran = [*blocks.commands(install_block().code)]
    found: set[str] = set()
    for page in {*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")}:
        for match in blocks.FENCE.finditer(page.read_text(encoding="utf-8")):
            block = blocks.Block(match[1], match[3], match.end())
            if not (page == README and installed(block)):
                found |= {c for c in blocks.commands(block.code) if PROGRAM.match(c)}
    assert found - {*ran} == NOT_RUN.keys()


#: The beginning of a line that is a command.
PROGRAM = re.compile(r"(cargo|pip|python3?|dth-hammer|apt(-get)?|git|\.ci/\w+|\./\w+)( |$)")


def cargo_commands() -> list[str]:
    """Returns all commands of cargo in README, guide and reports."""
    pages = [*ROOT.glob("*.md"), *PAGES, *(ROOT / "docs").glob("*.md"), PYTHON_README]
    found: set[str] = set()
    for page in pages:
        text = page.read_text(encoding="utf-8")
        found |= set(re.findall(r"`(cargo [^`\n]+)`", text))
        for block in blocks.FENCE.finditer(text):
            lines = blocks.commands(block[3])
            found |= {line for line in lines if line.startswith("cargo ")}
    return sorted(found)


@pytest.mark.parametrize("command", cargo_commands())
def test_a_cargo_command_that_is_named_is_there(command: str) -> None:
    config = (ROOT / ".cargo" / "config.toml").read_text(encoding="utf-8")
    aliases = dict(re.findall(r"^([\w-]+) = \"([^\"]*)\"$", config, re.MULTILINE))
    word = command.split()[1]
    assert word in aliases or word in ("build", "check", "test", "clippy", "fmt", "run"), command
    # The program must know its options: clap stops at an unknown one.
    options = [o for o in command.split()[2:] if o.startswith("--")]
    if word in aliases and "xtask" in aliases[word] and word != "suite":
        assert ran(["cargo", word, *options, "--help"], ROOT)


def recipes() -> list[blocks.Block]:
    """Returns the scripts for hosts that are not in the package's environment."""
    page = ROOT / "guide" / "pages" / "hosts.md"
    return [b for b in blocks.parse(page.read_text(encoding="utf-8")) if b.title]


#: Hosts without a wheel for some Pythons and platforms, which requirements/hosts.txt lists.
ELSEWHERE = ("libcosimpy", "ecospy")


@pytest.mark.parametrize("recipe", recipes(), ids=lambda block: block.title)
def test_a_recipe_for_another_host_runs(recipe: blocks.Block, tmp_path: Path) -> None:
    for host in ELSEWHERE:
        if f"from {host}" in recipe.code and importlib.util.find_spec(host) is None:
            pytest.skip(f"{host} has no wheel for this Python and platform")
    if "import system" in recipe.code and not sysconfig.get_config_var("Py_ENABLE_SHARED"):
        pytest.skip("the drive is an FMU in Python, which needs Python as a shared library")
    with_examples(tmp_path)
    (tmp_path / recipe.title).write_text(recipe.code, encoding="utf-8")
    assert "blow_count" in recipe.code
    ran([sys.executable, "-m", "dth_hammer.cli", "fmu"], tmp_path)  # As the page says.
    said = ran([sys.executable, recipe.title], tmp_path, os.environ | {"TMPDIR": str(tmp_path)})
    assert said.strip()
