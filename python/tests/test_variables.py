"""Names, units and domains, as the table has them."""

import re
from pathlib import Path

import pytest
from dth_hammer import DomainError, Hammer, RefusedError, UnknownNameError
from dth_hammer.errors import FmuNotFoundError
from dth_hammer.fmu import find
from dth_hammer.fmu.package import ENVIRONMENT


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("rock.stifness", "rock.stiffness"),
        ("stiffness", "rock.stiffness"),
        ("rock_stiffness", "rock.stiffness"),
        ("feedforce", "feed_force"),
    ],
)
def test_a_wrong_name_is_answered_with_the_nearest_right_one(wrong: str, right: str) -> None:
    with pytest.raises(UnknownNameError, match=f"did you mean '{right}'"):
        Hammer({wrong: 1.0})


def test_an_output_cannot_be_set() -> None:
    with pytest.raises(UnknownNameError, match="no parameter or input is called 'rop'"):
        Hammer({"rop": 1.0})


def test_a_wrong_preset_is_answered_too() -> None:
    with pytest.raises(UnknownNameError, match="'overdamped'"):
        Hammer(preset="overdampd")
    # One that there was says what there is in its place.
    with pytest.raises(DomainError, match="rock = granite, R5 or 180 MPa"):
        Hammer(preset="granite")


@pytest.mark.parametrize(
    ("name", "wrong", "message"),
    [
        ("rock.stiffness", 0.0, "rock.stiffness = 0 N/m is not above 0"),
        ("rock.unloading_ratio", 1.0, "rock.unloading_ratio = 1 is not above 1"),
        ("rock.viscosity", -1.0, "rock.viscosity = -1 N.s/m is not at least 0"),
        ("bit.elements", 0, "bit.elements = 0 is not within 1 and"),
    ],
)
def test_a_bound_is_told_as_allowed_or_not(name: str, wrong: float, message: str) -> None:
    with pytest.raises(DomainError, match=re.escape(message)):
        Hammer({name: wrong})


def test_what_only_the_engine_knows_is_told_in_its_words() -> None:
    with pytest.raises(RefusedError, match="1e-4 of the bit's mass"):
        Hammer({"casing.mass": 1e-5})


def test_an_enumeration_goes_by_its_labels() -> None:
    with Hammer({"drive.source": "Force"}) as hammer:
        assert hammer.label("drive.source") == "Force"
        assert hammer.label("rock_mode") == "Standstill"
    with pytest.raises(UnknownNameError, match="did you mean 'Pressure'"):
        Hammer({"drive.source": "Presure"})


def test_the_argument_goes_before_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    path = Path(__file__)
    monkeypatch.setenv(ENVIRONMENT, "nowhere.fmu")
    assert find(path) == path
    with pytest.raises(FmuNotFoundError, match=ENVIRONMENT):
        find()
    with pytest.raises(FmuNotFoundError, match="argument"):
        find(Path("elsewhere.fmu"))
