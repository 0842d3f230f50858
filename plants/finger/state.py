"""What a finger remembers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class FingerState:
    """Where the finger is. Everything here changes at instants of the finger's own, whoever looks.

    Attributes
    ----------
    z: (18,), the states x (14,) of `FingerEquations`, then the drive (4,): fitness times the recruited
        fraction that acts now.
    recruited: (4,), recruited fraction that acts now.
    arriving: recruited fractions still under way through the delay, each with its instant in ns.
    stimulation: (4, 2), the newest input.
    fitness: (4,).
    fitness_ns: instant that `fitness` is of.
    """

    __slots__ = ("arriving", "fitness", "fitness_ns", "recruited", "stimulation", "z")

    def __init__(self, fitness: Array) -> None:
        self.z = np.zeros(18)
        self.recruited = np.zeros(4)
        self.arriving: list[tuple[int, Array]] = []
        self.stimulation: Array = np.zeros((4, 2))
        self.fitness = fitness
        self.fitness_ns = 0

    def copy(self) -> FingerState:
        """A state that can go ahead on its own."""
        ahead = FingerState.__new__(FingerState)
        ahead.z, ahead.fitness = self.z.copy(), self.fitness
        ahead.recruited, ahead.stimulation = self.recruited, self.stimulation
        ahead.arriving, ahead.fitness_ns = self.arriving.copy(), self.fitness_ns
        return ahead
