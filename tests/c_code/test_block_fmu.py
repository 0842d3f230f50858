"""A controller as an FMU: FMPy validates and runs it, and the plant `fmu` gives the block's outputs."""

from __future__ import annotations

import numpy as np
import pytest
from c_code_parts import record_type, stepped
from c_controller_parts import closed_loop, hour, ilc, ilc_program, mpc, mpc_program, pid, pid_program
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

import fesloop
from fesloop.c_code import build
from fesloop.c_code.fmu import write_fmu
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock
from plants.fmu import Fmu

needs_cc = pytest.mark.skipif(build.find_compiler() is None, reason="there is no C compiler")
CLOCK = RateClock.from_rate("50")
AGE_S = 0.02


def usable(records: np.ndarray, program) -> np.ndarray:
    """The records as an FMU can have them: finite, always there, and of one age."""
    records = records.copy()
    for port in program.inputs:
        records[port.name] = np.nan_to_num(records[port.name], nan=0.4)
        records[f"{port.name}_newest_ns"] = records["time_ns"] - (
            20_000_000 if port.name == "measured" else 0
        )
    return records


@pytest.fixture(scope="module", params=["pid", "mpc"])
def exported(request, tmp_path_factory):
    """Block, programme, records and FMU."""
    if request.param == "pid":
        block = pid()
        program = pid_program(block)
        records = hour(record_type(program), 20, np.random.default_rng(1))
    else:
        block = mpc()
        program = mpc_program(block, "reference")
        records = closed_loop(block, record_type(program), 1000, 1)
    path = tmp_path_factory.mktemp("fmu") / "control.fmu"
    write_fmu(program, CLOCK, path)
    return block, program, usable(records, program), path


@needs_cc
def test_fmpy_validates_it_and_its_simulation_is_the_block(exported):
    block, program, records, path = exported
    assert validate_fmu(str(path)) == []
    names, columns = ["time"], [np.arange(len(records)) * 0.02]
    for port in program.inputs:
        for i in range(port.shape[0]):
            names.append(f"{port.name}[{i + 1}]")
            columns.append(records[port.name][:, i])
    signals = np.array(list(zip(*columns, strict=True)), dtype=[(name, np.float64) for name in names])
    outputs = [f"stimulation[{i + 1},{k + 1}]" for i in range(program.outputs[0].shape[0]) for k in range(2)]
    result = simulate_fmu(str(path), stop_time=len(records) * 0.02, step_size=0.02, output_interval=0.02,
                          input=signals, output=outputs, start_values={"measured_age": AGE_S})
    ours = np.array([list(row)[1:] for row in result])[1:]
    theirs = stepped(block, program, "50", records)
    assert np.ptp(theirs) > 1e-4
    assert np.abs(ours[:len(theirs)] - theirs[:len(ours)]).max() < 1e-9


@needs_cc
def test_the_plant_fmu_gives_the_blocks_outputs_with_its_ports_and_units(exported):
    block, program, records, path = exported
    plant = Fmu(path=str(path), step_rate="50", starts={"measured_age": AGE_S})
    known = {port.name: port for port in (*program.inputs, *program.outputs)}
    for port in (*plant.inputs, *plant.outputs):
        assert (port.shape, port.unit) == (known[port.name].shape, known[port.name].unit)
    assert plant.can_snapshot
    state = plant.init(Context("fmu", clock=plant.grid))
    names, ours = [port.name for port in plant.inputs], []
    for k, record in enumerate(records):
        plant.advance(
            state, [np.array(record[name]) for name in names], plant.grid.tick(k), plant.grid.tick(k + 1)
        )
        ours.append(np.ravel(plant.read(state, [])[0]))
    plant.close(state)
    assert np.abs(np.array(ours) - stepped(block, program, "50", records)).max() < 1e-9


@needs_cc
def test_equal_blocks_give_equal_bytes(tmp_path):
    write_fmu(pid_program(pid()), CLOCK, tmp_path / "a.fmu")
    write_fmu(pid_program(pid()), CLOCK, tmp_path / "b.fmu")
    assert (tmp_path / "a.fmu").read_bytes() == (tmp_path / "b.fmu").read_bytes()


def test_what_an_fmu_cannot_be_is_refused(tmp_path, monkeypatch):
    with pytest.raises(fesloop.InputError, match="learns between trials"):
        write_fmu(ilc_program(ilc()), CLOCK, tmp_path / "a.fmu")
    monkeypatch.setattr("fesloop.c_code.fmu.find_compiler", lambda: None)
    with pytest.raises(fesloop.InputError, match="no C compiler"):
        write_fmu(pid_program(pid()), CLOCK, tmp_path / "a.fmu")
