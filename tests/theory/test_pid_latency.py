"""The latency at which the simulated finger loop loses stability, against the exact sampled-data system.

The theory is built here from `control` alone: zero-order-hold steps over the two parts of a period that a
fractional delay cuts it into, closed through the controller's difference equations, judged by eigenvalues.
"""

import control
import numpy as np
import pytest
from scipy.optimize import brentq

from controllers.pid import Pid
from controllers.reference import MinimumJerk
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.finger import Finger

RATE, PERIOD_S = 50, 0.02
MIXING = ((0.2, 0.3, 0.5), (0.4, 0.6, -0.2), (-0.6, -0.2, -0.3), (0.5, -0.3, -0.2))
FINGER = Finger(recruitment_curve="linear")


def pid(gain):
    """A controller of all three joints, `gain` times a nominal one."""
    scaled = [tuple(gain * k for k in ks) for ks in ((0.8, 0.5, 0.4), (1.2, 1.0, 0.8), (0.05, 0.03, 0.02))]
    return Pid(kp=scaled[0], ki=scaled[1], kd=scaled[2], mixing=MIXING, current_ma=(20.0,) * 4,
               recruitment_curve="linear")


def spectral_radius(gain, delay_s):
    """Largest eigenvalue magnitude of the closed loop with everything on it delayed by `delay_s`."""
    model = FINGER.linear_model("angles")
    whole, rest = divmod(delay_s + model.delay_ns / NS_PER_S, PERIOD_S)
    whole = int(whole)
    states, muscles = model.b.shape
    full = control.ss(model.a, model.b, np.eye(states), 0)

    def held(duration):
        if duration <= 0:
            return np.eye(states), np.zeros((states, muscles))
        step = control.c2d(full, duration, "zoh")
        return step.A, step.B

    a_early, b_early = held(rest)
    a_late, b_late = held(PERIOD_S - rest)
    # v[k - whole - 1] acts for the first `rest` of the period, v[k - whole] for what is left of it
    size = states + (whole + 1) * muscles
    a, b = np.zeros((size, size)), np.zeros((size, muscles))
    a[:states, :states] = a_late @ a_early
    late, early = states + (whole - 1) * muscles, states + whole * muscles
    a[:states, early:early + muscles] = a_late @ b_early
    if whole:
        a[:states, late:late + muscles] = b_late
    else:
        b[:states] = b_late
    b[states:states + muscles] = np.eye(muscles)
    for i in range(whole):
        at = states + i * muscles
        a[at + muscles:at + 2 * muscles, at:at + muscles] = np.eye(muscles)
    plant = control.ss(a, b, np.hstack([model.c, np.zeros((3, size - states))]), 0, PERIOD_S)
    ca, cb, cc, cd = pid(gain).sampled(PERIOD_S)
    controller = control.ss(ca, cb[:, 3:], cc, cd[:, 3:], PERIOD_S)
    closed = control.feedback(plant, controller, sign=1)
    return np.abs(control.poles(closed)).max()


def simulated_growth(gain, delay_ns, where):
    """Logarithm of how much the rates grow between two late windows of the running loop."""
    out, back = Wire("finger.angles", "pid.measured"), Wire("pid.stimulation", "finger.stimulation")
    delay_ms = delay_ns / NS_PER_MS
    if where == "actuation":
        back = Wire(back.source, back.target, latency_ms=delay_ms)
    else:
        # sampled just so early that the value arrives as the controller steps
        early_ms = -delay_ms % (1e3 * PERIOD_S)
        out = Wire(out.source, out.target, latency_ms=delay_ms, rate=RATE, offset_ms=early_ms)
    aim = MinimumJerk(times_s=(0.0, 0.2), angles_deg=((20.0, 25.0, 15.0), (22.0, 26.0, 16.0)))
    nodes = [Node("reference", aim, rate=RATE), Node("pid", pid(gain), rate=RATE), Node("finger", FINGER)]
    wires = [Wire("reference.angles", "pid.reference"), out, back]
    recorder = Recorder(RATE)
    Loop(Wiring(nodes, wires), recorder=recorder).run_until(60 * NS_PER_S)
    rates = np.concatenate([row[2][1] for row in recorder.plants["finger"]])
    early, late = (np.log(np.linalg.norm(rates[k:k + 1000])) for k in (1000, 2000))
    return late - early


def crossing_ms(growth, low_ms, high_ms):
    """Where growth changes sign, by bisection to 0.01 ms."""
    while high_ms - low_ms > 0.01:
        middle = 0.5 * (low_ms + high_ms)
        if growth(middle) > 0:
            high_ms = middle
        else:
            low_ms = middle
    return 0.5 * (low_ms + high_ms)


@pytest.mark.slow
@pytest.mark.parametrize(("gain", "where"), [
    (1.7, "actuation"), (2.0, "measurement"), (2.3, "actuation"), (2.6, "measurement"), (2.9, "actuation")])
def test_the_loop_loses_stability_where_theory_says(gain, where):
    assert spectral_radius(gain, 0.0) < 1.0
    coarse = next(ms for ms in range(1, 500, 2) if spectral_radius(gain, ms * 1e-3) > 1.0)
    theory = brentq(lambda ms: spectral_radius(gain, ms * 1e-3) - 1.0, max(coarse - 2, 0), coarse, xtol=1e-4)
    found = crossing_ms(lambda ms: simulated_growth(gain, round(ms * NS_PER_MS), where),
                        max(theory - 5.0, 0.0), theory + 5.0)
    print(f"gain {gain:g} ({where}): theory {theory:.3f} ms, simulated {found:.3f} ms")
    assert abs(found - theory) < 0.1
