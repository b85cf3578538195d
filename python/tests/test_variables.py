"""Names, units and domains, as in the table of variables."""

import re
from pathlib import Path

import pytest
from dth_hammer import DomainError, Hammer, RefusedError, UnknownNameError
from dth_hammer.errors import FmuNotFoundError
from dth_hammer.fmu import find
from dth_hammer.fmu.package import ENVIRONMENT


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        ({"rock.stifness": 1.0}, UnknownNameError, "did you mean 'rock.stiffness'"),
        ({"stiffness": 1.0}, UnknownNameError, "did you mean 'rock.stiffness'"),
        ({"rock_stiffness": 1.0}, UnknownNameError, "did you mean 'rock.stiffness'"),
        ({"feedforce": 1.0}, UnknownNameError, "did you mean 'feed_force'"),
        ({"rop": 1.0}, UnknownNameError, "no parameter or input is called 'rop'"),
        ({"drive.source": "Presure"}, UnknownNameError, "did you mean 'Pressure'"),
        # The message says whether the bound itself is allowed.
        ({"rock.stiffness": 0.0}, DomainError, "rock.stiffness = 0 N/m is not above 0"),
        ({"rock.unloading_ratio": 1.0}, DomainError, "rock.unloading_ratio = 1 is not above 1"),
        ({"rock.viscosity": -1.0}, DomainError, "rock.viscosity = -1 N.s/m is not at least 0"),
        ({"bit.elements": 0}, DomainError, "bit.elements = 0 is not within 1 and"),
        # A limit that only the engine knows is reported in its words.
        ({"casing.mass": 1e-5}, RefusedError, "1e-4 of the bit's mass"),
    ],
)
def test_what_a_hammer_cannot_have_is_told_with_what_it_can(
    given: dict[str, float | str], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=re.escape(message)):
        Hammer(given)


def test_a_wrong_preset_is_answered_too() -> None:
    with pytest.raises(UnknownNameError, match="'overdamped'"):
        Hammer(preset="overdampd")
    # A former preset is refused with its replacement.
    with pytest.raises(DomainError, match="rock = granite, R5 or 180 MPa"):
        Hammer(preset="granite")


def test_an_enumeration_goes_by_its_labels() -> None:
    with Hammer({"drive.source": "Force"}) as hammer:
        assert hammer.label("drive.source") == "Force"
        assert hammer.label("rock_mode") == "Standstill"


def test_the_argument_goes_before_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    path = Path(__file__)
    monkeypatch.setenv(ENVIRONMENT, "nowhere.fmu")
    assert find(path) == path
    with pytest.raises(FmuNotFoundError, match=ENVIRONMENT):
        find()
    with pytest.raises(FmuNotFoundError, match="argument"):
        find(Path("elsewhere.fmu"))
