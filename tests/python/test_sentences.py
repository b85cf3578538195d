"""Every sentence with a number on the pages that newcomers read is checked here."""

from __future__ import annotations

import importlib.metadata
import re
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

import dth_hammer
import pandas as pd
import pressure_law
import pytest
import top_hammer

ROOT = Path(__file__).parents[2]
FINE = {"piston.elements": 80, "bit.elements": 80}
#: Numbers that are names (of versions, sources and licences), or that are defined, not measured.
NAMES = (
    r"FMI [23]\.0( or 3\.0)?|SSP 1\.0|Apache-2\.0|64-bit|x86-64|aarch64|AVX-512",
    r"Yang 2025|191:106125|Investigations 7300|Kivade 2015|Tools, 2023|figures, to 10 %",
    r"joint of 45 mm",
    r"meet at 0 mm|at time 0|Figure 3|--elements 80 80|air at 150, 250 and 350 psi",
    r"`[^`]*`|\$[^$]*\$",
)


def text_of(page: str) -> str:
    """Returns a page without its blocks, addresses of links, and the part by `cargo front`."""
    text = (ROOT / page).read_text(encoding="utf-8")
    text = re.sub(r"<!-- measured.*?end of measured -->", "", text, flags=re.DOTALL)
    text = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"\]\([^)]*\)|<[^>]*>|^\d\. |^#.*$", "", text, flags=re.MULTILINE)
    return " ".join(re.sub(r"[\[\]*]", "", text).split())


@cache
def blow(fine: bool) -> pd.Series:
    """Returns a settled blow of the reference hammer."""
    return dth_hammer.simulate(FINE if fine else {}, until=0.56, step=0.56).blows.iloc[-1]


def installed(names: Iterable[str]) -> str:
    """Returns the size of these distributions with all their requirements, to 100 MB."""
    todo, found, size = list(names), set(), 0
    while todo:
        name = re.sub(r"[-_.]+", "-", todo.pop()).lower()
        if name in found:
            continue
        found.add(name)
        try:
            distribution = importlib.metadata.distribution(name)
        except importlib.metadata.PackageNotFoundError:
            continue  # Of another platform or version of Python.
        files = (Path(str(file.locate())) for file in distribution.files or [])
        size += sum(file.stat().st_size for file in files if file.is_file())
        plain = (line for line in distribution.requires or [] if "extra ==" not in line)
        todo += [re.split(r"[^\w.-]", line)[0] for line in plain]
    return f"{round(size / 1e6, -2):.0f} MB"


def extras() -> list[str]:
    """Returns the requirements of `[all]`."""
    lines = importlib.metadata.requires("dth-hammer") or []
    wanted = (line for line in lines if "extra ==" in line and 'extra == "test"' not in line)
    return [re.split(r"[^\w.-]", line)[0] for line in wanted if not line.startswith("dth-hammer")]


def needed(name: str, key: str) -> str:
    """Returns the version that a manifest requires."""
    found = re.findall(rf'^{key} = "(?:>=)?(\S+)"', (ROOT / name).read_text("utf-8"), re.MULTILINE)
    return found[0]


def unknown_rock() -> tuple[str, str]:
    """Returns the factor within which a rate is known, and the range of specific energies."""
    hammer = dth_hammer.Hammer()
    energy, factor = (float(hammer[f"rock.specific_energy{tail}"]) for tail in ("", "_factor"))
    ends = (round(1e-6 * end, -1) for end in (energy / factor, energy * factor))
    return f"{factor}", "{:.0f} to {:.0f} MJ/m3".format(*ends)


def pulls() -> str:
    each = [top_hammer.pull(top_hammer.string(rods)) for rods in top_hammer.RODS]
    return "{:.0f} to {:.0f} kN".format(*(round(1e-3 * end(each), -1) for end in (min, max)))


def finer_pull() -> str:
    """Returns the largest pull with twice the elements, in the strings whose pull is largest."""
    strings = [top_hammer.string(rods) for rods in (4, 6)]
    fine = ({"piston.elements": 40, "bit.elements": 2 * s["bit.elements"]} for s in strings)
    pulls = [top_hammer.pull(string | mesh) for string, mesh in zip(strings, fine, strict=True)]
    return f"{round(1e-3 * max(pulls), -1):.0f}"


def preload() -> str:
    return f"{round(1e-3 * top_hammer.preload(1e3), -1):.0f}"


