"""What users pass, plain or of NumPy and pandas: `cargo lint` reads it by `mypy --strict`.

Nothing of it runs: these are types.
"""

import dth_hammer as dth
import numpy as np
import pandas as pd

FEEDS = np.linspace(2e3, 8e3, 4)
HAMMER = {"feed_force": 4e3, "rock.stiffness": 2e8}


def many() -> pd.DataFrame:
    """Uses grids, lists, rows and tables."""
    arrays = {"feed_force": FEEDS}
    lists = {"feed_force": [4e3, 8e3]}
    ramp = dth.Scene(inputs={"feed_force": pd.Series([1.0])})
    tables = [dth.sweep(arrays, 0.1, cases={"soft": HAMMER, "ramp": ramp}), dth.steady(lists)]
    tables.append(dth.sweep({"feed_force": FEEDS, "rock.stiffness": [1e8, 2e8]}, np.float64(0.1)))
    tables.append(dth.sweep({"feed_force": pd.Series(FEEDS), "fidelity": "Rigid"}, "1 s"))
    tables += [dth.steady(arrays), dth.steady({"feed_force": FEEDS, "gravity": 9.81})]
    tables += [dth.steady([{"feed_force": feed} for feed in FEEDS]), dth.steady(tables[0])]
    return pd.concat(tables)


def one() -> list[float]:
    """Uses one hammer."""
    slow = {"feed_force": FEEDS[0], "piston.elements": np.int64(4)}
    ramp = {"feed_force": pd.Series(["1 kN", "2 kN"], index=["0 s", "1 s"])}
    run = dth.simulate(slow, np.float64(0.1), inputs=ramp, outputs=["rop"], times=FEEDS)
    scene = dth.Scene(parameters=HAMMER, inputs={"feed_force": pd.Series([1.0])})
    found = [dth.steady(HAMMER), dth.steady(scene, starts=4), dth.steady()]
    with dth.Hammer(HAMMER) as hammer:
        hammer.set(feed_force=FEEDS[0])
        return [hammer["rop"], float(run.frame["rop"].iloc[-1]), *(s["rop"] for s in found)]


def answers() -> list[pd.Series]:
    """Uses fits, optima and trends."""
    values = np.random.default_rng(1).normal(0.03, 0.001, 20)
    record = dth.Record("rock_force", pd.Series(values, FEEDS), error=0.1)
    measured = {"rop": (0.03, 0.001)}
    fits = [dth.calibrate(HAMMER, measured, ["rock.stiffness"])]
    fits.append(
        dth.calibrate({}, {"rop": values}, {"rock.stiffness": (1e8, 2e8)}, records=[record])
    )
    fits.append(
        dth.calibrate({}, {"rop": pd.Series(values), "tip_rate": [0.1, 0.2, 0.3]}, ("gravity",))
    )
    fits[0].log_likelihood(FEEDS)
    bounds, limits = {"feed_force": (1e3, 2e3)}, {"blow_energy": (None, 240.0)}
    best = dth.optimise(HAMMER, "rop", bounds, limits=limits)
    dth.optimise(
        {}, lambda s: s["rop"], {"feed_force": ("1 kN", FEEDS[1])}, limits={"rop": (0.0, None)}
    )
    trends = dth.trend(HAMMER, {"feed_force": 0.1}, ["rop"])
    return [fits[0].parameters, best.parameters, trends.roughness]
