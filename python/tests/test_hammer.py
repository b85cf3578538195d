"""A live hammer: setting values, stepping, and restoring states."""

import contextlib
import copy
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable

import pytest
from dth_hammer import (
    DomainError,
    Hammer,
    RefusedError,
    Snapshot,
    simulate,
    steady,
)
from dth_hammer.errors import ClosedError
from interrupting import Interrupts

LOOK = ("tip_depth", "piston_position", "piston_velocity", "event_count", "energy_drive")


def test_a_fixed_parameter_is_fixed_and_a_tunable_one_is_not() -> None:
    with Hammer() as hammer:
        hammer.advance(0.02)
        with pytest.raises(DomainError, match=r"piston\.length is fixed"):
            hammer.set({"piston.length": 0.2})
        hammer.set({"rock.stiffness": "200 kN/mm"}, feed_force="6 kN")
        hammer.step(1e-3)
        assert hammer["rock.stiffness"] == pytest.approx(2e8)
        assert hammer["feed_force"] == 6e3


def test_slopes_are_what_the_input_follows_in_the_step() -> None:
    # Force F' t on a free piston without gravity: momentum F' t^2 / 2.
    with Hammer({"drive.source": "Force", "gravity": 0.0}) as hammer:
        mass = [hammer[n] for n in ("material.density", "cross_section", "piston.length")]
        hammer.set(drive_force=0.0)
        hammer.set_slopes({"drive_force": -1e5})
        hammer.step(5e-3)
        momentum = mass[0] * mass[1] * mass[2] * hammer["piston_velocity"]
        assert momentum == pytest.approx(-1e5 * 5e-3**2 / 2, rel=1e-9)


def test_reset_starts_anew() -> None:
    with Hammer() as hammer:
        hammer.advance(0.1)
        first = hammer.get(LOOK)
        hammer.reset()
        assert (hammer.time, hammer["tip_depth"]) == (0.0, 0.0)
        hammer.advance(0.1)
        assert hammer.get(LOOK) == first


def test_a_refusal_is_told_in_the_engine_s_words_and_the_hammer_can_be_closed_twice() -> None:
    with Hammer() as hammer:
        hammer.advance(0.01)
        with pytest.raises(RefusedError, match="cannot advance from"):
            hammer.step(-1e-3)
        hammer.close()


#: Every use of a hammer, by name.
USES: dict[str, Callable[[Hammer, Snapshot], object]] = {
    "read": lambda hammer, _: hammer["rop"],
    "read a switch": lambda hammer, _: hammer["contact_closed"],
    "read a label": lambda hammer, _: hammer.label("rock_mode"),
    "read again": lambda hammer, _: hammer.reader(["rop"])(),
    "read several": lambda hammer, _: hammer.get(["rop", "rock_mode"]),
    "set": lambda hammer, _: hammer.set(feed_force=6e3),
    "set slopes": lambda hammer, _: hammer.set_slopes({"feed_force": 1.0}),
    "step": lambda hammer, _: hammer.step(1e-3),
    "advance": lambda hammer, _: hammer.advance(1.0),
    "save": lambda hammer, _: hammer.save(),
    "restore": lambda hammer, snapshot: hammer.restore(snapshot),
    "reset": lambda hammer, _: hammer.reset(),
}


@pytest.mark.parametrize("use", USES)
def test_every_use_of_a_closed_hammer_is_a_python_error(use: str) -> None:
    with Hammer() as hammer:
        snapshot = hammer.save()
    with pytest.raises(ClosedError, match="closed"):
        USES[use](hammer, snapshot)
    assert "closed" in repr(hammer)


def test_a_hammer_closed_by_another_thread_is_an_error_there() -> None:
    # A thread makes steps until it learns that the hammer is closed.
    hammer, ended = Hammer(), threading.Event()

    def work() -> None:
        with contextlib.suppress(ClosedError):
            while True:
                hammer.step(1e-3)
        ended.set()

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    while hammer.time < 0.02:
        time.sleep(1e-3)
    hammer.close()
    assert ended.wait(60.0)


