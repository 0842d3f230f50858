"""Samples of a run, exported to each format of the field and imported again, to the last bit; about 10 s."""

import shutil
from fractions import Fraction

import numpy as np
import pytest
from export_parts import BLOCK, Node, write_run
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fesloop.experiment.export import export
from fesloop.streams.files import import_recording, open_recording
from fesloop.streams.timebase import stamps_of_rate

PORTS = {"gyr": ("rad/s", (2, 3)), "acc": ("m/s^2", (2, 3)), "mag": ("T", (2, 3))}
MAT_LAYOUT = "rate = \"RATE\"\n" + "".join(
    f"[sensors.{sensor}]\n" + "".join(
        f'{port} = {{variable = "imus_{port}.values", columns = {[3 * sensor + k for k in (1, 2, 3)]}}}\n'
        for port in PORTS) for sensor in (0, 1))


@st.composite
def runs(draw):
    """(rate, samples by port): any doubles that sensors may read, some of them lost."""
    count, rate = draw(st.integers(2, 40)), Fraction(draw(st.sampled_from(["100", "2000/7", "60", "1000/3"])))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    samples = {"gyr": rng.normal(0.0, draw(st.sampled_from([1e-12, 0.1, 5.0])), (count, 2, 3)),
               "acc": np.array([0.0, 0.0, 9.81]) + rng.normal(0.0, 0.3, (count, 2, 3)),
               "mag": rng.normal(4e-5, 1e-6, (count, 2, 3))}
    if draw(st.booleans()):
        samples["gyr"][1:][rng.random((count - 1, 2)) < 0.2] = np.nan
    return rate, samples


def imported(format, run, folder, rate):
    """The recording that comes back from an export."""
    exported = export(run, format, folder / format, signals=[f"imus.{port}" for port in PORTS])
    if format == "motion-bids":
        return open_recording(exported.path)
    table = next(path for path in exported.files if path.suffix == f".{format}" and "events" not in path.name)
    if format == "xdf":
        return open_recording(table)
    layout = table.with_suffix(".layout.toml")
    if format == "mat":
        layout.write_text(MAT_LAYOUT.replace("RATE", str(rate)))
    return open_recording(table, layout=layout)


@pytest.mark.slow
@pytest.mark.parametrize("format", ["xdf", "motion-bids", "mat", "csv"])
@given(run=runs())
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_samples_and_stamps_come_back_to_the_last_bit(tmp_path, format, run):
    rate, samples = run
    folder = tmp_path / "trip"
    shutil.rmtree(folder, ignore_errors=True)
    stamps = stamps_of_rate(len(samples["gyr"]), rate)
    write_run(folder / "run.h5", [Node("imus", BLOCK, PORTS).add(stamps, samples)])
    recording = imported(format, folder / "run.h5", folder, rate)
    for port, values in samples.items():
        assert getattr(recording, port).tobytes() == values.tobytes(), port
    np.testing.assert_array_equal(recording.stamps_ns, stamps)
    import_recording(recording.path, folder / "motion.h5", **(
        {"layout": next(folder.rglob("*layout.toml"))} if format in ("mat", "csv") else {}))
    assert open_recording(folder / "motion.h5").gyr.tobytes() == samples["gyr"].tobytes()
