"""Both exports together: PID and finger as FMUs in an SSP are the experiment of block and plant."""

from __future__ import annotations

import numpy as np
import pytest
from c_code_parts import needs_gcc
from ssp_parts import archived, component, connection, described, system

import fesloop
from plants.fmu.export import build_finger_fmu
from plants.ssp.experiment import import_ssp

_NATIVE = """
[experiment]
name = "native"
duration_s = 3

[blocks.reference]
kind = "minimum_jerk"
rate = "50"
times_s = [0.5, 1.0]
angles_deg = [[30, 40, 25], [30, 40, 25]]

[blocks.controller]
kind = "pid"
rate = "50"
kp = [1.0, 1.0, 1.0]
ki = [8.0, 8.0, 8.0]
kd = [0.02, 0.02, 0.02]
mixing = [[0.41, -0.49, 2.54], [-0.38, 1.83, -2.96], [-0.99, 0.15, -0.27], [1.51, -1.19, 0.43]]
bias = [0.17, 0.14, 0.30, 0.19]
current_ma = [40, 40, 40, 40]
recruitment = { threshold_ma = [12.0, 10.0, 10.0, 8.0], spread = [0.35, 0.35, 0.35, 0.35] }

[blocks.finger]
kind = "finger"

[[wires]]
from = "reference.angles"
to = "controller.reference"

[[wires]]
from = "finger.angles"
to = "controller.measured"

[[wires]]
from = "controller.stimulation"
to = "finger.stimulation"
latency_ms = 1
"""


@needs_gcc
@pytest.mark.slow
def test_the_loop_of_two_fmus_is_the_native_one(tmp_path):
    (tmp_path / "native.toml").write_text(_NATIVE)
    experiment = fesloop.load(tmp_path / "native.toml")
    fesloop.export_block(experiment, "controller", "fmu", tmp_path / "controller.fmu")
    build_finger_fmu(tmp_path / "finger.fmu")
    pulses = [f"stimulation[{i},{k}]" for i in (1, 2, 3, 4) for k in (1, 2)]
    target = (
        "".join(
            f'<ssv:Parameter name="reference[{i + 1}]"><ssv:Real value="{np.radians(deg)!r}" unit="rad"/>'
            "</ssv:Parameter>"
            for i, deg in enumerate((30.0, 40.0, 25.0))
        )
        .replace("np.float64(", "")
        .replace(')"', '"')
    )
    values = (
        '<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version="1.0" '
        f'name="v"><ssv:Parameters>{target}</ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues>'
        "</ssd:ParameterBinding></ssd:ParameterBindings>"
    )
    parts = [
        component(
            "controller",
            {f"measured[{i}]": "input" for i in (1, 2, 3)} | dict.fromkeys(pulses, "output"),
            "resources/controller.fmu",
            values,
        ),
        component(
            "finger",
            dict.fromkeys(pulses, "input") | {f"angles[{i}]": "output" for i in (1, 2, 3)},
            "resources/finger.fmu",
        ),
    ]
    wires = [connection(f"finger.angles[{i}]", f"controller.measured[{i}]") for i in (1, 2, 3)]
    wires += [connection(f"controller.{name}", f"finger.{name}") for name in pulses]
    ssp = archived(tmp_path / "loop.ssp", described(system("loop", parts, wires), 3.0),
                   {f"resources/{name}.fmu": tmp_path / f"{name}.fmu" for name in ("controller", "finger")})
    imported = import_ssp(ssp, tmp_path / "loop")
    assert imported.connections == 11
    ours = fesloop.run(imported.experiment, out=tmp_path / "runs")
    theirs = fesloop.run(experiment, out=tmp_path / "runs")
    with fesloop.Recording(ours.recording) as a, fesloop.Recording(theirs.recording) as b:
        native = b.signal("finger.angles")
        for i in range(3):
            exported = a.signal(f"finger.angles_{i + 1}")
            assert (exported.times_ns == native.times_ns).all()
            far = np.abs(exported.values - native.values[:, i]).max()
            print(f"joint {i + 1}: {far:.1e} rad of {np.ptp(native.values[:, i]):.2f}")
            assert np.ptp(native.values[:, i]) > 0.05
            assert far < 1e-9
