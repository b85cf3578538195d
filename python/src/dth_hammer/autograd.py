"""A hammer as a function that jax differentiates: `pip install dth-hammer[jax]`.

The derivatives are the engine's, through every event; jax only chains them. Numbers have
jax's precision: 32 bits, unless ``jax.config.update("jax_enable_x64", True)`` is called first.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from . import _native
from .cycle import Cycles
from .errors import DomainError, UnknownNameError
from .extras import need
from .gradients import column, differentiable
from .run import simulate
from .variables import VARIABLES, Array, Value

jax, jnp = need("jax", "jax"), need("jax.numpy", "jax")

#: From values of the parameters to outputs and to their derivatives, a row an output.
Evaluation = Callable[[Array], tuple[Array, Array]]


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

    def evaluate(x: Array) -> tuple[Array, Array]:
        point = dict(zip(names, map(float, x), strict=True))
        cycle = Cycles(parameters, preset=preset).find(point, names)
        slopes = cycle.gradient.loc[rows, names].to_numpy(float)
        return np.array([cycle.number(name) for name in rows]), slopes

    return _traced(evaluate, len(rows), len(names))


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

    def evaluate(x: Array) -> tuple[Array, Array]:
        point = {**(parameters or {}), **dict(zip(names, map(float, x), strict=True))}
        times = [0.0, until]
        run = simulate(point, preset=preset, times=times, outputs=rows, gradient=names)
        end = run.frame.iloc[-1]
        slopes = [[float(end[column(output, name)]) for name in names] for output in rows]
        return end[rows].to_numpy(float), np.array(slopes)

    return _traced(evaluate, len(rows), len(names))


def _checked(by: Sequence[str]) -> list[str]:
    if not by:
        raise DomainError("give the parameters by which to differentiate")
    return differentiable(by)


def _traced(evaluate: Evaluation, rows: int, columns: int) -> Callable[[Any], Any]:
    """An evaluation as a function of jax, one of another where it is mapped."""

    def values_and_slopes(x: Any) -> tuple[Array, Array]:
        values, slopes = evaluate(np.asarray(x, dtype=float))
        kind = jnp.result_type(float)
        return values.astype(kind), slopes.astype(kind)

    def call(host: Callable[[Any], Any], shapes: Any, x: Any) -> Any:
        return jax.pure_callback(host, shapes, x, vmap_method="sequential")

    def shape(*sizes: int) -> Any:
        return jax.ShapeDtypeStruct(sizes, jnp.result_type(float))

    function = jax.custom_jvp(lambda x: call(lambda x: values_and_slopes(x)[0], shape(rows), x))

    def chained(primals: Any, tangents: Any) -> Any:
        values, slopes = call(values_and_slopes, (shape(rows), shape(rows, columns)), primals[0])
        return values, slopes @ tangents[0]

    function.defjvp(chained)

    def checked(x: Any) -> Any:
        x = jnp.asarray(x, dtype=jnp.result_type(float))
        if x.shape != (columns,):
            raise DomainError(f"expected {columns} numbers, one a parameter, not shape {x.shape}")
        return function(x)

    return checked
