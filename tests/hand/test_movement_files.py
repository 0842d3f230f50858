"""Movements that users write: from a file into the search, its score, its recording and its report."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

import fesloop
from controllers.point_search.earlier import EarlierResponse, EarlierSearch
from controllers.point_search.prior_zones import ZONES
from fesloop import InputError
from fesloop.apps.cli import main
from fesloop.experiment.recording.reading import Recording
from fesloop.forms.toml import toml_text
from fesloop.hand.movements import FREEDOMS, MOVEMENTS, Movement, movement_text, stated_movement

THUMB = 'left_alone = ["F1_mcp_flexion"]\n[wanted_deg]\nF1_cmc_abduction = 30\n'
SEARCH = "array_search_two_phase"
KNOWN = "wrist_extension, finger_opening, pinch, key_pinch, power_grasp"


@pytest.fixture
def thumb(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "thumb.toml").write_text(THUMB)
    return "thumb.toml"


def test_every_shipped_movement_has_zones_and_its_own_name_is_itself():
    assert set(ZONES) == set(MOVEMENTS)
    assert all(stated_movement(name) == name for name in MOVEMENTS)


freedoms = st.lists(st.sampled_from(FREEDOMS), min_size=1, max_size=6, unique=True)
degrees = st.floats(1.0, 180.0) | st.floats(-180.0, -1.0) | st.integers(1, 180)


@given(names=freedoms, data=st.data())
def test_a_file_of_any_movement_makes_that_movement(names, data, tmp_path_factory):
    moved = names[:data.draw(st.integers(1, len(names)))]
    tables = {"wanted_deg": {name: data.draw(degrees) for name in moved}, "left_alone": names[len(moved):]}
    path = tmp_path_factory.mktemp("movement") / "mine.toml"
    path.write_text(toml_text(tables))
    stated = stated_movement(str(path))
    assert Movement(**stated) == Movement(**tables, name="mine")
    assert movement_text(stated) == movement_text(tables)


@given(tables=st.dictionaries(
    st.sampled_from(["name", "wanted_deg", "left_alone", "wanted"]),
    st.one_of(st.integers(), st.text(max_size=4), st.booleans(), st.lists(st.text(max_size=4), max_size=2),
              st.dictionaries(st.sampled_from(FREEDOMS), st.one_of(
                  st.floats(), st.text(max_size=3), st.booleans()), max_size=2))))
def test_any_file_makes_a_movement_or_is_refused_in_one_line_that_names_it(tables, tmp_path_factory):
    path = tmp_path_factory.mktemp("movement") / "mine.toml"
    path.write_text(toml_text(tables))
    try:
        made = str(Movement(**stated_movement(str(path))))
    except InputError as fault:
        made = str(fault)
        assert made.startswith(f"{path}: ")
    assert "\n" not in made


@pytest.mark.parametrize(("text", "told"), [
    ('left_alone = ["F1_ip_flexon"]\n[wanted_deg]\nF1_ip_flexion = 30',
     "left_alone: 'F1_ip_flexon' is no freedom of the hand; allowed: wrist_flexion, "),
    ("[wanted_dg]\nF1_ip_flexion = 30", "wanted_dg: unknown key; allowed: name, wanted_deg, left_alone; "
     "did you mean 'wanted_deg'?"),
    ("[wanted_deg]\nF1_ip_flexion = 0.0",
     "wanted_deg.F1_ip_flexion: 0; allowed: 1 to 180 deg, or -180 to -1"),
    ("[wanted_deg]\nF1_ip_flexion = nan",
     "wanted_deg.F1_ip_flexion: nan; allowed: 1 to 180 deg, or -180 to -1"),
    ('[wanted_deg]\nF1_ip_flexion = "a"', "wanted_deg.F1_ip_flexion: 'a' is no number; allowed: degrees"),
    ("wanted_deg = 3", "wanted_deg: 3 is no table; allowed: a table of freedoms, with degrees each"),
    ("[wanted_deg]", "wanted_deg: is empty; allowed: one or more freedoms that move"),
    ("", "wanted_deg: is missing; allowed: a table of freedoms, with degrees each; add it"),
    ('left_alone = ["F1_ip_flexion"]\n[wanted_deg]\nF1_ip_flexion = 30',
     "left_alone: 'F1_ip_flexion' is wanted, too; allowed: other freedoms; remove it from one of the two"),
    ('left_alone = "F1_ip_flexion"\n[wanted_deg]\nF1_ip_flexion = 30',
     "left_alone: 'F1_ip_flexion'; allowed: a list of freedoms"),
    ("[wanted_deg", "is not TOML: "),
])
def test_a_wrong_file_is_refused_in_one_line(text, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(text)
    assert main(["check", SEARCH, "--set", "movement=mine.toml"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"fesloop: {SEARCH}: blocks.search.movement: mine.toml: {told}")


@pytest.mark.parametrize(("given_name", "told"), [
    ("finger_openin", " (--set movement=finger_openin): 'finger_openin'; allowed: "
     f"{KNOWN}; did you mean 'finger_opening'?"),
    ("no.toml", ": no.toml: cannot be read: No such file or directory; allowed: a movement's file"),
    ("zzz", f" (--set movement=zzz): 'zzz'; allowed: {KNOWN}; or give the path"),
])
def test_an_unknown_name_is_refused_in_one_line(given_name, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["check", SEARCH, "--set", f"movement={given_name}"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"fesloop: {SEARCH}: blocks.search.movement{told}")


def test_the_file_reaches_search_and_score_and_a_users_experiment_names_it_from_its_folder(thumb, tmp_path):
    (tmp_path / "below").mkdir()
    (tmp_path / "below/own.toml").write_text(
        f'extends = "{SEARCH}"\n[blocks.search]\nmovement = "../thumb.toml"\n'
        '[score.search]\nmovement = "../thumb.toml"\n')
    movement = Movement(wanted_deg={"F1_cmc_abduction": 30.0}, left_alone=("F1_mcp_flexion",), name="thumb")
    for experiment in (fesloop.load(SEARCH, [f"movement={thumb}"]), fesloop.load("below/own.toml")):
        search = next(node.part for node in experiment.nodes if node.name == "search")
        assert search.movement == experiment.score.search.movement == movement
        assert search.space.zones == ()


def test_an_earlier_search_is_of_the_same_movement_or_refused(thumb):
    search = next(node.part for node in fesloop.load("array_search_gp", [f"movement={thumb}"]).nodes
                  if node.name == "search")
    responses = (EarlierResponse(elements=(16,), current_ma=10.0, quality=0.1),)
    make = type(search)
    same = EarlierSearch(movement=movement_text(stated_movement(thumb)), responses=responses)
    assert make(movement=search.movement, strategy="gaussian_process", space=search.space, earlier=same)
    with pytest.raises(InputError, match="is a search for pinch; allowed: one for thumb"):
        make(movement=search.movement, strategy="gaussian_process", space=search.space,
             earlier=EarlierSearch(movement="pinch", responses=responses))


@pytest.mark.slow
def test_a_run_holds_the_movement_and_is_repeated_and_reported_without_the_file(thumb, tmp_path, capsys):
    settings = [f"movement={thumb}", "strategy=semi_automatic", "duration_s=8"]
    first = fesloop.load(SEARCH, settings).run(tmp_path / "runs")
    (tmp_path / thumb).unlink()
    with Recording(first.recording) as recording:
        held = recording.experiment["blocks"]["search"]["movement"]
    assert held == {"name": "thumb", "left_alone": ["F1_mcp_flexion"],
                    "wanted_deg": {"F1_cmc_abduction": 30.0}}
    again = fesloop.load(str(first.recording)).run(tmp_path / "runs")
    assert json.dumps(again.metrics) == json.dumps(first.metrics)
    assert main(["report", str(first.recording)]) == 0
    assert " for thumb " in first.recording.with_suffix(".html").read_text()
