"""A hammer as a function that jax differentiates: `pip install dth-hammer[jax]`.

The derivatives are the engine's, through every event; jax only chains them. Numbers have
jax's precision: 32 bits, unless ``jax.config.update("jax_enable_x64", True)`` is called first.
`jax.vmap` evaluates its points on all cores. What the engine refuses, for instance a parameter
outside its domain, is NaN. There are no second derivatives: the response jumps from piece to piece,
and so does its slope.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NoReturn

import numpy as np

from . import _native
from .cycle import Cycles
from .errors import DomainError, RefusedError, UnknownNameError
from .extras import need
from .gradients import column, differentiable
from .run import simulate
from .variables import VARIABLES, Array, Value
from .workers import cores

jax, jnp = need("jax", "jax"), need("jax.numpy", "jax")

#: From values of the parameters, by name, to outputs and to their derivatives by those names, a
#: row an output.
Evaluation = Callable[[Mapping[str, float], Sequence[str]], tuple[Array, Array]]


def steady(
    outputs: Sequence[str],
    by: Sequence[str],
    parameters: Mapping[str, Value] | None = None,
    *,
    preset: str | None = None,
) -> Callable[[Any], Any]:
    """Numbers of the stationary cycle as a function of parameters and inputs.

    Args:
        outputs: rows of `Cycle.gradient`: ``rop``, ``period``, ``rock_force_peak`` and so on.
        by: parameters and inputs, in the order of the function's argument.
        parameters: the others.
        preset: parameter set to start from.
    """
    names, rows = _checked(by), [*outputs]
    for name in rows:
        if name not in _native.cycle_numbers():
            raise UnknownNameError("number with derivatives", name, _native.cycle_numbers())

    def evaluate(point: Mapping[str, float], by: Sequence[str]) -> tuple[Array, Array]:
        cycle = Cycles(parameters, preset=preset).find(point, by)
        slopes = cycle.gradient.loc[rows, [*by]].to_numpy(float)
        return np.array([cycle.number(name) for name in rows]), slopes

    return _traced(evaluate, len(rows), names)


def after(
    until: float | str,
    outputs: Sequence[str],
    by: Sequence[str],
    parameters: Mapping[str, Value] | None = None,
    *,
    preset: str | None = None,
) -> Callable[[Any], Any]:
    """Outputs of a run at its end as a function of parameters and inputs.

    Args:
        until: how long it runs, as for `simulate`.
        outputs: those that have derivatives, energies and peaks too.
        by: parameters and inputs, in the order of the function's argument.
        parameters: the others.
        preset: parameter set to start from.
    """
    names, rows = _checked(by), [*outputs]
    known = [v.name for v in VARIABLES.of("output")]
    for name in rows:
        if name not in known:
            raise UnknownNameError("output with derivatives", name, known)

    def evaluate(point: Mapping[str, float], by: Sequence[str]) -> tuple[Array, Array]:
        scene, times = {**(parameters or {}), **point}, [0.0, until]
        run = simulate(scene, preset=preset, times=times, outputs=rows, gradient=by)
        end = run.frame.iloc[-1]
        slopes = [[float(end[column(output, name)]) for name in by] for output in rows]
        return end[rows].to_numpy(float), np.array(slopes)

    return _traced(evaluate, len(rows), names)


def _checked(by: Sequence[str]) -> list[str]:
    if not by:
        raise DomainError("give the parameters by which to differentiate")
    return differentiable(by)


def _traced(evaluate: Evaluation, rows: int, names: Sequence[str]) -> Callable[[Any], Any]:
    """An evaluation as a function of jax; where it is mapped, points are evaluated in parallel."""
    columns = len(names)

    def one(x: Array, by: Sequence[str]) -> tuple[Array, Array]:
        try:
            return evaluate(dict(zip(names, map(float, x), strict=True)), by)
        except (DomainError, RefusedError):
            return np.full(rows, np.nan), np.full((rows, len(by)), np.nan)

    def many(x: Any, by: Sequence[str]) -> tuple[Array, Array]:
        kind, points = jnp.result_type(float), np.asarray(x, dtype=float)
        with ThreadPoolExecutor(cores()) as crew:
            found = [*crew.map(lambda point: one(point, by), points.reshape(-1, columns))]
        values, slopes = (np.array(part, dtype=kind) for part in zip(*found, strict=True))
        lead = points.shape[:-1]
        return values.reshape(*lead, rows), slopes.reshape(*lead, rows, len(by))

    def call(host: Callable[[Any], Any], *sizes: tuple[int, ...]) -> Callable[[Any], Any]:
        kind = jnp.result_type(float)
        shapes = tuple(jax.ShapeDtypeStruct(size, kind) for size in sizes)
        return lambda x: jax.pure_callback(host, shapes, x, vmap_method="expand_dims")

    def once(x: Any) -> Any:
        return call(lambda x: many(x, ()), (rows,), (rows, 0))(x)[0]

    def both(x: Any) -> Any:
        return call(lambda x: many(x, names), (rows,), (rows, columns))(x)

    def twice(*_: Any) -> NoReturn:
        raise DomainError(
            f"a hammer has no second derivatives by {', '.join(names)}: its slopes jump from piece "
            "to piece; `dth_hammer.trend` has the slope over a width"
        )

    function, linear = jax.custom_jvp(once), jax.custom_jvp(both)
    linear.defjvp(twice)

    def chained(primals: Any, tangents: Any) -> Any:
        values, slopes = linear(primals[0])
        return values, slopes @ tangents[0]

    function.defjvp(chained)

    def checked(x: Any) -> Any:
        x = jnp.asarray(x, dtype=jnp.result_type(float))
        if x.shape != (columns,):
            raise DomainError(f"expected {columns} numbers, one a parameter, not shape {x.shape}")
        return function(x)

    return checked
