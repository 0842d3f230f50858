"""Films: what is in them, that they keep time, and what is refused in one line."""

import json
import os
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import fesloop
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.show.film.film import Cut, film
from fesloop.show.film.panel import Channel, Panel
from fesloop.show.film.stage import GHOST, PAPER, SKIN, Stage, drawing_surface
from fesloop.show.film.writers import writer_of
from fesloop.show.picture.hand_mesh import Mesh
from fesloop.show.report.parts import Solid

SIZE = {"width": 480, "height": 270}
CORNERS = np.stack(np.meshgrid(*[(-0.02, 0.02)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
CUBE = Mesh(vertices=CORNERS, faces=np.array(
    [[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]], dtype=np.int32))
HERE = np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    settings = {"control": "pid", "latency_ms": 50, "experiment.duration_s": 2}
    folder = tmp_path_factory.mktemp("runs")
    return Path(fesloop.run("finger_control", settings, seed=3, out=folder).recording)


def at(*place):
    """Pose of one body at a place, m."""
    return np.array([[1.0, 0.0, 0.0, 0.0, *place]])


def colours(picture):
    """Mean colour of a picture's middle, of 0 to 1."""
    height, width, _ = picture.shape
    middle = picture[height // 2 - 8:height // 2 + 8, width // 2 - 8:width // 2 + 8]
    return middle.reshape(-1, 3).mean(axis=0) / 255.0


@contextmanager
def surface():
    """A surface to draw on. Without OpenGL tests are skipped: the README's need no package of Debian."""
    with ExitStack() as stack:
        try:
            stack.enter_context(drawing_surface(160, 120))
        except InputError as fault:
            pytest.skip(str(fault))
        yield


@pytest.fixture
def stage():
    with surface():
        made = Stage({"truth": [CUBE], "estimate": [CUBE]},
                     [Solid(kind="box", half_sizes=(0.01, 0.01, 0.01), role="object", moves=True)], 160, 120)
        made.look((0.0, 1.0, -0.5), np.zeros(3), 0.2, 0.15)
        yield made
        made.close()


def test_a_hand_is_seen_where_it_is_and_not_where_its_pose_is_unknown(stage):
    nowhere = np.full((1, 7), np.nan)
    seen = colours(stage.picture({"truth": HERE}, nowhere))
    assert seen[0] > seen[1] > seen[2]
    empty = stage.picture({"truth": nowhere}, nowhere)
    assert np.abs(empty / 255.0 - PAPER).max() < 0.01
    assert np.abs(stage.picture({}, nowhere) / 255.0 - PAPER).max() < 0.01


def test_an_estimate_that_coincides_leaves_the_true_hand_as_it_is_and_one_beside_it_is_orange(stage):
    nowhere = np.full((1, 7), np.nan)
    alone = colours(stage.picture({"truth": HERE}, nowhere))
    both = colours(stage.picture({"truth": HERE, "estimate": HERE}, nowhere))
    assert np.abs(both - alone).max() < 0.1
    aside = at(0.15, 0.0, 0.0)
    beside = colours(stage.picture({"truth": aside, "estimate": HERE}, nowhere))
    assert beside[0] - beside[2] > 0.3
    assert beside[2] > GHOST[2] + 0.1, "the paper behind it is seen"


def test_an_object_hides_the_estimate_but_for_a_tint(stage):
    before = at(0.0, -0.05, 0.025)
    far = at(5.0, 0.0, 0.0)
    seen = colours(stage.picture({"truth": far, "estimate": HERE}, before))
    assert seen[2] > seen[0], "the object is blue"


def test_without_a_true_hand_the_estimate_is_solid():
    with surface():
        alone = Stage({"estimate": [CUBE]}, [], 160, 120)
        alone.look((0.0, 1.0, -0.5), np.zeros(3), 0.2, 0.15)
        seen = colours(alone.picture({"estimate": HERE}, np.empty((0, 7))))
        alone.close()
    assert seen[0] > 2.0 * seen[2]


def test_nothing_that_draws_is_one_line(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "glfw")
    monkeypatch.setitem(sys.modules, "mujoco.glfw", None)
    with pytest.raises(InputError, match=r"nothing draws in three dimensions.*EGL or OSMesa"), \
            drawing_surface(64, 64):
        pass


@pytest.mark.slow
def test_an_opengl_that_is_not_installed_is_one_line(path, tmp_path):
    """In a process of its own: MuJoCo is imported once. (This name is unknown to every version of MuJoCo.)"""
    script = f"from fesloop.apps.cli import main; raise SystemExit(main(['film', {str(path)!r}]))"
    done = subprocess.run([sys.executable, "-c", script], check=False, capture_output=True, text=True,
                          env={**os.environ, "MUJOCO_GL": "nothing"}, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("fesloop: MUJOCO_GL=nothing: MuJoCo cannot load this OpenGL")
    assert done.stderr.count("\n") == 1


def channel(number=2):
    return Channel(number=number, times_s=np.array([0.0, 1.0]), current_ma=np.array([0.0, 20.0]),
                   width_us=np.array([300.0, 250.0]))


def test_a_channel_holds_its_pulses_until_the_next():
    one = channel()
    assert one.charge_uc.tolist() == [0.0, 5.0]
    assert one.at(0.99) == (0.0, 300.0)
    assert one.at(1.0) == (20.0, 250.0)
    assert one.at(-1.0) == (0.0, 0.0)


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (480, 270), (720, 1280)])
def test_the_hand_has_a_place_of_its_own_and_texts_move_with_time(width, height):
    panel = Panel(width, height, "a run", "trial 0", [("#ff0000", "true hand")], [channel()], (0.0, 2.0))
    left, top, wide, high = panel.hand
    hand = np.full((high, wide, 3), 7, dtype=np.uint8)
    early, late = panel.around(hand, 0.5), panel.around(hand, 1.5)
    assert early.shape == (height, width, 3)
    assert (early[top:top + high, left:left + wide] == 7).all()
    assert (early != late).any()
    assert (panel.around(hand, 0.5) == early).all(), "nothing is left of a later instant"


def test_a_hand_without_stimulation_takes_the_whole_width():
    assert Panel(640, 360, "a run", "", [], [], (0.0, 1.0)).hand.width == 640


def test_a_gif_keeps_time_at_any_rate(tmp_path):
    shades = [np.full((24, 32, 3), 30 * i, dtype=np.uint8) for i in range(7)]
    writer_of(tmp_path / "a.gif")(tmp_path / "a.gif", iter(shades), Fraction(30))
    with Image.open(tmp_path / "a.gif") as found:
        durations = []
        for number in range(found.n_frames):
            found.seek(number)
            durations.append(found.info["duration"])
    assert len(durations) == 7
    assert set(durations) == {30, 40}
    assert sum(durations) == pytest.approx(7000 / 30, abs=10)


@pytest.mark.slow
def test_an_mp4_shows_the_trial_in_the_time_asked_for(path, tmp_path):
    av = pytest.importorskip("av")
    with surface():
        pass
    out = fesloop.film(path, tmp_path / "talk.mp4", from_s=0.5, until_s=1.5, fps=10, size=(480, 270),
                       speed=0.5)
    with av.open(str(out)) as file:
        stream = file.streams.video[0]
        pictures = [each.to_ndarray(format="rgb24") for each in file.decode(stream)]
        assert stream.average_rate == 10
    assert len(pictures) == 21, "both ends, at half the speed"
    assert pictures[0].shape == (270, 480, 3)
    assert (pictures[0] != pictures[-1]).any()
    hand = pictures[10][60:240, :280].reshape(-1, 3) / 255.0
    assert (np.abs(hand - SKIN).max(axis=1) < 0.25).mean() > 0.05, "a hand fills some of its place"
    assert [each.name for each in tmp_path.iterdir()] == ["talk.mp4"]


@pytest.mark.slow
def test_the_command_says_what_it_filmed(path, tmp_path, capsys):
    with surface():
        pass
    out = tmp_path / "new" / "talk.gif"
    assert main(["film", str(path), "--out", str(out), "--until", "0.3", "--fps", "10", "--size", "480x270",
                 "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["film"] == str(out)
    assert (told["trial"], told["from_s"], told["pictures"]) == (0, 0.0, 4)
    assert told["notes"] == []
    with Image.open(out) as found:
        assert found.size == (480, 270)


@pytest.mark.parametrize(("cut", "message"), [
    (Cut(trial=3), r"--trial 3: is not in the recording; allowed: 0"),
    (Cut(from_s=5.0), r"--from 5: is not in what is recorded of trial 0; allowed: 0 to 1\.\d+ s"),
    (Cut(until_s=-1.0), r"--until -1: is not in what is recorded"),
    (Cut(from_s=1.0, until_s=0.5), r"--until 0\.5: is not after --from 1"),
    (Cut(from_s=float("nan")), r"--from nan: is not in what is recorded"),
    (Cut(fps=0.0), r"--fps 0: is no rate of a film \.gif; allowed: 1 to 50"),
    (Cut(fps=float("nan")), r"--fps nan"),
    (Cut(speed=0.0), r"--speed 0: is too slow or too fast; allowed: 0\.01 to 100"),
    (Cut(width=641), r"--size 641x720: 641 pixels; allowed: even numbers from 240"),
    (Cut(height=100), r"--size 1280x100: 100 pixels"),
])
def test_what_cannot_be_filmed_is_refused_before_anything_is_drawn(path, tmp_path, cut, message):
    with fesloop.Recording(path) as recording, pytest.raises(InputError, match=message):
        film(recording, tmp_path / "a.gif", cut)
    assert not any(tmp_path.iterdir())


def test_a_film_too_long_for_anybody_is_refused(path, tmp_path):
    with fesloop.Recording(path) as recording, pytest.raises(InputError, match=r"at most 20000; give --from"):
        film(recording, tmp_path / "a.mp4", Cut(speed=0.01, fps=120.0, until_s=1.9))


@pytest.mark.parametrize(("name", "message"), [
    ("a.avi", r"\.avi is no format of films; allowed: \.mp4 or \.gif; name it a\.mp4"),
    ("a", r"no suffix is no format of films"),
])
def test_other_formats_are_refused(tmp_path, name, message):
    with pytest.raises(InputError, match=message):
        writer_of(tmp_path / name)


def test_without_pyav_it_is_said_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(InputError, match=r"PyAV.*not installed.*pip install 'fesloop\[film\]'"):
        writer_of(tmp_path / "a.mp4")
    assert writer_of(tmp_path / "a.gif")


def test_a_place_that_cannot_be_written_is_refused(path, tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.gif").mkdir()
    with fesloop.Recording(path) as recording:
        with pytest.raises(InputError, match=r"--out .*cannot be written"):
            film(recording, tmp_path / "file" / "a.gif", Cut(**SIZE))
        with pytest.raises(InputError, match=r"is a folder; allowed: a file that ends in"):
            film(recording, tmp_path / "folder.gif", Cut(**SIZE))


def test_a_run_without_a_hand_is_refused(path, tmp_path, monkeypatch):
    monkeypatch.setattr("fesloop.show.film.film.hand_of", lambda recording: None)
    with fesloop.Recording(path) as recording, \
            pytest.raises(InputError, match=r"has no hand to film; allowed: a recording of a hand"):
        film(recording, tmp_path / "a.gif", Cut())


@pytest.mark.parametrize("size", ["big", "640", "x480", "640x480x3", "-640x480"])
def test_a_size_is_two_numbers(path, capsys, size):
    assert main(["film", str(path), f"--size={size}"]) == 2
    assert capsys.readouterr().err == (f"fesloop: --size {size}: is no size of a picture; "
                                       "allowed: WIDTHxHEIGHT, such as 1280x720\n")
