"""A feed controller, as it might come from another project: knows nothing of the FMU."""

from __future__ import annotations


class FeedController:
    """Holds the bit on the rock: more feed after a high rebound, less after none."""

    def __init__(self, start: float, lowest: float, highest: float, gain: float) -> None:
        self.feed, self.lowest, self.highest, self.gain = start, lowest, highest, gain

    def after_blow(self, lift: float, wanted: float) -> float:
        """Feed force for the next blow, from how high the bit has lifted, in metres."""
        self.feed += self.gain * (lift - wanted)
        self.feed = min(self.highest, max(self.lowest, self.feed))
        return self.feed
