"""The reachable floor: its plant is the loop's, and it finds what is known to be reachable."""

from dataclasses import replace

import numpy as np
import pytest

import fesloop
from controllers.reference import MinimumJerk
from fesloop import InputError, Recording
from fesloop.apps.reproduce.chain_slopes import ChainSlopes
from fesloop.apps.reproduce.open_chain import CHAIN, OpenChain
from fesloop.apps.reproduce.reachable import (
    Aim,
    bounded_step,
    descend,
    hats,
    reachable_floor,
    reference_course,
)
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

CURRENT_MA = np.array([14.0, 14.0, 14.0, 24.0, 24.0, 24.0, 24.0, 30.0])
TICKS = 36


@pytest.fixture(scope="module")
def experiment():
    """A learning grasp whose hand nobody holds at the start."""
    document = fesloop.load("grasp_ilc").document()
    del document["blocks"]["hand"]["assist"]
    return from_document(document)


@pytest.fixture(scope="module")
def chain(experiment):
    return OpenChain(experiment, CURRENT_MA, TICKS)


def held_back(seed, ticks=TICKS):
    """Random widths (ticks, 8), s: way-points every 250 ms, nothing in the first."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 200e-6, (2 + ticks // 10, 8))
    points[0] = 0.0
    return np.array([np.interp(np.arange(ticks), 10.0 * np.arange(len(points)), each) for each in points.T]).T


def test_the_chain_is_the_plant_of_the_loop(experiment, chain):
    """Against the experiment's own loop with the block `programme` in the controller's place."""
    from controllers.open_loop import Programme

    widths = chain.given(held_back(1))
    clock = RateClock.from_rate("40")
    programme = Programme(
        times_s=tuple(clock.tick(k) / NS_PER_S for k in range(TICKS)), current_ma=(tuple(CURRENT_MA),),
        width_us=tuple(tuple(row) for row in 1e6 * widths))
    kept = (*CHAIN, "truth")
    nodes = [Node("programme", programme, "40"), *(
        replace(node, rate="40") if node.name == "truth" else node
        for node in experiment.nodes if node.name in kept)]
    wires = [Wire("programme.stimulation", "safety.stimulation"), *(
        wire for wire in experiment.wires
        if wire.source.partition(".")[0] in kept and wire.target.partition(".")[0] in kept)]
    seen = Recorder(None)
    Loop(Wiring(nodes, wires, experiment.seed), recorder=seen).run_until(clock.tick(TICKS - 1))
    truth = np.array([row[5][0] for row in seen.blocks["truth"]])
    np.testing.assert_allclose(chain.course(widths, 0), truth, atol=1e-9)
    np.testing.assert_array_equal(chain.course(widths, 12), chain.course(widths, 0)[12:])


def test_what_is_played_leaves_the_safety_block_as_admitted(experiment):
    strict = {node.name: node for node in experiment.nodes}["safety"].part
    limited = replace(strict, charge_rise_uc=1.0, width_max_us=300.0)
    nodes = tuple(replace(node, part=limited) if node.name == "safety" else node for node in experiment.nodes)
    chain = OpenChain(replace(experiment, nodes=nodes), CURRENT_MA, 20)
    wild = np.random.default_rng(3).uniform(-1e-4, 9e-4, (20, 8))
    admitted = chain.admitted(wild)
    charges = 1e-3 * CURRENT_MA * admitted
    assert admitted.min() >= 0.0
    assert admitted.max() <= 300e-6
    assert np.diff(charges, axis=0, prepend=0.0).max() <= 1e-6 * (1.0 + 1e-12)
    assert np.diff(charges, axis=0).max() > 0.9e-6


@pytest.mark.slow
def test_slopes_are_those_of_the_plant(chain):
    """Against differences of the plant itself, whose axons fire one by one: alike, not equal."""
    slopes, first = ChainSlopes(chain), 5
    widths = np.full((TICKS, 8), 150e-6)
    widths[:first] = 0.0
    shapes = hats(TICKS, first, 10)
    course, jacobian = slopes.jacobian(widths, first, shapes)
    np.testing.assert_array_equal(course, chain.course(widths, first))
    for channel in (0, 1, 4, 7):
        move = np.zeros((TICKS, 8))
        move[:, channel] = 20e-6 * shapes[:, 1]
        difference = (chain.course(widths + move, first) - chain.course(widths - move, first)) / 40e-6
        told = jacobian[:, :, 1, channel]
        alike = np.sum(told * difference) / (np.linalg.norm(told) * np.linalg.norm(difference))
        assert alike > 0.95
        assert 0.4 < np.linalg.norm(told) / np.linalg.norm(difference) < 2.5


@pytest.mark.parametrize("seed", range(4))
def test_bounded_least_squares_is_that_of_scipy(seed):
    from scipy.optimize import lsq_linear

    rng = np.random.default_rng(seed)
    slopes, errors = rng.normal(size=(30, 12)), rng.normal(size=30)
    lower, upper = -rng.uniform(0.0, 0.2, 12), rng.uniform(0.0, 0.2, 12)
    whole = np.vstack([slopes, np.sqrt(0.3) * np.eye(12)])
    wanted = np.concatenate([errors, np.zeros(12)])
    expected = lsq_linear(whole, wanted, (lower, upper), method="bvls", tol=1e-14)
    np.testing.assert_allclose(bounded_step(slopes, errors, 0.3, lower, upper), expected.x, atol=1e-6)


@pytest.mark.slow
def test_what_stimulation_has_made_is_found_to_be_reachable(experiment, chain):
    """The floor of a course that held-back admissible widths made is 0."""
    reference = chain.course(chain.admitted(held_back(5)), 0)
    moved = np.degrees(reference[28:] - reference[0])
    floor = reachable_floor(experiment, reference, (0.7, TICKS / 40), current_ma=CURRENT_MA)
    assert np.sqrt(np.mean(moved**2)) > 5.0
    assert floor.rmse_deg < 0.5
    played = np.degrees(chain.course(floor.widths_s, 0)[28:] - reference[28:])
    assert np.sqrt(np.mean(played**2)) == pytest.approx(floor.rmse_deg, rel=1e-6)
    assert set(floor.ends_deg) == {"rest", "postures"}


@pytest.mark.slow
def test_a_start_is_made_better_and_its_beginning_kept(chain):
    widths = chain.admitted(held_back(7))
    aim = Aim(chain.course(widths, 0) + np.radians(4.0), 15, 30)
    reached = descend(chain, ChainSlopes(chain), aim, widths, spacing=4, steps=2)
    assert reached.rmse_rad[0] == pytest.approx(np.radians(4.0))
    assert reached.rmse_rad[-1] < reached.rmse_rad[0]
    np.testing.assert_array_equal(reached.widths[:15], widths[:15])
    np.testing.assert_array_equal(reached.course, chain.course(reached.widths, 15))


def test_misfits_are_named(experiment):
    with pytest.raises(InputError, match="reference"):
        reachable_floor(experiment, np.zeros((10, 3)), (0.0, 1.0))
    with pytest.raises(InputError, match=r"starts\.learnt"):
        reachable_floor(experiment, np.zeros((50, 3)), (0.5, 1.0), {"learnt": np.zeros((5, 8))})
    still = MinimumJerk(times_s=(0.0, 1.0), angles_deg=((0.0,), (0.0,)))
    nodes = (Node("reference", still, "40"),)
    with pytest.raises(InputError, match="no node named safety"):
        OpenChain(Experiment(name="none", nodes=nodes, duration_s=1.0), CURRENT_MA, 5)


def test_the_reference_is_what_the_run_asked_of_the_hand(tmp_path):
    result = fesloop.load("grasp_ilc", ["scene=free", "trials=1", "experiment.duration_s=4.5"]).run(tmp_path)
    with Recording(result.recording) as recording:
        course = np.degrees(reference_course(recording, 0))
        measured = recording.signal("synergies.synergies", 0)
        start = np.degrees(measured.values[np.searchsorted(measured.times_ns, 1.9 * NS_PER_S)])
    assert course.shape == (180, 3)
    np.testing.assert_allclose(course[80], start, atol=0.3)
    np.testing.assert_allclose(course[150], [25.0, 18.0, start[2]], atol=0.3)
