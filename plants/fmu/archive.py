"""Archives of FMUs: checked before anything is written, extracted to a temporary folder."""

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
"""Limit of an unpacked archive: 256 MB, or 50 times its size if that is more (chosen: shared libraries shrink
to a third, tables of numbers to a tenth; zeros to a thousandth, so that a zip of 1 MB could fill a disk)."""
SHIPPED = "shipped:finger"
"""Path that names the default finger as an FMU, built on demand."""
_CORRUPT = (zipfile.BadZipFile, OSError, EOFError, NotImplementedError, RuntimeError)


class ExtractedFmu:
    """Extracted files of one FMU, shared by its instances; the folder is removed with the last user.

    Attributes
    ----------
    path: the .fmu file.
    digest: sha256 of that file; for the shipped FMU of its description, as its binary differs by compiler.
    folder: folder that the archive is extracted to.
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
        """Remove the folder."""
        self._remove()

    def __reduce__(self) -> tuple[object, tuple[Path, str]]:
        return _extract_again, (self.path, self.digest)


def _opened(path: Path) -> io.BufferedReader | io.BytesIO:
    """The archive, open for reading; the shipped one is built first."""
    if str(path) == SHIPPED:
        from plants.fmu.export import build_finger_fmu

        with tempfile.TemporaryDirectory(prefix="fesloop-fmu-") as folder:
            return io.BytesIO(build_finger_fmu(Path(folder) / "finger.fmu", binary=True).path.read_bytes())
    try:
        return path.open("rb")
    except OSError as fault:
        raise InputError("path", f"{path} cannot be read: {fault.strerror}",
                         f"an .fmu file, or {SHIPPED}") from None


def _extract_again(path: Path, digest: str) -> ExtractedFmu:
    """Extract in another process, or for a saved run; SnapshotError for another file."""
    extracted = ExtractedFmu(path)
    if extracted.digest != digest:
        raise SnapshotError(f"{path} has changed since the state was saved")
    return extracted


def _remove_folder(folder: Path, owner: int) -> None:
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)


def _extract(file: IO[bytes], path: Path) -> Path:
    """Check an archive and extract it; nothing is written unless every name in it is safe."""
    try:
        archive = zipfile.ZipFile(file)
    except _CORRUPT:
        raise InputError("path", f"{path} is not a zip archive", "an FMU",
                         "export it again, or copy it again if it was cut short") from None
    with archive:
        require_safe(archive, path)
        if "modelDescription.xml" not in archive.namelist():
            raise InputError("path", f"{path} contains no modelDescription.xml", "an FMU")
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


def require_safe(archive: zipfile.ZipFile, path: Path) -> None:
    """Raise InputError for an archive with a file outside its folder, a link, or too much in it."""
    for entry in archive.infolist():
        _check_entry(entry, path)
    declared = sum(entry.file_size for entry in archive.infolist())
    file = archive.fp
    most = max(ROOM_BYTES, EXPANSION * file.seek(0, os.SEEK_END)) if file is not None else ROOM_BYTES
    if declared > most:
        raise InputError("path", f"{path} would unpack to {declared / 1e6:.0f} MB",
                         f"{most / 1e6:.0f} MB", "zip it again without compression if that is intended")


def _check_entry(entry: zipfile.ZipInfo, path: Path) -> None:
    """Raise InputError for an entry that would leave its folder, or is not a plain file."""
    name = entry.orig_filename
    parts = PurePosixPath(name).parts
    if name.startswith("/") or "\\" in name or ":" in name or ".." in parts or "\0" in name:
        raise InputError("path", f"{path} contains the file {name!r}, which would be written outside its "
                         "folder", "relative names without '..'",
                         "do not use this file; nothing was extracted")
    mode = entry.external_attr >> 16
    if mode and stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
        raise InputError("path", f"{path} contains {name!r}, which is a link or device, not a file",
                         "plain files", "do not use this file; nothing was extracted")
