"""`fesloop picture` as a user meets it: files, exit codes, one line a mistake; some 20 s."""

import json
import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from matplotlib.image import imread

from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document, load
from fesloop.experiment.playback import Playback
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import run as run_experiment
from fesloop.show.picture.cast import cast_of
from fesloop.show.picture.courses import courses_figure

SMALL = str(Path(__file__).resolve().parent.parent / "experiment" / "small.toml")


def rows_of(file):
    """Names of the datasets that grow with the run."""
    found = []
    file.visititems(lambda name, item: found.append(name)
                    if isinstance(item, h5py.Dataset) and item.maxshape[:1] == (None,) else None)
    return found


def draw(capsys, *arguments):
    """(exit code, standard output, lines of standard error)."""
    code = main(["picture", *map(str, arguments)])
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    return code, captured.out, captured.err.splitlines()


@pytest.mark.slow
def test_pictures_are_drawn_without_a_display(grasp, tmp_path):
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "MPLBACKEND")}
    command = [sys.executable, "-m", "fesloop", "picture", grasp, "--at", "0.1", "0.45", "--out", tmp_path]
    done = subprocess.run([*command, "--json"], env=environment, capture_output=True, text=True, check=False)
    told = json.loads(done.stdout)
    assert done.returncode == 0
    assert told["instants_s"] == [0.1, 0.45]
    assert told["notes"] == []
    names = [Path(path).name.removeprefix(f"{grasp.stem}_") for path in told["pictures"]]
    assert names == ["hand.png", "arrays_0.100s.png", "arrays_0.450s.png", "courses.png"]
    for path in told["pictures"]:
        picture = imread(path)
        assert Path(path).stat().st_size > 20_000
        assert min(picture.shape[:2]) > 300
        # Not all of it white.
        assert (picture[..., :3].min(axis=-1) < 0.9).mean() > 0.02


@pytest.mark.slow
def test_without_instants_those_that_differ_most_are_drawn_and_said(capsys, recorded, tmp_path):
    path = recorded(
        'record.leave_out=["tracker.angles", "hand.object_position", "stimulator.element_charge"]')
    code, out, err = draw(capsys, path, "--out", tmp_path)
    assert code == 0
    assert err[-1].startswith("instants, s: 0, ")
    assert err[-1].endswith("(postures differ most)")
    assert any("object is not drawn: hand.object_position" in line for line in err)
    assert {Path(line) for line in out.splitlines()} == set(tmp_path.iterdir())


def killed(recording, path, rows, names=None):
    """A copy as a run that was killed leaves it, with so many rows in some of its streams, or in each."""
    path.write_bytes(recording.read_bytes())
    with h5py.File(path, "r+") as file:
        del file["status"]
        file["status"] = b"running"
        for name in names or rows_of(file):
            file[name].resize(rows, axis=0)
    return path


@pytest.mark.slow
def test_a_run_that_was_killed_is_drawn_up_to_its_end(capsys, grasp, tmp_path):
    path = killed(grasp, tmp_path / "killed.h5", 21, ("plants/hand", "plants/muscles"))
    code, out, _ = draw(capsys, path, "--at", "0.2", "--out", tmp_path, "--json")
    assert code == 0
    assert len(json.loads(out)["pictures"]) == 3


def test_a_recording_without_rows_is_one_line(capsys, grasp, tmp_path):
    """As a run that was killed before its first flush leaves it."""
    path = killed(grasp, tmp_path / "empty.h5", 0)
    code, out, err = draw(capsys, path, "--out", tmp_path / "pictures")
    assert (code, out, len(err)) == (2, "", 1)
    assert "empty.h5: holds no row of any trial (run running)" in err[0]
    with pytest.raises(InputError, match=r"recording: .* holds no row of any trial"):
        Playback(recording=str(path), signal="hand.angles")


