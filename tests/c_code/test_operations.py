"""The worst case that a header states is counted: the same code, with doubles that count their operations."""

from __future__ import annotations

import re
import shutil
import subprocess

import numpy as np
import pytest
from c_code_parts import record_type
from c_controller_parts import (
    closed_loop,
    grasping,
    grasping_program,
    hour,
    ilc,
    ilc_program,
    mpc,
    mpc_program,
    pid,
    pid_program,
    remembering,
    trials,
    tuned_pid,
    tuned_pid_program,
)

from controllers.c_export.ilc import LAWS
from controllers.mpc.memory import Memory

_COUNTED = """
#include <stdint.h>
#include <math.h>
static long flops, calls;
struct counted {
    double v;
    counted() : v(0.0) {}
    counted(double x) : v(x) {}
    counted(int x) : v(x) {}
    counted(int64_t x) : v((double)x) {}
    explicit operator int64_t() const { return (int64_t)v; }
};
#define BINARY(o) static inline counted operator o(counted a, counted b) { flops++; return a.v o b.v; }
#define CHANGES(o) \\
    static inline counted &operator o##=(counted &a, counted b) { flops++; a.v = a.v o b.v; return a; }
#define COMPARES(o) static inline bool operator o(counted a, counted b) { flops++; return a.v o b.v; }
BINARY(+) BINARY(-) BINARY(*) BINARY(/) CHANGES(+) CHANGES(-) CHANGES(*) CHANGES(/)
COMPARES(<) COMPARES(>) COMPARES(<=) COMPARES(>=) COMPARES(==) COMPARES(!=)
static inline counted operator-(counted a) { return -a.v; }
#define CALLS(f) static inline counted f(counted a) { calls++; return (f)(a.v); }
CALLS(exp) CALLS(log) CALLS(sqrt) CALLS(erfc)
static inline counted fabs(counted a) { return (fabs)(a.v); }
#undef isfinite
#undef isnan
static inline bool isfinite(counted a) { return __builtin_isfinite(a.v); }
static inline bool isnan(counted a) { return __builtin_isnan(a.v); }
#define double counted
"""
_MAIN = """
#include <stdio.h>
static NAME_state state;
int main()
{
    static NAME_inputs in;
    static NAME_outputs out;
    long most = 0, most_calls = 0, between = 0;
    NAME_init(&state);
    while (fread(&in, sizeof in, 1, stdin) == 1) {
        if (in.time_ns == -2) {
            flops = 0;
            BETWEEN;
            if (flops > between) between = flops;
            continue;
        }
        flops = calls = 0;
        NAME_step(&state, &in, &out);
        if (flops > most) most = flops;
        if (calls > most_calls) most_calls = calls;
    }
    printf("%ld %ld %ld\\n", most, most_calls, between);
    return 0;
}
"""
needs_gxx = pytest.mark.skipif(shutil.which("g++") is None, reason="g++ counts operations, and is not there")


def counted(program, records, folder) -> tuple[int, ...]:
    """Most operations and calls of a step, and most operations between trials."""
    for name, text in program.files().items():
        (folder / name).write_text(text)
    between = f"{program.name}_next_trial(&state)" if program.between else ""
    # C++ wants a constructor for the state at rest, and no const one without a value
    code = re.sub(r"static const (\w+ at_rest;)", r"static \1", (folder / f"{program.name}.c").read_text())
    (folder / "main.cpp").write_text(
        _COUNTED + code + _MAIN.replace("NAME", program.name).replace("BETWEEN", between))
    done = subprocess.run(
        ["g++", "-O2", "-w", "main.cpp", "-o", "main"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[:3000]
    told = subprocess.run(
        [str(folder / "main")], input=records.tobytes(), capture_output=True, check=True
    ).stdout
    return tuple(int(word) for word in told.split())


@needs_gxx
@pytest.mark.parametrize("law", ["pid", *LAWS])
def test_the_stated_worst_case_is_reached_within_a_third(tmp_path, law):
    if law == "pid":
        program = pid_program(pid())
        records = hour(record_type(program), 60, np.random.default_rng(1))
    else:
        block = ilc(law=law, duration_s=4.0)
        program = ilc_program(block)
        records = trials(block, record_type(program), 4, 1)
    flops, calls, between = counted(program, records, tmp_path)
    print(f"{law}: {flops} of {program.operations.flops}, between {between} of {program.operations.between}")
    assert 0.66 * program.operations.flops < flops <= program.operations.flops
    assert calls <= program.operations.calls
    assert 0.4 * program.operations.between <= between <= program.operations.between


@needs_gxx
def test_predictive_control_stays_below_its_worst_case(tmp_path, monkeypatch):
    import controllers.c_export.mpc as in_c

    monkeypatch.setattr(in_c, "DEFAULT_ITERATIONS", 40)
    block = mpc(horizon=12)
    program = mpc_program(block, "reference_preview")
    flops, calls, _ = counted(program, closed_loop(block, record_type(program), 1500, 1), tmp_path)
    print(f"{flops} of at most {program.operations.flops}")
    assert 0.05 * program.operations.flops < flops <= program.operations.flops
    assert calls <= program.operations.calls


@needs_gxx
def test_contact_and_memory_stay_below_their_worst_case(tmp_path, monkeypatch):
    import controllers.c_export.mpc as in_c

    monkeypatch.setattr(in_c, "DEFAULT_ITERATIONS", 40)
    block = grasping(horizon=10, memory=Memory())
    program = grasping_program(block, 300)
    records, _ = remembering(block, record_type(program), 300, 1, 3, 1.4)
    flops, calls, between = counted(program, records, tmp_path)
    print(f"{flops} of at most {program.operations.flops}, between {between} of {program.operations.between}")
    assert 0.05 * program.operations.flops < flops <= program.operations.flops
    assert calls <= program.operations.calls
    assert 0.4 * program.operations.between <= between <= program.operations.between


@needs_gxx
def test_the_tuned_pid_stays_below_its_worst_case(tmp_path, monkeypatch):
    import controllers.c_export.tuned_pid as in_c

    monkeypatch.setattr(in_c, "DEFAULT_ITERATIONS", 4)
    program = tuned_pid_program(tuned_pid(), "reference_preview")
    flops, calls, _ = counted(program, closed_loop(tuned_pid(), record_type(program), 1500, 1), tmp_path)
    print(f"{flops} of at most {program.operations.flops}")
    assert 0.25 * program.operations.flops < flops <= program.operations.flops
    assert calls <= program.operations.calls
