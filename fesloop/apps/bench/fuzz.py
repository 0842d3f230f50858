"""`fesloop bench fuzz`: what becomes of files that are damaged, or made to do harm.

Sound files of every format are spoilt in bits, bytes, lengths, blocks, words and archive entries, and each is
read in a process of its own. It must be read, its samples finite or lost, or be refused with an InputError of
one line; within 5 s and 1 GB, and without a write outside the folder that was asked for. `bad` names every
file of which that is not so, by its number: `fesloop.apps.bench.fuzz.spoilt` makes it again. A row a format;
times are those of reading a file, the child process with its limits included. It can only tell of formats
whose plants and exporters are installed.
"""

from __future__ import annotations

import random
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.apps.bench import _fuzz_mutations as spoil
from fesloop.apps.bench._fuzz_reading import Reading
from fesloop.apps.bench._fuzz_seeds import Seed, make_seeds

SOUND = ("read", "refused")
_FULL, _SHORT = 10_000, 300
_SLOW = {"fmu": 0.25}
"""Share of files of a format that takes seconds each: an FMU is tried out in another process."""


def run(files: int = 0, seed: int = 0, short: bool = False,
        progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """One row a format: files that were read, refused, and neither; 10,000 `files`, 300 in the short form."""
    files = files or (_SHORT if short else _FULL)
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as name, Reading() as reading:
        folder = Path(name)
        (folder / "seeds").mkdir()
        seeds = make_seeds(folder / "seeds")
        counts = _shares(files, list(seeds))
        rows, done = [], 0
        for kind, sound in seeds.items():
            first = _read(reading, folder, sound, sound.files)
            if first["outcome"] != "read" and not (kind == "fmu" and "no binary" in first["detail"]):
                raise AssertionError(f"the sound {kind} file is not read: {first}")
            found = []
            for number in range(counts[kind]):
                found.append(_read(reading, folder, sound, spoilt(kind, sound, number, seed)))
                done += 1
                if progress:
                    progress(done / files)
            rows.append(_row(kind, found))
    return {"bench": "fuzz", "rows": rows, "files": sum(row["files"] for row in rows),
            "bad_files": sum(len(row["bad"]) for row in rows)}


def _shares(files: int, kinds: list[str]) -> dict[str, int]:
    """How many files of each kind, `files` altogether."""
    whole = sum(_SLOW.get(kind, 1.0) for kind in kinds)
    counts = {kind: int(files * _SLOW.get(kind, 1.0) / whole) for kind in kinds}
    counts[kinds[0]] += files - sum(counts.values())
    return counts


def spoilt(kind: str, sound: Seed, number: int, seed: int = 0) -> dict[str, bytes]:
    """Files number `number` of a kind, one of them spoilt."""
    chance = random.Random(f"{seed}-{kind}-{number}")
    name = chance.choice(list(sound.files))
    ending = next(ending for ending in sound.spoilers if name.endswith(ending))
    change = chance.choice(sound.spoilers[ending])
    if change is spoil.trick_archive and chance.random() < 0.5:
        change = spoil.spoil_bytes
    return {**sound.files, name: change(sound.files[name], chance)}


def _read(reading: Reading, folder: Path, sound: Seed, files: dict[str, bytes]) -> dict[str, Any]:
    """What becomes of files, and of the folder around them."""
    here = folder / "case"
    for part in ("source", "target", "tmp", "cwd"):
        (here / part).mkdir(parents=True)
    for name, content in files.items():
        (here / "source" / name).write_bytes(content)
    told = reading.read(sound.reader, here, next(iter(files)))
    stray = [path for part in ("cwd", "tmp") for path in (here / part).iterdir()]
    stray += [path for path in (here / "source").iterdir() if path.name not in files]
    stray += [path for up in (here / "tmp").resolve().parents if (path := up / spoil.ESCAPED).exists()]
    if told["outcome"] == "refused":
        stray += list((here / "target").iterdir())
    if stray and told["outcome"] in SOUND:
        told = {**told, "outcome": "write", "detail": str(stray[0])}
    shutil.rmtree(here)
    return told


def _row(kind: str, found: list[dict[str, Any]]) -> dict[str, Any]:
    micros = 1e6 * np.array([each["seconds"] for each in found] or [np.nan])
    bad = [f"{number}: {each['outcome']}: {each['detail']}" for number, each in enumerate(found)
           if each["outcome"] not in SOUND]
    return {"case": kind, "us_median": float(np.median(micros)), "us_p99": float(np.percentile(micros, 99)),
            "us_worst": float(micros.max()), "reference": None, "reference_us_median": None, "ratio": None,
            "files": len(found), **{outcome: sum(each["outcome"] == outcome for each in found)
                                    for outcome in SOUND},
            "mb_worst": max((each["bytes"] for each in found), default=0) / 1e6, "bad": bad}
