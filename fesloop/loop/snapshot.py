"""What a loop at rest is saved as."""

from __future__ import annotations


class Snapshot:
    """A loop at rest at one instant, as bytes.

    Attributes
    ----------
    time_ns, trial: where it stands.
    wiring: what it is of, as text: seed, nodes, wires.
    """

    __slots__ = ("content", "time_ns", "trial", "wiring")

    def __init__(self, content: bytes, time_ns: int, trial: int, wiring: str) -> None:
        self.content, self.time_ns, self.trial, self.wiring = content, time_ns, trial, wiring
