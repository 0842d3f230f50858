"""An FMU's archive: checked before anything is written, extracted to a folder that goes after use."""

from __future__ import annotations

import hashlib
import io
import os
import shutil
import stat
import tempfile
import weakref
import zipfile
from pathlib import Path, PurePosixPath
from typing import IO

from fesloop.errors import InputError, SnapshotError

ROOM_BYTES, EXPANSION = 2**28, 50
"""An archive is unpacked to 256 MB, or 50 times its size if that is more (chosen: shared libraries shrink to
a third, tables of numbers to a tenth; zeros to a thousandth, so that a zip of 1 MB could fill a disk)."""
SHIPPED = "shipped:finger"
"""Path that stands for the default finger as an FMU, built when it is asked for."""
_CORRUPT = (zipfile.BadZipFile, OSError, EOFError, NotImplementedError, RuntimeError)


class ExtractedFmu:
    """The extracted files of one FMU, shared by its instances; the folder goes when the last user does.

    Attributes
    ----------
    path: the .fmu file.
    digest: sha256 of that file; of the shipped one without its binary, which differs by compiler.
    folder: where the archive was extracted to.
    """

    __slots__ = ("__weakref__", "_remove", "digest", "folder", "path")

    def __init__(self, path: Path) -> None:
        self.path = path
        with _opened(path) as file:
            self.digest = hashlib.file_digest(file, "sha256").hexdigest()
            self.folder = _extract(file, path)
        if str(path) == SHIPPED:
            # Its description names the hash of all its sources and parameters.
            description = (self.folder / "modelDescription.xml").read_bytes()
            self.digest = hashlib.sha256(description).hexdigest()
        self._remove = weakref.finalize(self, _remove_folder, self.folder, os.getpid())

    def close(self) -> None:
        """Remove the folder now."""
        self._remove()

    def __reduce__(self) -> tuple[object, tuple[Path, str]]:
        return _again, (self.path, self.digest)


def _opened(path: Path) -> io.BufferedReader | io.BytesIO:
    """The archive, open to read; the shipped one is built first."""
    if str(path) == SHIPPED:
        from plants.fmu.export import build_finger_fmu

        with tempfile.TemporaryDirectory(prefix="fesloop-fmu-") as folder:
            return io.BytesIO(build_finger_fmu(Path(folder) / "finger.fmu", binary=True).path.read_bytes())
    try:
        return path.open("rb")
    except OSError as fault:
        raise InputError("path", f"{path} cannot be read: {fault.strerror}",
                         f"an .fmu file, or {SHIPPED}") from None


def _again(path: Path, digest: str) -> ExtractedFmu:
    """The files of an FMU in another process, or of a saved run: the same archive or none."""
    extracted = ExtractedFmu(path)
    if extracted.digest != digest:
        raise SnapshotError(f"{path} has changed since the state was saved")
    return extracted


def _remove_folder(folder: Path, owner: int) -> None:
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)


def _extract(file: IO[bytes], path: Path) -> Path:
    """Extract a checked archive; nothing is written unless every name in it is safe."""
    try:
        archive = zipfile.ZipFile(file)
    except _CORRUPT:
        raise InputError("path", f"{path} is not a zip archive", "an FMU",
                         "export it again, or copy it again if it was cut short") from None
    with archive:
        for entry in archive.infolist():
            _check_entry(entry, path)
        declared = sum(entry.file_size for entry in archive.infolist())
        most = max(ROOM_BYTES, EXPANSION * file.seek(0, os.SEEK_END))
        if declared > most:
            raise InputError("path", f"{path} would unpack to {declared / 1e6:.0f} MB",
                             f"{most / 1e6:.0f} MB", "zip it again without compression if that is meant")
        if "modelDescription.xml" not in archive.namelist():
            raise InputError("path", f"{path} holds no modelDescription.xml", "an FMU")
        folder = Path(tempfile.mkdtemp(prefix="fesloop-fmu-"))
        try:
            archive.extractall(folder)
        except BaseException as fault:
            shutil.rmtree(folder, ignore_errors=True)
            if isinstance(fault, (*_CORRUPT, ValueError)) or type(fault).__module__ == "zlib":
                raise InputError("path", f"{path} cannot be extracted: {fault}",
                                 remedy="copy it again, or make room in the temporary folder") from None
            raise
    return folder


def _check_entry(entry: zipfile.ZipInfo, path: Path) -> None:
    """Raise InputError for an entry that would leave the folder it is extracted to, or is no plain file."""
    name = entry.orig_filename
    parts = PurePosixPath(name).parts
    if name.startswith("/") or "\\" in name or ":" in name or ".." in parts or "\0" in name:
        raise InputError("path", f"{path} holds the file {name!r}, which escapes the folder it is extracted "
                         "to", "relative names without '..'", "do not use this file; nothing was extracted")
    mode = entry.external_attr >> 16
    if mode and stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
        raise InputError("path", f"{path} holds {name!r}, which is a link or device, not a file",
                         "plain files", "do not use this file; nothing was extracted")