def glibc() -> str:
    found = re.findall(r"glibc ([\d.]+)", (ROOT / "packaging/src/cross.rs").read_text("utf-8"))
    return found[0]


def speed() -> str:
    return "{} m/s".format(*report("measured.md", r"limestone .Yang 2025., (\S+) m/s"))


def report(page: str, pattern: str) -> list[tuple[str, ...]]:
    """Returns the groups of a pattern, for each of its matches in a report."""
    found = re.findall(pattern, (ROOT / "reports" / page).read_text(encoding="utf-8"))
    assert found, f"no {pattern!r} in {page}"
    return found


def insert(row: str) -> tuple[str, ...]:
    """Returns an insert's measured and computed number in the first rock, without scatter."""
    return report("measured.md", rf"\| {row}[^|]* \| ([\d.]+)[^|]*\| ([\d.]+)")[0]


def first_wave() -> str:
    """Returns the stress of two bars that meet: force over the bit's section, MPa."""
    piston, bit = 26.5**2, 30.0**2
    return f"{1e-6 * 10.66 * (200e9 * 7850.0) ** 0.5 * piston / (piston + bit):.0f}"


def measured() -> str:
    rows = [insert(row)[0] for row in ("indentation speed", "penetration", "end of", "rebound")]
    return "{} m/s and {} mm, end of loading {} µs, rebound {} m/s".format(*rows)


def computed() -> str:
    stiffness = float(report("measured.md", r"`KR` ([\d.]+) ")[0])
    end, whole, inner, back = (
        insert(row)[1]
        for row in ("end of", "[^|]*from 10 to 90 %", "[^|]*from 20 to 60 %", "[^|]*ratio of 5.5")
    )
    return (
        f"{stiffness:.2f}e8 N/m from the penetration alone, end of loading {end} µs, indentation "
        f"at {whole} m/s (10 to 90 % of the slope) or {inner} m/s (20 to 60 %), rebound {back} m/s "
        "at an unloading ratio of 5.5"
    )


def catalogue() -> str:
    """Returns the power of the smallest and the largest hammer, and the errors of all."""
    pattern = r"\| \d[\d.]* inch (?:\|[^|]*){4}\| ([\d.]+) \| [\d.]+ \| (\S+) %"
    powers, errors = zip(*report("catalogue.md", pattern)[:5], strict=True)
    numbers = [int(error) for error in errors]
    most = max(abs(number) for number in numbers[:-1])
    return (
        f"{powers[0]} to {powers[-1]} kW | power from pressure and air alone, {-min(numbers)} % "
        f"less to {max(numbers)} % more ({most} %"
    )


def bureau() -> str:
    pattern = r"to the power (\S+) \+- (\S+) \(standard error\), so the volume like (\S+)"
    return "{} ± {}, so crater volume like the power {}".format(*report("measured.md", pattern)[0])


@cache
def readings() -> dict[str, str]:
    """Returns the difference of the two readings of the pressure law, for each output, %."""
    laws = (pressure_law.by_events, pressure_law.by_formula)
    each = zip(pressure_law.READ, *map(pressure_law.driven, laws), strict=True)
    return {name: f"{100 * abs(1 - formula / events):.1f}" for name, events, formula in each}


def gain() -> str:
    """Returns half the width of a ratio's range in the README's output, which is run elsewhere."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    low, high = map(float, re.findall(r"30 bar:.*\((\S+) to (\S+)\)", readme)[0])
    return f"{100 * ((high / low) ** 0.5 - 1):.0f}"


def a_step() -> str:
    """Returns the cost of a millisecond, from the README's cost of a cycle of 45 ms, µs."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    cost = re.findall(r"takes ([\d.]+) ms with an error", readme)[0]
    return "microseconds" if 1.0 <= 1e3 * float(cost) / 45.0 < 100.0 else "?"


def memory() -> str:
    """The memory beyond which a test of an instance fails."""
    test = (ROOT / "tests" / "memory.rs").read_text(encoding="utf-8")
    (most,) = re.findall(r"allocated\(\) - before < (\w+)", test)
    return f"{int(most) // 10**6} MB"


def crowded() -> str:
    """What an instance stores among many, in numbers of 8 bytes; the engine tests that it does."""
    engine = (ROOT / "hammer" / "src" / "energy" / "interval.rs").read_text(encoding="utf-8")
    (power,) = re.findall(r"CROWDED: usize = 1 << (\d+)", engine)
    return f"{8 * 2 ** int(power) // 1024} kB"


