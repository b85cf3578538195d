"""What Python costs: the import, and a run of one second beside the engine's own time.

    python evidence/bench/python_face.py

The engine's own time is that of one call of the native module, which reads the same outputs at the
same instants; the least of some repetitions counts.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
from dth_hammer import VARIABLES, _native, simulate

REPEATED = 15


def least(work: Callable[[], object]) -> float:
    """The shortest time, s."""
    times = []
    for _ in range(REPEATED):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return min(times)


def main() -> None:
    """Measures and prints."""
    bare, alone, full = (
        least(lambda text=text: subprocess.run([sys.executable, "-c", text], check=True))
        for text in ("", "import dth_hammer", "import dth_hammer; dth_hammer.simulate")
    )
    names = [v.name for v in VARIABLES.of("output", "local")]
    selection, times = _native.Selection(names), np.linspace(0.0, 1.0, 1001)
    engine = least(lambda: _native.Machine({}).run(times, selection, {}))
    whole = least(lambda: simulate(until=1.0))
    advance = least(lambda: _native.Machine({}).advance(1.0))
    print(f"import dth_hammer: {alone - bare:.3f} s beyond Python's own start")
    print(f"with what simulate imports, numpy: {full - bare:.3f} s")
    print(f"simulate, 1 s, {len(names)} outputs at 1001 instants: {1e3 * whole:.1f} ms")
    print(f"the engine alone, the same outputs: {1e3 * engine:.1f} ms, ratio {whole / engine:.2f}")
    print(f"the engine alone, read at no instant: {1e3 * advance:.1f} ms")


if __name__ == "__main__":
    main()
