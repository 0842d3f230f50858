"""Tendons that yield: the length of every muscle's fibres follows from equilibrium of forces with its tendon.

    T(e - l) = a k f_l(l) f_v(l' / v) + P(l) + d l' / v

in units of the healthy muscle's greatest isometric force F and of its optimal fibre length: l length of the
fibres, e that of the whole muscle less its tendon's slack length, a activation, k strength, v the fastest
shortening. f_l, f_v and P are the curves that the muscles have with stiff tendons (MuJoCo's, see
`plants.hand.model`). Tendon force T is that of MoBL-ARMS (`TENDON_MM`): quadratic up to `TOE`, then straight.

Fibres are advanced by Rosenbrock's L-stable method of second order (Verwer 1999, doi
10.1137/S1064827597326651), or by Alexander's (1977, doi 10.1137/0714068) where forces change fast, with f_v
inverted in closed form. The forces F T act as R' F T on the joints from the start to the end of a step. Each
tendon moves a mass of `INERTIA` times its stiffness times the squared step, so that any tendon is stable
(Newmark's method of constant acceleration in an explicit form); it falls with the square of the step.

Numbers of the muscles are user data of the model's tendons, so that a model has all of its parameters; fibres
are user data of MuJoCo's data, so that their copies and pickles have them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.hand.movements import MUSCLES
from plants.hand.model import ECCENTRIC, FASTEST, LONGEST, RESTING_LENGTH, SHORTEST, Muscle

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
TENDON_MM = {
    "ECRL": 244.0, "ECRB": 222.3, "EDC2": 365.0, "EDC3": 365.0, "EDC4": 365.0, "EDC5": 335.0, "EDM": 335.0,
    "ECU": 228.5, "EIP": 210.0, "EPL": 230.5, "EPB": 115.5, "APL": 129.5, "FCR": 244.0, "PL": 269.4,
    "FCU": 265.0, "FDS2": 275.0, "FDS3": 295.0, "FDS4": 328.0, "FDS5": 338.6, "FDP2": 301.5, "FDP3": 303.0,
    "FDP4": 291.5, "FDP5": 281.9, "FPL": 197.0, "INT2": 50.0, "INT3": 50.0, "INT4": 50.0, "INT5": 50.0,
    "THENAR": 25.0}
"""Slack lengths in the adult hand: MoBL-ARMS 4.1 (Saul 2015, doi 10.1080/10255842.2014.916698). INT and
THENAR, which it does not have, are chosen: about as long as their fibres, and half as long."""
STRAIN = 0.033
"""Strain of all tendons under the muscle's greatest isometric force in MoBL-ARMS 4.1."""
TOE = 0.2255
"""Tendon force, relative to the greatest isometric one, at which its curve becomes straight (MoBL-ARMS 4.1,
from Millard 2013, doi 10.1115/1.4023390). With a quadratic toe the straight part has a slope of 1 + `TOE`
over the strain at the greatest force: 37.1 at .033, where MoBL-ARMS has 37.4."""
_STEEP, _TOE_END = 1.0 + TOE, 2.0 * TOE / (1.0 + TOE)
DAMPING = 0.001
"""Force of the fibres' damping at the fastest shortening, over the greatest isometric one. It makes the
fibres' rate unique at any activation (Millard 2013). Chosen: his .1, and even .01, is no less than the force
of fast muscles that are active by a few percent, and slows them."""
INERTIA = 0.25
"""Mass that each tendon moves, over its greatest stiffness times the squared step: the least that keeps an
undamped oscillation stable at any stiffness. At 1 ms it is .5 to 6.5 g, for INT 9 to 14 and THENAR 37 g."""
_FORCE, _STRENGTH, _FIBRE, _YIELDS, _EXCESS, _PASSIVE, _COLUMNS = range(7)
"""Columns of the table of muscles: greatest force of the healthy muscle, N; factor on it; optimal length of
fibres, m; stretch of the tendon at the greatest force, m; length beyond the slack tendon at joint angles of
0, m; factor of the passive force, over the greatest one, on the squared stretch (`passive`)."""
TRUSTED = 0.002
"""Difference of the tendon's relative stretch by the method of second order and by its part of first order
up to which the former is taken (chosen: with it, errors are those of the other method everywhere)."""
_HELD_S, _NEAR, _MOST_HELD = 0.01, 1e-12, 100_000
"""Step, s, to equilibrium at a held posture, relative length by which fibres move no more, and most steps."""
_NARROW, _MOST = 1e-13, 100
"""Tolerance of a stage's relative length, and most iterations."""
_GAMMA = 1.0 - 1.0 / math.sqrt(2.0)
_BOUND = ECCENTRIC - 1.0
"""Rate of lengthening, relative to the fastest shortening, beyond which force no longer grows (MuJoCo)."""
_KNEE = 0.5 * (LONGEST - 1.0)