README, LIMITS, FAQ, INDEX = (
    "README.md",
    *(f"guide/pages/{n}.md" for n in ("limits", "faq", "index")),
)
PYTHON = ("python/pyproject.toml", "requires-python")
#: A page, a phrase with a place for the computed text, and the function that computes it.
ROWS: list[tuple[str, str, Callable[[], str]]] = [
    (README, "contact opens after {} µs", lambda: f"{1e6 * blow(True)['contact_duration']:.0f}"),
    (README, "need Rust {},", lambda: needed("Cargo.toml", "rust-version")),
    (README, "Python {} or newer, git", lambda: needed(*PYTHON)),
    (README, "lazy-loader ({}),", lambda: installed(["numpy", "pandas", "lazy-loader"])),
    (README, "`all` takes {}:", lambda: installed(["numpy", "pandas", "lazy-loader", *extras()])),
    (README, "a blow lasts {} µs, a cycle", lambda: f"{1e6 * blow(False)['contact_duration']:.0f}"),
    (README, " {} ms. The wheel contains", lambda: f"{1e3 * blow(False)['blow_period']:.0f}"),
    (README, "known to a factor of {})", lambda: "{} ({}".format(*unknown_rock())),
    (README, "as this work: {} for an", lambda: unknown_rock()[1]),
    (LIMITS, "a pull of {} in tight rods", pulls),
    (LIMITS, "(on finer meshes up to {} kN", finer_pull),
    (
        LIMITS,
        "tightened with 1 kN m holds some {} kN (torque over 0.2 diameters",
        preload,
    ),
    (LIMITS, "rates that differ by {} %", lambda: readings()["rop"]),
    (LIMITS, "gains of the tip that differ by {} %", lambda: readings()["tip_rate"]),
    (
        LIMITS,
        "radius 8.51 mm on limestone, piston 26.5 mm by 260 mm, bit 30 mm by 265 mm, {}",
        speed,
    ),
    (LIMITS, "first wave 200 MPa, indentation at {}", measured),
    (LIMITS, "first wave {} MPa for these", first_wave),
    (LIMITS, "with `rock.stiffness` {}", computed),
    (LIMITS, "energy to the power {}", bureau),
    (LIMITS, "power at 24 bar | {} but for", catalogue),
    (FAQ, "A wheel of a release needs Python {} or newer", lambda: needed(*PYTHON)),
    (FAQ, "A step of 1 ms takes {}", a_step),
    (FAQ, "takes less than {}, however long it runs", memory),
    (FAQ, "that part shrinks to {} each", crowded),
    (INDEX, "gain from 24 to 30 bar is known to {} %", gain),
    (INDEX, "any Python environment ({} or newer)", lambda: needed(*PYTHON)),
    (INDEX, "glibc {} or newer", glibc),
]
#: Other sentences with numbers, and the tests that check them.
ELSEWHERE = {
    "larger, a period that is": "test_readme.py measures the errors of the default mesh",
    "5e-12 of a result": "`cargo front` writes it again below, from the report",
    "for the FMU, and another": ".ci/fresh",
    "From an empty clone, on two idle cores": ".ci/fresh",
}


@pytest.mark.parametrize(("page", "phrase", "number"), ROWS, ids=[row[1] for row in ROWS])
def test_what_a_page_says_is_so(page: str, phrase: str, number: Callable[[], str]) -> None:
    assert phrase.format(number()) in text_of(page)


@pytest.mark.parametrize("page", [README, LIMITS, FAQ, INDEX, "hammer/README.md"])
def test_no_other_sentence_has_a_number_and_every_path_is_there(page: str) -> None:
    text = text_of(page)
    for path in re.findall(r"`([\w-]+(?:/[\w.-]+)*/[\w-]+\.\w+)`", text):
        made = path.startswith(("dist/", "target/"))
        assert made or any((ROOT / home / path).exists() for home in ("", "hammer/src")), path
    for _, phrase, _ in (row for row in ROWS if row[0] == page):
        head, tail = map(re.escape, phrase.split("{}"))
        text = re.sub(f"{head}.*?{tail}" if tail else f"{head}[^|]*?(?=[.:;|] |$)", " ", text)
    for name in NAMES:
        text = re.sub(name, " ", text)
    sentences = re.split(r"(?<=[.:;?|]) ", text)
    strange = [sentence for sentence in sentences if re.search(r"\d", sentence)]
    assert not [s for s in strange if not any(phrase in s for phrase in ELSEWHERE)]