@pytest.mark.parametrize(("arguments", "said"), [
    (("--at", "7"), "--at 7"), (("--at", "-1"), "--at -1"), (("--trial", "3"), "--trial 3"),
    (("--trial", "-1"), "--trial -1")])
def test_what_is_not_in_the_recording_is_one_line(capsys, grasp, tmp_path, arguments, said):
    code, out, err = draw(capsys, grasp, *arguments, "--out", tmp_path)
    assert (code, out, len(err)) == (2, "", 1)
    assert said in err[0]
    assert list(tmp_path.iterdir()) == []


def test_a_run_without_a_hand_is_drawn_as_time_courses(capsys, tmp_path):
    recording = run_experiment(load(SMALL), tmp_path / "runs").recording
    code, out, err = draw(capsys, recording, "--out", tmp_path / "pictures")
    assert (code, err) == (0, ["trial 1, counted from 0"])
    assert out.splitlines() == [str(path) for path in (tmp_path / "pictures").iterdir()]
    assert out.endswith("_courses.png\n")
    with Recording(recording) as opened:
        figure, notes = courses_figure(opened, cast_of(opened), 1, np.empty(0, np.int64), 10**9, "")
        angles, activation = (opened.signal(f"finger.{port}", 1) for port in ("angles", "activation"))
    truth = np.degrees(angles.values)
    assert notes == []
    by_title = {axes.get_title(loc="left"): axes for axes in figure.axes}
    assert list(by_title) == ["current", "pulse width", "activation of the most active muscles", *angles.rows]
    for joint in range(3):
        lines = {line.get_label(): line.get_ydata() for line in by_title[angles.rows[joint]].lines}
        assert set(lines) == {"truth", "reference"}
        assert np.array_equal(lines["truth"], truth[:len(lines["truth"]), joint])
    names = {line.get_label() for line in by_title["activation of the most active muscles"].lines}
    assert {name for name in names if not name.startswith("_")} <= set(activation.rows)  # not those of a hand


def test_a_recording_with_nothing_to_draw_names_the_report(capsys, tmp_path):
    document = {key: table for key, table in load(SMALL).document().items() if key != "score"}
    recording = run_experiment(from_document(document), tmp_path / "runs").recording
    code, out, err = draw(capsys, recording, "--out", tmp_path / "pictures")
    assert (code, out, len(err)) == (2, "", 1)
    assert err[0].endswith(f"`fesloop report {recording}` draws what else there is")
    assert not (tmp_path / "pictures").exists()


@pytest.mark.parametrize("content", [None, b"no HDF5"])
def test_what_is_no_recording_is_one_line(capsys, tmp_path, content):
    path = tmp_path / "run.h5"
    if content is not None:
        path.write_bytes(content)
    code, _, err = draw(capsys, path, "--out", tmp_path / "pictures")
    assert (code, len(err)) == (2, 1)


def test_a_folder_that_cannot_be_made_is_one_line(capsys, grasp, tmp_path):
    (tmp_path / "taken").write_text("")
    code, _, err = draw(capsys, grasp, "--out", tmp_path / "taken")
    assert (code, len(err)) == (2, 1)
    assert "--out" in err[0]


def test_the_command_line_starts_without_matplotlib():
    done = subprocess.run([sys.executable, "-c", "import sys, fesloop.apps.cli.picture_command; "
                           "print('matplotlib' in sys.modules, 'numba' in sys.modules)"],
                          capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


@pytest.mark.slow
def test_of_several_trials_the_last_is_drawn(recorded, capsys, tmp_path):
    """A first trial may be one without stimulation, before anything is learnt."""
    path = recorded("experiment.trials=2", "experiment.duration_s=0.1")
    code, out, _ = draw(capsys, path, "--at", "0.05", "--json", "--out", tmp_path)
    assert code == 0
    told = json.loads(out)
    assert told["trial"] == 1
    assert all("_trial1" in Path(picture).name for picture in told["pictures"])
