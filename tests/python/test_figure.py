"""The figure from a made-up result, which needs no FMU."""

from __future__ import annotations

import numpy as np
from figure import MODES, ROWS, Record
from matplotlib.figure import Figure


def made_up() -> Record:
    time = np.linspace(-2e-3, 47e-3, 2000)
    names = list(MODES)
    mode = [names[i * len(names) // len(time)] for i in range(len(time))]
    closed = (time > 0) & (time < 65e-6)
    return Record(
        time, 0.0 * time, np.sin(time), 0.1 * time, np.cos(time), 0.1 + time, mode, closed
    )


def test_every_mode_and_status_has_its_own_labelled_lane() -> None:
    axes = Figure().subplots()
    *_, (_, _, statuses) = ROWS
    statuses(axes, made_up())
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels == ["open", "closed", "FF", "DFC", "FC", "BC", "SS"]
    law, _, contact = axes.get_lines()
    assert len(set(law.get_ydata())) == len(MODES)
    assert set(contact.get_ydata()).isdisjoint(law.get_ydata())
