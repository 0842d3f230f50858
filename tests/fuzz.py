"""Spoils sound files of every format and reads each: `python tests/fuzz.py [FILES] [SEED]`.

Bits, bytes, lengths, blocks, words and archive entries are changed. Each file must be read, its samples
finite or lost, or be refused with an InputError of one line, without a write outside the target's folder.
A worker process reads one file after the other, and foreign files go through the reader process. A worker
that dies, does not answer or takes more than its memory is bad. `spoilt` makes a file again by its number.
The last line that is printed counts all files. Formats of plants that are not installed are left out.
"""

from __future__ import annotations

import gc
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import fuzz_mutations as spoil
import numpy as np
from fuzz_seeds import make_seeds

from fesloop.errors import InputError

SOUND = ("read", "refused")
SLOW = {"fmu": 0.25}
"""Share of files of a format that takes seconds each: an FMU is tried out in another process."""
PATIENCE_S = 300.0
"""Time for one file; the reader process gives up long before, on a busy machine too."""
MOST_BYTES = 10**9
"""Memory of the worker beyond what it has at first; the reader process has a limit of its own."""
FMU_TRIAL_S = 3.0
_WRITING = {"open", "os.mkdir", "os.rename", "os.link", "os.symlink", "os.truncate", "os.remove", "os.rmdir",
            "os.chmod", "shutil.move"}
_HARMLESS = ("/dev/", "/proc/")


class Worker:
    """A process that reads files and is started again when it dies."""

    def __init__(self):
        self._process = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._process is not None:
            self._process.communicate()

    def read(self, reader, folder, name):
        """Outcome of `folder/source/name`: "read", "refused" or what is wrong, detail and seconds."""
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, __file__, "worker"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL, text=True, env={
                    **os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1",
                    "PYTHONDONTWRITEBYTECODE": "1"})
        process = self._process
        hanging = threading.Event()

        def end():
            hanging.set()
            process.kill()

        timer = threading.Timer(PATIENCE_S, end)
        timer.start()
        began = time.monotonic()
        try:
            process.stdin.write(json.dumps([reader, str(folder), name]) + "\n")
            process.stdin.flush()
            answer = process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        finally:
            timer.cancel()
        seconds = time.monotonic() - began
        if answer:
            return json.loads(answer) | {"seconds": seconds}
        process.communicate()
        self._process = None
        outcome = "hang" if hanging.is_set() else "crash"
        return {"outcome": outcome, "detail": f"exit code {process.returncode}", "seconds": seconds}


def work():
    """Answer a line on standard input with a line on standard output, until there is none."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    limit = pages * resource.getpagesize() + 2 * MOST_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    watch = Watch()
    sys.addaudithook(watch.note)
    for line in sys.stdin:
        reader, folder, name = json.loads(line)
        watch.writes, watch.allowed = [], (f"{folder}/target", f"{folder}/tmp")
        os.chdir(f"{folder}/cwd")
        tempfile.tempdir = os.environ["TMPDIR"] = f"{folder}/tmp"
        answer = outcome_of(READERS[reader], Path(folder), name)
        if watch.writes:
            answer = {"outcome": "write", "detail": watch.writes[0]}
        watch.allowed = ("/",)
        print(json.dumps(answer), flush=True)


class Watch:
    """Notes what is written outside the allowed folders."""

    def __init__(self):
        self.writes, self.allowed = [], ("/",)

    def note(self, event, args):
        if event not in _WRITING or not isinstance(args[0], (str, bytes, os.PathLike)):
            return
        reads = event == "open" and not args[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        in_open_folder = event != "open" and args[-1] != -1 and not os.fsdecode(args[0]).startswith("/")
        if reads or in_open_folder:  # rmtree goes from folder to folder by descriptors
            return
        path = os.path.realpath(os.fsdecode(args[0]))
        inside = any(f"{path}/".startswith(f"{each.rstrip('/')}/") for each in self.allowed)
        if not inside and not path.startswith(_HARMLESS):
            self.writes.append(f"{event} {path}")


def outcome_of(read, folder, name):
    """What reading a file comes to, as anybody would read it."""
    try:
        read(folder, name)
    except InputError as fault:
        lines = str(fault).split("\n")
        faults = getattr(fault, "faults", [fault])
        if len(lines) != len(faults) or not all(line.strip() for line in lines):
            return {"outcome": "unclear", "detail": str(fault)[:300]}
        return {"outcome": "refused", "detail": lines[0][:300]}
    except BaseException as fault:  # noqa: BLE001 - whatever else comes out is what this is after
        import traceback

        where = traceback.extract_tb(fault.__traceback__)[-1]
        text = " ".join(str(fault).split())[:200]
        return {"outcome": type(fault).__name__, "detail": f"{text} at {where.filename}:{where.lineno}"}
    return {"outcome": "read", "detail": ""}


def read_recording(folder, name, layout=None):
    """Import a recording of motion, and look at what was read."""
    from fesloop.streams.files import import_recording

    described = None if layout is None else folder / "source" / layout
    recording = import_recording(folder / "source" / name, folder / "target" / "motion.h5", described)
    if (np.diff(recording.stamps_ns) <= 0).any() or recording.stamps_ns[0] < 0:
        raise AssertionError("stamps do not increase from 0 on")
    for samples in (recording.gyr, recording.acc, recording.mag):
        if samples is not None and np.isinf(samples).any():
            raise AssertionError("samples are infinite")


def read_described(folder, name):
    """Import a recording with its layout."""
    read_recording(folder, name, "layout.toml")


def read_stimulation(folder, name):
    """Import a recording of stimulated muscle, and make of it what import prints and reports show."""
    from fesloop.streams.stimulation import features, import_stimulation, open_stimulation
    from fesloop.streams.stimulation.summary import doubts_about, summary_of

    import_stimulation(folder / "source" / name, folder / "target" / "person.h5")
    recording = open_stimulation(folder / "target" / "person.h5")
    json.dumps([summary_of(recording), doubts_about(recording)], allow_nan=False)
    for course in recording.courses:
        features.recruitment_curve(course)
    if recording.steady is not None:
        features.baselines(recording.steady)
        for muscle in np.unique(recording.steady.muscle[recording.steady.stimulated]):
            features.by_repeat(recording.steady, muscle)


def read_run(folder, name):
    """Read everything that a run's recording holds."""
    from fesloop.experiment.recording.reading import Recording

    with Recording(folder / "source" / name) as recording:
        _ = (recording.status, recording.wall, recording.events, recording.messages, recording.digest(),
             recording.step_times_ns)
        for trial in range(min(recording.trials, 3)):
            for signal_name in recording.signals:
                recording.signal(signal_name, trial)


