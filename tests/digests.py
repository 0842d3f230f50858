"""Digests of what shipped experiments compute, to compare before and after a change that must change none.

Signals with their stamps, and events; not the text of the experiment, so that files may be written anew.

    python tests/digests.py [--only NAME]... [--workers N] > before.json
    python tests/digests.py --against before.json

Long ones are shortened. Ends with 1, naming them, if digests differ.
"""

import argparse
import dataclasses
import hashlib
import json
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

SHORT = {"grasp_ilc": ["trials=2"], "open_close_ilc": ["trials=2"], "tracker_hour": ["duration_s=60"],
         "identify_grasp": ["duration_s=30"], "identify_key": ["duration_s=30"],
         "sweep_grasp": ["experiment.duration_s=20"],
         "identify_patient": ["experiment.duration_s=30"],
         "array_search_gp": ["duration_s=40"], "fatigue": ["experiment.duration_s=30"],
         "array_search_exhaustive": ["experiment.duration_s=40"], "finger_ilc": ["experiment.trials=3"],
         "array_search_magnets": ["duration_s=40"], "array_search_two_phase": ["duration_s=40"]}
LEFT_OUT = {"hil_live", "hil_dry_stimulator", "hil_twin", "hil_error_replay", "hil_replay", "replay"}
"""Live ones, and those that want a file of the user's."""


def digest(name):
    """Name and digest of a shipped experiment's run, or why there is none."""
    from fesloop import Recording, load
    from fesloop.errors import FesloopError

    with tempfile.TemporaryDirectory() as folder:
        try:
            with Recording(load(name, SHORT.get(name, [])).run(out=folder).recording) as recording:
                return name, content_digest(recording)
        except FesloopError as fault:
            return name, f"none: {fault}"


def content_digest(recording):
    """SHA-256 of signals with all their stamps, and of events."""
    told = [(each.trial, each.time_ns, each.where, each.status, each.detail) for each in recording.events]
    total = hashlib.sha256(repr(sorted(told)).encode())
    for name in sorted(recording.signals):
        for trial in range(recording.trials):
            signal = recording.signal(name, trial)
            total.update(name.encode())
            for field in dataclasses.fields(signal):
                value = getattr(signal, field.name)
                if isinstance(value, np.ndarray):
                    total.update(f"{field.name} {value.dtype} {value.shape}".encode() + value.tobytes())
    return total.hexdigest()


def main(arguments):
    """Print digests, or compare them; exit code."""
    from fesloop.experiment.files.source import shipped

    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--against", type=Path)
    given = parser.parse_args(arguments)
    names = [name for name in shipped() if name not in LEFT_OUT and (not given.only or name in given.only)]
    with ProcessPoolExecutor(given.workers) as pool:
        found = dict(pool.map(digest, names))
    if given.against is None:
        print(json.dumps(found, indent=1))
        return 0
    before = json.loads(given.against.read_text())
    differ = [name for name in found if name in before and before[name] != found[name]]
    print("\n".join(f"{name}: {before[name]} -> {found[name]}" for name in differ))
    print(f"{len(found)} digests, {len(differ)} differ")
    return int(bool(differ))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
