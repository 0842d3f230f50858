"""Losses in bursts against Gilbert's chain, worked out by hand. About 5 s."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_parts import Sink, Source
from scipy import stats

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.loop.noise import NoiseStream
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

CASES = [(0.1, 5.0), (0.3, 2.0), (0.02, 20.0), (0.5, 1.25), (0.4, 1.0)]


def fates(share, burst, count, seed=1):
    """(count,), True where the message of a tick is lost."""
    return fates_over(Wire("a.y", "b.u", loss=share, burst_messages=burst), count, seed)


def fates_over(wire, count, seed):
    noise = wire.noise(seed, 0)
    losses = wire.losses(noise)
    return np.array([losses.lost(k, noise.row(k)[0]) for k in range(count)])


def runs_of(lost):
    """Lengths of the runs of lost messages that begin and end within the record."""
    edges = np.diff(lost.astype(int))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    ends = ends[ends > starts[0]]
    return ends - starts[:ends.size]


@pytest.mark.parametrize(("share", "burst"), CASES)
def test_share_and_mean_burst_are_those_asked_for_and_runs_are_geometric(share, burst):
    count = 60_000
    lost = fates(share, burst, count)
    # The chain's autocorrelation r^k widens the spread of the share by (1 + r) / (1 - r).
    r = 1.0 - 1.0 / burst - share / (1.0 - share) / burst
    assert lost.mean() == pytest.approx(
        share, abs=4.0 * np.sqrt(share * (1.0 - share) / count * (1.0 + r) / (1.0 - r)))
    runs = runs_of(lost)
    if burst == 1.0:
        assert runs.max() == 1
        return
    assert runs.mean() == pytest.approx(burst, abs=4.0 * np.sqrt(burst * (burst - 1.0) / runs.size))
    most = int(stats.geom.ppf(1.0 - 20.0 / runs.size, 1.0 / burst))
    found = np.bincount(np.minimum(runs, most + 1), minlength=most + 2)[1:]
    wanted = runs.size * np.append(stats.geom.pmf(np.arange(1, most + 1), 1.0 / burst),
                                   stats.geom.sf(most, 1.0 / burst))
    assert stats.chisquare(found, wanted).pvalue > 1e-3
    assert np.corrcoef(lost[:-1], lost[1:])[0, 1] == pytest.approx(r, abs=0.03)


@pytest.mark.parametrize(("share", "burst"), CASES)
def test_the_first_message_is_lost_as_often_as_any(share, burst):
    first = [fates(share, burst, 1, seed)[0] for seed in range(1500)]
    assert np.mean(first) == pytest.approx(share, abs=4.0 * np.sqrt(share * (1.0 - share) / 1500))


def test_independent_losses_are_what_they_were():
    """To the bit: a message is lost where its own number is below the share."""
    noise = NoiseStream(Wire("a.y", "b.u").noise(1, 0).key, 2, "uniform")
    np.testing.assert_array_equal(fates(0.3, 0.0, 500), [noise.row(k)[0] < 0.3 for k in range(500)])


@given(st.sampled_from([*CASES, (0.9, 9.0), (0.95, 40.0)]), st.integers(0, 2**32),
       st.lists(st.integers(0, 600), min_size=1, max_size=40))
@settings(max_examples=60, deadline=None)
def test_a_messages_fate_is_the_same_whichever_were_asked_for_before(case, seed, indices):
    """And that of the chain followed from its beginning."""
    (share, burst), lost = case, []
    wire = Wire("a.y", "b.u", loss=share, burst_messages=burst)
    noise = wire.noise(seed, 0)
    stays = 1.0 - 1.0 / burst
    begins = share / (burst * (1.0 - share))
    for k in range(max(indices) + 1):
        limit = (stays if lost[-1] else begins) if lost else share
        lost.append(noise.row(k)[0] < limit)
    losses = wire.losses(noise)
    assert [losses.lost(k, noise.row(k)[0]) for k in indices] == [lost[k] for k in indices]


def test_a_loop_counts_them_and_no_burst_is_the_better_for_a_snapshot():
    nodes = [Node("source", Source(), rate="100"), Node("sink", Sink(), rate="100")]
    wires = [Wire("source.y", "sink.u", loss=0.3, burst_messages=6)]
    loop = Loop(Wiring(nodes, wires, seed=7))
    loop.run_until(3 * NS_PER_S)
    snapshot = loop.snapshot()
    loop.run_until(10 * NS_PER_S)
    counts, log = loop.message_counts()["source.y->sink.u"], list(loop.states()["sink"].log)
    loop.restore(snapshot)
    loop.run_until(10 * NS_PER_S)
    assert loop.message_counts()["source.y->sink.u"] == counts
    assert list(loop.states()["sink"].log) == log
    assert counts["lost"] == fates_over(wires[0], 1001, 7).sum()


@pytest.mark.parametrize(("loss", "burst", "least"), [
    (0.1, 0.5, "1 or more"), (0.9, 5.0, "9 or more"), (0.1, -1.0, "1 or more"), (0.1, float("inf"), "1 or"),
    (0.1, True, "1 or more")])
def test_bursts_that_cannot_be_are_named(loss, burst, least):
    with pytest.raises(InputError, match=rf"a\.y->b\.u: burst_messages.*{least}"):
        Wire("a.y", "b.u", loss=loss, burst_messages=burst)