def read_fmu(folder, name):
    """Make a plant of an FMU, which extracts it, reads its description and tries it out."""
    from fesloop.experiment import registry

    made = registry.find("fmu")(path=str(folder / "source" / name), probe_timeout_s=FMU_TRIAL_S)
    del made
    gc.collect()


READERS = {"recording": read_recording, "layout": read_described, "stimulation": read_stimulation,
           "run": read_run, "fmu": read_fmu}


def spoilt(kind, sound, number, seed=0):
    """Files number `number` of a kind, one of them spoilt."""
    chance = random.Random(f"{seed}-{kind}-{number}")
    name = chance.choice(list(sound.files))
    ending = next(ending for ending in sound.spoilers if name.endswith(ending))
    change = chance.choice(sound.spoilers[ending])
    if change is spoil.trick_archive and chance.random() < 0.5:
        change = spoil.spoil_bytes
    return {**sound.files, name: change(sound.files[name], chance)}


def read_files(worker, here, reader, files):
    """What becomes of files, and of the folder around them."""
    for part in ("source", "target", "tmp", "cwd"):
        (here / part).mkdir(parents=True)
    for name, content in files.items():
        (here / "source" / name).write_bytes(content)
    found = worker.read(reader, here, next(iter(files)))
    stray = [path for part in ("cwd", "tmp") for path in (here / part).iterdir()]
    stray += [path for path in (here / "source").iterdir() if path.name not in files]
    stray += [path for up in (here / "tmp").resolve().parents if (path := up / spoil.ESCAPED).exists()]
    if found["outcome"] == "refused":
        stray += list((here / "target").iterdir())
    if stray and found["outcome"] in SOUND:
        found = {**found, "outcome": "write", "detail": str(stray[0])}
    shutil.rmtree(here)
    return found


def run(files, seed=0, report=lambda row: None):
    """A row a format: files that were read, that were refused, and the bad ones."""
    rows = []
    with tempfile.TemporaryDirectory(prefix="fesloop-fuzz-") as name, Worker() as worker:
        folder = Path(name)
        (folder / "seeds").mkdir()
        seeds = make_seeds(folder / "seeds")
        whole = sum(SLOW.get(kind, 1.0) for kind in seeds)
        counts = {kind: int(files * SLOW.get(kind, 1.0) / whole) for kind in seeds}
        counts["xdf"] += files - sum(counts.values())
        for kind, sound in seeds.items():
            first = read_files(worker, folder / "case", sound.reader, sound.files)
            if first["outcome"] != "read" and not (kind == "fmu" and "no binary" in first["detail"]):
                raise AssertionError(f"the sound {kind} file is not read: {first}")
            found = [read_files(worker, folder / "case", sound.reader, spoilt(kind, sound, number, seed))
                     for number in range(counts[kind])]
            seconds = [each["seconds"] for each in found] or [0.0]
            rows.append({
                "format": kind, "files": len(found),
                **{outcome: sum(each["outcome"] == outcome for each in found) for outcome in SOUND},
                "out_of_memory": sum("of memory" in each["detail"] for each in found),
                "out_of_time": sum("is not read within" in each["detail"] for each in found),
                "crashed_reader": sum("crashes its reader" in each["detail"] for each in found),
                "ms_median": round(1e3 * float(np.median(seconds))), "ms_worst": round(1e3 * max(seconds)),
                "bad": [f"{number}: {each['outcome']}: {each['detail']}" for number, each in enumerate(found)
                        if each["outcome"] not in SOUND]})
            report(rows[-1])
    return rows


def main(files=10_000, seed=0):
    """Print a line a format, each bad file, and the count of all."""
    rows = run(files, seed, lambda row: print(json.dumps(row), flush=True))
    bad = sum(len(row["bad"]) for row in rows)
    count, read, refused = (sum(row[key] for row in rows) for key in ("files", *SOUND))
    print(f"{count} spoilt files of {len(rows)} formats: {read} read, {refused} refused, {bad} bad")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(work() if sys.argv[1:] == ["worker"] else main(*map(int, sys.argv[1:])))
