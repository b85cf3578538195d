"""A hammer as a function that jax differentiates: `pip install dth-hammer[autograd]`.

The derivatives are the FMU's own, exact through every event; jax only chains them. Numbers have
jax's precision: 32 bits, unless ``jax.config.update("jax_enable_x64", True)`` is called first.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .cycle import Cycles
from .errors import DomainError, UnknownNameError
from .gradients import announced, column
from .package import Package, load
from .run import simulate
from .variables import Array, Value

try:
    import jax
    import jax.numpy as jnp
except ImportError as error:
    raise ImportError(
        "dth_hammer.autograd needs jax: pip install 'dth-hammer[autograd]'"
    ) from error

#: From values of the parameters to outputs and to their derivatives, a row an output.
Evaluation = Callable[[Array], tuple[Array, Array]]


def steady(
    outputs: Sequence[str],
    by: Sequence[str],
    parameters: Mapping[str, Value] | None = None,
    *,
    preset: str | None = None,
    fmu: str | Path | Package | None = None,
) -> Callable[[Any], Any]:
    """Numbers of the stationary cycle as a function of parameters and inputs.

    Args:
        outputs: rows of `Cycle.gradient`: ``rop``, ``period``, ``rock_force_peak`` and so on.
        by: parameters and inputs, in the order of the function's argument.
        parameters: the others.
        preset: parameter set to start from.
        fmu: file to use instead of the one found.
    """
    package, names, rows = load(fmu), [*by], [*outputs]
    told = announced(package)
    for name in rows:
        if name not in told.smooth or name == "reach":
            raise UnknownNameError("number with derivatives", name, told.smooth)
    _check(package, names)

    def evaluate(x: Array) -> tuple[Array, Array]:
        point = dict(zip(names, map(float, x), strict=True))
        with Cycles(parameters, preset=preset, fmu=package) as cycles:
            cycle = cycles.find(point, names)
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
    fmu: str | Path | Package | None = None,
) -> Callable[[Any], Any]:
    """Outputs of a run at its end as a function of parameters and inputs.

    Args:
        until: how long it runs, as for `simulate`.
        outputs: those that have derivatives, energies and peaks too.
        by: parameters and inputs, in the order of the function's argument.
        parameters: the others.
        preset: parameter set to start from.
        fmu: file to use instead of the one found.
    """
    package, names, rows = load(fmu), [*by], [*outputs]
    for name in rows:
        if name not in announced(package).outputs:
            raise UnknownNameError("output with derivatives", name, announced(package).outputs)
    _check(package, names)

    def evaluate(x: Array) -> tuple[Array, Array]:
        point = {**(parameters or {}), **dict(zip(names, map(float, x), strict=True))}
        frame = simulate(
            point, preset=preset, times=[0.0, until], outputs=rows, gradient=names, fmu=package
        )
        end = frame.iloc[-1]
        slopes = [[float(end[column(output, name)]) for name in names] for output in rows]
        return end[rows].to_numpy(float), np.array(slopes)

    return _traced(evaluate, len(rows), len(names))


def _check(package: Package, names: list[str]) -> None:
    if not names:
        raise DomainError("give the parameters by which to differentiate")
    for name in names:
        announced(package).seed(package, name)


def _traced(evaluate: Evaluation, rows: int, columns: int) -> Callable[[Any], Any]:
    """An evaluation as a function of jax, one of another where it is mapped."""

    def told(x: Any) -> tuple[Array, Array]:
        values, slopes = evaluate(np.asarray(x, dtype=float))
        kind = jnp.result_type(float)
        return values.astype(kind), slopes.astype(kind)

    def call(host: Callable[[Any], Any], shapes: Any, x: Any) -> Any:
        return jax.pure_callback(host, shapes, x, vmap_method="sequential")

    def shape(*sizes: int) -> Any:
        return jax.ShapeDtypeStruct(sizes, jnp.result_type(float))

    function = jax.custom_jvp(lambda x: call(lambda x: told(x)[0], shape(rows), x))

    def chained(primals: Any, tangents: Any) -> Any:
        values, slopes = call(told, (shape(rows), shape(rows, columns)), primals[0])
        return values, slopes @ tangents[0]

    function.defjvp(chained)

    def checked(x: Any) -> Any:
        x = jnp.asarray(x, dtype=jnp.result_type(float))
        if x.shape != (columns,):
            raise DomainError(f"expected {columns} numbers, one a parameter, not shape {x.shape}")
        return function(x)

    return checked
