"""The block in time: rests, ramps, looks, and an end; hands that do not answer."""

import math
from dataclasses import replace

import numpy as np
import pytest

from controllers.point_search.block import PointSearch
from controllers.point_search.exhaustive import Listed
from controllers.point_search.space import SearchSpace
from controllers.point_search.state import BASELINE, ENDED, MEASURE, Timetable
from controllers.point_search.strategies import Strategies, TwoPhase
from fesloop import Recording, load
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.metrics.search import answered
from fesloop.hand.movements import FREEDOMS, movement_of
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample

RATE = 40
CLOCK = RateClock.from_rate(str(RATE))


def listed(*elements, **parameters):
    """A search of a few elements at 10 mA for wrist extension."""
    strategies = Strategies(listed=Listed(elements=tuple((e,) for e in elements),
                                          current_ma=(10.0,) * len(elements)))
    return PointSearch(movement="wrist_extension", strategy="listed", strategies=strategies, **parameters)


def run(search, seconds, hand, sd=0.0):
    """Outputs by name and reports of every tick; `hand(time, outputs before)` gives angles, None for none.

    `sd` is of all freedoms, or a function of the same that gives each.
    """
    state, tick = search.init(Context("search", 1, 0, CLOCK)), Tick()
    names, rows, reports = [port.name for port in search.outputs], [], []
    before = dict.fromkeys(names, 0.0)
    arrived, angles = NEVER, np.zeros(len(FREEDOMS))
    for k in range(int(seconds * RATE)):
        tick.index, tick.time_ns = k, CLOCK.tick(k)
        told = hand(k / RATE, before)
        if told is not None:
            arrived, angles = tick.time_ns, told
        each = sd(k / RATE, before) if callable(sd) else np.full(len(FREEDOMS), sd)
        samples = (Sample(angles, arrived, arrived, arrived), Sample(each, NEVER, NEVER, NEVER))
        before = dict(zip(names, search.step(state, samples, tick), strict=True))
        rows.append(before)
        reports += [(k / RATE, *report) for report in tick.reports]
        tick.reports.clear()
    return {name: np.array([row[name] for row in rows]) for name in names}, reports


def extends(element, degrees):
    """A wrist that follows one element at once."""
    def hand(now, outputs):
        angles = np.full(len(FREEDOMS), 0.3)
        if np.any(outputs["stimulation"]) and outputs["multiplexing"][0, element] > 0.0:
            angles[0] -= math.radians(degrees)
        return angles
    return hand


def test_queries_take_the_time_that_is_stated_and_the_search_ends():
    out, reports = run(listed(4, 17, 30), 15.0, extends(17, 30.0))
    # 2 s, then three times 1.5 + .3 + .8 + .2 s.
    ((when, status, detail),) = reports
    assert (when, status) == (pytest.approx(2.0 + 3 * 2.8, abs=2.0 / RATE), "search_ended")
    assert "element 17 at 10 mA" in detail
    over = out["phase"] == ENDED
    assert not out["stimulation"][over].any()
    assert not out["multiplexing"][over].any()
    on = out["stimulation"][:, 0, 1] > 0.0
    assert on.sum() / RATE == pytest.approx(3 * 1.3, abs=4.0 / RATE)
    assert not on[:int(3.4 * RATE)].any()
    assert out["best_quality"][-1] == pytest.approx(30.0 / 40.0)
    np.testing.assert_allclose(out["best_stimulation"][-1], [0.01, 3e-4])
    assert np.flatnonzero(out["best_multiplexing"][-1]).tolist() == [17]


def test_the_pulse_width_rises_from_half_and_current_is_never_more_than_asked():
    out, _ = run(listed(4), 6.0, extends(4, 10.0))
    widths = out["stimulation"][:, 0, 1][out["stimulation"][:, 0, 1] > 0.0]
    assert widths[0] == pytest.approx(1.5e-4)
    assert (np.diff(widths) >= 0.0).all()
    assert widths[-1] == pytest.approx(3e-4)
    assert set(out["stimulation"][:, 0, 0]) == {0.0, 0.01}


