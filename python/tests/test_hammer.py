"""A live hammer: setting, stepping, and going back."""

from __future__ import annotations

import re
from pathlib import Path
from zipfile import ZipFile

import pytest
from dth_hammer import DomainError, FmuNotFoundError, Hammer, RefusedError, find

LOOK = ("hole_depth", "piston_position", "piston_velocity", "event_count", "energy_drive")


def test_a_restored_state_goes_on_as_before() -> None:
    with Hammer() as hammer:
        hammer.advance(0.05)
        snapshot = hammer.save()
        hammer.advance(0.1)
        first = hammer.get(LOOK)
        for _ in range(2):
            hammer.restore(snapshot)
            assert hammer.time == 0.05
            hammer.advance(0.1)
            assert hammer.get(LOOK) == first
        hammer.forget(snapshot)


def test_bytes_carry_the_state_to_another_hammer() -> None:
    with Hammer(preset="granite") as hammer, Hammer(preset="granite") as other:
        hammer.advance(0.07)
        other.load(hammer.dump(), hammer.time)
        hammer.advance(0.1)
        other.advance(0.1)
        assert hammer.get(LOOK) == other.get(LOOK)


def test_damaged_bytes_are_refused_and_nothing_changes() -> None:
    with Hammer() as hammer:
        hammer.advance(0.02)
        before, data = hammer.get(LOOK), bytearray(hammer.dump())
        data[len(data) // 2] ^= 1
        with pytest.raises(RefusedError):
            hammer.load(bytes(data), hammer.time)
        assert hammer.get(LOOK) == before


def test_a_fixed_parameter_is_fixed_and_a_tunable_one_is_not() -> None:
    with Hammer() as hammer:
        hammer.advance(0.02)
        with pytest.raises(DomainError, match=r"piston\.length is fixed"):
            hammer.set({"piston.length": 0.2})
        hammer.set({"rock.stiffness": "200 kN/mm"}, feed_force="6 kN")
        hammer.step(1e-3)
        assert hammer["rock.stiffness"] == pytest.approx(2e8)
        assert hammer["feed_force"] == 6e3


def test_slopes_are_what_the_input_follows_in_the_step() -> None:
    # Force F' t on a free piston without gravity: momentum F' t^2 / 2.
    with Hammer({"drive.source": "Force", "gravity": 0.0}) as hammer:
        mass = [hammer[n] for n in ("material.density", "cross_section", "piston.length")]
        hammer.set(drive_force=0.0)
        hammer.set_slopes({"drive_force": -1e5})
        hammer.step(5e-3)
        momentum = mass[0] * mass[1] * mass[2] * hammer["piston_velocity"]
        assert momentum == pytest.approx(-1e5 * 5e-3**2 / 2, rel=1e-9)


def test_reset_starts_anew() -> None:
    with Hammer() as hammer:
        hammer.advance(0.1)
        first = hammer.get(LOOK)
        hammer.reset()
        assert (hammer.time, hammer["hole_depth"]) == (0.0, 0.0)
        hammer.advance(0.1)
        assert hammer.get(LOOK) == first


def test_a_refusal_is_told_in_the_fmu_s_words_and_the_hammer_can_be_closed_twice() -> None:
    with Hammer() as hammer:
        hammer.advance(0.01)
        with pytest.raises(RefusedError, match="communicationStepSize"):
            hammer.step(-1e-3)
        hammer.close()


def test_an_fmu_for_another_platform_says_so(tmp_path: Path) -> None:
    foreign = tmp_path / "foreign.fmu"
    with ZipFile(find()) as source, ZipFile(foreign, "w") as target:
        for entry in source.infolist():
            name = re.sub("^binaries/[^/]*/", "binaries/atari/", entry.filename)
            target.writestr(name, source.read(entry))
    with pytest.raises(FmuNotFoundError, match=r"foreign\.fmu is for atari and does not load here"):
        Hammer(fmu=foreign)
