"""Runs exported C programmes: built with every warning and sanitizer, and fed the records of blocks."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fesloop.c_code.program import Program
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Sample

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-g", "-fsanitize=address,undefined",
          "-fno-sanitize-recover=all")
QUICK = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-O2")
NEXT_TRIAL = -2

needs_gcc = pytest.mark.skipif(
    shutil.which("gcc") is None, reason="gcc builds the exported C, and is not there"
)

_MAIN = """
#include <stdio.h>
#include "NAME.h"
static NAME_state state;
int main(void)
{
    NAME_inputs in;
    NAME_outputs out;
    NAME_init(&state);
    while (fread(&in, sizeof in, 1, stdin) == 1) {
        if (in.time_ns == -2) { BETWEEN; continue; }
        const double status = NAME_step(&state, &in, &out);
        fwrite(&status, sizeof status, 1, stdout);
        fwrite(&out, sizeof out, 1, stdout);
    }
    return 0;
}
"""


def build(program: Program, folder: Path, flags: tuple[str, ...] = STRICT) -> Path:
    """Compile a programme that steps on records of its inputs from standard input."""
    for name, text in program.files().items():
        (folder / name).write_text(text)
    between = f"{program.name}_next_trial(&state)" if program.between else ""
    (folder / "main.c").write_text(_MAIN.replace("NAME", program.name).replace("BETWEEN", between))
    done = subprocess.run(["gcc", *flags, "main.c", f"{program.name}.c", "-o", "main", "-lm"], cwd=folder,
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    return folder / "main"


def record_type(program: Program) -> np.dtype:
    """The struct of the inputs."""
    fields = [("time_ns", np.int64)]
    for port in program.inputs:
        fields += [(port.name, np.float64, port.shape), (f"{port.name}_newest_ns", np.int64)]
    return np.dtype(fields)


def run(binary: Path, program: Program, records: np.ndarray) -> np.ndarray:
    """Status and outputs of each step, (steps, 1 + outputs), flat; records of NEXT_TRIAL give no row."""
    done = subprocess.run([str(binary)], input=records.tobytes(), capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()[:3000]
    size = 1 + sum(int(np.prod(port.shape)) for port in program.outputs)
    return np.frombuffer(done.stdout).reshape(-1, size)


def stepped(block, program: Program, rate: str, records: np.ndarray) -> np.ndarray:
    """Outputs of the block itself, (steps, outputs), flat, from the same records."""
    context = Context("block", clock=RateClock.from_rate(rate))
    state, tick, rows = block.init(context), Tick(), []
    known = {port.name for port in program.inputs}
    tick.index = 0
    for record in records:
        if record["time_ns"] == NEXT_TRIAL:
            state, tick.index = block.next_trial(state, context), 0
            continue
        tick.time_ns = int(record["time_ns"])
        tick.reports.clear()
        samples = []
        for port in block.inputs:
            if port.name not in known:
                value = None if not port.resolved else port.initial_value()
                samples.append(Sample(value, -1, -1, -1))
                continue
            newest = int(record[f"{port.name}_newest_ns"])
            value = np.array(record[port.name]) if port.shape else float(record[port.name])
            samples.append(Sample(value, newest, newest, tick.time_ns if newest >= 0 else -1))
        rows.append(np.concatenate([np.ravel(each) for each in block.step(state, samples, tick)]))
        tick.index += 1
    return np.array(rows)
