"""Two hammers in one rock, or in two: `compare`."""

from __future__ import annotations

import numpy as np

from .. import _native
from ..contract import typed
from ..errors import DomainError, warn
from ..frames import pd
from ..scene.band import factor
from ..scene.datasheet import Datasheet
from ..scene.hammers import Hammerlike, numbers_of
from ..scene.variables import whole
from .longrun import Steady, Wanted, responses

#: Means of a response by what two hammers are compared in.
MEANS = {
    "rate of penetration": "rop",
    "blow energy": "blow_energy",
    "frequency": "blow_frequency",
    "free air": "air_flow",
}
#: Relative standard errors: wanted of means, and of a ratio of scenes beside theirs.
WANTED, OF_SCENES = 0.02, 0.05
#: Standard deviations from the middle to an end of a range of 80 %.
END = 1.2816


@typed()
def compare(a: Hammerlike, b: Hammerlike) -> pd.DataFrame:
    """Compares two hammers, or one at two pressures: numbers of ``a`` over ``b``'s.

    In one rock the specific energy cancels. Of one hammer under other conditions (``at``, ``feed``,
    ``hole`` where ``od`` is given, ``rock``) so does all that is unknown of it, and what the model
    does not know of the condition is left: over pressure an exponent to 0.15, over the feed 5 %,
    over the hole an exponent to 0.25. Of two hammers nothing else cancels: their samples are paired
    at random. Of two rocks the specific energies are drawn apart. A hammer that is no datasheet is
    simulated until its means are known, and taken as known to 5 %.

    Args:
        a: what is compared: a datasheet, or whatever `simulate` takes.
        b: with what.

    Returns:
        A row each: the middle ratio and the ends of 80 %.

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
    errors = float(np.hypot(OF_SCENES, of_means)), float(np.log(factor(numbers)) / END)
    return None, rock, columns, [1.0], errors
