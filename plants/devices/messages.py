"""Messages between loop and keeper: packets on a socket pair, each whole or absent.

    loop to keeper    terms, commands, "end"
    keeper to loop    "ready"; an answer for each command that the device has taken; "stopped", with the cause

A command carries its number, its instant of the loop (by the monotonic clock, which all processes of a
machine share), the pulses and a checksum. Anything else is malformed.
"""

from __future__ import annotations

import json
import socket
import struct
import zlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from plants.devices.driver import Pulses

MOST_BYTES = 4096
_MOST_PACKETS = 256
"""Most packets read at once, so that a flood of messages does not keep the keeper from checking the time."""
_COMMAND, _ANSWER, _NOTE = b"C", b"A", b"N"
_HEAD = struct.Struct("<cQq")
_CHECK = struct.Struct("<I")


class Malformed(ValueError):
    """A malformed message."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """Settings of a keeper.

    Attributes
    ----------
    driver: "module:Class" of the driver.
    port, channels, hertz: arguments of the driver.
    charge_max: largest charge of a phase in any command, C.
    hold_ms: time without a fresh command after which the device is stopped.
    loop: process number of the loop.
    """

    driver: str
    port: str
    channels: int
    hertz: float
    charge_max: float
    hold_ms: float
    loop: int


class Command(NamedTuple):
    """Pulses for all channels, with the number of the command and its instant of the loop, ns."""

    number: int
    of_ns: int
    pulses: Pulses


class Answer(NamedTuple):
    """Confirmation that the device took the command of this number, at this instant, ns."""

    number: int
    taken_ns: int


def command_bytes(number: int, of_ns: int, pulses: Pulses) -> bytes:
    """Encode a command."""
    flat = [value for pulse in pulses for value in pulse]
    body = _HEAD.pack(_COMMAND, number, of_ns) + struct.pack(f"<{len(flat)}d", *flat)
    return body + _CHECK.pack(zlib.crc32(body))


def read_command(message: bytes, channels: int) -> Command:
    """Decode a command; Malformed for anything else."""
    if len(message) != _HEAD.size + 16 * channels + _CHECK.size:
        raise Malformed(f"{len(message)} bytes are not a command for {channels} channels")
    body = message[:-_CHECK.size]
    if _CHECK.unpack(message[-_CHECK.size:]) != (zlib.crc32(body),):
        raise Malformed("a command fails its checksum")
    kind, number, of_ns = _HEAD.unpack_from(body)
    if kind != _COMMAND:
        raise Malformed(f"{kind!r} is not a command")
    flat = struct.unpack_from(f"<{2 * channels}d", body, _HEAD.size)
    return Command(number, of_ns, tuple(zip(flat[::2], flat[1::2], strict=True)))


def answer_bytes(answer: Answer) -> bytes:
    """Encode an answer."""
    return _HEAD.pack(_ANSWER, *answer)


def note_bytes(**content: Any) -> bytes:
    """Encode a note, a message of any other kind."""
    return _NOTE + json.dumps(content).encode()


def terms_bytes(terms: Terms) -> bytes:
    """Encode the terms."""
    return note_bytes(**asdict(terms))


def read_terms(message: bytes) -> Terms:
    """Decode the terms; Malformed for anything else."""
    try:
        return Terms(**_note(message))
    except TypeError as fault:
        raise Malformed(str(fault)) from None


def is_note(message: bytes) -> bool:
    """Whether a message is a note, such as "end"."""
    return message[:1] == _NOTE


def read_answer(message: bytes) -> Answer | dict[str, Any]:
    """Decode an answer or a note; Malformed for anything else."""
    if message[:1] == _ANSWER and len(message) == _HEAD.size:
        _, number, taken_ns = _HEAD.unpack(message)
        return Answer(number, taken_ns)
    return _note(message)


def packets(line: socket.socket) -> Iterator[bytes]:
    """Packets received at the keeper's end of the line; an empty one is the end of the line."""
    for _ in range(_MOST_PACKETS):
        try:
            message = line.recv(MOST_BYTES, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return
        except OSError:
            message = b""
        yield message
        if not message:
            return


def _note(message: bytes) -> dict[str, Any]:
    try:
        content = json.loads(message[1:]) if is_note(message) else None
    except ValueError:
        content = None
    if not isinstance(content, dict):
        raise Malformed(f"{message[:16]!r} is not a message")
    return content
