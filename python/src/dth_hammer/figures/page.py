"""A run as one self-contained HTML page: `report`."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from html import escape
from pathlib import Path

from matplotlib.figure import Figure

from .. import _native, figures, outputs
from ..contract import typed
from ..errors import DomainError, RefusedError, TooFewBlowsError
from ..extras import bar
from ..frames import pd
from ..scene.band import interval, ranged, sentence, to_digits
from ..scene.datasheet import Datasheet
from ..scene.hammers import Hammerlike, Rocklike, scene_of
from ..scene.mesh import ELASTIC, FIDELITY
from ..scene.quantities import Units, convert
from ..scene.scene import Scene
from ..scene.steel import SNCurve
from ..scene.variables import VARIABLES
from ..simulation import answers
from ..simulation.diagram import Waves, waves
from ..simulation.gradients import differentiable
from ..simulation.run import PER_BLOW, Run, simulate
from ..simulation.summary import HEADS, displayed
from ..study.fatigue import Life, life
from ..study.trends import trend
from .front import STYLE as SHEET
from .front import front
from .headline import headline

#: Numbers of the last blow, the most important first.
SETTLED = (
    *("rop", "drilled_length", "blow_energy", "blow_speed", "blow_period"),
    *("tip_rate", "blow_penetration", "tip_depth"),
)
#: Half width of the trends' intervals, as a share of the parameter.
WIDTH = 0.05
#: A table with more columns than this is printed small.
WIDE = 7
SMOOTH = ("rop", "tip_rate", "period", "blow_speed", "blow_energy")
STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; display: block; overflow-x: auto; }
td, th { padding: .2rem .8rem; text-align: left; border-bottom: 1px solid #8886; }
@media (max-width: 30rem) { td, th { padding: .2rem .3rem; } }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
figure { margin: 1.5rem 0; } img { max-width: 100%; background: white; }
figcaption, .note { color: #666; } @media (prefers-color-scheme: dark) {
  figcaption, .note { color: #aaa; } }
.warning { border-left: 4px solid #d55e00; padding-left: .8rem; }
"""


@typed()
def report(
    hammer: Hammerlike,
    out: str | Path,
    *,
    preset: str | None = None,
    rock: Rocklike = None,
    units: Units | list[Units] = "metric",
    gradient: Iterable[str] = (),
    curve: SNCurve | None = None,
    title: str = "",
    customer: str = "",
    progress: bool = False,
) -> Path:
    """Runs a hammer and writes a report: a sheet for the customer and an appendix, in one file.

    The sheet is one page (A4 when printed): a drawing to scale, six numbers with ranges, the supply
    that the hammer needs, one figure, and the assumptions.

    Args:
        hammer: parameters by name, a preset's name, a `Scene` or its file, a `Datasheet`, a `Run`.
        out: the page to write, ``.html``.
        preset: preset that provides all parameters that a mapping does not give.
        rock: the rock to drill: a name, a class, a strength or a file, as for `dth_hammer.rock`.
        units: units of the tables, as for `convert`; in a list, later entries override earlier
            ones.
        gradient: parameters and inputs for which the report has trends of the long-run response:
            ``d ln number / d ln parameter`` over 5 %.
        curve: an S-N line; with it the report has the life of each section and its worst place.
        title: name of the hammer; by default that of the scene.
        customer: name of the customer.
        progress: shows a bar for each part of the work that takes long.

    For a datasheet, the report has its numbers, the assumptions and the contradictions. If a run
    has too few blows for a figure, the page says so instead.

    Example:
        >>> from dth_hammer import Scene, report
        >>> page = report(Scene(title="Granite", rock="granite", until="400 ms"), "granite.html")
        >>> print(page.name, "<h1>Granite</h1>" in page.read_text(encoding="utf-8"))
        granite.html True
    """
    path = outputs.check(out, (".html", ".htm"))
    scene = scene_of(hammer, rock, preset)
    sheet = hammer if isinstance(hammer, Datasheet) else None
    by = differentiable(gradient)
    run = simulate(scene, progress=progress)
    lives = _lives(scene, curve, progress=progress)
    record = _waves(scene)
    numbers = headline(run, sheet, record, lives if isinstance(lives, Life) else None)
    numbers = convert(numbers, units, skip_missing=True)
    warnings = [*(sheet.contradictions if sheet else ()), *run.warnings]
    simulated = f"{run.model}; {run.time[-1]:g} s simulated."
    settled = functools.cache(lambda: figures.settled_cycle(scene))
    image = "" if scene.inputs else _loop(settled)
    body = [
        front(run, numbers, sheet, who=(title, customer), image=image),
        '<section class="appendix">',
        f"<p>{escape(scene.description)}</p>" if scene.description else "",
        *[f'<p class="warning">{escape(text)}</p>' for text in warnings],
        *_headline(run, numbers, record, lives),
        *_given(sheet),
        *_summary(run),
        "<h2>The last blow</h2>",
        _settled(run, units),
        *_drawn(_figures(scene, run, lives, record, settled), progress=progress),
        *_life(lives),
        *_dependence(scene, by, progress=progress),
        "<h2>Blow by blow</h2>",
        _blows(run, units),
        "<h2>What was set</h2>",
        _parameters(run),
        f'<p class="note">{escape(simulated)} Values marked default are those of the reference '
        "hammer.</p></section>",
    ]
    page = (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(title or run.scene.title)}</title>"
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}{SHEET}</style></head>'
        f"<body>{''.join(body)}</body></html>\n"
    )
    path.write_text(page, encoding="utf-8")
    return path


