"""What loop and keeper say to each other: packets on a socket pair, each whole or not there.

    loop to keeper    terms, commands, "end"
    keeper to loop    "ready"; an answer for each command that the device has taken; "stopped", with the cause

A command carries its number, the instant of the loop that it belongs to (by the monotonic clock, which all
processes of a machine share), the pulses and a checksum. What is not exactly that is malformed.
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
"""Taken at once: a loop gone wild must not keep the keeper from looking at the clock."""
_COMMAND, _ANSWER, _NOTE = b"C", b"A", b"N"
_HEAD = struct.Struct("<cQq")
_CHECK = struct.Struct("<I")


class Malformed(ValueError):
    """A message that is none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """On what terms the keeper keeps the device.

    Attributes
    ----------
    driver: "module:Class" of it.
    port, channels, hertz: as a driver takes them.
    charge_max: C, of a phase: no command may ask for more.
    hold_ms: without a fresh command for so long the device is stopped.
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
    """Pulses for all channels, with their number and the instant of the loop that they belong to, ns."""

    number: int
    of_ns: int
    pulses: Pulses


class Answer(NamedTuple):
    """The device took the command of that number at that instant, ns."""

    number: int
    taken_ns: int


def command_bytes(number: int, of_ns: int, pulses: Pulses) -> bytes:
    """A command as it goes over the line."""
    flat = [value for pulse in pulses for value in pulse]
    body = _HEAD.pack(_COMMAND, number, of_ns) + struct.pack(f"<{len(flat)}d", *flat)
    return body + _CHECK.pack(zlib.crc32(body))


def read_command(message: bytes, channels: int) -> Command:
    """A command from the line; raises Malformed for anything else."""
    if len(message) != _HEAD.size + 16 * channels + _CHECK.size:
        raise Malformed(f"{len(message)} bytes are no command for {channels} channels")
    body = message[:-_CHECK.size]
    if _CHECK.unpack(message[-_CHECK.size:]) != (zlib.crc32(body),):
        raise Malformed("a command fails its checksum")
    kind, number, of_ns = _HEAD.unpack_from(body)
    if kind != _COMMAND:
        raise Malformed(f"{kind!r} is no command")
    flat = struct.unpack_from(f"<{2 * channels}d", body, _HEAD.size)
    return Command(number, of_ns, tuple(zip(flat[::2], flat[1::2], strict=True)))


def answer_bytes(answer: Answer) -> bytes:
    """An answer as it goes over the line."""
    return _HEAD.pack(_ANSWER, *answer)


def note_bytes(**told: Any) -> bytes:
    """Anything that is rare, as it goes over the line."""
    return _NOTE + json.dumps(told).encode()


def terms_bytes(terms: Terms) -> bytes:
    """The terms as they go over the line."""
    return note_bytes(**asdict(terms))


def read_terms(message: bytes) -> Terms:
    """The terms from the line; raises Malformed for anything else."""
    try:
        return Terms(**_note(message))
    except TypeError as fault:
        raise Malformed(str(fault)) from None


def is_note(message: bytes) -> bool:
    """Whether a message is a note, such as "end"."""
    return message[:1] == _NOTE


def read_answer(message: bytes) -> Answer | dict[str, Any]:
    """An answer, or a note; raises Malformed for anything else."""
    if message[:1] == _ANSWER and len(message) == _HEAD.size:
        _, number, taken_ns = _HEAD.unpack(message)
        return Answer(number, taken_ns)
    return _note(message)


def packets(line: socket.socket) -> Iterator[bytes]:
    """What has come on the keeper's end of the line; an empty one stands for its end."""
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
        told = json.loads(message[1:]) if is_note(message) else None
    except ValueError:
        told = None
    if not isinstance(told, dict):
        raise Malformed(f"{message[:16]!r} is no message")
    return told