@pytest.mark.parametrize("copy", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_hammer_has_no_copies_that_could_be_closed_twice(
    copy: Callable[[Hammer], object],
) -> None:
    with Hammer() as hammer, pytest.raises(TypeError, match="save and restore"):
        copy(hammer)


@pytest.mark.parametrize("data", ["text", 3, None, b"abc"])
def test_only_a_snapshot_is_restored(data: object) -> None:
    with Hammer() as hammer, pytest.raises(DomainError, match="is a Snapshot, not"):
        hammer.restore(data)  # type: ignore[arg-type]


def test_a_notebook_shows_where_a_hammer_is() -> None:
    with Hammer() as hammer:
        hammer.advance("60 ms")
        expected = hammer._repr_html_()
        assert "<td>time</td><td>0.06 s</td>" in expected
        assert f"<td>rop</td><td>{hammer['rop']:g} m/s</td>" in expected
        assert "<td>blow_count</td><td>2</td>" in expected
        assert repr(hammer).startswith("<Hammer at 0.06 s, 0 parameters set")
    assert "closed" in hammer._repr_html_()
    assert "&lt;Hammer closed" in hammer._repr_html_()


def test_a_state_goes_on_as_before_again_and_again_also_in_another_hammer() -> None:
    with Hammer() as hammer, Hammer() as other:
        hammer.set(feed_force=7e3)
        hammer.advance(0.06)
        hammer.set({"rock.stiffness": 2e8})
        snapshot = pickle.loads(pickle.dumps(hammer.save()))
        hammer.advance(0.1)
        first = hammer.get(LOOK)
        for each in (other, hammer, hammer):
            each.restore(snapshot)
            assert each.time == 0.06
            each.advance(0.1)
            assert each.get(LOOK) == first


def test_of_an_altered_pickle_nothing_comes_but_the_snapshot_itself() -> None:
    with Hammer() as hammer:
        hammer.advance(0.06)
        honest = hammer.save()
    data, same = pickle.dumps(honest), 0
    for place in range(len(data)):
        altered = bytearray(data)
        altered[place] ^= 1 << place % 8
        try:
            found = pickle.loads(bytes(altered))
        except Exception:
            continue
        # Only bytes that pickle alone reads may change: its memo, the length of a frame.
        same += 1
        assert not isinstance(found, Snapshot) or found.to_bytes() == honest.to_bytes()
    assert same < 20


def test_a_hammer_that_two_threads_use_goes_on_in_turn() -> None:
    with Hammer() as hammer, Hammer() as alone:
        alone.advance(0.2)

        def work() -> None:
            for _ in range(200):
                with contextlib.suppress(RefusedError):
                    hammer.advance(max(hammer.time, 0.2))
                hammer.get(LOOK)

        crew = [threading.Thread(target=work) for _ in range(4)]
        for thread in crew:
            thread.start()
        for thread in crew:
            thread.join()
        assert hammer.get(LOOK) == alone.get(LOOK)


def test_ctrl_c_is_heard_while_a_scene_is_made_and_meets_its_first_blow(ctrl_c: Interrupts) -> None:
    fine = {"piston.elements": 400, "bit.elements": 400, "rock.stiffness": 1.1e8}
    with ctrl_c(0.05):
        for k in range(1000):
            with Hammer(fine | {"piston.length": 0.3 + 1e-3 * k}) as hammer:
                hammer.advance(0.02)


def test_ctrl_c_is_heard_while_derivatives_and_means_are_sought(ctrl_c: Interrupts) -> None:
    with ctrl_c(0.3):
        for _ in range(1000):
            simulate({}, 3.0, gradient=["feed_force", "rock.stiffness"])
    with ctrl_c(0.3):
        for _ in range(1000):
            steady({"feed_force": 0.0}, error=1e-6, blows=10_000_000)


def test_ctrl_c_is_heard_while_other_threads_make_the_runs_of_derivatives(
    ctrl_c: Interrupts,
) -> None:
    # Without the interrupt the runs would take 3 s and more.
    begun, main = threading.Event(), threading.get_ident()

    def control(_: Hammer) -> None:
        if threading.get_ident() != main:
            begun.set()

    with ctrl_c(0.05, begun):
        for _ in range(1000):
            simulate({}, 60.0, step=1.0, control=control, gradient=["feed_force", "rock.stiffness"])


def test_ctrl_c_is_heard_while_the_engine_works(ctrl_c: Interrupts) -> None:
    with Hammer() as hammer:
        with ctrl_c(0.2):
            hammer.advance(1e5)
        # The hammer has stopped at an event, is valid, and can continue.
        assert 0.0 < hammer.time < 1e5
        hammer.step(0.01)


def test_a_signal_s_handler_that_reads_the_hammer_being_stepped_is_told_that_it_is_busy(
    handles: Callable[..., None],
) -> None:
    """It would wait for itself. Another hammer can be used."""
    told: list[str] = []
    with Hammer() as hammer, Hammer() as other:

        def handler(*_: object) -> None:
            other.step(1e-3)
            told.append(f"{other.time:g}")
            try:
                hammer["rop"]
            except RefusedError as error:
                told.append(str(error))

        handles(signal.SIGALRM, handler)
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        hammer.advance(60.0)
        assert told[0] == "0.001"
        assert told[1].startswith("busy: this thread is using the same object")
        # The step was completed.
        assert hammer.time == 60.0


def test_ctrl_c_is_heard_while_a_thread_waits_for_a_hammer_that_another_steps(
    ctrl_c: Interrupts,
) -> None:
    hammer, begun = Hammer(), threading.Event()

    def work() -> None:
        begun.set()
        hammer.advance(100.0)

    thread = threading.Thread(target=work)
    thread.start()
    with ctrl_c(0.2, begun):
        # Ctrl-C may also come before the thread has begun.
        while hammer.time < 100.0:
            pass
    assert thread.is_alive()
    thread.join()
    assert hammer.time == 100.0


FORKS = """
import os, sys, threading, time
from dth_hammer import Hammer, _native
from dth_hammer.errors import DthHammerError

hammer, free = Hammer(), Hammer()
thread = threading.Thread(target=hammer.advance, args=(3000.0,))
thread.start()
time.sleep(0.1)
errors = [1e-6] * len(_native.MEANS)
batch = _native.Batch.steady([[("feed_force", 0.0)]], (errors, 10**6, 10.0, 8, False), 1)
child = os.fork()
if not child:
    free.advance(0.1)
    for use in (lambda: hammer["rop"], lambda: batch.take(1), batch.stop):
        try:
            use()
        except DthHammerError as error:
            print(error, flush=True)
    del batch
    sys.exit(7)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
batch.stop()
# The thread has long to go.
os._exit(0)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks")
def test_a_forked_child_uses_what_was_free_and_is_told_of_what_was_not() -> None:
    command = [sys.executable, "-W", "ignore", "-c", FORKS]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done
    used, taken, stopped = done.stdout.splitlines()
    assert used.startswith("busy: a thread used this object while the process was forked")
    assert taken == stopped
    assert taken.startswith("this batch belongs to the process that began it")


def test_a_state_that_allows_calls_more_work_than_its_reader_is_refused() -> None:
    refused = pytest.raises(RefusedError, match="work_limit = 31, above this hammer's 30")
    with Hammer({"work_limit": 31}) as generous, Hammer() as other, refused:
        other.restore(generous.save())
