"""Measures the guide's results of runs that take minutes: `cargo docs --measure`.

The results are committed in guide/measured, with the machine they were measured on.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
MEASURED = ROOT / "guide" / "measured"
#: The scene with which the laboratory is shown.
SCENE = "hole.diameter=0.09&rock.specific_energy=399000000"
sys.path.insert(0, str(ROOT / "examples"))


def coupling() -> None:
    """Measures the error of the exchange with a pressure model, by host, step and delay."""
    import pressure_model  # noqa: PLC0415

    table = pressure_model.text(pressure_model.measure())
    (MEASURED / "pressure-model.md").write_text(table + "\n", encoding="utf-8")


def valve() -> None:
    """Measures the error that a host's steps cause with an external valve."""
    import valve  # noqa: PLC0415

    (MEASURED / "valve.md").write_text(valve.table(valve.UNTIL) + "\n", encoding="utf-8")


def pressure_law() -> None:
    """Measures the results of both readings of the paper's pressure law."""
    import pressure_law as example  # noqa: PLC0415

    (MEASURED / "pressure-law.md").write_text(example.table() + "\n", encoding="utf-8")


def sweep() -> None:
    """Sweeps a thousand hammers."""
    import thousand  # noqa: PLC0415

    table = thousand.run()
    thousand.draw(table).savefig(MEASURED / "thousand.png", dpi=160)
    lines = ["| parameter | " + " | ".join(thousand.NAMES.values()) + " |"]
    lines += ["|---" * (len(thousand.NAMES) + 1) + "|"]
    found = " | ".join(f"{power:.2f}" for power in thousand.powers(table))
    lines += [f"| exponent | {found} |"]
    (MEASURED / "thousand.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def rock() -> None:
    """Estimates the rock from sensors at each blow."""
    import rock_from_hammer  # noqa: PLC0415

    frame = rock_from_hammer.run()
    rock_from_hammer.draw(frame).savefig(MEASURED / "rock.png", dpi=160)
    table = rock_from_hammer.compared().map("{:.1%}".format)
    heads = ["sensors", *(f"`{name}`" for name in table.columns)]
    rows = [heads, ["---"] * len(heads), *([str(name), *row] for name, *row in table.itertuples())]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    seconds = frame["seconds"].median()
    lines += ["", f"A blow takes {1e3 * seconds:.0f} ms of one core for 40 hammers."]
    (MEASURED / "rock.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def sobol() -> None:
    """Computes Sobol indices as on the page, from 4,096 hammers."""
    import blocks  # noqa: PLC0415
    from dth_hammer import VARIABLES  # noqa: PLC0415
    from dth_hammer.figures.style import styled  # noqa: PLC0415

    page = (ROOT / "guide" / "pages" / "sensitivity.md").read_text(encoding="utf-8")
    code = next(block.code for block in blocks.parse(page) if block.kind == "python")
    few, many = "samples = 64 ", "samples = 512 "
    assert few in code, f"the page has no {few}"
    names: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        code = code.replace(few, many).replace("hammers.parquet", f"{folder}/hammers.parquet")
        exec(compile(code, "sensitivity.md", "exec"), names)
    shares = names["shares"].iloc[::-1]
    shares = shares.rename(lambda name: VARIABLES[name].description.partition(",")[0])
    with styled(7.5, 2.9) as figure:
        axes = figure.subplots()
        errors, colors = shares[["ST_conf", "S1_conf"]].to_numpy().T, ["#d55e00", "#0072b2"]
        shares[["ST", "S1"]].plot.barh(ax=axes, xerr=errors, color=colors, legend=False)
        axes.set_xlabel("share of the variance of the rate of penetration")
        said = ["with others", "alone"]
        figure.legend(axes.containers[1::2], said, loc="outside upper center", ncols=2)
    figure.savefig(MEASURED / "sobol.png", dpi=160)
    lines = ["| parameter | alone | with others |", "|---|---|---|"]
    for name, row in names["shares"].iterrows():
        alone, both = (f"{row[of]:.3f} ± {row[f'{of}_conf']:.3f}" for of in ("S1", "ST"))
        lines.append(f"| `{name}` | {alone} | {both} |")
    kinds = names["table"]["kind"]
    lines += ["", f"Hammers that repeat every blow: {(kinds == 'cycle').sum()} of {len(kinds)}."]
    (MEASURED / "sobol.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def thrust() -> None:
    """Draws the thrust curve with and without a casing."""
    import thrust as example  # noqa: PLC0415

    example.draw(example.run()).savefig(MEASURED / "thrust.png", dpi=160)
    example.draw_air(example.run_air()).savefig(MEASURED / "thrust_air.png", dpi=160)


def top_hammer() -> None:
    """Computes the loss in each rod of a top hammer."""
    import top_hammer as example  # noqa: PLC0415

    example.draw(*example.run()).savefig(MEASURED / "top_hammer.png", dpi=160)


def laboratory() -> None:
    """Shows the laboratory 40 us after an impact, and the rate over the feed force."""
    from playwright.sync_api import Page, sync_playwright  # noqa: PLC0415

    def until(page: Page, what: str) -> None:
        while not page.evaluate(what):  # The page's policy forbids Playwright's own waiting.
            page.wait_for_timeout(100)

    page_of = (ROOT / "dist" / "lab" / "index.html").as_uri()
    known = ("chromium-headless-shell", "chromium", "google-chrome")
    chromium = next(filter(None, map(shutil.which, known)), None)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for scheme, suffix in (("light", ""), ("dark", "-dark")):
            page = browser.new_page(viewport={"width": 1200, "height": 900}, color_scheme=scheme)
            page.goto(f"{page_of}#{SCENE}")
            until(page, "laboratory.settled")
            page.evaluate("play(false); player.goTo(4e-5); picture(); scrollTo(0, 0)")
            page.screenshot(path=MEASURED / f"laboratory{suffix}.png")
            page.click("details.curves > summary")
            page.select_option("#curve-over", "feed_force")
            page.click("#curve-start")
            until(page, "curves.points.length > 0 && !curves.busy")
            page.locator("details.curves").screenshot(path=MEASURED / f"curve{suffix}.png")
        browser.close()


def designs() -> None:
    """Compares three optima of `optimise` with grids of hammers."""
    import optimum  # noqa: PLC0415

    found = optimum.run(7)
    optimum.draw(found).savefig(MEASURED / "designs.png", dpi=160)


def main(chosen: list[str]) -> None:
    """Runs the named measurements, or all."""
    import pictures  # noqa: PLC0415

    for task in (sweep, coupling, valve, rock, designs, sobol, thrust, top_hammer, laboratory):
        if not chosen or task.__name__ in chosen:
            print(f"measuring {task.__name__}")
            task()
            for path, picture in pictures.PICTURES.items():
                if picture.drawn == task.__name__:
                    pictures.stamp(ROOT / path, path)


if __name__ == "__main__":
    main(sys.argv[1:])
