"""What `fesloop export` writes, `fesloop import` and `replay` read: the same samples at the same instants."""

import numpy as np
import pytest
from export_parts import BLOCK, Node, write_run
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fesloop.experiment.export import export
from fesloop.streams.files import open_recording

FORMATS = ("xdf", "motion-bids", "csv")


def worn(folder, rate_hz, rows, sensors, with_mag, lost, start_ns=0):
    """Sensors at rest, each of which lost some samples."""
    rng = np.random.default_rng(rows)
    ports = {"gyr": ("rad/s", (sensors, 3)), "acc": ("m/s^2", (sensors, 3))}
    values = {"gyr": 0.1 * rng.normal(size=(rows, sensors, 3)),
              "acc": [0.0, 0.0, 9.8] + 0.1 * rng.normal(size=(rows, sensors, 3))}
    if with_mag:
        ports["mag"] = ("T", (sensors, 3))
        values["mag"] = 3e-5 + 1e-6 * rng.normal(size=(rows, sensors, 3))
    for row in lost:
        values["gyr"][row % (rows - 1), row % sensors] = np.nan
    instants = start_ns + np.array([k * 10**9 // rate_hz for k in range(rows)])
    node = Node("imus", BLOCK, ports).add(instants, values)
    names = [f"F{number}p" for number in range(1, sensors + 1)]
    run = write_run(folder / "run.h5", [node], parameters={"imus": {"sites": names}})
    return run, values, instants, names


def read(run, kind, folder):
    path = export(run, kind, folder / kind).path
    if kind == "csv":
        return open_recording(path / "imus.csv", layout=path / "imus.layout.toml")
    return open_recording(next(path.glob("*.xdf")) if kind == "xdf" else path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", FORMATS)
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rate_hz=st.integers(10, 500), rows=st.integers(3, 60), sensors=st.integers(1, 4),
       with_mag=st.booleans(), lost=st.lists(st.integers(0, 100), max_size=5))
def test_samples_and_instants_are_the_same(kind, rate_hz, rows, sensors, with_mag, lost, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    run, values, instants, names = worn(folder, rate_hz, rows, sensors, with_mag, lost)
    found = read(run, kind, folder)
    assert list(found.sensors) == names
    np.testing.assert_array_equal(found.gyr, values["gyr"])
    np.testing.assert_array_equal(found.acc, values["acc"])
    assert (found.mag is not None) == with_mag
    if with_mag:
        np.testing.assert_array_equal(found.mag, values["mag"])
    if kind == "xdf":  # readers of XDF put instants of a stream of nominal rate on a line, some ns aside
        np.testing.assert_allclose(found.stamps_ns, instants, rtol=0.0, atol=2.0)
        assert float(found.rate) == pytest.approx(rate_hz, rel=1e-6)
    else:
        np.testing.assert_array_equal(found.stamps_ns, instants)
        assert found.rate == rate_hz


@pytest.mark.parametrize("kind", FORMATS)
def test_a_stream_that_begins_late_begins_at_nought(kind, tmp_path):
    run, values, instants, _ = worn(tmp_path, 100, 20, 2, True, [], start_ns=123_456_789)
    found = read(run, kind, tmp_path)
    np.testing.assert_array_equal(found.stamps_ns, instants - instants[0])
    np.testing.assert_array_equal(found.gyr, values["gyr"])
