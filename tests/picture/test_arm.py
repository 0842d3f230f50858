"""Pictures of an arm in a device, read from the figures themselves."""

import numpy as np
import pytest

from fesloop.apps.cli import main
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import run
from fesloop.hand.muscle_paths import JOINTS
from fesloop.show.picture.arm import arm_figure, arm_of


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Run three seconds of the bench with settings; the recording's path."""
    def record(*settings):
        experiment = load("arm_bench", ("experiment.duration_s=3", *settings))
        return run(experiment, tmp_path_factory.mktemp("runs")).recording

    return record


def panels(figure):
    """Lines with a label of each panel, by the panel's title; the last of equal titles."""
    return {axes.get_title(loc="left"): {line.get_label(): line.get_xydata() for line in axes.lines}
            for axes in figure.axes if axes.get_visible()}


def test_shows_torque_of_muscles_and_as_the_device_reads_it(bench):
    with Recording(bench()) as recording:
        assert arm_of(recording) == "arm"
        figure = arm_figure(recording, "arm", 0, np.array([1_500_000_000]), 3_000_000_000, "arm_bench")
        evoked, device = (np.asarray(recording.signal(f"arm.{port}").values) for port in ("evoked", "device"))
        shown = panels(figure)
    elbow = shown["elbow flexion"]
    assert elbow["of the muscles"][:, 1].max() == pytest.approx(evoked[:, 0].max())
    assert elbow["as the device reads it"][:, 1].max() == pytest.approx(-device[:, 0].min())
    # what friction hides: .36 N m of the elbow
    assert evoked[:, 0].max() - elbow["as the device reads it"][:, 1].max() == pytest.approx(0.36)
    widths = shown["pulse width at 65 mA"]
    assert max(line[:, 1].max() for line in widths.values()) == pytest.approx(31.0)
    assert "biceps" in shown["activation"]
    curve = max((line for line in shown["activation over pulse width"].values()), key=len)
    assert {19.0, 31.0} <= set(curve[:, 0].round(6))
    loop = max((line for line in shown["read over that of the muscles"].values()), key=len)
    drawn = [joint for joint in JOINTS if joint.replace("_", " ") in shown]
    j = JOINTS.index(drawn[-1])
    assert loop == pytest.approx(np.column_stack([evoked[:, j], -device[:, j]]))


def test_without_friction_the_device_reads_the_muscles(bench):
    with Recording(bench("friction_nm=[0, 0, 0, 0]")) as recording:
        elbow = panels(arm_figure(recording, "arm", 0, np.array([]), 3_000_000_000, ""))["elbow flexion"]
    assert elbow["as the device reads it"] == pytest.approx(elbow["of the muscles"], abs=1e-6)


def test_joints_without_torque_are_named_in_small_print(bench):
    with Recording(bench("blocks.arm.electrodes=['triceps']", "current_ma=[[1]]")) as recording:
        figure = arm_figure(recording, "arm", 0, np.array([]), 3_000_000_000, "")
    assert len([title for title in panels(figure) if title.replace(" ", "_") in JOINTS]) == 1
    assert any(text.get_text().startswith("below 0.005 N m: ") for text in figure.texts)


def test_command_draws_an_arm(bench, tmp_path, capsys):
    recording = str(bench())
    assert main(["picture", recording, "--out", str(tmp_path), "--at", "1.5"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["arm_bench-1_arm.png"]
    capsys.readouterr()
    assert main(["picture", recording, "--out", str(tmp_path), "--at", "99"]) == 2
    assert "--at 99: is not in what is recorded of trial 0" in capsys.readouterr().err
