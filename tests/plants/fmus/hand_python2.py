"""A hand for pythonfmu as others might write one: two channels in mA and us, five joints in degrees.

Each joint goes to its own posture with a time constant of 0.15 s: `RESTING` + drive `BENDING`; drive is how
much more the flexor is stimulated than the extensor, in charge over 5 uC, from -1 to 1.
"""

import math

from pythonfmu import Fmi2Causality, Fmi2Slave, Real

JOINTS = ("thumb.ip", "index.mcp", "index.pip", "middle.mcp", "middle.pip")
RESTING = (15.0, 25.0, 25.0, 25.0, 25.0)
BENDING = (10.0, 30.0, 45.0, 30.0, 45.0)


class HandPython2(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for channel in ("extensor", "flexor"):
            for quantity in ("current_ma", "width_us"):
                self._register(f"{channel}.{quantity}", 0.0, Fmi2Causality.input)
        for joint, angle in zip(JOINTS, RESTING, strict=True):
            self._register(f"{joint}.angle_deg", angle, Fmi2Causality.output)

    def _register(self, name, value, causality):
        attribute = name.replace(".", "_")
        setattr(self, attribute, value)
        self.register_variable(Real(name, causality=causality, getter=lambda: getattr(self, attribute),
                                    setter=lambda given: setattr(self, attribute, given)))

    def do_step(self, current_time, step_size):
        charge_uc = (self.flexor_current_ma * self.flexor_width_us
                     - self.extensor_current_ma * self.extensor_width_us) / 1e3
        drive = max(-1.0, min(1.0, charge_uc / 5.0))
        share = 1.0 - math.exp(-step_size / 0.15)
        for joint, resting, bending in zip(JOINTS, RESTING, BENDING, strict=True):
            attribute = f"{joint}.angle_deg".replace(".", "_")
            angle = getattr(self, attribute)
            setattr(self, attribute, angle + share * (resting + drive * bending - angle))
        return True
