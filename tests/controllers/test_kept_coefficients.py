"""What controllers work out once and keep: they run on as fresh ones begin."""

import pytest

import fesloop
from fesloop.experiment.running import run

RUNS = [("finger_mpc", ("experiment.duration_s=1.5", "experiment.trials=2")),
        ("finger_ilc", ("experiment.trials=2",))]


@pytest.mark.parametrize(("name", "settings"), RUNS)
def test_a_controller_that_has_run_before_does_as_a_fresh_one(tmp_path, name, settings):
    def digest(experiment):
        with fesloop.Recording(run(experiment, tmp_path).recording) as recording:
            return recording.digest()

    used = fesloop.load(name, settings, seed=1)
    first = digest(used)
    digest(used.with_seed(2))
    assert digest(used) == first
    assert digest(fesloop.load(name, settings, seed=1)) == first


@pytest.mark.parametrize(("settings", "changed"), [
    (("blocks.controller.measurement_deg=0.1",), ("blocks.controller.measurement_deg=2.0",)),
    (("blocks.controller.move_weight=1.0",), ("blocks.controller.move_weight=2.0",))])
def test_controllers_of_other_parameters_keep_coefficients_of_their_own(settings, changed):
    def coefficients(more):
        node = fesloop.load("finger_mpc", more).wiring.node("controller")
        candidate = node.part.init(node.context(0, 0)).candidates[0]
        return candidate.plan.hessian.tobytes() + candidate.observer.gain.tobytes()

    assert coefficients(settings) == coefficients(settings) != coefficients(changed)
