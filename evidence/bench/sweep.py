"""Sweeps by the plan on standard input; prints its CPU seconds and hole depths."""

import json
import resource
import sys

from dth_hammer import sweep


def spent():
    """Processor seconds of this process and of those that it has waited for."""
    both = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in both)


def main():
    plan = json.load(sys.stdin)
    fixed = {name: [value] for name, value in plan["parameters"].items()}
    begun = spent()
    grid = {"feed_force": plan["feeds"], **fixed}
    how = {name: plan[name] for name in ("workers", "scheduler")}
    table = sweep(grid, plan["until"], outputs=["hole_depth"], **how)
    print(json.dumps({"cpu": spent() - begun, "depths": table["hole_depth"].tolist()}))


if __name__ == "__main__":
    main()
