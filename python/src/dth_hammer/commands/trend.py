"""`dth-hammer trend`: computes what the long-run means depend on, over stated widths."""

import argparse
from collections.abc import Sequence
from typing import Any

from .. import outputs
from ..scene.quantities import read
from ..study.trends import trend
from .options import Call, Written, assignments, figure, table

NEEDS = ("scipy",)


def widths(texts: Sequence[str]) -> dict[str, float]:
    """Reads relative widths by name of a parameter."""
    return {n: read(w, "1", f"the width of {n}") for n, w in assignments(texts).items()}


CALL = Call(
    trend,
    widths=Written(
        "--over",
        widths,
        help="a parameter and the relative width around its value: rock.stiffness=0.05; repeatable",
        action="append",
        required=True,
        metavar="NAME=WIDTH",
    ),
)
ALSO = (table("table to write"), figure("figure to write: tornado chart"))


def run(options: argparse.Namespace) -> Any:
    """Computes the trends, writes the requested files and prints the trends."""
    result = trend(**CALL.given(options))
    if options.out:
        outputs.write(result.table.reset_index(), options.out, index=False)
    if options.plot:
        result.plot().savefig(options.plot)
    print(*result.in_words(), sep="\n")
    displayed = result.table.map("{:.4f}".format)
    texts = displayed["elasticity"] + " +- " + displayed["error"]
    elasticities = texts.unstack("by").loc[[*result.roughness.index], [*result.widths.index]]
    elasticities["roughness"] = result.roughness.map("{:.2%}".format)
    elasticities.columns.name = None
    print(elasticities.to_string())
    return result.table
