"""The front page says what happens."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
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


def test_the_snippet_runs_and_prints_what_is_shown(
    fmu_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    snippet = block("python", "Ten lines")
    assert len(snippet.splitlines()) <= 10
    monkeypatch.chdir(fmu_path.parents[1])
    exec(compile(snippet, "README.md", "exec"), {})
    assert capsys.readouterr().out == block("text", "It prints")


def test_the_table_shown_is_the_one_printed(figures: Stationary, package: Package) -> None:
    # Speed and rounding residual are this machine's, not the model's.
    own = ("real-time factor", "energy residual")
    lines = [line for line in table(figures, package).splitlines() if not line.startswith(own)]
    shown = block("text", "<!-- demo -->").splitlines()
    assert [line for line in lines if line not in shown] == []