class Tendons(NamedTuple):
    """Coefficients of a model's tendons in the form that the kernels take.

    Attributes
    ----------
    table: (29, columns), a row for each muscle.
    arms: (29, most), lengthening per angle of the crossed joints, m/rad. joints: (29, most), their indices in
        positions and speeds; -1: none.
    step_s: step of the solver.
    """

    table: Array
    arms: Array
    joints: Numbers
    step_s: float

    @classmethod
    def of(cls, model: mujoco.MjModel) -> Tendons | None:
        """Tendons of a model, None if they are stiff."""
        if not model.nuser_tendon:
            return None
        rows = [model.tendon(name).id for name in MUSCLES]
        shape = len(rows), int(model.tendon_num[rows].max())
        arms, joints = np.zeros(shape), np.full(shape, -1)
        for i, row in enumerate(rows):
            start, count = model.tendon_adr[row], model.tendon_num[row]
            arms[i, :count] = model.wrap_prm[start:start + count]
            # Hinges come before any free joint, so that an index is that of the position and of the speed.
            joints[i, :count] = model.jnt_dofadr[model.wrap_objid[start:start + count]]
        return cls(np.ascontiguousarray(model.tendon_user[rows]), arms, joints, float(model.opt.timestep))

    def rest(self, data: mujoco.MjData) -> None:
        """Set fibres to equilibrium without activation, at the posture in the data."""
        rest(data.qpos, data.userdata, self.table, self.arms, self.joints)

    def pull(self, data: mujoco.MjData, activation: Array) -> None:
        """Do before each of MuJoCo's steps: `pull` under an activation (29,)."""
        activated(data.userdata)[:] = activation
        pull(data.qpos, data.qvel, data.userdata, data.qfrc_applied, *self)


    def held(self, positions: Array, activation: Array) -> Array:
        """Forces (v,), N m, of muscles in equilibrium at a posture (q,) that is held, from rest."""
        memory, forces = np.zeros(3 * len(self.table)), np.zeros(len(positions))
        rest(positions, memory, self.table, self.arms, self.joints)
        activated(memory)[:] = activation
        still, count = np.zeros_like(positions), len(self.table)
        for _ in range(_MOST_HELD):
            before = memory[:count].copy()
            pull(positions, still, memory, forces, *self[:3], _HELD_S)
            if np.abs(memory[:count] - before).max() < _NEAR:
                break
        return forces


def fibres(memory: Array) -> Array:
    """Relative lengths of the fibres (29,) in the user data of MuJoCo's data."""
    return memory[:len(MUSCLES)]


def fibre_rates(memory: Array) -> Array:
    """Mean rates of the fibres (29,), optimal lengths per second, over the last step."""
    return memory[len(MUSCLES):2 * len(MUSCLES)]


def activated(memory: Array) -> Array:
    """Activation (29,) under which fibres go on, clipped to 0 to 1 there."""
    return memory[2 * len(MUSCLES):]


def add_tendons(spec: mujoco.MjSpec, muscles: tuple[Muscle, ...], strength: Array, tension: float,
                resting_lengths: Array, strain: float, scale: float) -> None:
    """Give each muscle's tendon the numbers of `Tendons`, in place of MuJoCo's muscles.

    Parameters are those of `plants.hand.model.add_muscles`; `strain` under the greatest force of the healthy
    muscle, and `scale` of the hand. In the resting hand, fibres are as long as with stiff tendons.
    """
    spec.nuserdata, spec.nuser_tendon = 3 * len(MUSCLES), _COLUMNS
    stretch = RESTING_LENGTH - 1.0
    for name, muscle, factor, rest_m in zip(MUSCLES, muscles, strength, resting_lengths, strict=True):
        fibre, yields = 1e-3 * muscle.fibre_mm, 1e-3 * scale * strain * TENDON_MM[name]
        passive = tension * muscle.passive_n_m * fibre / (2.0 * stretch * muscle.force_n)
        at_rest = fibre * RESTING_LENGTH + yields * stretched(passive * stretch**2)
        spring = spec.tendon(name)
        spring.userdata = [muscle.force_n, factor, fibre, yields, at_rest - rest_m, passive]
        spring.armature = INERTIA * spec.option.timestep**2 * muscle.force_n * _STEEP / yields


