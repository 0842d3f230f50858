"""C sources as a shared library, and files as an FMU's archive."""

from __future__ import annotations

import shutil
import subprocess
import sysconfig
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from importlib import resources
from pathlib import Path

from fesloop.errors import InputError, RunError

FMI_HEADERS = ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h")
COMPILERS = ("cc", "gcc", "clang")
COMPILE = ("-std=c11", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off",
           "-Wl,--build-id=none")
"""Without contraction, results do not depend on whether the processor fuses multiply and add."""
_PLATFORM = {"linux-x86_64": "linux64", "linux-aarch64": "aarch64-linux"}
BASE_UNITS: dict[str, dict[str, str]] = {
    "A": {"A": "1"}, "s": {"s": "1"}, "rad": {"rad": "1"}, "rad/s": {"rad": "1", "s": "-1"},
    "rad/s^2": {"rad": "1", "s": "-2"}, "1": {}}
"""Exponents of SI base units, by unit."""


def fmi_headers() -> dict[str, bytes]:
    """Headers of FMI 2.0, by their names among the sources."""
    packaged = resources.files("fmpy") / "c-code"
    return {f"sources/{name}": (packaged / name).read_bytes() for name in FMI_HEADERS}


def find_compiler() -> str | None:
    """Path of the first C compiler on the search path."""
    return next((found for name in COMPILERS if (found := shutil.which(name))), None)


def platform() -> str:
    """FMI 2.0's name of this platform; raises InputError where no binary can be built."""
    system = sysconfig.get_platform()
    if system not in _PLATFORM:
        raise InputError("binary", f"no binary FMU can be built on {system}", ", ".join(_PLATFORM),
                         "export sources only")
    return _PLATFORM[system]


def shared_library(compiler: str, files: Mapping[str, bytes], sources: Sequence[str], name: str) -> bytes:
    """Compile `sources`, which are among `files` in the folder sources, into the library `name`.so.

    File names are relative, so that its bytes do not depend on the folder. Raises RunError if the compiler
    fails.
    """
    with tempfile.TemporaryDirectory(prefix="fesloop-fmu-") as made:
        folder = Path(made)
        for path, content in files.items():
            if path.startswith("sources/"):
                (folder / path.removeprefix("sources/")).write_bytes(content)
        command = [compiler, *COMPILE, *sources, "-o", f"{name}.so", "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines() or ["no message"]
            raise RunError(f"{compiler} failed on the sources of {name}: {lines[0]}")
        return (folder / f"{name}.so").read_bytes()


def write_archive(target: Path, files: Mapping[str, bytes]) -> None:
    """Write a zip whose bytes depend on its contents alone; it appears whole or not at all."""
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
