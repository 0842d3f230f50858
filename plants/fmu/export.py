"""Writing the finger as an FMU of FMI 2.0: C sources for everybody, a binary where there is a compiler."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sysconfig
import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from fesloop.errors import InputError, RunError
from plants.finger.plant import Finger
from plants.fmu.export_data import FingerData, model_description, plant_data_header

SOURCES = ("fmi2_life.c", "fmi2_variables.c", "fmi2_state.c", "fmi2_model_exchange.c", "fmi2_co_simulation.c",
           "muscle_plant.c", "expm.c")
HEADERS = ("instance.h", "muscle_plant.h", "expm.h")
FMI_HEADERS = ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h")
COMPILERS = ("cc", "gcc", "clang")
COMPILE = ("-std=c11", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off",
           "-Wl,--build-id=none")
"""No contraction: the numbers do not depend on whether the processor fuses multiply and add."""
_PLATFORM = {"linux-x86_64": "linux64", "linux-aarch64": "aarch64-linux"}


@dataclass(frozen=True, slots=True)
class FmuBuilt:
    """What was written.

    Attributes
    ----------
    path: the FMU.
    size: bytes.
    guid: of its contents; equal parameters give equal bytes.
    binary: platform that it holds a binary for, "" if it holds sources only.
    note: why there is no binary, and what to do; "" if there is one.
    """

    path: Path
    size: int
    guid: str
    binary: str
    note: str


def build_finger_fmu(target: Path, *, finger: Finger | None = None, binary: bool | None = None) -> FmuBuilt:
    """Write the finger as a source FMU (co-simulation and model exchange), with a binary if it can be made.

    Parameters
    ----------
    target: file to write, ending in .fmu.
    finger: parameters; None for the default finger. Fatigue is refused: it makes the plant nonlinear.
    binary: True demands one, False leaves it out, None makes one where a C compiler is found.

    Raises
    ------
    InputError: for a bad target, a finger with fatigue, or no compiler where a binary is demanded.
    RunError: if the compiler fails.
    """
    target = Path(target)
    if target.suffix != ".fmu":
        raise InputError("target", f"{target} does not end in .fmu", "a file name such as finger.fmu")
    if not target.parent.is_dir():
        raise InputError("target", f"the folder {target.parent} does not exist", remedy="make it first")
    finger = finger if finger is not None else Finger()
    if finger.fatigue is not None:
        raise InputError("finger.fatigue", "an exported finger cannot tire", "no fatigue", "leave it out")
    guid, files = _source_files(finger)
    platform, note = "", "binary left out as asked"
    if binary is not False:
        compiler = _compiler()
        if compiler is not None:
            platform = _platform()
            files[f"binaries/{platform}/finger.so"] = _compiled(compiler, files)
            note = ""
        else:
            note = f"no C compiler ({', '.join(COMPILERS)}) found: the FMU holds sources only"
            if binary:
                raise InputError("binary", note, remedy="install gcc, or ask for a source FMU")
    _write_archive(target, files)
    return FmuBuilt(target, target.stat().st_size, guid, platform, note)


def _source_files(finger: Finger) -> tuple[str, dict[str, bytes]]:
    """GUID, and every file of the source FMU by its name in the archive."""
    packaged = resources.files("plants.fmu") / "sources"
    files = {f"sources/{name}": (packaged / name).read_bytes() for name in (*SOURCES, *HEADERS)}
    fmi = resources.files("fmpy") / "c-code"
    files |= {f"sources/{name}": (fmi / name).read_bytes() for name in FMI_HEADERS}
    data = FingerData.of(finger.equations())
    content = hashlib.sha256(plant_data_header(data, "").encode())
    for name in sorted(files):
        content.update(name.encode() + files[name])
    guid = "{" + content.hexdigest()[:32] + "}"
    files["sources/plant_data.h"] = plant_data_header(data, guid).encode()
    files["modelDescription.xml"] = model_description(data, guid, SOURCES)
    return guid, files


def _compiler() -> str | None:
    """Path of the first C compiler on the search path."""
    return next((found for name in COMPILERS if (found := shutil.which(name))), None)


def _platform() -> str:
    """FMI's name of this platform."""
    system = sysconfig.get_platform()
    if system not in _PLATFORM:
        raise InputError("binary", f"no binary FMU can be built on {system}", ", ".join(_PLATFORM),
                         "ask for a source FMU")
    return _PLATFORM[system]


@contextmanager
def _unpacked(files: dict[str, bytes]) -> Iterator[Path]:
    """A temporary folder with the source files."""
    with tempfile.TemporaryDirectory(prefix="fesloop-fmu-") as name:
        folder = Path(name)
        for path, content in files.items():
            if path.startswith("sources/"):
                (folder / path.removeprefix("sources/")).write_bytes(content)
        yield folder


def _compiled(compiler: str, files: dict[str, bytes]) -> bytes:
    """The shared library; compiled by relative names, so that its bytes do not tell where."""
    with _unpacked(files) as folder:
        command = [compiler, *COMPILE, *SOURCES, "-o", "finger.so", "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines() or ["no message"]
            raise RunError(f"{compiler} failed on the finger's sources: {lines[0]}")
        return (folder / "finger.so").read_bytes()


def _write_archive(target: Path, files: dict[str, Any]) -> None:
    """A zip whose bytes depend on nothing but its contents; appears whole or not at all."""
    partial = target.with_name(f".{target.name}.partial")
    try:
        with zipfile.ZipFile(partial, "w") as archive:
            for name in sorted(files, key=lambda name: (name != "modelDescription.xml", name)):
                entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.create_system = 3
                entry.external_attr = (0o755 if name.endswith(".so") else 0o644) << 16
                archive.writestr(entry, files[name])
        partial.replace(target)
    except OSError as fault:
        raise InputError("target", f"{target} cannot be written: {fault.strerror}",
                         "a file in a folder that can be written to") from None
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
