"""Tests of unfitted members in the experiment of recorded people: arm, device, and comparison."""

import mujoco
import numpy as np
import pytest
from stimulation_parts import wrist_recording

from fesloop.analysis.people.pads import Forearm, HeldWrist, Pads
from fesloop.apps.reproduce.people import unfitted
from fesloop.apps.reproduce.people.unfitted import Evoked, compared, evoked_of, passed
from fesloop.experiment.registry import patient_reader
from fesloop.hand.movements import MUSCLES, muscle
from plants.hand.model import ADULT_MM, muscles

ELECTRODES = tuple(Pads().muscles)


def test_means_and_changes_with_posture_are_of_cells_without_the_scatter_of_repeats():
    def torque(signs, repeats, _):
        scatter = np.where(repeats == 0, -0.3, 0.3)
        return np.column_stack([scatter * 0, scatter * 0, 1.0 + 0.4 * signs[:, 1] + scatter, signs[:, 2]])

    recording = wrist_recording(torque)
    found = evoked_of(recording, recording.steady.evoked_nm[:, 2:], ELECTRODES)
    assert found.mean[0] == pytest.approx([1.0, 0.0], abs=1e-12)
    # .4 over eight postures, half of which are + and half -; repeats of variance .18 average to .09 a cell
    assert found.change[0] == pytest.approx([np.sqrt(8 / 7 * 0.16 - 0.09), np.sqrt(8 / 7)])
    assert np.isnan(found.mean[1:]).all()
    shown = unfitted.postures_shown()
    assert found.by_posture[0, :, 0] == pytest.approx([1.0 + 0.4 * w for _, w, _ in shown])
    assert found.by_posture[0, :, 1] == pytest.approx([r for _, _, r in shown])


def test_friction_hides_what_it_would_hide_in_the_order_of_the_trials():
    torque = np.array([[0.02, 0.02], [-0.5, 0.0], [1.0, 0.0], [0.01, 0.0], [0.2, -0.2]])
    visit, order = np.array([0, 0, 0, 1, 1]), np.array([1, 2, 0, 0, 1])
    found = passed(torque, visit, order)
    # visit 0: 1.0 reads .97; on the way back to 0 it stays at .03, where .02 leaves it; then -.5 reads -.47
    assert found[:, 0] == pytest.approx([0.03, -0.47, 0.97, 0.0, 0.17])
    assert found[:, 1] == pytest.approx([0.0, 0.0, 0.0, 0.0, -0.17])


def member(number):
    return patient_reader().load("able_bodied").member(cohort=1, number=number)


def forearm_of(number, **pads):
    return Forearm(member(number), Pads(**pads), np.random.default_rng(number))


@pytest.fixture(scope="module")
def wrist():
    return HeldWrist(member(3))


def test_pulses_of_a_pad_recruit_alone_and_alike():
    arm = forearm_of(3)
    given = (0, 0.025, 2e-4, 40.0, 0.0)
    weak, strong = arm.recruitment(0, 1e-4, 2e-4, 40.0, 0.0)[0], arm.recruitment(0, 2.0, 1e-3, 40.0, 0.0)[0]
    assert not weak.any()
    assert strong[muscle("FCR")] == pytest.approx(1.0)
    first, hertz = arm.recruitment(*given)
    elsewhere, _ = arm.recruitment(3, *given[1:])
    again, _ = arm.recruitment(*given)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, elsewhere)
    assert first[muscle("FCR")] > 0.0
    assert hertz[muscle("FCR")] == pytest.approx(40.0)


def test_pads_without_error_are_over_the_persons_own_motor_points():
    block = forearm_of(5, error_mm=0.0).block
    points = {point.muscle: (np.deg2rad(point.around_deg) * block.radius_mm, point.along_mm)
              for point in member(5).electrodes(4)["motor_points"]}
    points["ECRL"] = tuple(np.mean([points[name] for name in ("ECRL", "ECRB", "EDC2", "EDC3")], axis=0))
    expected = [points[name] for name in ("FCR", "PL", "FCU", "ECRL")]
    assert block.places[:, :2] == pytest.approx(np.array(expected))
    assert block.places[:, 2] == pytest.approx(12.0)
    near, far = ([forearm_of(number, error_mm=mm).block.places for number in range(8)] for mm in (0.0, 4.0))
    assert 3.0 < np.subtract(far, near)[:, :, :2].std() < 5.0


def test_torque_is_tendon_force_times_moment_arm(wrist):
    """Both moments are one force times minus the slopes of the length of MuJoCo's tendon."""
    activation = np.zeros(len(MUSCLES))
    activation[muscle("FCR")] = 0.4
    flexion, radial = 0.3, -0.1
    found = wrist.torque_nm(activation, flexion, radial)
    model = wrist.hand.model
    data, tendon = mujoco.MjData(model), model.tendon("FCR").id
    places = [model.joint(joint).qposadr[0] for joint in ("wrist_flexion", "wrist_abduction")]

    def length(place, change):
        data.qpos[places] = flexion, -radial
        data.qpos[place] += change
        mujoco.mj_forward(model, data)
        return data.ten_length[tendon]

    slopes = [(length(place, 1e-4) - length(place, -1e-4)) / 2e-4 for place in places]
    forces = np.array([-found[0] / slopes[0], found[1] / slopes[1]])
    assert forces[0] == pytest.approx(forces[1], rel=1e-4)
    strength = dict(zip(MUSCLES, wrist.hand.strength, strict=True))["FCR"]
    largest = muscles(wrist.hand.hand.hand_mm / ADULT_MM)[muscle("FCR")].force_n * strength
    assert 0.25 * largest < forces[0] < 0.4 * largest
    assert found[0] > 0.1


