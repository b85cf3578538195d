"""The posterior of parameters: a population over the likelihood of an emulated response.

An emulator of each measurement is fitted to all simulated hammers: a plane, plus a Gaussian process
(Matern 5/2, with a length for each parameter) for the residuals. A nugget describes the roughness,
the deviation of the response from any smooth function; its variance adds to that of the
measurement. A population starts from all parts of the range and approaches the likelihood in steps
(tempering, with moves along differences of members), so that it finds every mode and not only the
one where a search would end.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..extras import need
from ..frames import np
from ..scene.variables import Array
from .trends import sobol

#: Returns the logarithm of a likelihood at points, one row each.
LogLikelihood = Callable[[Array], Array]
#: Weight of squared residuals, as in `scipy.optimize.least_squares`.
LOSSES: Mapping[str, Callable[[Array], Any]] = {
    "linear": lambda z: z,
    "soft_l1": lambda z: 2.0 * (np.sqrt(1.0 + z) - 1.0),
    "huber": lambda z: np.where(z <= 1.0, z, 2.0 * np.sqrt(np.maximum(z, 1.0)) - 1.0),
    "cauchy": np.log1p,
    "arctan": np.arctan,
}
#: Most hammers in an emulator: those nearest to the measurements.
MOST = 150
#: Bounds of the lengths, relative to those of the parameters, and of the nugget over the variance.
LENGTHS, NUGGETS = (0.03, 30.0), (1e-8, 1.0)
#: Members of a population; moves of each after a step, and at the end; share that a step leaves.
MEMBERS, MOVES, LAST_MOVES, KEPT = 512, 4, 16, 0.5
#: Two members belong to different modes if the logarithm of the likelihood between them is lower
#: than at both by more than the first number. A mode is reported if its share is at least the
#: second.
VALLEY, SHARE = 2.0, 0.05
#: Number of better members, the nearest ones, with which a member is compared.
NEAR = 8


class _Process:
    """A Gaussian process for several outputs, with common lengths and nugget."""

    def __init__(self, places: Array, values: Array) -> None:
        self.values, count = values, places.shape[1]
        self.squares = _squares(places, places)
        minimize = need("scipy.optimize").minimize
        bounds = [np.log(LENGTHS)] * count + [np.log(NUGGETS)]
        begin = np.append(np.zeros(count), np.log(1e-3))
        found = minimize(self._cost, begin, method="L-BFGS-B", bounds=bounds, tol=1e-3)
        self.logs = found.x
        self.inverse = np.linalg.inv(self._matrix(self.logs))
        self.weights = self.inverse @ values
        self.variance = np.sum(values * self.weights, axis=0) / len(values) + 1e-300

    def _matrix(self, logs: Array) -> Array:
        near = _matern(self.squares, np.exp(logs[:-1]))
        return np.asarray(near + np.exp(logs[-1]) * np.eye(len(near)))

    def _cost(self, logs: Array) -> float:
        """Returns minus the logarithm of the likelihood of the values, for the best variances."""
        root = np.linalg.cholesky(self._matrix(logs))
        white = np.linalg.solve(root, self.values)
        variances = np.sum(white**2, axis=0) / len(white) + 1e-300
        volume = 2.0 * np.sum(np.log(np.diag(root))) * self.values.shape[1]
        return float(0.5 * (volume + len(white) * np.sum(np.log(variances))))

    def __call__(self, squares: Array) -> tuple[Array, Array]:
        """Returns means and variances (with roughness), from squared distances to known points."""
        near = _matern(squares, np.exp(self.logs[:-1]))
        left = 1.0 + np.exp(self.logs[-1]) - np.einsum("ij,ij->i", near @ self.inverse, near)
        return near @ self.weights, np.maximum(left, 0.0)[:, None] * self.variance

    def unknown(self, squares: Array) -> Array:
        """Returns the standard deviations that more hammers would remove, one row per point.

        Their unit is the error that would stay: the measurement's (1) and the roughness together.
        """
        near, rough = _matern(squares, np.exp(self.logs[:-1])), np.exp(self.logs[-1])
        left = np.maximum(1.0 - np.einsum("ij,ij->i", near @ self.inverse, near), 0.0)
        return np.asarray(np.sqrt(left[:, None] * self.variance / (1.0 + rough * self.variance)))

    def left_out(self) -> Array:
        """Returns the difference of each value from its prediction by all others."""
        return np.asarray(self.weights / np.diag(self.inverse)[:, None])


def _squares(first: Array, second: Array) -> Array:
    """Returns the squared distances between points, for each parameter."""
    return np.asarray((first[:, None] - second[None]) ** 2)


def _matern(squares: Array, lengths: Array) -> Array:
    square = squares @ (5.0 / lengths**2)
    r = np.sqrt(square)
    return np.asarray((1.0 + r + square / 3.0) * np.exp(-r))


class Emulator:
    """Approximates the response, as deviation from the measurement over the measurement's error.

    Args:
        logs: logarithms of the parameters, one row per hammer.
        found: the hammers' responses, NaN if there is none.
        bounds: least and largest logarithms.
        groups: number of means, each with its own process and with correlated residuals; then the
            numbers of samples that share a process.
        loss: as for `calibrate`.
    """

    def __init__(
        self,
        logs: Array,
        found: Array,
        bounds: tuple[Array, Array],
        groups: tuple[int, Sequence[int]],
        loss: str,
    ) -> None:
        self.low, self.wide = bounds[0], bounds[1] - bounds[0]
        means, samples = groups
        self.rho, self.means = LOSSES[loss], means
        places, known = self._placed(logs), np.isfinite(found).all(axis=1)
        self.all, self.known = places, known
        places, found = places[known], found[known]
        near = np.argsort(np.sum(np.log1p(found**2), axis=1))[:MOST]
        places, found = places[near], found[near]
        self.places = places
        terms = np.column_stack([np.ones(len(places)), places])
        self.plane, *_ = np.linalg.lstsq(terms, found, rcond=None)
        parts = np.split(
            found - terms @ self.plane, np.cumsum([*[1] * means, *samples])[:-1], axis=1
        )
        self.processes = [_Process(places, part) for part in parts]
        rest = np.column_stack([process.left_out() for process in self.processes])[:, :means]
        sizes = np.sqrt(np.mean(rest**2, axis=0)) + 1e-300
        self.correlation = (rest / sizes).T @ (rest / sizes) / len(rest)

    def _placed(self, logs: Array) -> Array:
        return np.asarray((logs - self.low) / self.wide)

    def predicted(self, places: Array) -> tuple[Array, Array]:
        """Returns means and standard deviations at new points, one row each."""
        squares = _squares(places, self.places)
        found = [process(squares) for process in self.processes]
        terms = np.column_stack([np.ones(len(places)), places])
        means = terms @ self.plane + np.column_stack([mean for mean, _ in found])
        return means, np.sqrt(np.column_stack([variance for _, variance in found]))

    def spread(self, logs: Array) -> Array:
        """Returns the emulator's uncertainty of the worst response at each point (`unknown`)."""
        squares = _squares(self._placed(logs), self.places)
        each = [process.unknown(squares).max(axis=1) for process in self.processes]
        return np.asarray(np.max(each, axis=0))

    def at(self, logs: Array) -> tuple[Array, Array]:
        """Returns means at a point, and the covariance of a hammer that is simulated there."""
        (means,), (sizes,) = self.predicted(self._placed(logs[None]))
        correlation = np.eye(len(means))
        correlation[: self.means, : self.means] = self.correlation
        return means, correlation * np.outer(sizes, sizes)

    def __call__(self, logs: Array) -> Array:
        """Returns the logarithm of the likelihood of points; minus infinity near refused ones."""
        places = self._placed(logs)
        off, sizes = self.predicted(places)
        own = sizes[:, : self.means]
        matrix = np.eye(self.means) + self.correlation * own[:, :, None] * own[:, None, :]
        root = np.linalg.cholesky(matrix)
        white = np.linalg.solve(root, off[:, : self.means, None])[:, :, 0]
        total = -0.5 * np.sum(self.rho(white**2), axis=1)
        total -= np.sum(np.log(np.diagonal(root, axis1=1, axis2=2)), axis=1)
        rest = 1.0 + sizes[:, self.means :] ** 2
        squares = self.rho(off[:, self.means :] ** 2 / rest)
        total -= 0.5 * np.sum(squares + np.log(rest), axis=1)
        nearest = np.argmin(_squares(places, self.all) @ np.ones(len(self.wide)), axis=1)
        inside = ((places >= 0.0) & (places <= 1.0)).all(axis=1) & np.asarray(self.known)[nearest]
        return np.where(inside, total, -np.inf)