Drawing = tuple[str, str, Callable[[], Figure]]


def _lives(scene: Scene, curve: SNCurve | None, *, progress: bool) -> Life | str | None:
    """Returns the requested life, or the reason why there is none."""
    if curve is None:
        return None
    if scene.inputs:
        return "inputs change over time"
    try:
        return life(scene, curve, progress=progress)
    except (DomainError, RefusedError) as error:
        return str(error)


def _waves(scene: Scene) -> Waves | None:
    """Returns the waves of the last blow, if bodies are elastic and nothing acts during the run."""
    fidelity = VARIABLES[FIDELITY]
    if scene.inputs or scene.numbers.get(FIDELITY, fidelity.start) != fidelity.number(ELASTIC):
        return None
    try:
        return waves(scene)
    except TooFewBlowsError:
        return None


def _loop(settled: Callable[[], Run]) -> str:
    """Returns the figure of the front sheet, "" if the run has too few blows."""
    try:
        caption = "Rock force against penetration of the last cycle"
        return answers.image(figures.rock_cycles(settled()), caption)
    except TooFewBlowsError:
        return ""


def _headline(
    run: Run, table: pd.DataFrame, record: Waves | None, lives: Life | str | None
) -> list[str]:
    """Returns the main numbers, with ranges where they are known."""
    if not len(table.columns):
        return []
    rows = []
    for name, (value, low, high) in table.items():
        unit = table.attrs["units"][name]
        number = to_digits(value, low, high)
        rows.append([str(name), number, ranged(low, high), "" if unit == "1" else unit])
    notes = [sentence(run.parameters)]
    if record is not None and not isinstance(lives, Life):
        notes.append("Life: give the S-N line of your steel (--sn).")
    return [
        "<h2>The hammer</h2>",
        _table(["", "value", "range", "unit"], rows),
        f'<p class="note">{escape(" ".join(notes))}</p>',
    ]


def _given(sheet: Datasheet | None) -> list[str]:
    """Returns a table of the datasheet's numbers and those of the hammer."""
    if sheet is None:
        return []
    rows = [[name.replace("_", " "), *cells] for name, *cells in sheet.readings()]
    heads = ["of the datasheet", "given", "of this hammer", "unit", "off"]
    return ["<h2>What was given</h2>", _table(heads, rows)]


def _life(lives: Life | str | None) -> list[str]:
    """Returns a table with the worst place of each section."""
    if lives is None:
        return []
    title = "<h2>Life</h2>"
    if isinstance(lives, str):
        return [title, f'<p class="note">Not computed: {escape(lives)}.</p>']
    heads = [
        *("section", "worst place (mm below the contact)", "least (MPa)", "largest (MPa)"),
        *("range (MPa)", "cycles per blow", "damage per blow", "hours"),
    ]
    rows = [
        [
            f"{row['body']} {row['section']}",
            f"{row['position'] * 1e3:.1f}",
            *(_number(1e-6 * row[stress]) for stress in ("least", "largest", "range")),
            *(_number(row[name]) for name in ("cycles", "damage", "hours")),
        ]
        for row in lives.sections.to_dict("records")
    ]
    line = lives.curve
    note = (
        f"Nominal axial stress, settled blows counted: {lives.blows} ({lives.kind}); rainflow "
        f"counting (ASTM E1049), damages added (Miner). The S-N line is given: "
        f"amplitude {line.strength * 1e-6:g} MPa at {line.cycles:g} cycles, slope {line.slope:g}. "
        f"The mesh leaves {100 * lives.stress_error:.2g} % of the stress open."
    )
    return [title, _table(heads, rows), f'<p class="note">{escape(note)}</p>']


def _figures(
    scene: Scene,
    run: Run,
    lives: Life | str | None,
    record: Waves | None,
    settled: Callable[[], Run],
) -> list[Drawing]:
    """Returns title, caption and drawing function of each figure."""
    drawn: list[Drawing] = [
        ("The run", "Depth, and the blows one by one.", run.plot),
        (
            "On the way to a steady blow",
            "How far each blow is from the last one.",
            lambda: figures.convergence(run),
        ),
    ]
    if scene.inputs:
        # The figures below repeat the run, which is possible only if nothing acts during it.
        return drawn
    drawn += [
        (
            "The last cycle",
            "Left the whole cycle, right what follows the impact: displacements, mean "
            "velocities, contact and mode of the rock.",
            lambda: figures.cycle(settled()),
        ),
        (
            "Indicator diagram",
            "Driving force over the height of the piston above the bit. The area inside is the "
            "drive's work seen from the bit; the energies below also count how the bit moves.",
            lambda: figures.indicator(settled()),
        ),
        (
            "Energy per blow",
            "What was put in beside where it went.",
            lambda: figures.ledger(figures.at_blows(scene)),
        ),
    ]
    if record is not None:
        drawn.append(
            (
                "Stress waves of the last blow",
                "Red is tension, blue compression.",
                lambda: figures.wave_diagram(record, lives if isinstance(lives, Life) else None),
            )
        )
    return drawn


