"""Report and pictures of recordings of stimulated muscle."""

import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from stimulation_parts import recording, recordings_of_all_kinds

from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.show.picture.stimulation import draw_stimulation
from fesloop.show.report.page import page_html
from fesloop.show.report.parts import Chart, Fold
from fesloop.show.report.stimulated import stimulation_page
from fesloop.streams.stimulation.stored import write_stimulation


def charts_in(parts):
    return [chart for part in parts for chart in (
        charts_in(part.parts) if isinstance(part, Fold) else [part] if isinstance(part, Chart) else [])]


def test_the_report_has_every_trial_of_every_muscle_and_joint(tmp_path):
    made = recording(np.random.default_rng(2))
    page = stimulation_page(made, tmp_path / "p.h5")
    section = next(section for section in page.sections if section.key == "posture")
    charts = {chart.key: chart for chart in charts_in(section.parts)}
    assert sorted(charts) == ["posture-0-0", "posture-0-1", "posture-1-0", "posture-1-1"]
    rows = made.steady.muscle == 1
    shown = charts["posture-1-0"].lines[0].y
    np.testing.assert_allclose(np.sort(shown), np.sort(made.steady.evoked_nm[rows, 0]))
    snr = made.steady.repeatability().snr
    assert f"elbow flexion {snr[0]:.1f}, wrist flexion {snr[1]:.1f}" in page.sentence


@given(made=recordings_of_all_kinds())
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.filterwarnings("error")
def test_any_recording_has_a_page(tmp_path, made):
    assert len(page_html(stimulation_page(made, tmp_path / "p.h5"))) > 1000


def test_the_commands_write_page_and_pictures(tmp_path, capsys):
    write_stimulation(recording(np.random.default_rng(2)), tmp_path / "p.h5")
    assert main(["report", str(tmp_path / "p.h5"), "--json"]) == 0
    out = json.loads(capsys.readouterr().out)
    assert out["kind"] == "stimulation"
    assert {"posture", "recruitment", "drift", "movements", "force"} <= set(out["sections"])
    assert (tmp_path / "p.html").stat().st_size == out["bytes"]
    assert main(["picture", str(tmp_path / "p.h5"), "--out", str(tmp_path / "pictures"), "--json"]) == 0
    drawn = json.loads(capsys.readouterr().out)["pictures"]
    assert [path.rsplit("/", 1)[1] for path in drawn] == ["torque_over_posture.png", "drift.png", "force.png"]
    assert main(["picture", str(tmp_path / "p.h5"), "--trial", "1"]) == 2
    assert "--trial" in capsys.readouterr().err


def test_a_recording_of_movements_alone_is_not_drawn(tmp_path):
    made = recording(np.random.default_rng(2), steady=None, courses=(), forces=())
    with pytest.raises(InputError, match="holds no isometric trials, ramps or forces"):
        draw_stimulation(made, tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_published_recordings_have_pages_and_pictures(recordings, tmp_path):
    from fesloop.streams.stimulation import open_stimulation

    for name, drawn in (("fes_exo/S9006", 3), ("fes_exo/S9001", 1), ("rat_gm/GMe2", 1)):
        found = open_stimulation(recordings / f"{name}.npz")
        assert len(draw_stimulation(found, tmp_path / found.person)) == drawn
        assert len(page_html(stimulation_page(found, tmp_path / "p.h5"))) > 10_000
