"""A lag for pythonfmu: y' = (u - y) / 0.1 s."""

import math

from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class LagPython2(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u = 0.0
        self.y = 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.y += (self.u - self.y) * (1.0 - math.exp(-step_size / 0.1))
        return True
