import pytest

import fesloop
from controllers.safety import Safety
from fesloop.errors import InputError
from plants.patients.files import load

TENDER = 'name = "anna"\n[tolerance]\ncurrent_max_ma = 15.0\ncharge_max_uc = 3.0\n'


def safety_of(experiment):
    return next(node.part for node in experiment.nodes if node.name == "safety")


def test_a_patients_limits_are_those_of_the_safety_block(tmp_path):
    (tmp_path / "anna.toml").write_text(TENDER)
    safety = safety_of(fesloop.load("open_close", [f"patient={tmp_path / 'anna.toml'}"]))
    assert (safety.current_max_ma, safety.charge_max_uc) == (15.0, 3.0)
    assert safety.charge_per_s_max_uc == Safety().charge_per_s_max_uc


def test_an_experiment_may_lower_them_and_never_raise_them(tmp_path):
    (tmp_path / "anna.toml").write_text(TENDER)
    settings = [f"patient={tmp_path / 'anna.toml'}", "blocks.safety.current_max_ma=12"]
    assert safety_of(fesloop.load("open_close", settings)).current_max_ma == 12.0
    with pytest.raises(InputError, match=r"safety.current_max_ma: 16; allowed: at most 15 for anna"):
        fesloop.load("open_close", [*settings[:1], "blocks.safety.current_max_ma=16"])


@pytest.mark.parametrize("key", ["current_max_ma", "charge_max_uc"])
def test_limits_of_each_channel_are_held_against_the_patient_too(tmp_path, key):
    (tmp_path / "anna.toml").write_text(TENDER)
    anna = load(str(tmp_path / "anna.toml"))
    limit = {"current_max_ma": 15.0, "charge_max_uc": 3.0}[key]
    assert anna.parameters("safety", {key: [1.0, limit]})[key] == limit
    with pytest.raises(InputError, match=rf"safety.{key}: 16; allowed: at most {limit:g} for anna"):
        anna.parameters("safety", {key: [1.0, 16.0, 2]})


def test_presets_leave_the_blocks_own():
    assert load("able_bodied").parameters("safety", {}) == {}
