"""Makes docs/picture.png, the picture of the README, from runs made here and now.

    python docs/picture.py

Left: what the patient's MCP joint does in the first and the last trial of `finger_ilc`. Right: what tracker
latency costs PID and MPC on the same virtual patient.
"""

import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np

import fesloop

mpl.use("agg")
import matplotlib.pyplot as plt

LATENCIES_MS = (0, 20, 40, 60, 80, 90, 100, 110, 120, 125)
INK, GREY, BLUE, ORANGE = "#222222", "#8a8a8a", "#1f6fb4", "#d95f02"


def learning(axes, folder):
    """Reference and truth of MCP flexion, first and last trial."""
    result = fesloop.load("finger_ilc").run(folder)
    recording = fesloop.Recording(result.recording)
    errors = result.metrics["joint_rmse_deg"]
    reference = recording.signal("reference.angles", trial=0)
    last = len(errors) - 1
    axes.plot(reference.times_ns * 1e-9, np.degrees(reference.values[:, 0]), color=INK, lw=3, alpha=0.25,
              label="reference")
    for trial, colour in ((0, GREY), (1, ORANGE), (last, BLUE)):
        truth = recording.signal("patient.angles", trial=trial)
        axes.plot(truth.times_ns * 1e-9, np.degrees(truth.values[:, 0]), color=colour, lw=1.5,
                  label=f"trial {trial + 1}: {errors[trial]:.1f}°")
    axes.set(xlabel="time, s", ylabel="MCP flexion, deg",
             title="Learning a movement, the model 20 % and 15 % wrong")
    axes.legend(frameon=False, fontsize=8)


def latency(axes, folder):
    """Joint error over tracker latency."""
    cases = (("finger_pid_latency", ORANGE, "PID"), ("finger_mpc", BLUE, "MPC, told the age of each sample"))
    for name, colour, label in cases:
        errors = [fesloop.load(name, settings=[f"latency_ms={ms}"]).run(folder).metrics["joint_rmse_deg"][0]
                  for ms in LATENCIES_MS]
        axes.plot(LATENCIES_MS, errors, "o-", color=colour, ms=4, label=label)
    axes.set(xlabel="tracker latency, ms", ylabel="joint error, deg RMSE", ylim=(0, None),
             title="What tracker latency costs two controllers")
    axes.legend(frameon=False, fontsize=8, loc="upper left")


def main():
    """Draw both panels."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    with tempfile.TemporaryDirectory() as folder:
        learning(left, folder)
        latency(right, folder)
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
        axes.title.set_fontsize(9)
    figure.savefig(Path(__file__).with_name("picture.png"), dpi=130)


if __name__ == "__main__":
    main()
