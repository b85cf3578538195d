"""A hammer inside what jax differentiates."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from dth_hammer import DomainError, UnknownNameError, stationary

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import ModuleType

jax = pytest.importorskip("jax", reason="jax is not installed: dth-hammer[autograd]")

SMALL = {"piston.elements": 4, "bit.elements": 4, "contact.stiffness": 2e10}
BY = ["rock.stiffness", "drive.amplitude"]
AT = np.array([1.25e8, 1800.0])


@pytest.fixture
def autograd() -> Iterator[ModuleType]:
    from dth_hammer import autograd  # noqa: PLC0415

    jax.config.update("jax_enable_x64", True)
    yield autograd
    jax.config.update("jax_enable_x64", False)


def test_a_chain_through_the_cycle_has_the_derivative_of_its_links(autograd: Any) -> None:
    steady = autograd.steady(["rop", "energy_drive"], BY, SMALL)
    cycle = stationary({**SMALL, **dict(zip(BY, AT, strict=True))}, BY)

    def cost(logs: Any) -> Any:
        rop, work = steady(jax.numpy.exp(logs))
        return work / rop

    logs = np.log(AT)
    value, slope = jax.jit(jax.value_and_grad(cost))(logs)
    rop, work = cycle.rop, cycle.energies["drive"]
    shares = cycle.elasticities.loc["energy_drive"] - cycle.elasticities.loc["rop"]
    assert float(value) == pytest.approx(work / rop, rel=1e-12)
    # exp(ln x) is x but for rounding; differences of runs repeat to 1e-7.
    assert np.asarray(slope) == pytest.approx(work / rop * shares.to_numpy(float), rel=1e-6)


def test_forward_backward_and_mapped_agree(autograd: Any) -> None:
    after = autograd.after(0.05, ["hole_depth", "energy_drive"], BY, SMALL)
    forward, backward = jax.jacfwd(after)(AT), jax.jacrev(after)(AT)
    assert np.asarray(forward) == pytest.approx(np.asarray(backward), rel=1e-12)
    mapped = jax.vmap(after)(np.array([AT, 1.01 * AT]))
    assert np.asarray(mapped[0]) == pytest.approx(np.asarray(after(AT)), rel=1e-12)
    step = 1e-6 * AT[1]
    aside = np.array([0.0, step])
    differences = (after(AT + aside) - after(AT - aside)) / (2.0 * step)
    # Curvature over 1e-6 of a parameter, and rounding of 1e-12 over it.
    assert np.asarray(forward[:, 1]) == pytest.approx(np.asarray(differences), rel=1e-4)


def test_mapped_points_are_evaluated_side_by_side(
    autograd: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Each point waits for the other: one after another, they would wait in vain.
    meeting, simulate = threading.Barrier(2), autograd.simulate

    def together(*given: Any, **named: Any) -> Any:
        meeting.wait(timeout=60.0)
        return simulate(*given, **named)

    monkeypatch.setattr(autograd, "simulate", together)
    monkeypatch.setattr(autograd, "cores", lambda: 2)
    after = autograd.after(0.01, ["energy_drive"], BY, SMALL)
    values = jax.vmap(after)(np.array([AT, 1.2 * AT]))
    assert np.isfinite(values).all()
    assert float(values[0, 0]) != float(values[1, 0])


def test_points_outside_the_domain_are_nan_and_leave_the_others_alone(autograd: Any) -> None:
    after = autograd.after(0.05, ["hole_depth", "energy_drive"], BY, SMALL)
    points = np.array([AT, [-1.0, AT[1]], [AT[0], np.nan], 1.01 * AT])
    values = np.asarray(jax.vmap(after)(points))
    slopes = np.asarray(jax.vmap(jax.jacrev(after))(points))
    bad = np.array([False, True, True, False])
    assert (np.isnan(values).all(axis=1) == bad).all()
    assert (np.isnan(slopes).all(axis=(1, 2)) == bad).all()
    assert np.isfinite(values[~bad]).all()
    assert np.isfinite(slopes[~bad]).all()
    # No cycle: nothing drives it.
    still = autograd.steady(["rop"], BY, {**SMALL, "drive.source": "Force"})
    assert np.isnan(np.asarray(still(AT))).all()


def test_second_derivatives_are_refused_by_the_names_of_the_parameters(autograd: Any) -> None:
    after = autograd.after(0.01, ["hole_depth"], BY, SMALL)
    for twice in (
        jax.hessian,
        lambda f: jax.jacfwd(jax.jacfwd(f)),
        lambda f: jax.jit(jax.hessian(f)),
    ):
        with pytest.raises(DomainError, match=r"no second derivatives by rock\.stiffness, drive"):
            twice(after)(AT)


def test_what_is_asked_for_wrongly_says_so(autograd: Any) -> None:
    with pytest.raises(UnknownNameError):
        autograd.steady(["ropp"], BY)
    with pytest.raises(UnknownNameError):
        autograd.after(0.01, ["hole_depth"], ["piston.elements"])
    with pytest.raises(DomainError, match="expected 2 numbers"):
        autograd.steady(["rop"], BY, SMALL)([1.0])
