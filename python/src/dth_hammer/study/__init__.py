"""Studies of many runs: long-run means, sweeps, trends, fits, optimisation, fatigue."""
