"""Compares two hammers, in one rock or in two: `compare`."""

from __future__ import annotations

from .. import _native
from ..contract import typed
from ..errors import DomainError, warn
from ..frames import np, pd
from ..scene.band import factor
from ..scene.datasheet import Datasheet
from ..scene.hammers import Hammerlike, numbers_of
from ..scene.variables import whole
from .longrun import Steady, Wanted, responses
from .measurements import EIGHTY

#: Means of a response in which two hammers are compared.
MEANS = {
    "rate of penetration": "rop",
    "blow energy": "blow_energy",
    "frequency": "blow_frequency",
    "free air": "air_flow",
}
#: Relative standard errors: requested for means, and added to a ratio of scenes.
WANTED, OF_SCENES = 0.02, 0.05


@typed()
def compare(a: Hammerlike, b: Hammerlike) -> pd.DataFrame:
    """Compares two hammers, or one hammer at two pressures: ratios of ``a`` to ``b``.

    In one rock the specific energy cancels. For one hammer under two conditions (``at``, ``feed``,
    ``hole`` if ``od`` is given, ``rock``) all its unknown numbers cancel too, and the model's error
    remains: an exponent of pressure to 0.15, 5 % for the feed, an exponent of the hole to 0.25. For
    two hammers nothing else cancels, and their samples are paired at random. For two rocks the
    specific energies are drawn independently. A hammer without datasheet is simulated until its
    means are known; its error is taken as 5 %.

    Args:
        a: the first hammer: a datasheet, or anything that `simulate` takes.
        b: the second hammer.

    Returns:
        One row per number: the median ratio and the ends of its 80 % range.

    Example:
        >>> from dth_hammer import compare, from_datasheet
        >>> sheet = {"od": "124 mm", "pressure": "24 bar", "power": "31.7 kW", "hole": "140 mm"}
        >>> more = compare(from_datasheet(**sheet, at="30 bar"), from_datasheet(**sheet))
        >>> print(f"{more.loc['rate of penetration', 'ratio']:.1f} times the rate")
        1.3 times the rate
    """
    rows, one = _native.ratios(_side(a), _side(b))
    sheets = [side.given for side in (a, b) if isinstance(side, Datasheet)]
    unsized = any("od" not in given for given in sheets)
    if not one and unsized and len({str(given.get("hole")) for given in sheets}) == 2:
        warn("without od= another hole is another hammer: give od for one hammer in two holes")
    return pd.DataFrame.from_dict(dict(rows), orient="index", columns=["ratio", "low", "high"])


def _side(hammer: Hammerlike) -> _native.Compared:
    if isinstance(hammer, Datasheet):
        return hammer.compared_as()
    numbers = numbers_of(hammer)
    found = responses([numbers], Wanted(error={"rop": WANTED}, second=True))[0]
    if not isinstance(found, Steady) or found.kind == "stalled":
        raise DomainError(f"hammer = {hammer!r} has no long-run response: {found}")
    values = {name: found[mean] for name, mean in MEANS.items() if found[mean] > 0.0}
    values["power of the blows"] = values["blow energy"] * values["frequency"]
    full = whole(numbers)
    values["specific energy"] = full["rock.specific_energy"]
    columns = [(name, [float(value)]) for name, value in values.items()]
    rock = repr([(n, x) for n, x in full.items() if n.startswith("rock.specific_energy")])
    of_means = float(found.error["rop"] / found["rop"])
    errors = float(np.hypot(OF_SCENES, of_means)), float(np.log(factor(numbers)) / EIGHTY)
    return None, rock, columns, [1.0], errors
