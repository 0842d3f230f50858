"""What a loop at rest is saved as."""

from __future__ import annotations

from collections.abc import Mapping


class Snapshot:
    """A loop at rest at one instant, as bytes.

    Attributes
    ----------
    time_ns, trial: where it stands.
    wiring: what it is of, as text: seed, nodes, wires.
    parameters: digests of each node's parameters, by their names.
    """

    __slots__ = ("content", "parameters", "time_ns", "trial", "wiring")

    def __init__(self, content: bytes, time_ns: int, trial: int, wiring: str,
                 parameters: Mapping[str, Mapping[str, str]]) -> None:
        self.content, self.time_ns, self.trial, self.wiring = content, time_ns, trial, wiring
        self.parameters = parameters
