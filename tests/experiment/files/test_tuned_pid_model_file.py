"""The tuned PID from a patient's model file, through the whole loop, on plants that are not the model."""

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document
from fesloop.models.patient_model import PatientModel
from plants.finger import Finger


@pytest.fixture
def model_file(tmp_path):
    model = Finger().linear_model()
    path = tmp_path / "model.toml"
    PatientModel(patient="", source="the finger itself", outputs=("MCP", "PIP", "DIP"), electrodes=(),
                 current_ma=(40.0,) * 4, rate="40", model=model, operating_drive=np.zeros(4),
                 operating_outputs=model.offset).save(path)
    return path


def document(path, **finger):
    angles = [[20.0, 25.0, 15.0], [40.0, 55.0, 25.0], [40.0, 55.0, 25.0], [25.0, 32.0, 18.0]]
    return {
        "experiment": {"name": "finger_tuned_pid", "duration_s": 6.0},
        "blocks": {
            "reference": {"kind": "minimum_jerk", "rate": "40", "times_s": [1.0, 2.0, 3.0, 4.0],
                          "angles_deg": angles, "preview": 20},
            "pid": {"kind": "tuned_pid", "rate": "40", "model": {"file": str(path)}, "preview": 20,
                    "delay_ms": 20.0},
            "safety": {"kind": "safety", "rate": "40"},
            "finger": {"kind": "finger", **finger},
            "tracker": {"kind": "ideal", "rate": "100", "noise_deg": 0.2}},
        "wires": [{"from": "reference.angles", "to": "pid.reference"},
                  {"from": "reference.preview", "to": "pid.reference_preview"},
                  {"from": "tracker.angles", "to": "pid.measured", "latency_ms": 20},
                  {"from": "pid.stimulation", "to": "safety.stimulation"},
                  {"from": "safety.stimulation", "to": "finger.stimulation"},
                  {"from": "finger.angles", "to": "tracker.angles"}],
        "score": {"truth": "finger.angles", "reference": "reference.angles", "after_s": 1.0}}


@pytest.mark.parametrize("strength", [0.7, 1.0, 1.3])
def test_a_finger_follows_within_degrees_though_stronger_or_weaker_than_its_model(
        strength, model_file, tmp_path):
    result = from_document(document(model_file, strength=strength)).run(tmp_path)
    assert result.metrics["joint_rmse_deg"][0] < 2.5


def test_a_file_of_another_patient_is_named(model_file):
    other = document(model_file) | {"patient": {"file": "able_bodied"}}
    with pytest.raises(InputError, match="the model is of ''"):
        from_document(other)
