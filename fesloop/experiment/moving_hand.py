"""Simulated samples of sensors on a moving hand, for use without sensors or a recording."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.experiment.files.parse import load
from fesloop.loop.clock import RateClock
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.streams.recording import MotionRecording
from fesloop.streams.timebase import stamps_of_rate


def moving_hand() -> MotionRecording:
    """16 sensors with magnetometers, 30 s at 100 Hz, of the hand that `moving_hand.toml` describes.

    It ends as it began, so that it can be played again and again.
    """
    file = Path(str(files("fesloop.experiment") / "moving_hand.toml"))
    experiment = load(file)
    recorder = Recorder(plant_rate=None)
    Loop(experiment.wiring, recorder=recorder).run_until(experiment.duration_ns - 1)
    node = next(node for node in experiment.nodes if node.name == "imus")
    imus: Any = node.part
    assert isinstance(node.clock, RateClock)
    gyr, acc, mag = (np.stack(kind) for kind in zip(*(row[-1] for row in recorder.blocks["imus"]),
                                                    strict=True))
    rate = node.clock.rate
    return MotionRecording(path=file, source_format="computed", sensor_set=None, sensors=tuple(imus.sites),
                           rate=rate, stamps_ns=stamps_of_rate(len(gyr), rate), gyr=gyr, acc=acc, mag=mag,
                           reference=None, pairs=())