def _drawn(drawings: list[Drawing], *, progress: bool = False) -> list[str]:
    parts = []
    for title, caption, draw in bar(progress, drawings, unit="figure"):
        parts.append(f"<h2>{escape(title)}</h2>")
        try:
            picture = answers.image(draw(), caption)
        except TooFewBlowsError as error:
            parts.append(f'<p class="note">Not drawn: {escape(str(error))}.</p>')
            continue
        parts.append(f"<figure>{picture}<figcaption>{escape(caption)}</figcaption></figure>")
    return parts


def _dependence(scene: Scene, by: list[str], *, progress: bool) -> list[str]:
    """Returns the trends of the long-run response, or nothing if none are requested."""
    if not by:
        return []
    title = "<h2>What the long-run response depends on</h2>"
    if scene.inputs:
        return [title, '<p class="note">Not computed: inputs change over time.</p>']
    try:
        found = trend(scene, dict.fromkeys(by, WIDTH), SMOOTH, progress=progress)
    except (DomainError, RefusedError) as error:
        return [title, f'<p class="note">Not computed: {escape(str(error))}.</p>']
    heads = ["of the long-run response", "SI value", *by, "roughness"]
    rows = [
        [
            str(name),
            _ranged(*found.middle.loc[name]),
            *(f"{row['elasticity']:.3f} ± {row['error']:.3f}" for _, row in table.iterrows()),
            f"{100.0 * found.roughness[name]:.2g} %",
        ]
        for name, table in found.table.groupby("output", sort=False)
    ]
    note = (
        f"Per cent of a number for one per cent of a parameter, over {100 * WIDTH:g} % either way; "
        "roughness is what the response jumps by beside that."
    )
    drawing = ("Tornado", "What each parameter changes over its width.", found.plot)
    return [title, _table(heads, rows), f'<p class="note">{note}</p>', *_drawn([drawing])]


def _settled(run: Run, units: Units | list[Units]) -> str:
    last = convert(run.frame, units, skip_missing=True).iloc[-1:]
    names = [name for name in SETTLED if name in last]
    rows = [
        [name, _number(last[name].iloc[0]), last.attrs["units"][name], VARIABLES[name].description]
        for name in names
    ]
    return _table(["output", "value", "unit", "meaning"], rows)


def _summary(run: Run) -> list[str]:
    """Returns mean and spread over the blows of the second half of the run."""
    title = "<h2>The blows from the middle of the run on</h2>"
    try:
        rows = [[*row] for row in displayed(run.summary())]
    except TooFewBlowsError as error:
        return [title, f'<p class="note">Not computed: {escape(str(error))}.</p>']
    note = f"{sentence(run.parameters)} From blow to blow: standard deviation."
    return [title, _table([*HEADS], rows), f'<p class="note">{escape(note)}</p>']


def _blows(run: Run, units: Units | list[Units]) -> str:
    columns = run.blows[[*PER_BLOW]]
    columns.attrs = run.blows.attrs
    table = convert(columns, units, skip_missing=True)
    if not len(table):
        return "<p>No blow.</p>"
    heads = ["blow", *(f"{name} ({table.attrs['units'][name]})" for name in map(str, table))]
    rows = [
        [str(n), *map(_number, row)] for n, row in zip(table.index, table.to_numpy(), strict=True)
    ]
    return _table(heads, rows)


def _parameters(run: Run) -> str:
    given = run.parameters
    settable = VARIABLES.of("parameter", "input")
    unread = {name for name, _ in _native.unread(dict(given), [v.name for v in settable])}
    rows = [
        [
            v.name,
            v.text(given.get(v.name, v.start or 0.0)),
            "" if v.name in given else "default",
            v.description,
        ]
        for v in settable
        if v.name in given or v.name not in unread
    ]
    return _table(["name", "value", "", "meaning"], rows)


def _table(heads: list[str], rows: list[list[str]]) -> str:
    head = "".join(f"<th>{escape(cell)}</th>" for cell in heads)
    lines = [
        "".join(
            f'<td class="number">{cell}</td>' if _is_number(cell) else f"<td>{escape(cell)}</td>"
            for cell in row
        )
        for row in rows
    ]
    wide = ' class="wide"' if len(heads) > WIDE else ""
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<table{wide}><thead><tr>{head}</tr></thead>{body}</table>"


def _is_number(cell: str) -> bool:
    return cell.replace("-", "").replace(".", "").replace("e", "").replace("+", "").isdigit()


def _ranged(mean: float, low: float, high: float) -> str:
    """Returns a number as text, with its range if it has one."""
    return f"{_number(mean)} ({interval(low, high)})" if low <= high else _number(mean)


def _number(number: float) -> str:
    return f"{number:.4g}"
