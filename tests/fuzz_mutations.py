"""What is done to sound files to spoil them: as a disk, a cut connection or somebody of ill will would."""

from __future__ import annotations

import io
import random
import re
import stat
import struct
import warnings
import zipfile
import zlib
from collections.abc import Callable

_EXTREMES = (0xFF, 0x7F, 0x80, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x7FFFFFFFFFFFFFFF,
             0xFFFFFFFFFFFFFFFF, 2**40, 10**9, 0)
_WORDS = ("nan", "inf", "-1", "0", "1e999", "1e-320", "99999999999999999999", "0x10", "", "true", "null",
          "\t", "\n", ",", ";", '"', "'", "{", "[" * 3000, "}", "]", "<a>", "</info>", "<!ENTITY x 'y'>", "=",
          "\u00e9\u2603", "\x00", "n/a", "GYRO", "x" * 20000, "-", "../../up", "2000/0")
_TOKEN = re.compile(r"[-+.\w]+")
_BOMB_BYTES = 2**29
_CLIMBS = ("../{}", "../../../{}", "/tmp/{}", "a/../../{}", "..\\{}", "C:\\{}", "./../{}", "\u2025/{}")
ESCAPED = "fesloop_fuzz_escaped"
"""Name of files that an archive tries to write outside."""


def flip_bits(content: bytearray, chance: random.Random) -> None:
    """Some bits, anywhere."""
    for _ in range(chance.randint(1, 16)):
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)


def change_written(content: bytearray, chance: random.Random) -> None:
    """Some bytes that are not 0: where a format has its tags, lengths and text."""
    written = [i for i, byte in enumerate(content) if byte] or [0]
    for _ in range(chance.randint(1, 4)):
        content[chance.choice(written)] = chance.randrange(256)


def blow_up(content: bytearray, chance: random.Random) -> None:
    """A number that may be a length, far too great."""
    width = chance.choice((1, 2, 4, 8))
    at = chance.randrange(max(1, len(content) - width)) // width * width + chance.choice((0, 0, 1, 2))
    value = chance.choice(_EXTREMES) & (2**(8 * width) - 1)
    content[at:at + width] = value.to_bytes(width, chance.choice(("little", "little", "big")))


def cut(content: bytearray, chance: random.Random) -> None:
    """The end is missing."""
    del content[chance.randrange(len(content)):]


