"""Many runs: long-run means, sweeps, trends, fits, designs, fatigue."""