def test_movement_is_told_from_rest_so_that_an_offset_does_not_count():
    drifting = extends(4, 20.0)
    still, _ = run(listed(4), 6.0, drifting)
    shifted, _ = run(listed(4), 6.0, lambda now, outputs: drifting(now, outputs) + 0.4)
    assert shifted["best_quality"][-1] == pytest.approx(still["best_quality"][-1])


def test_quality_is_that_of_the_mean_of_what_was_told_while_the_hand_was_looked_at():
    rng, kept = np.random.default_rng(1), []

    def hand(now, outputs):
        kept.append(0.1 * rng.standard_normal(len(FREEDOMS)))
        return kept[-1]

    out, _ = run(listed(4), 6.0, hand)
    # Ticks after the one that begins a look, to the one that ends it.
    rest, end = (np.mean([kept[k + 1] for k in np.flatnonzero(out["phase"] == phase)], axis=0)
                 for phase in (2, 5))
    assert out["quality"][-1] == pytest.approx(movement_of("wrist_extension").judge(end - rest).quality)


def test_stairs_follow_each_other_without_rest():
    strategies = Strategies(two_phase=TwoPhase(step_uc=1.0, best=1))
    search = PointSearch(strategy="two_phase", strategies=strategies, space=SearchSpace(elements=(3, 4)))
    out, reports = run(search, 12.0, extends(3, 5.0))
    # Two elements, nine stairs of .12 s, which are 5 ticks: the halves are rounded up to 3 each.
    assert reports[-1][1] == "search_ended"
    assert reports[-1][0] == pytest.approx(2.0 + 2 * (1.5 + 9 * 6 / RATE), abs=0.1)
    for query in range(9):
        given = out["stimulation"][:, 0, 0][(out["query"] == query) & (out["stimulation"][:, 0, 1] > 0.0)]
        np.testing.assert_allclose(given, (query + 1) / 300.0, rtol=1e-12)


def test_a_hand_that_nobody_sees_is_asked_again_and_then_given_up():
    out, reports = run(listed(4), 20.0, lambda now, outputs: None)
    assert [status for _, status, _ in reports] == ["no_response"] * 3 + ["search_failed"]
    assert out["phase"][-1] == ENDED
    assert not out["stimulation"][-1].any()


def test_a_short_silence_costs_one_query_and_no_more():
    hand = extends(4, 20.0)
    out, reports = run(listed(4), 12.0, lambda now, outputs: hand(now, outputs) if now > 5.0 else None)
    assert [status for _, status, _ in reports] == ["no_response", "search_ended"]
    assert out["best_quality"][-1] == pytest.approx(0.5)


def test_unseen_freedoms_count_as_not_moved_and_bad_angles_are_left_out():
    out, reports = run(listed(4), 6.0, extends(4, 20.0), sd=math.pi)
    assert out["best_quality"][-1] == 0.0
    assert "untracked" in {status for _, status, _ in reports}
    hand = extends(4, 20.0)

    def sometimes(now, outputs):
        return np.full(len(FREEDOMS), np.nan) if int(now * RATE) % 2 else hand(now, outputs)

    out, reports = run(listed(4), 6.0, sometimes)
    assert out["best_quality"][-1] == pytest.approx(0.5)
    assert "bad_input" in {status for _, status, _ in reports}


@pytest.mark.parametrize("hidden_in", [BASELINE, MEASURE])
def test_a_freedom_that_is_seen_only_at_rest_or_only_afterwards_has_not_moved(hidden_in):
    def hidden(now, outputs):
        return np.where(np.arange(len(FREEDOMS)) == 0, math.pi * (outputs["phase"] == hidden_in), 0.0)

    hand = extends(4, 20.0)
    out, _ = run(listed(4), 6.0, lambda now, outputs: hand(now, outputs) + 0.5, sd=hidden)
    assert out["phase"][-1] == ENDED
    assert out["best_quality"][-1] == 0.0