def remove_block(content: bytearray, chance: random.Random) -> None:
    """Something in between is missing."""
    at = chance.randrange(len(content))
    del content[at:at + chance.randint(1, max(1, len(content) // 4))]


def repeat_block(content: bytearray, chance: random.Random) -> None:
    """Something is there twice."""
    at = chance.randrange(len(content))
    block = content[at:at + chance.randint(1, max(1, len(content) // 4))]
    content[at:at] = block


def blank_block(content: bytearray, chance: random.Random) -> None:
    """A sector that was never written."""
    at = chance.randrange(len(content))
    size = min(chance.choice((8, 64, 512)), len(content) - at)
    content[at:at + size] = bytes(size) if chance.random() < 0.5 else chance.randbytes(size)


_BINARY: tuple[Callable[[bytearray, random.Random], None], ...] = (
    flip_bits, change_written, change_written, blow_up, blow_up, cut, remove_block, repeat_block, blank_block)


def spoil_bytes(content: bytes, chance: random.Random) -> bytes:
    """A file of any kind, spoilt once or twice."""
    spoilt = bytearray(content or b"\0")
    for _ in range(chance.choice((1, 1, 2))):
        chance.choice(_BINARY)(spoilt, chance)
        if not spoilt:
            break
    return bytes(spoilt)


def spoil_text(content: bytes, chance: random.Random) -> bytes:
    """A text file, spoilt in its words, lines or bytes."""
    text = content.decode("utf-8", "replace")
    for _ in range(chance.randint(1, 3)):
        lines = text.split("\n")
        at = chance.randrange(len(lines))
        action = chance.randrange(6)
        if action == 0:
            return spoil_bytes(text.encode("utf-8", "replace"), chance)
        if action == 1:
            del lines[at]
        elif action == 2:
            lines[at:at] = [lines[at]] * chance.choice((1, 2, 300))
        elif action == 3:
            lines[at] = lines[at][:chance.randrange(len(lines[at]) + 1)]
        else:
            words = [match.span() for match in _TOKEN.finditer(text)] or [(0, 0)]
            start, stop = chance.choice(words)
            new = chance.choice(_WORDS) if action == 4 else text[slice(*chance.choice(words))]
            text = text[:start] + new + text[stop:]
            continue
        text = "\n".join(lines)
    return text.encode("utf-8", "surrogatepass")


def spoil_xdf(content: bytes, chance: random.Random) -> bytes:
    """An XDF file whose chunks are as long as they say, but say or hold something else."""
    chunks, at = [], 4
    while at < len(content):
        width = content[at]
        length = int.from_bytes(content[at + 1:at + 1 + width], "little")
        chunks.append(content[at + 1 + width:at + 1 + width + length])
        at += 1 + width + length
    for _ in range(chance.randint(1, 3)):
        at = chance.randrange(len(chunks))
        action = chance.randrange(5)
        if action == 0:
            del chunks[at]
        elif action == 1:
            chunks.insert(chance.randrange(len(chunks)), chunks[at])
        elif action == 2:
            chunks[at] = struct.pack("<H", chance.randrange(8)) + chunks[at][2:]
        else:
            is_text = chunks[at][:2] in (b"\x01\x00", b"\x02\x00", b"\x06\x00")
            inner = 6 if chunks[at][:1] != b"\x01" else 2
            spoil = spoil_text if is_text else spoil_bytes
            chunks[at] = chunks[at][:inner] + spoil(chunks[at][inner:], chance)
        if not chunks:
            break
    return b"XDF:" + b"".join(b"\x04" + struct.pack("<I", len(chunk)) + chunk for chunk in chunks)


def spoil_mat5(content: bytes, chance: random.Random) -> bytes:
    """A compressed MATLAB 5 file whose inflated content is spoilt, and deflated again."""
    spoilt, at = content[:128], 128
    elements = []
    while at + 8 <= len(content):
        kind, size = struct.unpack_from("<II", content, at)
        elements.append((kind, content[at + 8:at + 8 + size]))
        at += 8 + size
    target = chance.randrange(len(elements))
    for number, (kind, body) in enumerate(elements):
        if kind == 15 and number == target:
            body = zlib.compress(spoil_bytes(zlib.decompress(body), chance))
        spoilt += struct.pack("<II", kind, len(body)) + body
    return spoilt


def spoil_members(content: bytes, chance: random.Random) -> bytes:
    """An archive with sound sums whose files are spoilt."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = chance.choice([*members, *(key for key in members if key.endswith(".xml"))])
    is_text = name.endswith((".xml", ".c", ".h"))
    members[name] = (spoil_text if is_text else spoil_bytes)(members[name], chance)
    if chance.random() < 0.1:
        del members[chance.choice(list(members))]
    return _archive(list(members.items()))


def _archive(members: list[tuple[str | zipfile.ZipInfo, bytes]]) -> bytes:
    made = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        warnings.simplefilter("ignore")
        for name, body in members:
            if isinstance(name, str):  # of which it would make a member of this very second
                name = zipfile.ZipInfo(name)
                name.compress_type, name.external_attr = zipfile.ZIP_DEFLATED, 0o600 << 16
            archive.writestr(name, body)
    return made.getvalue()


def trick_archive(content: bytes, chance: random.Random) -> bytes:
    """An archive that tries to leave its folder, to fill the disk, or to be something else."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members: list[tuple[str | zipfile.ZipInfo, bytes]] = [(name, archive.read(name))
                                                             for name in archive.namelist()]
    action = chance.randrange(7)
    if action == 0:
        members.append((chance.choice(_CLIMBS).format(ESCAPED), b"escaped"))
    elif action == 1:
        link = zipfile.ZipInfo("resources")
        link.create_system, link.external_attr = 3, (stat.S_IFLNK | 0o777) << 16
        members = [(link, b"/tmp"), *members, (f"resources/{ESCAPED}", b"escaped")]
    elif action == 2:
        members.append(chance.choice(members))
    elif action == 3:
        members.append(("zeros", bytes(_BOMB_BYTES)))
    elif action == 4:
        members.append(("n" * 5000 + "/" * chance.randint(1, 300), b""))
    elif action == 5:
        members = []
    made = bytearray(_archive(members))
    if action == 6:  # says that it is encrypted, or of an unknown method
        for mark in (b"PK\x03\x04", b"PK\x01\x02"):
            at = made.find(mark)
            if at >= 0:
                made[at + (6 if mark[2] == 3 else 8)] |= 1
    return bytes(made)
