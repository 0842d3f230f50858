"""Surface pads on the virtual patient's forearm, and the torque that they evoke at a held wrist."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.registry import Patient, find
from fesloop.forms.schema import make
from fesloop.hand.movements import FREEDOMS, MUSCLES
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import NEVER, Sample

Array = NDArray[np.float64]
_STEADY_NS = 5 * NS_PER_S
"""Time of stimulation after which activation is steady (chosen: 20 time constants of the slowest muscle)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pads:
    """Surface pads, each over one muscle's motor point, as an experimenter places them.

    The recordings state neither size nor place. A pad is over the person's motor point, with an error: an
    experimenter moves a pad until the wanted movement is seen, but does not see the motor point.

    Attributes
    ----------
    radius_mm: of a pad (chosen: a common small round one has a diameter of 25 mm).
    error_mm: standard deviation of a pad's place around the forearm and along it (chosen).
    muscles: muscle under each electrode.
    between: motor points over whose middle an electrode lies instead. That of ECRL lies where the wrist
        extends without much deviation (chosen).
    """

    radius_mm: float = 12.0
    error_mm: float = 6.0
    muscles: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({
        "flexor carpi radialis": "FCR", "palmaris longus": "PL", "flexor carpi ulnaris": "FCU",
        "extensor carpi radialis longus": "ECRL"}))
    between: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({
        "extensor carpi radialis longus": ("ECRL", "ECRB", "EDC2", "EDC3")}))


class Forearm:
    """A patient's forearm with pads: recruitment of its muscles.

    Parameters
    ----------
    patient: who it is.
    pads: their size, place, and error of place.
    rng: source of that error.
    changed: parameters of `electrodes` in place of the patient's.
    """

    def __init__(self, patient: Patient, pads: Pads, rng: np.random.Generator,
                 changed: Mapping[str, Any] | None = None) -> None:
        self.block: Any = _with_pads(patient, pads, rng, changed or {})
        self._state = self.block.init(Context("electrodes"))
        self._tick = Tick()

    def recruitment(self, electrode: int, current_a: float, width_s: float, hertz: float,
                    pronation_rad: float) -> tuple[Array, Array]:
        """Recruitment (29,) and frequency (29,), Hz, by one pulse of one pad."""
        self._tick.time_ns += NS_PER_S  # the last pulse no longer counts
        now = self._tick.time_ns
        pulses = np.zeros((self.block.elements, 3))
        pulses[electrode] = current_a, width_s, hertz
        # Posture, skin and shift follow; the last two have had no message.
        inputs = (Sample(pulses, now, now, now), Sample(pronation_rad, now, now, now),
                  Sample(1.0, NEVER, NEVER, NEVER), Sample(np.zeros(2), NEVER, NEVER, NEVER))
        recruited, frequency = self.block.step(self._state, inputs, self._tick)
        return recruited, frequency


class HeldWrist:
    """A patient's muscles and hand, its wrist held: steady activation and torque, rested and on average.

    Fatigue and variation from trial to trial are left out.
    """

    def __init__(self, patient: Patient) -> None:
        parameters = {**patient.parameters("muscles", {}), "fatigue": None, "variation": {}}
        self.muscles: Any = make(find("muscles"), parameters, {}, "muscles")
        self.hand: Any = make(find("hand"), dict(patient.parameters("hand", {})), {}, "hand")

    def activation(self, recruited: Array, frequency: Array) -> Array:
        """Activation (29,) at which steady stimulation settles."""
        state, still = self.muscles.init(Context("muscles")), np.zeros(len(MUSCLES))
        inputs = (recruited, frequency, still, still)
        self.muscles.advance(state, inputs, 0, _STEADY_NS)
        return np.asarray(self.muscles.read(state, inputs)[0])

    def torque_nm(self, activation: Array, flexion_rad: float, radial_rad: float) -> Array:
        """Change (2,) of the muscles' moments of flexion and radial deviation at a held wrist."""
        wrist = [FREEDOMS.index("wrist_flexion"), FREEDOMS.index("wrist_abduction")]
        angles = np.array(self.hand.outputs[0].initial_value())
        angles[wrist] = flexion_rad, -radial_rad
        change = (self.hand.held_moments(angles, activation)
                  - self.hand.held_moments(angles, np.zeros(len(MUSCLES))))
        return np.asarray(change[wrist] * (1.0, -1.0))


def _with_pads(patient: Patient, pads: Pads, rng: np.random.Generator, changed: Mapping[str, Any]) -> Any:
    """Block `electrodes` of a patient with one pad for each of the muscles."""
    own = dict(patient.parameters("electrodes", {}))
    points = {each["muscle"]: (each["around_deg"], each["along_mm"]) for each in own["motor_points"]}
    errors = pads.error_mm * rng.normal(size=(len(pads.muscles), 2))
    positions = []
    for (electrode, name), (around, along) in zip(pads.muscles.items(), errors, strict=True):
        deg, mm = np.mean([points[each] for each in pads.between.get(electrode, (name,))], axis=0)
        positions.append([float(deg + np.degrees(around / own["radius_mm"])),
                          float(np.clip(mm + along, 0.0, own["length_mm"]))])
    arrays = [{"positions": positions, "pad_mm": pads.radius_mm}]
    own = dict(patient.parameters("electrodes", {"arrays": arrays}))
    return make(find("electrodes"), {**own, "arrays": arrays, "shift_mm": 0.0, "shift_deg": 0.0, **changed},
                {}, "electrodes")