@compiled
def tendon(stretch: float) -> tuple[float, float]:
    """Relative force of a tendon, and its slope; `stretch` relative to that at the greatest force."""
    if stretch <= 0.0:
        return 0.0, 0.0
    if stretch < _TOE_END:
        return TOE * (stretch / _TOE_END) ** 2, _STEEP * stretch / _TOE_END
    return TOE + _STEEP * (stretch - _TOE_END), _STEEP


def stretched(force: float) -> float:
    """Relative stretch at which a tendon bears a relative force."""
    return _TOE_END * math.sqrt(force / TOE) if force < TOE else _TOE_END + (force - TOE) / _STEEP


@compiled
def bell(length: float) -> tuple[float, float]:
    """Active force at a relative length, and its slope: MuJoCo's parabolas."""
    if length <= SHORTEST or length >= LONGEST:
        return 0.0, 0.0
    if length <= 0.5:
        return 2.0 * length * length, 4.0 * length
    if length <= 1.5:
        return 1.0 - 2.0 * (1.0 - length) ** 2, 4.0 * (1.0 - length)
    return 2.0 * (2.0 - length) ** 2, -4.0 * (2.0 - length)


@compiled
def passive(length: float, share: float) -> tuple[float, float]:
    """Passive force, and its slope: `share` times squared stretch, straight from a stretch of .5 on."""
    stretch = length - 1.0
    if stretch <= 0.0:
        return 0.0, 0.0
    if stretch <= _KNEE:
        return share * stretch * stretch, 2.0 * share * stretch
    return share * _KNEE * (2.0 * stretch - _KNEE), 2.0 * share * _KNEE


@compiled
def rate(length: float, force: float, active: float, share: float) -> tuple[float, float, float]:
    """Rate of the fibres, 1/s, under a tendon's relative force, and its slopes over length and force.

    `active`: activation times strength. The equation of the module's docstring, solved for l': f_v is a
    parabola in shortening, another one in lengthening, and constant beyond.
    """
    height, slope = bell(length)
    held, held_slope = passive(length, share)
    most, borne = active * height, force - held
    across = 2.0 * most + DAMPING
    over = borne - most
    if most <= 0.0 or borne <= -DAMPING:  # no active force
        speed, gain, part = borne / DAMPING, DAMPING, 0.0
    elif over <= 0.0:
        speed = 2.0 * over / (across + math.sqrt(across * across + 4.0 * most * over))
        gain, part = 2.0 * most * (speed + 1.0) + DAMPING, (speed + 1.0) ** 2
    elif over <= most * _BOUND + DAMPING * _BOUND:
        inner = across * across - 4.0 * most * over / _BOUND
        speed = 2.0 * over / (across + math.sqrt(max(0.0, inner)))
        gain = 2.0 * most * (1.0 - speed / _BOUND) + DAMPING
        part = 1.0 + _BOUND - (_BOUND - speed) ** 2 / _BOUND
    else:
        speed, gain, part = (borne - most * ECCENTRIC) / DAMPING, DAMPING, ECCENTRIC
    scaled = FASTEST / gain
    return FASTEST * speed, -scaled * (part * active * slope + held_slope), scaled


