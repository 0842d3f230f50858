"""Learning laws: the drives of the next trial from those of the last and the error that they left.

With drives v and errors e = r - y stacked over a trial, y = G v + y_0, weights W (0 where a trial was not
observed) and limits 0 <= v <= reach, |v_k - v_{k-1}| <= slew:

    phase_lead          v+ = Q (v + gain K^+ e shifted forward by the lead), then clipped
    noilc               v+ = v + (G'WG + rho I)^-1 G'W e, then clipped
    noilc_constrained   v+ = argmin |e - G (v+ - v)|^2_W + rho |v+ - v|^2 inside the limits

K is the static gain and Q a zero-phase low-pass. Sources: Bristow, Tharayil and Alleyne 2006
(doi 10.1109/MCS.2006.1636313) for the first, Amann, Owens and Rogers 1996 (doi 10.1049/ip-cta:19960244) for
the second; the third is the second with the limits inside its minimisation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from controllers.qp import Qp
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
LawName = Literal["phase_lead", "noilc", "noilc_constrained"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Learning:
    """A learning law over trials of one length.

    Attributes
    ----------
    law: by name.
    model: sampled at the controller's period.
    samples: ticks of a trial.
    reach: (muscles,), greatest drive.
    slew: greatest change of a drive a tick.
    output_weight: (outputs,).
    change_weight: rho.
    gain, lead: of "phase_lead"; lead in ticks.
    cutoff: of its low-pass Q, as a share of the Nyquist frequency, below 1; 0 for none.
    solver: of "noilc_constrained".
    """

    law: LawName
    model: SampledModel
    samples: int
    reach: Array
    slew: float
    output_weight: Array
    change_weight: float
    gain: float
    lead: int
    cutoff: float
    solver: Literal["daqp", "osqp"]

    def learn(self, drives: Array, errors: Array, covered: Mask) -> tuple[Array, str]:
        """(drives of the next trial, status): (samples, muscles), and "" or why nothing was learnt.

        Parameters
        ----------
        drives: (samples, muscles), of the trial.
        errors: (samples, outputs), reference less posture, rad.
        covered: (samples,), where the trial was observed; elsewhere errors count for nothing.
        """
        if not covered.any():
            return drives, "unobserved"
        if self.law == "noilc_constrained":
            return self._constrained(drives, errors, covered)
        step = self.learning_operator(covered) @ np.where(covered[:, None], errors, 0.0).ravel()
        return self.within_limits(self.smoothed(drives + step.reshape(drives.shape))), ""

    def learning_operator(self, covered: Mask) -> Array:
        """L of v + L e, (samples muscles, samples outputs)."""
        if self.law == "phase_lead":
            model = self.model
            steady = model.c @ np.linalg.solve(np.eye(model.a.shape[0]) - model.a, model.b)
            shift = np.zeros((self.samples, self.samples))
            ahead = np.minimum(np.arange(self.samples) + self.lead, np.flatnonzero(covered)[-1])
            shift[np.arange(self.samples), ahead] = 1.0
            shift[np.flatnonzero(covered)[-1] + 1:] = 0.0
            shifted = self.gain * np.kron(shift, np.linalg.pinv(steady))
            return np.asarray(shifted, dtype=np.float64)
        lifted = self.model.lifted(self.samples)
        weighted = lifted.T * self._weights(covered)
        curvature = weighted @ lifted + self.change_weight * np.eye(lifted.shape[1])
        operator = np.linalg.solve(curvature, weighted)
        return np.asarray(operator, dtype=np.float64)

    def within_limits(self, drives: Array) -> Array:
        """Drives clipped into their box and then, tick by tick, into the slew limit."""
        limited = np.clip(drives, 0.0, self.reach)
        before = np.zeros(drives.shape[1])
        for k in range(self.samples):
            before = limited[k] = np.clip(limited[k], before - self.slew, before + self.slew)
        return limited

    def convergence_factor(self, plant: SampledModel | None = None, share: float = 0.01) -> float:
        """Largest factor by which a trial's error in the drives may grow: below 1 it shrinks every trial.

        The 2-norm of Q (I - L G_plant) (Bristow et al. 2006, theorem 2) on the drives that the nominal
        model can see: right singular vectors of G with a singular value of at least `share` of the
        greatest. Without limits; `plant` is what is controlled, the nominal model if not given.
        """
        nominal = self.model.lifted(self.samples)
        actual = nominal if plant is None else plant.lifted(self.samples)
        _, strength, seen = np.linalg.svd(nominal, full_matrices=False)
        seen = seen[strength >= share * strength[0]].T
        left = seen - self.learning_operator(np.ones(self.samples, dtype=bool)) @ (actual @ seen)
        shape = (self.samples, -1, seen.shape[1])
        return float(np.linalg.norm(seen.T @ self.smoothed(left.reshape(shape)).reshape(left.shape), 2))

    def smoothed(self, drives: Array) -> Array:
        """Q along the first axis."""
        if self.law != "phase_lead" or self.cutoff == 0.0:
            return drives
        sections = butter(2, self.cutoff, output="sos")
        smooth: Array = sosfiltfilt(sections, drives, axis=0, padlen=min(15, self.samples - 1))
        return smooth

    def _weights(self, covered: Mask) -> Array:
        """(samples outputs,)."""
        return np.outer(covered, self.output_weight).ravel()

    def _constrained(self, drives: Array, errors: Array, covered: Mask) -> tuple[Array, str]:
        size, muscles = drives.size, drives.shape[1]
        lifted = self.model.lifted(self.samples)
        weighted = lifted.T * self._weights(covered)
        previous = drives.ravel()
        hessian = weighted @ lifted + self.change_weight * np.eye(size)
        linear = -weighted @ (np.where(covered[:, None], errors, 0.0).ravel() + lifted @ previous)
        linear -= self.change_weight * previous
        scale = 1.0 / np.mean(np.diag(hessian))
        programme = Qp(scale * 0.5 * (hessian + hessian.T), np.eye(size) - np.eye(size, k=-muscles),
                       solver=self.solver, tolerance=1e-5, max_iterations=20000)
        programme.start_from(previous)
        slew = np.full(size, self.slew)
        result = programme.solve(scale * linear, np.concatenate([np.zeros(size), -slew]),
                                 np.concatenate([np.tile(self.reach, self.samples), slew]))
        if not result.solved:
            return drives, result.status
        return self.within_limits(result.x.reshape(drives.shape)), ""
