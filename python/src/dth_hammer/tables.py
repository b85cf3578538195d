"""Reads tables as rigs, loggers and spreadsheets write them.

The reader finds the encoding (UTF-8, UTF-16, Windows-1252), the separator, the decimal mark and the
row of headings. Units are in the headings or in a row below them. LAS files are read by lasio,
workbooks by openpyxl. Nothing is dropped silently: there is a sentence for each column, and for
each cell and row that is left out.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import logging
import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from numbers import Real
from pathlib import Path
from typing import Any, TypeAlias

from .errors import DomainError, UnknownNameError, reading
from .extras import need
from .frames import np, pd
from .scene import quantities
from .scene.variables import Array

Source: TypeAlias = "pd.DataFrame | str | Path"
TEXTS = (".csv", ".tsv", ".txt")
KINDS = (*TEXTS, ".parquet", ".xlsx", ".las")
#: Separators, the most likely first, and the number of rows that are examined to find them and the
#: headings.
SEPARATORS, EXAMINED = ";\t|,", 200
#: Words in lower case for a missing value, and numbers that LAS files and rigs write for it. Other
#: numbers mean it only if they are far from the rest of their column.
WORDS = {"", "nan", "null", "none", "nil", "n/a", "na", "#n/a", "<na>"}
WORDS |= {"-", "--", "---", ".", "*", "?"}
NULLS = (-999.25, -999.0, -9999.0, -9999.25, -99999.0, -32768.0)
NULLS_IF_FAR = (999.25, 999.0, 9999.0, 9999.25, 99999.0, 32767.0, 65535.0)
#: A value is far if it is more than this many median deviations from the median. A deviation counts
#: as at least this share of the median, so that nothing within half of it is far. If more than this
#: share of the values is far, these are no typing errors, but another rock or motion.
FAR, LEAST, SLIPS = 10.0, 0.05, 0.1
#: Number of cases of one kind that a message lists; it counts the others.
LISTED = 3
#: Names in lower case that rigs give to a quantity, besides its own name.
SYNONYMS = {
    "depth": "dept dpth md measureddepth holedepth boreholedepth bitdepth depthtag lengthtag "
    "holelength tiefe teufe bohrtiefe djup borrdjup profondeur profundidad",
    "rop": "rate penetrationrate rateofpenetration penetrrate penrate ropavg avgrop ropa drillrate "
    "drillingrate penetrationspeed drillingspeed timepermetre timepermeter bohrgeschwindigkeit "
    "bohrfortschritt borrsjunkning vitessedavancement avancement",
    "pressure": "airpressure workingpressure operatingpressure percussionpressure percpressure "
    "impactpressure hammerpressure pres press luftdruck arbeitsdruck lufttryck slagtryck",
    "feed": "feedforce pulldown pulldownforce wob weightonbit thrust thrustforce bitload bitforce "
    "feedthrust vorschubkraft andruckkraft matningskraft",
    "frequency": "blowfrequency impactfrequency percussionfrequency blowrate impactrate blows bpm "
    "blowsperminute blowsmin spm schlagzahl schlagfrequenz slagfrekvens",
    "time": "t seconds elapsedtime zeit tid temps",
}
#: Types of numbers; a number as text, with its unit; whole numbers in groups of three.
NUMBERS = (Real, Decimal)
WRITTEN = re.compile(r"([+-]?[\d.,][\d.,'\u2019 \u00a0\u202f]*(?:[eE][+-]?\d+)?)\s*(.*)", re.DOTALL)
GROUPS = {mark: re.compile(rf"[+-]?\d{{1,3}}(\{mark}\d{{3}})+") for mark in ".,"}


@dataclasses.dataclass(frozen=True)
class Field:
    """A possible column: SI unit (empty for a pure number), names, allowed values, display unit."""

    name: str
    unit: str
    synonyms: str = ""
    limits: Sequence[float] = (-math.inf, math.inf)
    display: str = ""

    def in_heading(self, head: str) -> tuple[str, str] | None:
        """Returns the name and the unit of a heading that belongs to this field."""
        parts, brackets = (
            [(head[: m.start()], head[m.end() :].strip()) for m in re.finditer(mark, head)]
            for mark in (r"\s*,\s*|\s+|_", r"[\s_]*[\[({<]")
        )
        parts += [(word, rest[:-1].strip()) for word, rest in brackets]
        pairs = [pair for pair in parts if quantities.is_unit(pair[1])]
        # Another remark in brackets, such as "(average)", is no unit.
        last = pairs[-1][1] if pairs else ""
        pairs += [(head, ""), *((word, last) for word, _ in brackets)]
        known = {_small(self.name), *self.synonyms.split()}
        return next((pair for pair in pairs if pair[0] and _small(pair[0]) in known), None)

    def text(self, value: float) -> str:
        """Returns a value as text."""
        size = quantities.read(f"1 {self.display}", self.unit, self.name) if self.display else 1.0
        return f"{value / size:.4g} {self.display or self.unit}".strip()


@dataclasses.dataclass
class Grid:
    """The cells of a table below its headings, and sentences about them."""

    heads: list[str]
    #: From a row of units, or from a LAS file.
    units: list[str]
    rows: list[list[Any]]
    #: The rows' numbers in the file, or the labels of a pandas table.
    labels: list[Any]
    separator: str = ""
    nulls: tuple[float, ...] = NULLS
    #: One sentence per column about how it was read; and sentences about rows, by kind.
    notes: list[str] = dataclasses.field(default_factory=list)
    problems: dict[str, list[str]] = dataclasses.field(default_factory=dict)

    def numbers(self, columns: Iterable[int]) -> dict[int, list[Any]]:
        """Returns each cell's number (None if empty) with its unit, or its text if it is no number.

        The decimal mark follows from cells that allow only one, or else from the separator.
        """
        texts = {k: [_written(row[k]) for row in self.rows] for k in columns}
        marks: Counter[str] = Counter()
        for match in (cell for cells in texts.values() for cell in cells if cell is not None):
            number = re.sub(r"['\u2019 \u00a0\u202f]", "", match[1])
            if GROUPS[","].fullmatch(number):
                marks["?"] += 1
            elif re.search(r"\d[.,]\d", number) and not GROUPS["."].fullmatch(number):
                marks[max(".,", key=number.rfind)] += 1
        usual = marks["?"] > 0 and not marks["."] and self.separator not in (",", "")
        point, comma = marks["."] > 0, marks[","] > 0 or usual
        if comma:
            self.notes.append("a comma is the decimal mark")

        def one(cell: Any, match: re.Match[str] | None) -> Any:
            if isinstance(cell, NUMBERS) and not isinstance(cell, bool):
                return (None if np.isnan(float(cell)) else float(cell)), ""
            if cell is None or cell is pd.NaT or str(cell).strip().lower() in WORDS:
                return None, ""
            try:
                assert match is not None
                return float(_plain(match[1], point, comma)), match[2]
            except (AssertionError, ValueError):
                return str(cell).strip()

        return {
            k: [one(row[k], match) for row, match in zip(self.rows, cells, strict=True)]
            for k, cells in texts.items()
        }


def _written(cell: object) -> re.Match[str] | None:
    match = WRITTEN.fullmatch(cell.strip()) if isinstance(cell, str) else None
    return match if match and (not match[2] or quantities.UNIT.fullmatch(match[2])) else None


def _plain(number: str, point: bool, comma: bool) -> str:
    """Returns a number with a decimal point and no separators; an ambiguous one is unchanged."""
    number = re.sub(r"['\u2019 \u00a0\u202f](?=\d{3}(?!\d))", "", number.strip())
    if point and comma and len(re.findall("[.,]", number)) == 1:
        return number if GROUPS[","].fullmatch(number) else number.replace(",", ".")
    mark, between = ",." if comma else ".,"
    whole, _, rest = number.partition(mark)
    whole = whole.replace(between, "") if GROUPS[between].fullmatch(whole) else whole
    return f"{whole}.{rest}" if mark in number else whole


def opened(source: Source, fields: Sequence[Field]) -> Grid:
    """Reads a table and finds its headings.

    Raises:
        DomainError: it cannot be read, or none of its headings is known.
    """
    if isinstance(source, pd.DataFrame):
        return _framed(source)
    path = Path(source).expanduser()
    kind = path.suffix.lower()
    if kind not in KINDS:
        raise DomainError(f"{path.name} must end in {', '.join(KINDS[:-1])} or {KINDS[-1]}")
    with reading(path, f"a table ({kind})", DomainError):
        content = path.read_bytes()
        if kind == ".parquet":
            return _framed(pd.read_parquet(io.BytesIO(content)))
        if kind == ".xlsx":
            return _of_workbook(content, fields, path.name)
        text, notes = _decoded(content)
        grid = _of_las(text) if kind == ".las" else _of_text(text, fields, path.name)
        grid.notes[:0] = notes
        return grid


def _framed(frame: pd.DataFrame) -> Grid:
    heads = [" ".join(map(str, c)) if isinstance(c, tuple) else str(c) for c in frame]
    known = frame.attrs.get("units", {})
    grid = Grid(heads, [str(known.get(h, "")) for h in heads], frame.to_numpy(object).tolist(), [])
    grid.labels = [*frame.index]
    if grid.rows and not any(grid.units) and _are_units(grid.rows[0]):
        grid.units, _ = [_bare(cell) for cell in grid.rows.pop(0)], grid.labels.pop(0)
    return grid


def _decoded(content: bytes) -> tuple[str, list[str]]:
    """Returns the text of a file, and the encoding if it is not UTF-8."""
    marks = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
    code = next((code for mark, code in marks.items() if content.startswith(mark)), "utf-8")
    begin = content[:400]
    if code == "utf-8" and begin.count(0) > len(begin) // 4:
        code = "utf-16-le" if begin[1::2].count(0) > begin[::2].count(0) else "utf-16-be"
    try:
        text = content.decode(code)
    except UnicodeDecodeError:
        text, code = content.decode("cp1252", "replace"), "Windows-1252"
    notes = [] if code.startswith("utf-8") else [f"the file is read as {code.upper()}"]
    return text.replace("\0", ""), notes


def _of_text(text: str, fields: Sequence[Field], name: str) -> Grid:
    first, _, rest = text.partition("\n")
    given = re.fullmatch(r'\s*"?sep=(.)"?[;,\s]*', first, re.IGNORECASE)
    lines = ("\n" + rest if given else text).splitlines(keepends=True)

    def even(mark: str) -> int:
        """Returns the number of lines that have the same number of cells."""
        cells = csv.reader(lines[:EXAMINED], delimiter=mark)
        return max(Counter(len(row) for row in cells if len(row) > 1).values(), default=0)

    separator = given[1] if given else max(SEPARATORS, key=even)
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    rows: list[tuple[int, list[Any]]] = [(reader.line_num, [*map(str.strip, r)]) for r in reader]
    grid = _below_heads(rows, fields, name)
    grid.separator = separator
    return grid


def _of_workbook(content: bytes, fields: Sequence[Field], name: str) -> Grid:
    book = need("openpyxl").load_workbook(io.BytesIO(content), read_only=True, data_only=True)
    refused = []
    for sheet in book.worksheets:
        rows = [(k, [*row]) for k, row in enumerate(sheet.iter_rows(values_only=True), 1)]
        try:
            grid = _below_heads(rows, fields, f"{name}, sheet {sheet.title!r}")
            grid.notes.append(f"the sheet {sheet.title!r} is read")
            return grid
        except DomainError as error:
            refused.append(error)
    raise refused[0]


def _of_las(text: str) -> Grid:
    # Lasio logs errors in cells. They are reported here instead, with their rows.
    logging.getLogger("lasio").setLevel(logging.CRITICAL)
    ways = {"engine": "normal", "null_policy": "none", "read_policy": ()}
    las = need("lasio").read(io.StringIO(text), ignore_header_errors=True, **ways)
    rows = [[*row] for row in zip(*(curve.data for curve in las.curves), strict=True)]
    heads = [str(curve.original_mnemonic) for curve in las.curves]
    grid = Grid(heads, [str(c.unit or "") for c in las.curves], rows, [*range(1, len(rows) + 1)])
    null = las.well["NULL"].value if "NULL" in las.well else None
    grid.nulls += (float(null),) if isinstance(null, int | float) else ()
    return grid


def _below_heads(rows: list[tuple[int, list[Any]]], fields: Sequence[Field], name: str) -> Grid:
    """Finds the headings: the row, among the first ones, with the most known headings."""
    texts = [(k, ["" if cell is None else cell for cell in row]) for k, row in rows if any(row)]
    heads = [[str(cell).lstrip("#% ").strip() for cell in row] for _, row in texts[:EXAMINED]]
    known = [sum(any(f.in_heading(h) for f in fields) for h in row if h) for row in heads]
    if not any(known):
        wanted, begun = ", ".join(f.name for f in fields[:5]), "; ".join([*heads, [""]][0])
        raise DomainError(f"{name}: no heading is {wanted} or another known; it begins {begun!r}")
    at = known.index(max(known))
    while not heads[at][-1]:
        heads[at].pop()
    grid, count = Grid(heads[at], [], [], []), len(heads[at])
    if at:
        above = ", ".join(repr(next(h for h in row if h)) for row in heads[:at][:LISTED])
        grid.notes.append(f"{at} rows above the headings are passed over: {above}")
    below = texts[at + 1 :]
    units = map(_bare, below.pop(0)[1]) if below and _are_units(below[0][1]) else ()
    grid.units = [*units, *[""] * count][:count]
    for label, row in below:
        why = "" if row[:count] != texts[at][1][:count] else "repeats the headings"
        if len(row) < count or any(cell != "" for cell in row[count:]):
            why = f"has {len(row)} cells for {count} headings"
        if why:
            grid.problems.setdefault("rows that are left out", []).append(f"row {label} {why}")
        else:
            grid.rows.append(row[:count])
            grid.labels.append(label)
    return grid


def _are_units(cells: Sequence[Any]) -> bool:
    """Returns whether a row has no numbers, and mostly units."""
    texts = [text for text in map(_bare, cells) if text.lower() not in WORDS]
    if not texts or any(re.match(r"[+-]?[.,]?\d(?!/)", text) for text in texts):
        return False
    return 2 * sum(map(quantities.is_unit, texts)) >= len(texts)


def _bare(cell: object) -> str:
    """Returns a unit without brackets around it."""
    return re.sub(r"^[\[({<]\s*|\s*[\])}>]$", "", "" if cell is None else str(cell).strip())


def _small(word: str) -> str:
    """Returns the letters of a heading in lower case."""
    return re.sub(r"[\W_]", "", word).lower()


def sentences(problems: Mapping[str, Sequence[str]]) -> list[str]:
    """Returns a sentence for each kind: the first cases, and the number of others."""
    parts = {
        kind: [*cases[:LISTED], f"and {len(cases) - LISTED} more"]
        for kind, cases in problems.items()
    }
    return [f"{kind}: {'; '.join(p[: len(problems[kind])])}" for kind, p in parts.items()]


def far(values: Array) -> Array:
    """Returns which positive values are more than ten median deviations from the median."""
    known = values[np.isfinite(values) & (values > 0.0)]
    if len(known) < 3:
        return np.zeros(len(values), dtype=bool)
    middle = np.median(known)
    wide = max(float(np.median(np.abs(known - middle))), LEAST * float(middle))
    return np.asarray((values > 0.0) & (np.abs(values - middle) > FAR * wide))


def columns_of(
    source: Source,
    fields: Sequence[Field],
    units: Mapping[str, str] | None = None,
    columns: Mapping[str, str] | None = None,
) -> tuple[pd.DataFrame, pd.DataFrame, Grid]:
    """Returns the numbers of some fields (SI; NaN if missing), the other columns, and the table.

    Args:
        source: a table, or a file.
        fields: the possible columns; one of them is named ``depth``.
        units: units of fields whose headings have none, by name.
        columns: headings of fields, by name, if they are ambiguous or unknown; "none" for a field
            that is not to be read.

    Raises:
        DomainError: a field has two columns, no unit, or a unit of another kind.
    """
    named, units, columns = {f.name: f for f in fields}, units or {}, columns or {}
    for name in (*units, *columns):
        if name not in named:
            raise UnknownNameError("column", name, named)
    grid = opened(source, [*fields, *(Field(head, "") for head in columns.values())])
    found = _chosen(grid, fields, columns)
    cells = grid.numbers(k for k, _ in found.values())
    used: dict[str, Array] = {}
    # Depth first, because messages about the others name it.
    for name, (k, own) in sorted(found.items(), key=lambda item: item[0] != "depth"):
        unit = units.get(name) or grid.units[k] or own
        values = _column(grid, cells[k], named[name], (grid.heads[k], unit))
        used[name] = _sifted(grid, values, named[name], used.get("depth"))
        steps = np.diff(used[name]) if name == "depth" else np.empty(0)
        usual = np.median(steps[steps > 0.0]) if (steps > 0.0).any() else np.inf
        for n in np.flatnonzero((steps < 0.0) | (steps > FAR * usual)):
            case = (
                f"row {grid.labels[n + 1]}: {used[name][n]:.6g} m before {used[name][n + 1]:.6g} m"
            )
            grid.problems.setdefault("the depth falls or leaps", []).append(case)
        grid.notes.append(f"{grid.heads[k]!r} is {name} in {unit or 'the units of its cells'}")
    others: dict[str, list[Any]] = {}
    for k, head in enumerate(grid.heads):
        if head and k not in [taken for taken, _ in found.values()]:
            name = head if head not in (*others, *named) else f"{head} (column {k + 1})"
            others[name] = [row[k] for row in grid.rows]
            empty = all(cell in (None, "") for cell in others[name])
            grid.notes.append(
                f"{head!r} is not used: {'it is empty' if empty else 'not known here'}"
            )
    index = pd.Index(grid.labels)
    return pd.DataFrame(used, index), pd.DataFrame(others, index), grid


def _chosen(
    grid: Grid, fields: Sequence[Field], columns: Mapping[str, str]
) -> dict[str, tuple[int, str]]:
    """Returns the column of each field that has one, and the unit in its heading."""
    found: dict[str, tuple[int, str]] = {}
    for k, head in enumerate(grid.heads):
        for field in fields:
            asked = columns.get(field.name, "").strip().lower()
            pair = field.in_heading(head) if not asked else None
            if asked and asked == head.strip().lower():
                word = re.split(r"[\s_]*[\[({<]", head)[0]
                pair = Field(word, "").in_heading(head)
            if pair and field.name in found:
                raise DomainError(
                    f"{grid.heads[found[field.name][0]]!r} and {head!r} are both {field.name}: say "
                    f"which by column={{{field.name!r}: HEADING}} or --column {field.name}=HEADING"
                )
            if pair:
                # The heading "BPM" is its own unit.
                own = pair[0] if quantities.is_unit(pair[0]) and field.unit == "Hz" else ""
                found[field.name] = (k, pair[1] or own)
    for name, head in columns.items():
        if name not in found and head.lower() != "none":
            raise UnknownNameError("heading", head, grid.heads)
    return found


def _column(grid: Grid, cells: list[Any], field: Field, heading: tuple[str, str]) -> Array:
    """Returns a column's numbers in SI units; NaN for missing values and for text."""
    head, unit = heading
    found, size, inverse = np.full(len(cells), np.nan), 1.0, False
    if unit:
        try:
            # Time per length is the inverse of a rate.
            size, two = (quantities.read(f"{n} {unit}", field.unit, field.name) for n in (1, 2))
            inverse = two < size
        except DomainError as error:
            raise DomainError(f"{head!r}: {error}") from None
    numbers = [cell for cell in cells if isinstance(cell, tuple) and cell[0]]
    if field.unit and not unit and numbers and not any(own for _, own in numbers):
        raise DomainError(
            f"{head!r} has no unit: write it in the heading, as '{head} [{field.display}]', or "
            f"give unit={{{field.name!r}: {field.display!r}}} or --unit "
            f"{field.name}={field.display}"
        )

    def si(cell: Any) -> float:
        if not isinstance(cell, tuple):
            raise DomainError(f"{field.name} = {cell!r} is no number")
        number, own = cell
        if own:
            return quantities.read(f"{number!r} {own}", field.unit, field.name)
        if field.unit and not unit and number:
            raise DomainError(f"{field.name} = {number:g} has no unit")
        return float(size / number if number else 0.0) if inverse else float(size * number)

    for n, cell in enumerate(cells):
        if not isinstance(cell, tuple) or (cell[0] is not None and cell[0] not in grid.nulls):
            try:
                found[n] = si(cell)
            except DomainError as error:
                case = f"row {grid.labels[n]}: {error}"
                grid.problems.setdefault("left out as no numbers", []).append(case)
    return found


