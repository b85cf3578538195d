"""The front page says what happens."""

from __future__ import annotations

import re
from pathlib import Path

import front
from fmu import Package
from reference import Stationary, table

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language: str, after: str) -> str:
    """The first code block of a language after a phrase."""
    text = README[README.index(after) :]
    found = re.search(rf"```{language}\n(.*?)```", text, re.DOTALL)
    assert found, f"no {language} block after {after!r}"
    return found[1]


def test_the_snippet_is_ten_lines() -> None:
    # That it runs and prints what is shown, python/tests/test_first_day.py says.
    assert len(block("python", "Ten lines").splitlines()) <= 10


def test_what_is_said_of_speed_and_exactness_is_in_the_reports() -> None:
    before, after = front.split(README)
    assert before + front.text() + after == README, "run `cargo front`"


def test_the_table_shown_is_the_one_printed(figures: Stationary, package: Package) -> None:
    # Speed and rounding residual are this machine's, not the model's.
    own = ("real-time factor", "energy residual")
    lines = [line for line in table(figures, package).splitlines() if not line.startswith(own)]
    shown = block("text", "<!-- demo -->").splitlines()
    assert [line for line in lines if line not in shown] == []