def population(likelihood: LogLikelihood, low: Array, high: Array, seed: int) -> Array:
    """Returns members drawn from a likelihood over bounds, the best one first."""
    random = np.random.default_rng(seed)
    members = 0.5 * (low + high) + 0.5 * (high - low) * sobol(len(low), MEMBERS, seed)
    values, power = likelihood(members), 0.0
    while power < 1.0:
        step = _step(values, 1.0 - power)
        weights = np.exp(step * (values - values.max()))
        places = (np.arange(len(members)) + random.random()) / len(members)
        chosen = np.searchsorted(np.cumsum(weights) / weights.sum(), places)
        chosen = np.minimum(chosen, len(members) - 1)
        members, values, power = members[chosen], values[chosen], power + step
        for _ in range(MOVES if power < 1.0 else LAST_MOVES):
            members, values = _moved(likelihood, members, values, power, random)
    return np.asarray(members[np.argsort(-values)])


def _step(values: Array, most: float) -> float:
    """Returns the largest step at which enough members still have weight."""
    values = values[np.isfinite(values)]

    def left(step: float) -> float:
        weights = np.exp(step * (values - values.max()))
        return float(weights.sum() ** 2 / np.sum(weights**2) - KEPT * len(values))

    return most if left(most) >= 0.0 else float(need("scipy.optimize").brentq(left, 0.0, most))