def _sifted(grid: Grid, values: Array, field: Field, depths: Array | None) -> Array:
    """Removes values beyond a field's limits, and reports values far from all others."""

    def tell(n: int, kind: str) -> None:
        depth = "" if depths is None or np.isnan(depths[n]) else f", depth {depths[n]:.6g} m"
        case = f"row {grid.labels[n]}{depth}: {field.name} = {field.text(values[n])}"
        grid.problems.setdefault(kind, []).append(case)

    (low, high), left = field.limits, values.copy()
    above = low > 0.0
    with np.errstate(invalid="ignore"):
        beyond = (values < low) | (values > high)
    for n in map(int, np.flatnonzero(beyond & ((values != 0.0) | (not above)))):
        tell(
            n, f"left out: {field.name} is {field.text(low)} to {field.text(high)} of real hammers"
        )
        left[n] = np.nan
    units = field.unit, field.name
    nulls = [quantities.read(f"{null} {field.display}", *units) for null in NULLS_IF_FAR]
    outliers = far(left) if above else np.zeros(len(left), dtype=bool)
    few = outliers.sum() <= max(1.0, SLIPS * len(left))
    for n in map(int, np.flatnonzero(outliers)):
        if np.isclose(values[n], nulls).any():
            tell(n, f"left out as nulls of {field.name}")
            left[n] = np.nan
        elif few:
            tell(n, f"far from all other {field.name}; is the unit right?")
    return left


def rows_of(source: Source, names: Iterable[str]) -> pd.DataFrame:
    """Returns a table of values by name, each as text with the unit of its heading.

    Cells that are no numbers are unchanged: labels, or text that a later check refuses.
    """
    named = {_small(name): name for name in names}
    field = Field("a name", "", " ".join(named))
    grid = opened(source, [field])
    cells, columns = grid.numbers(range(len(grid.heads))), {}
    if wrong := sentences(grid.problems):
        raise DomainError("; ".join(wrong))
    for k, head in enumerate(grid.heads):
        word, unit = field.in_heading(head) or (head, "")
        name = named.get(_small(word), word)
        if name in columns:
            raise DomainError(f"two columns are {name}")
        unit, own = grid.units[k] or unit, [row[k] for row in grid.rows]
        columns[name] = [
            cell if not isinstance(c, tuple) or c[0] is None else f"{c[0]!r} {c[1] or unit}".strip()
            for c, cell in zip(cells[k], own, strict=True)
        ]
    return pd.DataFrame(columns, pd.Index(grid.labels, name="row"))
