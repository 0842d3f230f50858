"""Which FMU a result is of: experiments, recordings and repeated runs name the contents of the file."""

import json
import shutil

import pytest

from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document, load
from plants.fmu import Fmu


def experiment(fmu):
    """A reference that moves the FMU at a path."""
    return from_document({
        "experiment": {"name": "moved", "duration_s": 0.2},
        "blocks": {
            "reference": {"kind": "minimum_jerk", "rate": "50", "times_s": [0.0, 0.1],
                          "angles_deg": [[0], [30]]},
            "plant": {"kind": "fmu", "path": str(fmu),
                      "input_ports": [{"name": "u", "unit": "rad", "shape": [1], "variables": ["u"]}]}},
        "wires": [{"from": "reference.angles", "to": "plant.u"}]})


@pytest.mark.slow
def test_another_fmu_at_the_same_path_is_another_experiment(small2, tmp_path):
    path = tmp_path / "own.fmu"
    shutil.copy(small2(), path)
    one, same = experiment(path), experiment(path)
    shutil.copy(small2("SQUARE_S=0.01"), path)
    other = experiment(path)
    assert one.fingerprint() == same.fingerprint() != other.fingerprint()


@pytest.mark.slow
def test_a_recording_is_run_again_with_the_same_fmu_or_not_at_all(small2, tmp_path):
    path = tmp_path / "own.fmu"
    shutil.copy(small2(), path)
    made = experiment(path)
    recording = made.run(tmp_path / "runs").recording
    assert load(recording).fingerprint() == made.fingerprint()
    assert from_document(json.loads(made.as_json())) == made
    found = Fmu(path=str(path)).fingerprint
    shutil.copy(small2("SQUARE_S=0.01"), path)
    with pytest.raises(InputError) as caught:
        load(recording)
    message = str(caught.value)
    assert "\n" not in message
    for words in (str(path), found[:12], Fmu(path=str(path)).fingerprint[:12], "set fingerprint"):
        assert words in message
    assert load(recording, ['blocks.plant.fingerprint=""']).fingerprint() != made.fingerprint()


@pytest.mark.slow
def test_the_shipped_fmu_is_the_same_whenever_it_is_built():
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    assert len({Fmu(path="shipped:finger").fingerprint for _ in range(2)}) == 1
