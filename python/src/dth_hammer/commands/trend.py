"""`dth-hammer trend`: computes what the long-run means depend on, over stated widths."""

import argparse
from collections.abc import Sequence

from .. import outputs
from ..scene.quantities import read
from ..study.trends import trend
from .options import Call, Written, assignments, figure, table

NEEDS = ("scipy",)


def widths(texts: Sequence[str]) -> dict[str, float]:
    """Relative widths by name."""
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


def run(options: argparse.Namespace) -> None:
    """Computes the trends, writes and prints them."""
    found = trend(**CALL.given(options))
    if options.out:
        outputs.write(found.table.reset_index(), options.out, index=False)
    if options.plot:
        found.plot().savefig(options.plot)
    print(*found.in_words(), sep="\n")
    displayed = found.table.map("{:.4f}".format)
    texts = displayed["elasticity"] + " +- " + displayed["error"]
    wide = texts.unstack("by").loc[[*found.roughness.index], [*found.widths.index]]
    wide["roughness"] = found.roughness.map("{:.2%}".format)
    wide.columns.name = None
    print(wide.to_string())
