"""The workers that simulate a sweep: threads of the engine, or a user's executor."""

import pickle
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, wait

from .. import _native
from ..errors import DthHammerError, LostWorkerError
from ..extras import need
from .cases import Job, Row
from .longrun import Wanted, cores

#: Longest time between two reports of finished runs, s.
REPORT_INTERVAL = 0.5
#: Largest number of runs in one task of an executor.
TASK = 25


def parts_of(
    runs: Sequence[Job], scheduler: Executor | None, workers: int | None
) -> Generator[list[Row], None, None]:
    """Yields the rows of the runs, a few at a time, as they are completed."""
    if scheduler is not None:
        size = max(1, min(TASK, len(runs) // 40))
        yield from _by_executor(scheduler, [runs[i : i + size] for i in range(0, len(runs), size)])
        return
    yield from _by_engine([run for run in runs if not run.case.needs_python], workers or cores())
    # Runs with Python code hold the interpreter's lock, so threads would not make them faster.
    yield from ([run.played()] for run in runs if run.case.needs_python)


def _by_engine(runs: Sequence[Job], count: int) -> Iterator[list[Row]]:
    """Simulates runs on the engine's threads, which do not hold Python's lock while they work."""
    if not runs:
        return
    until, scenes = runs[0].until, [[*run.numbers.items()] for run in runs]
    if isinstance(until, Wanted):
        native = _native.Batch.steady(scenes, until.engine_arguments, count)
    else:
        native = _native.Batch(scenes, until, _native.Selection([*runs[0].names]), count)
    try:
        while (ready := native.take(len(runs), REPORT_INTERVAL)) is not None:
            if ready:
                yield [runs[k].row(values, why, notes) for k, values, why, notes in ready]
    except KeyboardInterrupt:
        if ready := native.stop():
            yield [runs[k].row(values, why, notes) for k, values, why, notes in ready]
        raise
    finally:
        native.stop()


def _by_executor(executor: Executor, tasks: Sequence[Sequence[Job]]) -> Iterator[list[Row]]:
    dumps = need("cloudpickle").dumps
    pending = {executor.submit(_rows, dumps(task)) for task in tasks}
    try:
        while pending:
            # On some systems Ctrl-C takes effect only between two waits, so each wait is short.
            done, pending = wait(pending, REPORT_INTERVAL, FIRST_COMPLETED)
            for future in done:
                yield future.result()
    except DthHammerError:
        raise
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".rstrip(": ")
        raise LostWorkerError(f"a worker ended (killed, or out of memory: {reason})") from error
    finally:
        for future in pending:
            future.cancel()


def _rows(task: bytes) -> list[Row]:
    return [row for part in parts_of(pickle.loads(task), None, 1) for row in part]
