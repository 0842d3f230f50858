"""A recording grows on the disk and not in memory; in a process of its own, about 5 s."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="of Linux")
WRITE = """
import os, sys
from pathlib import Path
import numpy as np
from loop_parts import Source
from fesloop.experiment.running import Experiment
from fesloop.experiment.recording.writing import RecordingWriter
from fesloop.loop.record import Recorder
from fesloop.loop.wiring import Node

def resident_mb():
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6

nodes = tuple(Node(f"n{i}", Source(), "100") for i in range(20))
recorder = Recorder()
writer = RecordingWriter(Path(sys.argv[1]), Experiment(name="long", nodes=nodes, duration_s=1.0))
sizes = []
for turn in range(160):
    for node in nodes:
        recorder.blocks[node.name] = [(k, k, k, k, k, (float(k),)) for k in range(256)]
    writer.write(recorder, 0)
    sizes.append(resident_mb())
writer.close("done", 1.0)
print(sizes[20], sizes[-1])
"""


@pytest.mark.slow
def test_twenty_streams_of_40_000_rows_stay_on_the_disk(tmp_path):
    done = subprocess.run([sys.executable, "-c", WRITE, str(tmp_path)], capture_output=True, text=True,
                          check=True, cwd=Path(__file__).parents[2])
    early, late = (float(size) for size in done.stdout.split())
    written = sum(path.stat().st_size for path in tmp_path.iterdir()) / 1e6
    assert written > 40.0
    assert late - early < 0.1 * written
