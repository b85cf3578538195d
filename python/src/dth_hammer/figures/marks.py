"""Colours, abbreviations and label positions that several figures share."""

import itertools

# Colours that remain distinct in print and to colour-blind readers (Okabe and Ito).
PISTON, BIT, ROCK, DARK = "#d55e00", "#0072b2", "#8c6d31", "#444444"
COLOURS = {
    "FreeFlight": "#999999",
    "DissipativeForward": "#d55e00",
    "Forward": "#e69f00",
    "Backward": "#56b4e9",
    "Standstill": "#009e73",
}
#: Abbreviations of the rock law's modes as in the paper, from the free bit to the bit at rest.
MODES = dict(zip(COLOURS, ("FF", "DFC", "FC", "BC", "SS"), strict=True))
PRESSURES = {
    "drive_chamber_pressure": ("drive chamber", PISTON),
    "return_chamber_pressure": ("return chamber", BIT),
}


def apart(wanted: list[float], room: float, top: float) -> list[float]:
    """Returns positions close to those wanted, at least ``room`` apart and none above ``top``."""
    from_below = sorted(range(len(wanted)), key=wanted.__getitem__)
    places = list(wanted)
    for below, above in itertools.pairwise(from_below):
        places[above] = max(places[above], places[below] + room)
    ceiling = top
    for index in reversed(from_below):
        places[index] = min(places[index], ceiling)
        ceiling = places[index] - room
    return places