def test_a_freedom_that_is_seen_now_and_then_moves_as_it_does_when_seen():
    hand = extends(4, 20.0)
    out, reports = run(listed(4), 6.0, hand, lambda now, outputs: np.full(
        len(FREEDOMS), math.pi if int(now * RATE) % 2 else 0.0))
    assert out["best_quality"][-1] == pytest.approx(0.5)
    assert [status for _, status, _ in reports].count("untracked") > 1


def test_what_cannot_be_is_refused_by_name():
    with pytest.raises(InputError, match="exhaustive"):
        PointSearch(strategy="exhaustiv")
    with pytest.raises(InputError, match="elements"):
        listed(60)
    with pytest.raises(InputError, match="rest_s"):
        Timetable(rest_s=0.1)
    with pytest.raises(InputError, match="above 0"):
        replace(Timetable(), measure_s=0.0)


def test_a_search_begins_with_the_recording_of_another(tmp_path):
    pytest.importorskip("sklearn")
    short = ["duration_s=9", "tracker=ideal"]
    first = load("array_search_gp", [*short, "movement=pinch"]).run(tmp_path)
    earlier = f"blocks.search.earlier.file={first.recording}"
    with pytest.raises(InputError, match="is a search for pinch"):
        load("array_search_gp", ["movement=finger_opening", earlier])
    with pytest.raises(InputError, match="is not used by the strategy exhaustive"):
        load("array_search_exhaustive", ["movement=pinch", earlier])
    with Recording(first.recording) as recording:
        asked = list(answered(recording, "search"))
    assert len(asked) >= 2
    second = load("array_search_gp", [*short, "movement=pinch", "day=2", f"earlier={first.recording}"])
    search = next(node.part for node in second.nodes if node.name == "search")
    assert [(each.elements, each.current_ma, each.quality) for each in search.earlier.responses] == [
        (each.elements, each.current_ma, each.quality) for each in asked]
    other = load("finger_pid_latency", ["experiment.duration_s=1.0"]).run(tmp_path)
    with pytest.raises(InputError, match="block of kind point_search"):
        load("array_search_gp", [f"earlier={other.recording}"])


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """Recording of a search of member 0 of cohort 1 of sci_c6, on day 1."""
    pytest.importorskip("sklearn")
    folder = tmp_path_factory.mktemp("searched")
    return load("array_search_gp", ["duration_s=9", "tracker=ideal"]).run(folder).recording


@pytest.mark.parametrize(("other", "here"), [
    (["member=3"], "sci_c6, member 3 of cohort 1"),
    (["cohort=59"], "sci_c6, member 0 of cohort 59"),
    (["patient=able_bodied", "day=2"], "able_bodied, member 0 of cohort 1")])
def test_an_earlier_search_of_another_person_is_refused_unless_asked_for(searched, other, here, tmp_path,
                                                                         monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    settings = [*other, "tracker=ideal", f"earlier={searched}"]
    words = [word for each in settings for word in ("--set", each)]
    for command in (["check"], ["run", "--out", "made"]):
        assert main([*command, "array_search_gp", *words]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line == (
            f"fesloop: array_search_gp with tracker=ideal: blocks.search.earlier: {searched}: patient: the "
            f"recording is of sci_c6, member 0 of cohort 1; allowed: {here}, as this experiment has, on any "
            "day; record this one, or say --set any_patient=true")
    asked = load("array_search_gp", [*settings, "any_patient=true"])
    search = next(node.part for node in asked.nodes if node.name == "search")
    assert search.earlier.responses
    assert [f"is of another person: of sci_c6, member 0 of cohort 1, and this is {here}" in note
            for note in asked.notes] == [True]


def test_an_earlier_search_of_another_day_or_by_another_path_is_of_the_same_person(searched, tmp_path):
    assert not load("array_search_gp", ["day=7", f"earlier={searched}"]).notes
    for name, text in (("sci_c6", ""), ("weaker", "[strength]\noverall = 0.7\n")):
        path = tmp_path / f"{name}.toml"
        path.write_text(f'extends = "sci_c6"\n{text}')
        settings = [f"patient={path}", f"earlier={searched}"]
        if text:
            with pytest.raises(InputError, match="as this experiment has"):
                load("array_search_gp", settings)
        else:
            assert not load("array_search_gp", settings).notes
