"""The table [electrodes] of experiment files."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fesloop
from fesloop.errors import InputError

OWN = """
channels = "nearest"

[[arrays]]
rows = 5
columns = 8
pitch_mm = [14, 12]
pad_mm = 5

[[arrays]]
rows = 5
columns = 6
pitch_mm = [14, 14]
centre_deg = 175
pad_mm = 6
"""


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(OWN)
    return path


def blocks(experiment, *settings):
    return fesloop.load(experiment, settings).document()["blocks"]


def fault(experiment, *settings):
    with pytest.raises(InputError) as raised:
        fesloop.load(experiment, settings)
    assert "\n" not in str(raised.value)
    return str(raised.value)


@pytest.mark.parametrize("experiment", ["array_search_gp", "array_search_two_phase",
                                        "array_search_exhaustive"])
def test_one_key_gives_a_search_its_arrays(own, experiment):
    made = blocks(experiment, f"electrodes.array={own}")
    assert made["stimulator"]["elements"] == 70
    assert len(made["stimulator"]["element_area_cm2"]) == 70
    layouts = made["search"]["space"]["layouts"]
    for array, layout in zip(made["electrodes"]["arrays"], layouts, strict=True):
        assert {key: array[key] for key in layout} == layout
    assert len(made["electrodes"]["skin_gain"]) == 70
    assert "electrodes" not in fesloop.load(experiment, [f"electrodes.array={own}"]).document()


def test_one_key_gives_a_sweep_its_arrays(own):
    assert blocks("recruitment_sweep", f"electrodes.array={own}")["sweep"]["count"] == 70


def test_the_channels_of_an_experiment_go_to_the_nearest_elements(own):
    made = blocks("identify_grasp", f"electrodes.array={own}")["stimulator"]["electrodes"]
    usual = blocks("identify_grasp")["stimulator"]["electrodes"]
    assert len(made) == len(usual) == 8
    assert made[3]["elements"] == [49]  # element 44, 175 - 11.5 deg and 66 mm: row 1, column 3 of the second


def test_the_usual_arrays_change_nothing():
    arrays = "[{rows=5, columns=7}, {rows=4, columns=6, centre_deg=175}]"
    setting = f"electrodes.array={{arrays={arrays}, channels='nearest'}}"
    for experiment in ("identify_grasp", "array_search_gp"):
        made = blocks(experiment, setting)
        made["stimulator"]["element_area_cm2"] = 1.54  # rounded there
        assert made == blocks(experiment)


def test_a_file_of_an_experiment_may_hold_its_arrays(tmp_path, own):
    (tmp_path / "mine.toml").write_text('extends = "array_search_gp"\n[electrodes]\narray = "own.toml"\n')
    (tmp_path / "inside.toml").write_text('extends = "array_search_gp"\n[electrodes.array]\n'
                                          + OWN.replace("[[arrays]]", "[[electrodes.array.arrays]]"))
    made = blocks("array_search_gp", f"electrodes.array={own}")
    assert blocks(tmp_path / "mine.toml") == blocks(tmp_path / "inside.toml") == made


@given(st.integers(1, 5), st.integers(1, 7), st.lists(st.tuples(st.integers(-8, 8), st.integers(3, 9)),
                                                      min_size=1, max_size=9, unique=True))
@settings(max_examples=15, deadline=None)
def test_grids_and_positions_fit_together(rows, columns, spots):
    positions = [[150.0 + 6.0 * around, 20.0 * along] for around, along in spots if not around % 4]
    arrays = [{"rows": rows, "columns": columns, "pad_mm": 5.0}]
    if positions:
        arrays.append({"positions": positions, "pad_mm": 3.0})
    count = rows * columns + len(positions)
    experiment = fesloop.load("array_search_gp", {"electrodes.array": {"arrays": arrays}})
    wired = {node.name: node.part for node in experiment.wiring.nodes}
    found = wired["electrodes"].elements, wired["stimulator"].elements, wired["search"].space.count
    assert found == (count,) * 3
    singles = [each for each in wired["search"].space.electrodes if len(each) == 1]
    assert len(singles) == count


@pytest.mark.parametrize(("text", "told"), [
    (OWN.replace("rows = 5", "rows = 0", 1), "own.toml: arrays[0]: array: 0 rows, 8 columns and 0 position"),
    (OWN.replace("pitch_mm = [14, 12]", "pitch_mm = 14"), "own.toml: arrays[0].pitch_mm: 14"),
    (OWN.replace("rows = 5", "row = 5", 1), "own.toml: arrays[0].row: "),
    (OWN.replace("pad_mm = 5", "pad_mm = 9"), "own.toml: arrays: elements 0 and 1 overlap: 12 mm apart"),
    (OWN.replace("rows = 5", "rows = 20", 1).replace("pad_mm = 5", "pad_mm = 1"),
     "own.toml: arrays"),
    (OWN.replace("columns = 8", "columns = 25").replace("pad_mm = 5", "pad_mm = 3"), "m from the elbow"),
    (OWN.replace('"nearest"', '"any"'), "own.toml: channels"),
    (OWN.replace('"nearest"', "[{elements = [70]}]"), "own.toml: channels[0].elements: element 70"),
    (OWN.replace('channels = "nearest"', ""), "own.toml: channels: is missing: the experiment"),
    (OWN.replace("centre_deg", "centre_mm = 180\ncentre_deg"), 'own.toml: channels: "nearest": channel'),
    (OWN.replace('"nearest"', "[{elements = [1]}]"), "1"),
    ("arrays = []", "own.toml: arrays: none"),
    ("arrays = [", "own.toml: is not TOML"),
])
def test_contradictions_are_one_line(own, text, told):
    own.write_text(text)
    assert told in fault("identify_grasp", f"electrodes.array={own}")


@pytest.mark.parametrize(("setting", "told"), [
    ("blocks.stimulator.elements=59", "blocks.stimulator.elements: is given beside electrodes.array"),
    ("blocks.search.space.layouts=[{rows=2, columns=2}]", "blocks.search.space.layouts: is given beside"),
    ("blocks.electrodes.arrays=[{rows=2, columns=2}]", "blocks.electrodes.arrays: is given beside"),
    ("blocks.search.space.elements=[70]", "element 70 does not exist"),
])
def test_what_follows_from_the_arrays_is_not_stated_again(own, setting, told):
    assert told in fault("array_search_gp", f"electrodes.array={own}", setting)


def test_pads_may_overlap_on_one_forearm_and_not_on_another(own):
    told = fault("array_search_gp", f"electrodes.array={own}", "blocks.electrodes.radius_mm=20")
    assert "own.toml: arrays: elements" in told
    assert "on a forearm of 20 mm radius" in told


def test_an_experiment_without_arrays_refuses_them(own):
    assert "would change nothing" in fault("finger_pid_latency", f"electrodes.array={own}")
    assert "cannot be read" in fault("array_search_gp", "electrodes.array=none.toml")
    assert "electrodes: {'arrays'" in fault("array_search_gp", "electrodes.arrays=none.toml")


def test_a_model_of_other_arrays_is_refused(own):
    told = fault("grasp_ilc", f"electrodes.array={own}")
    assert "the model is of the usual arrays; allowed: 5 x 8 at 14 x 12 mm and 5 x 6 at 14 x 14 mm" in told


@pytest.mark.slow
def test_a_model_that_is_identified_with_arrays_serves_with_them(own, tmp_path, monkeypatch):
    from fesloop.apps.cli import main

    monkeypatch.chdir(tmp_path)
    arrays = ["--set", f"electrodes.array={own}"]
    assert main(["run", "identify_grasp", *arrays, "--out", "runs"]) == 0
    assert main(["identify", "runs/identify_grasp-1.h5", "--out", "model.toml"]) == 0
    assert 'arrays = "5 x 8 at 14 x 12 mm and 5 x 6 at 14 x 14 mm (' in (tmp_path / "model.toml").read_text()
    fesloop.load("grasp_ilc", [f"electrodes.array={own}", "model=model.toml"])
    assert "the model is of 5 x 8 at" in fault("grasp_ilc", "model=model.toml")


@pytest.mark.slow
def test_a_sweep_over_own_arrays_chooses_the_channels(own, tmp_path, monkeypatch):
    from fesloop.apps.cli import main

    monkeypatch.chdir(tmp_path)
    arrays = f"electrodes.array={own}"
    longer = ["--set", "experiment.duration_s=185", "--out", "runs"]
    assert main(["run", "sweep_grasp", "--set", arrays, *longer]) == 0
    assert main(["identify", "runs/sweep_grasp-1.h5", "--out", "model.toml"]) == 0
    chosen = ["follow=fingers", "channels=model", "model=model.toml"]
    made = blocks("grasp_mpc", arrays, *chosen)["stimulator"]
    assert made["elements"] == 70
    assert len(made["electrodes"]) == 8
    assert "the model is of 5 x 8 at" in fault("grasp_mpc", *chosen)


def test_an_earlier_search_knows_its_arrays(own, tmp_path):
    pytest.importorskip("sklearn")
    arrays = f"electrodes.array={own}"
    run = fesloop.load("array_search_gp", [arrays, "duration_s=14"]).run(out=tmp_path)
    earlier = f"earlier={run.recording}"
    made = blocks("array_search_gp", arrays, earlier, "day=2")["search"]
    assert made["earlier"]["layouts"] == made["space"]["layouts"]
    assert "is a search of other arrays" in fault("array_search_gp", earlier, "day=2")


def test_check_shows_what_follows(own, capsys):
    from fesloop.apps.cli import main

    assert main(["check", "identify_grasp", "--set", f"electrodes.array={own}", "--json"]) == 0
    rows = {(row["node"], row["what"]): row["value"]
            for row in json.loads(capsys.readouterr().out)["arrays"]}
    assert rows["stimulator", "elements"] == "70, of 0.785 or 1.13 cm2"
    assert rows["stimulator", "channel 3"] == "element 49"
    assert rows["electrodes", "array 1"].startswith("elements 40 to 69: 5 x 6 at 14 x 14 mm, pads of 6 mm")
