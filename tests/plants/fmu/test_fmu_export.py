"""The finger as an FMU is the finger: both interfaces, sources and binary, against the state-space plant."""

import shutil
import subprocess
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.c_code import build
from fesloop.errors import InputError, RunError
from fesloop.loop.block import Context
from plants.finger import Finger
from plants.fmu import Fmu
from plants.fmu.export import build_finger_fmu
from plants.muscles.lags import Fatigue

PORTS = ("angles", "rates", "accelerations", "activation")


def pulses(seed, count):
    """Stimulation (4, 2) that moves the finger about, in A and s."""
    return np.random.default_rng(seed).uniform(0.0, (0.04, 4e-4), (count, 4, 2))


def largest_differences(finger, plant, hold, ticks, seed=0):
    """Largest difference of each output over a run in which stimulation changes every `hold` ticks."""
    exact, state = finger.init(Context("finger")), plant.init(Context("fmu"))
    inputs = list(pulses(seed, ticks // hold + 1))
    largest, size = np.zeros(4), np.zeros(4)
    for k in range(ticks):
        held = [inputs[k // hold]]
        span = plant.grid.tick(k), plant.grid.tick(k + 1)
        finger.advance(exact, held, *span)
        plant.advance(state, held, *span)
        for port, (a, b) in enumerate(zip(finger.read(exact, held), plant.read(state, held), strict=True)):
            largest[port] = max(largest[port], np.abs(a - b).max())
            size[port] = max(size[port], np.abs(a).max())
    plant.close(state)
    return dict(zip(PORTS, largest, strict=True)), dict(zip(PORTS, size, strict=True))


def test_ports_are_those_of_the_finger(finger_fmu):
    plant, finger = Fmu(path=str(finger_fmu)), Finger()
    described = [[(port.name, port.shape, port.unit) for port in (*each.inputs, *each.outputs)]
                 for each in (plant, finger)]
    assert described[0] == described[1]


@pytest.mark.slow
def test_co_simulation_is_the_finger_over_ten_seconds(finger_fmu):
    differences, size = largest_differences(Finger(), Fmu(path=str(finger_fmu)), hold=20, ticks=10_000)
    assert size["angles"] > 0.5
    assert differences["angles"] < 1e-9
    assert differences["rates"] < 1e-9
    assert differences["activation"] < 1e-9
    assert differences["accelerations"] < 1e-9


@pytest.mark.slow
def test_model_exchange_is_the_finger_over_ten_seconds(finger_fmu):
    plant = Fmu(path=str(finger_fmu), interface="model_exchange")
    differences, size = largest_differences(Finger(), plant, hold=20, ticks=10_000)
    assert size["angles"] > 0.5
    assert differences["angles"] < 1e-9
    assert differences["rates"] < 1e-9
    assert differences["activation"] < 1e-9
    assert differences["accelerations"] < 1e-9


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(rate=st.sampled_from(["200", "125", "333.333", "60", "2000/7", "4000"]), hold=st.integers(1, 7),
       seed=st.integers(0, 2**16))
def test_a_delay_that_ends_within_a_step_is_exact(delayed_fmu, rate, hold, seed):
    finger, path = delayed_fmu
    differences, _ = largest_differences(finger, Fmu(path=str(path), step_rate=rate), hold, 60, seed)
    # Communication points are on the plant's whole nanoseconds only to 1 ns.
    assert differences["angles"] < 1e-7
    assert differences["activation"] < 1e-6


@pytest.fixture(scope="session")
def delayed_fmu(tmp_path_factory):
    """A finger of another delay, strength and speed, as FMU."""
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    finger = Finger(delay_ms=13.7, strength=0.7, speed=1.3, rest_deg=(10.0, 20.0, 5.0))
    return finger, build_finger_fmu(tmp_path_factory.mktemp("delayed") / "d.fmu", finger=finger).path


@pytest.mark.slow
@pytest.mark.parametrize("finger", [
    Finger(delay_ms=0.0), Finger(recruitment_curve="linear", full_scale_us=300.0, delay_ms=7.25)])
@pytest.mark.parametrize("interface", ["co_simulation", "model_exchange"])
def test_other_fingers_export_too(tmp_path, finger, interface):
    path = build_finger_fmu(tmp_path / "f.fmu", finger=finger, binary=True).path
    plant = Fmu(path=str(path), step_rate="500", interface=interface, substeps=10)
    differences, _ = largest_differences(finger, plant, hold=10, ticks=300)
    assert differences["angles"] < 1e-9
    assert differences["activation"] < 1e-9


@pytest.mark.slow
def test_the_archive_is_valid_and_the_same_every_time(tmp_path, finger_fmu):
    assert validate_fmu(str(finger_fmu)) == []
    again = build_finger_fmu(tmp_path / "finger.fmu", binary=True)
    assert again.path.read_bytes() == finger_fmu.read_bytes()
    assert again.size == finger_fmu.stat().st_size
    other = build_finger_fmu(tmp_path / "other.fmu", finger=Finger(strength=1.1), binary=False)
    assert other.guid != again.guid
    assert validate_fmu(str(other.path)) == []


def test_others_can_compile_the_sources_alone(tmp_path):
    built = build_finger_fmu(tmp_path / "source.fmu", binary=False)
    assert built.binary == ""
    with zipfile.ZipFile(built.path) as archive:
        assert not any(name.startswith("binaries/") for name in archive.namelist())
        archive.extractall(tmp_path / "unpacked")
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    sources = sorted(path.name for path in (tmp_path / "unpacked" / "sources").glob("*.c"))
    command = ["gcc", "-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fPIC", "-shared", *sources]
    subprocess.run([*command, "-o", "finger.so", "-lm"], cwd=tmp_path / "unpacked" / "sources", check=True)


def test_without_a_compiler_there_are_sources_and_a_word(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    built = build_finger_fmu(tmp_path / "finger.fmu")
    assert built.binary == ""
    assert "no C compiler" in built.note
    with pytest.raises(InputError, match="install gcc"):
        build_finger_fmu(tmp_path / "demanded.fmu", binary=True)
    assert not (tmp_path / "demanded.fmu").exists()


def test_a_failing_compiler_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(build, "COMPILE", ("-no-such-option",))
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    with pytest.raises(RunError, match="failed on the sources of finger"):
        build_finger_fmu(tmp_path / "finger.fmu", binary=True)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_its_place_is_refused(tmp_path):
    target = tmp_path / "finger.fmu"
    target.mkdir()
    with pytest.raises(InputError, match=r"finger\.fmu cannot be written: Is a directory; allowed: a file"):
        build_finger_fmu(target, binary=False)
    assert list(tmp_path.iterdir()) == [target]


def test_what_cannot_be_exported_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"finger\.fatigue"):
        build_finger_fmu(tmp_path / "finger.fmu", finger=Finger(fatigue=Fatigue()))
    with pytest.raises(InputError, match=r"does not end in \.fmu"):
        build_finger_fmu(tmp_path / "finger.zip")
    with pytest.raises(InputError, match="does not exist"):
        build_finger_fmu(tmp_path / "nowhere" / "finger.fmu")


def test_every_variable_says_what_it_is_and_in_which_unit(finger_fmu):
    with zipfile.ZipFile(finger_fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    for variable in root.find("ModelVariables"):
        unit, text = variable.find("Real").get("unit"), variable.get("description", "")
        assert text.endswith(f", {unit}") if unit else "tate " in text
