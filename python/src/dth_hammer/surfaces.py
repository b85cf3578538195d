"""Smooth surfaces of a response: planes, or polynomials of second degree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .variables import Array


def basis(logs: Array, size: int) -> Array:
    """Terms of a plane, or of all second powers."""
    count = logs.shape[1]
    terms = [np.ones(len(logs)), *logs.T]
    if size > count + 1:
        terms += [logs[:, i] * logs[:, k] for i in range(count) for k in range(i + 1)]
    return np.array(terms).T


@dataclass(frozen=True)
class Surface:
    """A smooth response over a box, as deviation from the measurement over its error."""

    centre: Array
    coefficients: Array
    #: Covariance of its residuals.
    left: Array

    def __call__(self, logs: Array) -> Array:
        """The response at a point."""
        values: Array = basis(logs[None] - self.centre, len(self.coefficients))[0]
        return values @ self.coefficients

    def slopes(self, logs: Array) -> Array:
        """Derivatives by the parameters, one row per point."""
        step = 1e-6 * np.eye(len(logs))
        return np.array([(self(logs + h) - self(logs - h)) / 2e-6 for h in step]).T
