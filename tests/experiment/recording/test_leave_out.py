"""Outputs, and inputs of plants, that are left out of a recording."""

import numpy as np
import pytest

from fesloop.errors import InputError, InputErrors
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.recording.reading import Recording

DOCUMENT = {
    "experiment": {"name": "some", "duration_s": 0.2},
    "record": {"plant_rate": "100"},
    "blocks": {"hand": {"kind": "moving_hand", "phases": [
        {"duration_s": 0.2, "posture_deg": {"F2_pip_flexion": 60.0}}]},
        "imus": {"kind": "imus", "rate": "100"}},
    "wires": [{"from": f"hand.{name}", "to": f"imus.{name}"}
              for name in ("site_orientation", "site_position", "site_rate", "site_force")]}


def recorded(folder, *left_out):
    record = {"plant_rate": "100", "leave_out": list(left_out)}
    return Recording(from_document(DOCUMENT | {"record": record}).run(folder).recording)


def test_what_is_left_out_is_not_there_and_the_rest_is_the_same(tmp_path):
    with recorded(tmp_path) as whole, recorded(tmp_path, "hand.site_rate", "hand.angles", "imus.acc") as part:
        assert set(whole.signals) - set(part.signals) == {"hand.site_rate", "hand.angles", "imus.acc"}
        for name in part.signals:
            assert np.array_equal(whole.signal(name).values, part.signal(name).values, equal_nan=True)
            assert np.array_equal(whole.signal(name).newest_ns, part.signal(name).newest_ns)
        with pytest.raises(InputError, match="is not recorded"):
            part.signal("imus.acc")


def test_what_does_not_exist_or_is_scored_cannot_be_left_out():
    for change, text in (({"record": {"leave_out": ["hand.angle"]}}, "record.leave_out"),
                         ({"record": {"leave_out": ["hand.fingertips"]},
                           "score": {"fingertips": "hand.fingertips", "trackers": ["hand"]}}, "left out")):
        with pytest.raises(InputErrors, match=text):
            from_document(DOCUMENT | change)


def test_inputs_of_plants_can_be_left_out(tmp_path):
    document = {
        "experiment": {"name": "pushed", "duration_s": 0.2},
        "blocks": {"programme": {"kind": "programme", "rate": "100", "times_s": [0.0],
                                 "current_ma": [[20] * 4], "width_us": [[300] * 4]},
                   "finger": {"kind": "finger"}},
        "wires": [{"from": "programme.stimulation", "to": "finger.stimulation"}]}
    with Recording(from_document(document).run(tmp_path).recording) as whole:
        pushed = whole.signal("finger.angles").values
        assert whole.signal("finger.stimulation").values.size
    left_out = document | {"record": {"leave_out": ["finger.stimulation"]}}
    with Recording(from_document(left_out).run(tmp_path).recording) as part:
        assert np.array_equal(part.signal("finger.angles").values, pushed)
        with pytest.raises(InputError, match="is not recorded"):
            part.signal("finger.stimulation")