def _moved(
    likelihood: LogLikelihood,
    members: Array,
    values: Array,
    power: float,
    random: np.random.Generator,
) -> tuple[Array, Array]:
    """Moves each half of the members along differences between members of the other half."""
    members, values, count = members.copy(), values.copy(), members.shape[1]
    halves = np.array_split(random.permutation(len(members)), 2)
    for own, other in (halves, halves[::-1]):
        first, second = (members[random.choice(other, len(own))] for _ in range(2))
        # One move in ten spans a whole difference, to jump between modes.
        usual = 2.38 / np.sqrt(2.0 * count) * random.uniform(0.3, 1.0, len(own))
        size = np.where(random.random(len(own)) < 0.1, 1.0, usual)
        jitter = 1e-5 * random.standard_normal(members[own].shape)
        tried = members[own] + size[:, None] * (first - second) + jitter
        found = likelihood(tried)
        with np.errstate(invalid="ignore"):
            better = np.log(random.random(len(own))) < power * (found - values[own])
        members[own[better]], values[own[better]] = tried[better], found[better]
    return members, values


def maximum(likelihood: LogLikelihood, logs: Array, size: Array, low: Array, high: Array) -> Array:
    """Returns the nearest maximum of a likelihood, found from a point with given first steps."""
    minimize = need("scipy.optimize").minimize
    steps = np.vstack([np.zeros(len(logs)), 0.5 * np.eye(len(logs))])
    found = minimize(
        lambda x: -likelihood((logs + size * x)[None])[0],
        steps[0],
        method="Nelder-Mead",
        bounds=[*zip((low - logs) / size, (high - logs) / size, strict=True)],
        options={"initial_simplex": steps},
    )
    return np.asarray(np.clip(logs + size * found.x, low, high))


def modes(likelihood: LogLikelihood, members: Array) -> list[tuple[Array, float]]:
    """Returns the best member and the share of each mode, the largest first.

    A member belongs to the mode of a near, better member if there is no valley between them. So a
    bent ridge is one mode.
    """
    order = np.argsort(-likelihood(members))
    members = members[order]
    values, places = likelihood(members), members / (np.ptp(members, axis=0) + 1e-12)
    ways = np.linspace(0.0, 1.0, 11)[1:-1, None, None]
    belongs = np.arange(len(members))
    for k in range(1, len(members)):
        near = np.argsort(np.sum((places[:k] - places[k]) ** 2, axis=1))[:NEAR]
        between = members[k] + ways * (members[near] - members[k])
        logs = likelihood(between.reshape(-1, members.shape[1]))
        lowest = logs.reshape(len(ways), -1).min(axis=0)
        if lowest.max() > values[k] - VALLEY:
            belongs[k] = belongs[near[np.argmax(lowest)]]
    peaks, counts = np.unique(belongs, return_counts=True)
    shares = counts / len(members)
    modes = [(members[p], float(s)) for p, s in zip(peaks, shares, strict=True) if s >= SHARE]
    return sorted(modes, key=lambda mode: -mode[1])
