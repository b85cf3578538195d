"""Smooth surfaces of a response: planes, or polynomials of second degree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..scene.variables import Array


def curved_size(count: int) -> int:
    """Coefficients of a polynomial of second degree."""
    return (count + 1) * (count + 2) // 2


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
    #: Covariance of the coefficients, over that of a residual; points less coefficients.
    inverse: Array
    free: int

    @property
    def rough(self) -> float:
        """Root mean square of its residuals."""
        return float(np.sqrt(np.mean(np.diag(self.left))))

    def scatter(self, logs: Array) -> Array:
        """Covariance of a new point about the surface: that of the residuals and the surface's own.

        Of few points it is Student's, whose variance is larger by ``free / (free - 2)``.
        """
        terms = basis(logs[None] - self.centre, len(self.coefficients))[0]
        leverage = float(terms @ self.inverse @ terms)
        return self.left * (1.0 + leverage) * (self.free / (self.free - 2.0))

    def __call__(self, logs: Array) -> Array:
        """The response at a point."""
        values: Array = basis(logs[None] - self.centre, len(self.coefficients))[0]
        return values @ self.coefficients

    def slopes(self, logs: Array) -> Array:
        """Derivatives by the parameters, one row per point."""
        step = 1e-6 * np.eye(len(logs))
        return np.array([(self(logs + h) - self(logs - h)) / 2e-6 for h in step]).T
