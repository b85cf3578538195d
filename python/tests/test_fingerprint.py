"""A digest tells code from edited code, and is the same in every process."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from dth_hammer.fingerprint import digest

MODULES = {
    "limits.py": "FEEDS = {'soft', 'hard', 'harder', 'hardest'}\nLEAST = 3e3\nOTHER = 1.0\n",
    "rules.py": (
        "import limits\n\n\n"
        "def least(x):\n    return max(x, limits.LEAST) if limits.FEEDS else even(x)\n\n\n"
        "def even(x):\n    return odd(x - 1) if x else True\n\n\n"
        "def odd(x):\n    return even(x - 1) if x else False\n\n\n"
        "class Base:\n    gain = 2.0\n\n    @staticmethod\n"
        "    def pull(x):\n        return least(x)\n"
    ),
    "controllers.py": (
        "import functools\nfrom dataclasses import dataclass\n\n"
        "import numpy as np\n\nimport rules\n\n"
        "SCALE = np.array([1.0, 2.0])\n\n\n"
        "def plain(hammer):\n    hammer.set(feed_force=SCALE[1] * rules.least(4e3))\n\n\n"
        "@dataclass\nclass Held(rules.Base):\n    feed: float = 5e3\n\n"
        "    def __call__(self, hammer):\n        hammer.set(feed_force=self.pull(self.feed))\n\n\n"
        "@functools.cache\ndef late(hammer):\n    import limits\n\n    return limits.LEAST\n\n\n"
        "def made(by):\n    return lambda hammer: hammer.set(feed_force=by * rules.even(2))\n\n\n"
        "def scaled(by, hammer):\n    return by\n\n\n"
        "CASES = {'plain': plain, 'held': Held(), 'late': late, 'made': made(3.0),\n"
        "         'partial': functools.partial(scaled, 2.0), 'method': Held().pull}\n"
    ),
}
#: An edit, and whose digests change by it.
EDITS = [
    ("limits.py", "LEAST = 3e3", "LEAST = 4e3", "plain held late method"),
    ("limits.py", "'hardest'", "'softest'", "plain held method"),
    ("limits.py", "OTHER = 1.0", "OTHER = 2.0", ""),
    ("rules.py", "max(x,", "min(x,", "plain held method"),
    (
        "rules.py",
        "return odd(x - 1) if x else True",
        "return odd(x - 1) if x else 1",
        "made plain held method",
    ),
    ("rules.py", "gain = 2.0", "gain = 3.0", "held"),
    ("controllers.py", "[1.0, 2.0]", "[1.0, 3.0]", "plain"),
    ("controllers.py", "made(3.0)", "made(4.0)", "made"),
    (
        "controllers.py",
        "functools.partial(scaled, 2.0)",
        "functools.partial(scaled, 3.0)",
        "partial",
    ),
    ("controllers.py", "feed: float = 5e3", "feed: float = 6e3", "held"),
    ("controllers.py", "import rules\n", "import rules  # as ever\n", ""),
]


def digests(folder: Path, seed: int) -> dict[str, str]:
    """Of all cases, in a new process whose sets are in an order of their own."""
    code = (
        "from controllers import CASES; from dth_hammer.fingerprint import digest; "
        "print({name: digest(case) for name, case in CASES.items()})"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=os.environ | {"PYTHONHASHSEED": str(seed), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    return dict(eval(done.stdout))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("controllers")
    for name, text in MODULES.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def before(folder: Path) -> dict[str, str]:
    return digests(folder, 1)


def test_unchanged_code_has_the_same_digest_in_another_process(
    folder: Path, before: dict[str, str]
) -> None:
    found = digests(folder, 2)
    assert found == before
    assert len({*found.values()}) == len(found)


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_changes_what_refers_to_it_and_nothing_else(
    folder: Path, before: dict[str, str], edit: tuple[str, str, str, str]
) -> None:
    name, old, new, changed = edit
    file = folder / name
    text = file.read_text(encoding="utf-8")
    assert text.count(old) == 1
    file.write_text(text.replace(old, new), encoding="utf-8")
    try:
        after = digests(folder, 3)
    finally:
        file.write_text(text, encoding="utf-8")
    assert {case for case in before if after[case] != before[case]} == {*changed.split()}


def test_what_is_installed_counts_by_name_and_version(monkeypatch: pytest.MonkeyPatch) -> None:
    def uses(x: object) -> object:
        return pytest.approx(x)

    before = digest(uses)
    monkeypatch.setattr(pytest, "__version__", "0")
    assert digest(uses) != before


def test_what_cannot_be_copied_has_no_digest() -> None:
    lock = threading.Lock()
    with pytest.raises(TypeError, match="lock"):
        digest(lambda: lock)


def test_data_that_holds_itself_has_one() -> None:
    one: list[object] = [1.0]
    one.append(one)
    two: list[object] = [1.0]
    two.append(two)
    assert digest(one) == digest(two) != digest([1.0, [1.0]])