def test_steady_activation_is_that_of_40_hz(wrist):
    recruited = np.zeros(len(MUSCLES))
    recruited[3] = 0.5
    activation = wrist.activation(recruited, np.full(len(MUSCLES), 40.0))
    fusion = wrist.muscles.fusion_hz
    assert activation[3] == pytest.approx(0.5 * 40.0**2 / (40.0**2 + fusion**2), rel=1e-4)
    assert not np.delete(activation, 3).any()


def test_a_member_is_read_as_a_person_is():
    """Without pulses the member evokes nothing; with strong ones FCR flexes, and repeats are alike."""
    nothing = wrist_recording(lambda signs, *_: np.zeros((len(signs), 4)), width_s=1e-6)
    assert not unfitted.simulated(nothing, 0, Pads()).mean[0].any()
    strong = wrist_recording(lambda signs, *_: np.zeros((len(signs), 4)), current_a=0.1, width_s=5e-4)
    found = unfitted.simulated(strong, 0, Pads())
    assert found.mean[0, 0] > 0.5
    assert np.isnan(found.mean[1:]).all()
    assert 0.0 < found.recruited[0, muscle("FCR")] <= 1.0


def evoked(flexion, radial, change):
    """Ones with a mean of all electrodes, and their change with posture."""
    mean = np.tile([flexion, radial], (4, 1))
    return Evoked(mean, np.full((4, 2), change), np.zeros((4, 8, 2)), np.zeros((4, len(MUSCLES))))


@pytest.mark.parametrize(("scale", "radial", "change", "spread", "failing"), [
    (1.9, 0.5, 0.7, 1.4, []), (2.1, 0.5, 0.7, 1.4, ["mean"]), (0.45, 0.2, 0.7, 1.4, ["mean"]),
    (-1.0, 0.5, 0.7, 1.0, ["mean"]), (1.0, 1.1, 0.7, 1.0, ["over flexion"]),
    (1.0, 0.5, 0.29, 1.0, ["over mean"]), (1.0, 0.5, 0.7, 1.6, ["ours over theirs"]),
    (1.0, 0.5, 0.7, 0.6, ["ours over theirs"])])
def test_bars(scale, radial, change, spread, failing):
    theirs = [evoked(1.0 + off, 0.1, 0.5) for off in (-0.2, 0.0, 0.2)]
    ours = [evoked(scale + spread * off, radial, change) for off in (-0.2, 0.0, 0.2)]
    rows = compared(theirs, ours, Pads()).rows
    assert len(rows) == 15
    broken = {row.row for row in rows if not row.holds}
    assert all(any(name in row for name in failing) for row in broken)
    assert all(any(name in row for row in broken) for name in failing)
    if failing == ["mean"]:
        assert {row.split(":")[0] for row in broken} == {"FCR", "PL", "ECRL"}


def test_members_who_evoke_nothing_fail_and_muscles_that_nobody_has_are_left_out():
    theirs = [evoked(1.0, 0.1, 0.5), evoked(1.2, 0.1, 0.5)]
    nothing = compared(theirs, [evoked(0.0, 0.0, 0.0)] * 2, Pads()).rows
    assert {row.holds for row in nothing if "no bar" not in str(row.theirs)} == {False}
    for each in theirs:
        each.mean[2] = np.nan
    assert not [row for row in compared(theirs, theirs, Pads()).rows if row.row.startswith("FCU")]
    alone = compared(theirs[:1], theirs, Pads()).rows
    assert all(row.holds for row in alone)
    assert not [row for row in alone if "ours over theirs" in row.row]


@pytest.mark.slow
def test_people_have_the_torques_that_another_script_finds(recordings):
    """The means and spreads over five people, of an independent script on the same recordings."""
    found = unfitted.part(recordings / "fes_exo", 0)
    theirs = {row.row: row.theirs for row in found.rows}
    assert theirs["FCR: flexion, mean (sd over people)"].startswith("+0.085 (0.070)")
    assert theirs["ECRL: flexion, mean (sd over people)"].startswith("-0.139 (0.075)")
    assert theirs["FCU: radial deviation, mean (sd over people)"].startswith("+0.004 (0.006)")
    assert theirs["PL: flexion, sd over postures over mean"].startswith("0.68")
    radius = dict(found.sweeps["unfitted_pads"].rows)
    smaller, greater = (np.array(radius[f"pads of {mm} mm radius"]) for mm in (10, 14))
    assert (smaller > greater).all()
    assert found.curves["unfitted"]["ours_nm"].shape == (unfitted.MEMBERS, 4, 2)
    # The preset's recruitment is set by these people; without its change with pronation a bar is missed.
    assert [row.row for row in found.rows if not row.holds] == []
