"""FMUs as plants: every version and interface, against what their equations say."""

import copy
import math
import pickle
import tempfile

import numpy as np
import pytest

from fesloop.errors import InputError, RunError, SnapshotError
from fesloop.loop.block import Context
from plants.fmu import Fmu
from plants.fmu.ports import FmuPort

LAG_S = 0.1


def run(plant, state, inputs, start=0):
    """Outputs at each communication point after the first under a list of inputs."""
    rows = []
    for tick, value in enumerate(inputs, start):
        plant.advance(state, value, plant.grid.tick(tick), plant.grid.tick(tick + 1))
        rows.append(plant.read(state, value))
    return rows


def lag_response(times):
    return 1.0 - np.exp(-np.asarray(times) / LAG_S)


@pytest.fixture
def no_folder_left(tmp_path, monkeypatch):
    """Nothing of an FMU may stay in the temporary folder, which is one of this test alone."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setenv("TMPDIR", str(folder))
    yield
    assert not list(folder.iterdir())


@pytest.mark.parametrize("rate", ["1000", "60", "2000/7"])
def test_c_co_simulation_follows_its_equation(small2, rate):
    plant = Fmu(path=str(small2()), step_rate=rate)
    state = plant.init(Context("plant"))
    rows = run(plant, state, [[1.0]] * 200)
    times = plant.grid.period_s * np.arange(1, 201)
    np.testing.assert_allclose([row[0] for row in rows], lag_response(times), rtol=0, atol=1e-12)
    assert [row[1] for row in rows] == list(range(1, 201))
    plant.close(state)


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_python_made_fmus_follow_their_equation(python_fmu, version):
    plant = Fmu(path=str(python_fmu(version)), step_rate="100")
    first, second = plant.init(Context("one")), plant.init(Context("two"))
    for k in range(100):
        plant.advance(first, [1.0], 0, 0)
        plant.advance(second, [-2.0], 0, 0)
        expected = lag_response(0.01 * (k + 1))
        assert plant.read(first, [1.0])[0] == pytest.approx(expected, abs=1e-12)
        assert plant.read(second, [1.0])[0] == pytest.approx(-2.0 * expected, abs=1e-12)
    plant.close(first)
    plant.close(second)


def test_fmi3_arrays_become_vector_ports(small3):
    plant = Fmu(path=str(small3()), step_rate="1000")
    assert [(port.name, port.shape) for port in (*plant.inputs, *plant.outputs)] == [("u", (3,)), ("y", (3,))]
    state = plant.init(Context("plant"))
    u = np.array([1.0, 2.0, -3.0])
    rows = run(plant, state, [[u]] * 50)
    np.testing.assert_allclose(rows[-1][0], u * lag_response(0.05), rtol=0, atol=1e-12)
    assert plant.read(state, [u])[0] is not plant.read(state, [u])[0]
    plant.close(state)


@pytest.mark.slow
@pytest.mark.parametrize("substeps", [1, 10])
def test_model_exchange_meets_a_time_event_exactly(small2, substeps):
    fmu = small2(kind="ModelExchange", states=1)
    plant = Fmu(path=str(fmu), step_rate="100", substeps=substeps)
    state = plant.init(Context("plant"))
    rows = run(plant, state, [[0.0]] * 20)
    times = 0.01 * np.arange(1, 21)
    expected = np.where(times <= 0.0505, times, 0.101 - times)
    np.testing.assert_allclose([row[0] for row in rows], expected, rtol=0, atol=1e-14)
    plant.close(state)


def bounce(time_s):
    """Height of a ball dropped from 1 m that keeps 0.8 of its speed."""
    start, speed, gravity = math.sqrt(2 / 9.81), 0.8 * math.sqrt(2 * 9.81), 9.81
    if time_s < start:
        return 1.0 - 0.5 * gravity * time_s**2
    while time_s >= start + 2 * speed / gravity:
        start, speed = start + 2 * speed / gravity, 0.8 * speed
    since = time_s - start
    return speed * since - 0.5 * gravity * since**2


@pytest.mark.slow
def test_model_exchange_meets_state_events(small2):
    plant = Fmu(path=str(small2("BALL", kind="ModelExchange", indicators=1, states=2)), step_rate="100")
    state = plant.init(Context("plant"))
    rows = run(plant, state, [[0.0]] * 250)
    np.testing.assert_allclose([row[0] for row in rows], [bounce(0.01 * k) for k in range(1, 251)],
                               rtol=0, atol=1e-9)
    plant.close(state)


@pytest.mark.slow
@pytest.mark.parametrize("interface", ["co_simulation", "model_exchange"])
@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda state: pickle.loads(pickle.dumps(state))])
def test_a_saved_finger_goes_on_as_if_nothing_had_happened(finger_fmu, interface, duplicate, no_folder_left):
    plant = Fmu(path=str(finger_fmu), step_rate="500", interface=interface, substeps=4)
    state = plant.init(Context("plant"))
    rng = np.random.default_rng(5)
    pulses = [[rng.uniform(0, (0.04, 4e-4), (4, 2))] for _ in range(20)]
    inputs = [pulses[k // 10] for k in range(200)]
    run(plant, state, inputs[:97])
    ahead = duplicate(state)
    through = run(plant, state, inputs[97:], 97)
    again = run(plant, ahead, inputs[97:], 97)
    assert np.abs(through[-1][0]).max() > 0.1
    for one, other in zip(through, again, strict=True):
        for port in range(len(plant.outputs)):
            np.testing.assert_array_equal(one[port], other[port])
    plant.close(state)
    plant.close(ahead)
    del plant, state, ahead


def test_fmi3_state_is_saved_too(small3):
    plant = Fmu(path=str(small3()), step_rate="100")
    state = plant.init(Context("plant"))
    u = np.array([1.0, 2.0, 3.0])
    run(plant, state, [[u]] * 10)
    twin = pickle.loads(pickle.dumps(state))
    np.testing.assert_array_equal(run(plant, state, [[2 * u]], 10), run(plant, twin, [[2 * u]], 10))
    plant.close(state)
    plant.close(twin)


@pytest.mark.parametrize(("definitions", "state", "reason"), [
    (("FORGETS",), None, "did not give the same outputs"), ((), "", "does not offer it")])
def test_what_does_not_replay_is_not_saved(small2, definitions, state, reason):
    fmu = small2(*definitions) if state is None else small2(*definitions, state=state)
    plant = Fmu(path=str(fmu), step_rate="100")
    running = plant.init(Context("plant"))
    assert not plant.can_snapshot
    with pytest.raises(SnapshotError, match=f"plant: .*cannot be saved: .*{reason}"):
        pickle.dumps(running)
    plant.close(running)


@pytest.mark.parametrize(("definition", "words"), [
    ("ERROR_AT_S=0.05", "fmi2DoStep returned fmi2Error at 0.05 s: dry at 0.050 s"),
    ("DISCARD_AT_S=0.05", "fmi2DoStep returned fmi2Discard at 0.05 s"),
    ("DISCARD_AT_S=0.05 ENDS TELLS", "the FMU requested the end of the run at 0.05 s")])
def test_a_failure_in_mid_run_names_time_and_message(small2, definition, words, no_folder_left, capfd):
    plant = Fmu(path=str(small2(*definition.split())), step_rate="100")
    state = plant.init(Context("tank"))
    with pytest.raises(RunError, match=f"tank: {words}"):
        run(plant, state, [[1.0]] * 10)
    plant.close(state)
    del state, plant
    assert capfd.readouterr().out == ""


@pytest.mark.slow
def test_messages_reach_the_instance_they_are_from(small2):
    plants = [Fmu(path=str(small2(f"ERROR_AT_S={at}")), step_rate="100") for at in ("0.02", "0.03")]
    states = [plant.init(Context(f"node{i}")) for i, plant in enumerate(plants)]
    for plant, state, at in zip(plants, states, ("0.020", "0.030"), strict=True):
        with pytest.raises(RunError, match=f"dry at {at} s$"):
            run(plant, state, [[1.0]] * 10)
        plant.close(state)


@pytest.mark.slow
def test_the_plant_itself_can_be_sent_to_another_process(small2, no_folder_left):
    plant = Fmu(path=str(small2()), step_rate="100")
    sent = pickle.loads(pickle.dumps(plant))
    rows = []
    for each in (plant, sent):
        state = each.init(Context("plant"))
        rows.append(run(each, state, [[1.0]] * 5))
        each.close(state)
    assert rows[0] == rows[1]
    del plant, sent, each, state


@pytest.mark.slow
def test_next_trial_starts_anew(small2):
    plant = Fmu(path=str(small2()), step_rate="100")
    state = plant.init(Context("plant"))
    first = run(plant, state, [[1.0]] * 5)
    state = plant.next_trial(state, Context("plant", trial=1))
    assert run(plant, state, [[1.0]] * 5) == first
    plant.close(state)
    plant.close(state)


def test_declared_ports_group_and_scale(finger_fmu):
    plant = Fmu(
        path=str(finger_fmu),
        input_ports=(FmuPort(name="flexor", variables=("stimulation[1,1]", "stimulation[1,2]"), unit="A,s"),),
        output_ports=(FmuPort(name="mcp_deg", variables=("angles[1]",), unit="deg", scale=math.pi / 180),
                      FmuPort(name="pip_dip", variables=("angles[2]", "angles[3]"))))
    assert [(port.name, port.shape, port.unit) for port in plant.outputs] == [
        ("mcp_deg", (), "deg"), ("pip_dip", (2,), "rad")]
    state = plant.init(Context("plant"))
    mcp, rest = plant.read(state, [])
    assert mcp == pytest.approx(20.0)
    np.testing.assert_allclose(rest, np.deg2rad([25.0, 15.0]))
    run(plant, state, [[np.array([0.03, 3e-4])]] * 100)
    assert plant.read(state, [])[0] > 21.0
    plant.close(state)


@pytest.mark.slow
def test_start_values_reach_the_fmu(finger_fmu):
    pulse = [np.tile([0.05, 4e-4], (4, 1))]
    angles, activations = [], []
    for gain in (1.0, 2.0):
        starts = {f"gain_{muscle}": gain for muscle in ("fdp", "fds", "edc", "int")}
        plant = Fmu(path=str(finger_fmu), starts=starts)
        state = plant.init(Context("plant"))
        values = run(plant, state, [pulse] * 300)[-1]
        angles.append(values[0] - np.deg2rad([20.0, 25.0, 15.0]))
        activations.append(values[3])
        plant.close(state)
    assert activations[0].min() > 0.01
    np.testing.assert_allclose(activations[1], activations[0], rtol=1e-12)
    np.testing.assert_allclose(angles[1], 2.0 * angles[0], rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("rate", "substeps", "fits"), [
    ("1000", 5, True), ("80", 5, False), ("80", 100, True)])
def test_model_exchange_with_substeps_too_long_is_refused(finger_fmu, rate, substeps, fits):
    def made():
        return Fmu(path=str(finger_fmu), interface="model_exchange", step_rate=rate, substeps=substeps)

    if fits:
        assert made().cautions(Context("plant")) == ()
        return
    with pytest.raises(InputError, match="substeps: 5 are too few"):
        made()