@compiled
def advance(length: float, before: float, after: float, active: float, share: float, fibre: float,
            yields: float, step: float) -> float:
    """Relative length of the fibres `step` s later.

    The whole muscle beyond the slack tendon goes from `before` to `after`, m, at constant speed. Where the
    method's own estimate of its error is above `TRUSTED`, as where a slack tendon becomes taut, `solved`
    stages take its place. At a step of 1 ms the force of 95 % of random courses is within 2 % of the greatest
    one of the exact solution, .4 % root mean square over 40 ms (all: 10 and 2 %, medians: .07 and .02 %);
    activation jumps, and the whole muscle moves at up to half the fastest shortening
    (tests/plants/hand/test_tendons.py).
    """
    steep = fibre / yields
    force, stiff = tendon((before - fibre * length) / yields)
    speed, over_length, over_force = rate(length, force, active, share)
    drift = _GAMMA * over_force * stiff / yields * (after - before)
    factor = 1.0 / (1.0 - _GAMMA * step * (over_length - over_force * stiff * steep))
    one = (speed + drift) * factor
    middle = length + step * one
    force, _ = tendon((after - fibre * middle) / yields)
    speed, _, _ = rate(middle, force, active, share)
    two = (speed - 2.0 * one - drift) * factor
    end = middle + 0.5 * step * (one + two)
    if abs(end - middle) * steep <= TRUSTED:
        return end
    part = _GAMMA * step
    first = solved(length, before + _GAMMA * (after - before), active, share, fibre, yields, part)
    start = length + (1.0 - _GAMMA) / _GAMMA * (first - length)
    return solved(start, after, active, share, fibre, yields, part)


@compiled
def solved(base: float, whole: float, active: float, share: float, fibre: float, yields: float,
           part: float) -> float:
    """Length that is `base` plus `part`, s, times its own rate: a stage of Alexander's method.

    Newton's method, which halves its bracket where it would leave it or converge slowly; the excess of the
    length grows with the length.
    """
    low = base - part * FASTEST * max(1.0, passive(base, share)[0] / DAMPING)
    high = max(base, whole / fibre)
    length, moved = min(max(base, low), high), 2.0 * (high - low)
    for _ in range(_MOST):
        force, stiff = tendon((whole - fibre * length) / yields)
        speed, over_length, over_force = rate(length, force, active, share)
        excess = length - base - part * speed
        slope = 1.0 - part * (over_length - over_force * stiff * fibre / yields)
        if excess > 0.0:
            high = length
        else:
            low = length
        following = length - excess / slope
        if not (low <= following <= high and 2.0 * abs(excess) < abs(moved * slope)):
            following = 0.5 * (low + high)
        moved, length = abs(following - length), following
        if moved <= _NARROW:
            break
    return length


@compiled
def pull(qpos: Array, qvel: Array, memory: Array, forces: Array, table: Array, arms: Array, joints: Numbers,
         step: float) -> None:
    """Advance fibres to this instant under the activation in `memory`, and set the joints' `forces`, N m.

    MuJoCo's last step moved the whole muscles here at the present rate.
    """
    count = table.shape[0]
    forces[:] = 0.0
    for i in range(count):
        after, speed = table[i, _EXCESS], 0.0
        for k in range(arms.shape[1]):
            if joints[i, k] < 0:
                break
            after += arms[i, k] * qpos[joints[i, k]]
            speed += arms[i, k] * qvel[joints[i, k]]
        fibre, yields, level = table[i, _FIBRE], table[i, _YIELDS], memory[2 * count + i]
        level = 0.0 if level < 0.0 else 1.0 if level > 1.0 else level
        length = advance(memory[i], after - step * speed, after, level * table[i, _STRENGTH],
                         table[i, _PASSIVE], fibre, yields, step)
        memory[count + i] = (length - memory[i]) / step
        memory[i] = length
        tension = table[i, _FORCE] * tendon((after - fibre * length) / yields)[0]
        for k in range(arms.shape[1]):
            if joints[i, k] < 0:
                break
            forces[joints[i, k]] -= arms[i, k] * tension


@compiled
def rest(qpos: Array, memory: Array, table: Array, arms: Array, joints: Numbers) -> None:
    """Set fibres in `memory` to equilibrium without activation at `qpos`, by bisection to the last bit.

    Where nothing pulls, the tendon is just slack.
    """
    memory[:] = 0.0
    for i in range(table.shape[0]):
        whole = table[i, _EXCESS]
        for k in range(arms.shape[1]):
            if joints[i, k] < 0:
                break
            whole += arms[i, k] * qpos[joints[i, k]]
        fibre, yields = table[i, _FIBRE], table[i, _YIELDS]
        high = whole / fibre
        low = min(high, 1.0)
        middle = 0.5 * (low + high)
        while low < middle < high:
            if tendon((whole - fibre * middle) / yields)[0] > passive(middle, table[i, _PASSIVE])[0]:
                low = middle
            else:
                high = middle
            middle = 0.5 * (low + high)
        memory[i] = high
