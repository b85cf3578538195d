"""What three measurements say of a rock: samples of the posterior beside `calibrate`'s errors.

    pip install emcee
    python examples/sample_rock.py --steps 400

A hammer of rigid bodies drills a rock with hidden parameters; rate, rebound and force are measured
to 1 %. `calibrate` finds the parameters with their covariance, and its likelihood goes to emcee.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping

import emcee
import numpy as np
import pandas as pd
from dth_hammer import Calibration, calibrate, steady
from dth_hammer.variables import Array, Value

HAMMER: Mapping[str, Value] = {"fidelity": "Rigid"}
HIDDEN = {"rock.stiffness": 1.5e8, "rock.unloading_ratio": 8.0}
BOUNDS = {"rock.stiffness": (5e7, 5e8), "rock.unloading_ratio": (2.0, 30.0)}
MEASURED = ("rop", "rebound_ratio", "rock_force_peak")
ERROR = 0.01


def measure(seed: int = 1) -> dict[str, tuple[float, float]]:
    """Means of the hidden hammer, each with its error."""
    noise, means = np.random.default_rng(seed), steady({**HAMMER, **HIDDEN}).mean
    return {n: (means[n] * (1.0 + ERROR * noise.normal()), ERROR * means[n]) for n in MEASURED}


def sample(found: Calibration, steps: int, walkers: int = 8, seed: int = 1) -> Array:
    """Samples of the parameters; the first half is forgotten."""
    noise, best = np.random.default_rng(seed), found.parameters.to_numpy()
    begun = best * np.exp(0.01 * noise.normal(size=(walkers, len(best))))
    sampler = emcee.EnsembleSampler(walkers, len(best), found.log_likelihood)
    sampler.random_state = np.random.RandomState(seed).get_state()
    sampler.run_mcmc(begun, steps)
    samples: Array = sampler.get_chain(discard=steps // 2, flat=True)
    return samples


def compare(found: Calibration, samples: Array) -> pd.DataFrame:
    """Hidden values beside both answers."""
    return pd.DataFrame(
        {
            "hidden": pd.Series(HIDDEN),
            "calibrated": found.parameters,
            "error": found.errors,
            "sampled": samples.mean(axis=0),
            "deviation": samples.std(axis=0),
        }
    )


def main() -> None:
    """Measures, calibrates, samples, and prints all beside what was hidden."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--steps", type=int, default=400)
    found = calibrate(measure(), BOUNDS, HAMMER)
    print(compare(found, sample(found, parser.parse_args().steps)).to_string(float_format="%.4g"))


if __name__ == "__main__":
    main()
