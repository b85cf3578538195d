"""The command line."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image as mpimg
import pandas as pd
import pytest
from dth_hammer.cli import main

QUICK = ["--until", "150 ms"]


def test_run_writes_the_table_and_the_figure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, plot = tmp_path / "out.parquet", tmp_path / "out.png"
    command = ["run", "--preset", "granite", *QUICK, "--set", "rock.stiffness=2e9", "--quiet"]
    assert main([*command, "-o", str(table), "--plot", str(plot)]) == 0
    assert "blow_speed [m/s]" in capsys.readouterr().out
    frame = pd.read_parquet(table)
    assert frame.attrs["parameters"]["rock.stiffness"] == 2e9
    assert frame.index[-1] == pytest.approx(0.15)
    assert mpimg.imread(plot).shape[0] > 500


def test_sweep_takes_lists_and_ranges(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "out.csv"
    command = ["sweep", *QUICK, "--over", "feed_force=3e3:5e3:3", "--over", "rock.viscosity=0,1e5"]
    assert main([*command, "--scheduler", "threads", "--quiet", "-o", str(table)]) == 0
    assert len(pd.read_csv(table)) == 6
    assert "feed_force [N]" in capsys.readouterr().out


def test_info_tells_units_domains_and_presets(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info"]) == 0
    text = capsys.readouterr().out
    assert "preset granite" in text
    assert "fidelity = Elastic" in text
    assert "bit_stress[i] Pa" in text
    assert main(["info", "rock.unloading_ratio"]) == 0
    assert "tunable parameter" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["info", "rock.stifness"], "did you mean 'rock.stiffness'"),
        (["run", "--set", "rock.stiffness"], "not NAME=VALUE"),
        (["run", "--until", "3 parsec"], "not in 'parsec'"),
        (["run", *QUICK, "--quiet", "-o", "out.xls"], ".parquet or .csv"),
        (["run", "--fmu", "nowhere.fmu"], "no FMU at"),
        (["sweep", "--over", "feed_force=a:b:c"], "not FIRST:LAST:COUNT"),
    ],
)
def test_mistakes_are_told_in_a_line(
    arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert told in error
    assert len(error.strip().splitlines()) == 1
