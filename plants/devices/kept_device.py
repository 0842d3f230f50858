"""Loop's side of a kept device: starts the keeper, sends commands and receives their answers."""

from __future__ import annotations

import os
import select
import socket
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from fesloop.errors import RunError
from fesloop.loop.clock import NS_PER_MS
from plants.devices.driver import SLACK_MS, Pulses
from plants.devices.messages import (
    MOST_BYTES,
    Answer,
    Malformed,
    Terms,
    command_bytes,
    note_bytes,
    read_answer,
    terms_bytes,
)

_START_S = 20.0
"""Longest start of the keeper's process (chosen: 100 times the time on a quiet machine)."""
_BUSY_ANSWERS = 4.0
"""Most answers of the device that a keeper waits for: to a pending command, and to three stops."""
_MS_PER_S = 1e3


@dataclass(slots=True, eq=False)
class KeptDevice:
    """A device held by a keeper. It owns a process and a socket, so it cannot be copied or saved.

    Attributes
    ----------
    name: name of the block, for messages.
    line: socket to the keeper.
    keeper: process of the keeper.
    answer_ms: longest answer of the device, from which the keeper's busy time follows.
    hold_ms: time without a fresh command after which the keeper stops the device.
    number: number of the command sent last.
    sent: instants of unanswered commands, by number.
    answer_s: time from sending to the device's answer, of the newest answered command.
    origin_ns: monotonic clock at t = 0; 0 before it is known.
    reported: whether the loop knows that the device is stopped, or its keeper gone.
    granted: memory and scheduling granted to the keeper by the operating system, as text.
    """

    name: str
    line: socket.socket
    keeper: subprocess.Popen[bytes]
    answer_ms: float
    hold_ms: float
    number: int = -1
    sent: dict[int, int] = field(default_factory=dict)
    answer_s: float = 0.0
    origin_ns: int = 0
    reported: bool = False
    granted: str = ""

    @classmethod
    def started(cls, name: str, terms: Terms, answer_ms: float, open_s: float) -> KeptDevice:
        """Start a keeper with an open device without current; RunError if that fails.

        The keeper has the module path of this process, and its own session: signals of a terminal, such as
        Ctrl-C, reach the loop alone.
        """
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            modules = os.pathsep.join(path or os.curdir for path in sys.path)
            keeper = subprocess.Popen(
                [sys.executable, "-P", "-m", "plants.devices.keeper", str(theirs.fileno())],
                pass_fds=(theirs.fileno(),), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                env={**os.environ, "PYTHONPATH": modules}, start_new_session=True)
        this = cls(name, ours, keeper, answer_ms, terms.hold_ms)
        try:
            ours.send(terms_bytes(terms))
            this._await_ready(open_s + _START_S)
        except BaseException:
            this._let_go()
            raise
        ours.setblocking(False)
        return this

    def _await_ready(self, patience_s: float) -> None:
        poll = select.poll()
        poll.register(self.line, select.POLLIN)
        if not poll.poll(patience_s * _MS_PER_S):
            raise RunError(f"{self.name}: the keeper of the device was not ready within {patience_s:g} s")
        note = self._read(self._packet() or b"")
        if isinstance(note, Answer) or not note.get("ready"):
            raise RunError(f"{self.name}: the device does not open: {_cause(note)}")
        self.granted = f"memory: {note.get('memory')}; scheduling: {note.get('scheduling')}"

    def send(self, pulses: Pulses, of_ns: int | None = None) -> None:
        """Send a command without waiting; RunError if the keeper is gone or overloaded.

        `of_ns`: the command's instant of the loop (monotonic clock); None: now.
        """
        self.number += 1
        now = time.monotonic_ns()
        self.sent[self.number] = now
        try:
            self.line.send(command_bytes(self.number, now if of_ns is None else of_ns, pulses))
        except BlockingIOError:
            raise self._failure("the keeper of the device takes no more commands") from None
        except OSError:
            self.hear()
            raise self._failure(self._keepers_end()) from None

    def hear(self) -> None:
        """Receive answers; RunError, with the cause, if the device is stopped."""
        while (message := self._packet()) is not None:
            if not message:
                raise self._failure(self._keepers_end())
            received = self._read(message)
            if not isinstance(received, Answer):
                raise self._failure(f"the device is stopped: {_cause(received)}{self._when(received)}")
            self._answered(received)
        self._require_answers()

    def _packet(self) -> bytes | None:
        """The next message from the keeper; empty at the end of the line, None if there is none.

        If the keeper ends with an unread command, the socket reports that error before its last messages.
        """
        for _ in range(2):
            try:
                return self.line.recv(MOST_BYTES)
            except BlockingIOError:
                return None
            except OSError:
                continue
        return b""

    def _answered(self, answer: Answer) -> None:
        """Note an answer, which also covers older commands that the keeper skipped."""
        sent_ns = self.sent.get(answer.number, answer.taken_ns)
        self.answer_s = (answer.taken_ns - sent_ns) / (_MS_PER_S * NS_PER_MS)
        self.sent = {number: at for number, at in self.sent.items() if number > answer.number}

    def _require_answers(self) -> None:
        """Raise RunError if the keeper has not answered for so long that it must hang."""
        if self.sent:
            oldest, newest = min(self.sent.values()), max(self.sent.values())
            waited_ms = (newest - oldest) / NS_PER_MS
            if waited_ms > self.hold_ms + self._busy_ms:
                raise self._failure(f"the keeper of the device has not answered for {waited_ms:.0f} ms; "
                                    "the device's own watchdog ends stimulation")

    @property
    def _busy_ms(self) -> float:
        """Longest time for which a working keeper does not answer."""
        return _BUSY_ANSWERS * self.answer_ms + SLACK_MS

    def _failure(self, what: str) -> RunError:
        """Error that ends the run."""
        self.reported = True
        return RunError(f"{self.name}: {what}")

    def _read(self, message: bytes) -> Answer | dict[str, Any]:
        if not message:
            return {"status": "keeper_ended", "detail": self._keepers_end()}
        try:
            return read_answer(message)
        except Malformed as fault:
            return {"status": "malformed", "detail": f"from the keeper: {fault}"}

    def _keepers_end(self) -> str:
        with suppress(subprocess.TimeoutExpired):
            self.keeper.wait(1.0)
        code = self.keeper.returncode
        how = f"exit code {code}" if code is None or code >= 0 else f"signal {-code}"
        return (f"the keeper of the device has ended by itself ({how}); the device's own watchdog ends "
                "stimulation")

    def _when(self, note: dict[str, Any]) -> str:
        """Instant of a stop on the loop's clock, as text."""
        at_ns = note.get("at_ns", 0) - self.origin_ns
        return f" (at {at_ns / (_MS_PER_S * NS_PER_MS):.3f} s)" if self.origin_ns and at_ns > 0 else ""

    def close(self) -> None:
        """Set zero current and end the keeper.

        Raises RunError if the device does not confirm zero current, and for a fault of the device not yet
        reported. Silence after the last command is no fault.
        """
        if self.line.fileno() < 0:
            return
        note: dict[str, Any] = {}
        try:
            with suppress(OSError):
                self.line.send(note_bytes(end=True))
            note = self._last_note()
        finally:
            self._let_go()
        if self.reported:
            return
        if not note.get("stopped"):
            raise RunError(f"{self.name}: the device has not confirmed zero current; it stops by itself when "
                           "it receives no more messages")
        if note.get("status", "command_timeout") != "command_timeout":
            raise RunError(f"{self.name}: the device failed at the end: {_cause(note)}")

    def _last_note(self) -> dict[str, Any]:
        """Last note of the keeper, with the state of the device; empty if none arrives."""
        until = time.monotonic() + (self._busy_ms + 4.0 * SLACK_MS) / _MS_PER_S
        poll = select.poll()
        poll.register(self.line, select.POLLIN)
        while (left_s := until - time.monotonic()) > 0.0 and poll.poll(left_s * _MS_PER_S):
            message = self._packet()
            if not message:
                return {}
            note = self._read(message)
            if not isinstance(note, Answer):
                return note
        return {}

    def _let_go(self) -> None:
        """Close the line, which ends the keeper, and kill a keeper that does not end."""
        self.line.close()
        try:
            self.keeper.wait((self._busy_ms + 10.0 * SLACK_MS) / _MS_PER_S)
        except subprocess.TimeoutExpired:
            self.keeper.kill()
            self.keeper.wait()


def _cause(note: Answer | dict[str, Any]) -> str:
    """Text of the keeper's note."""
    if isinstance(note, Answer):
        return "the keeper sent an unexpected answer"
    known = "" if note.get("stopped", True) else ("; it has not confirmed zero current, and stops by itself "
                                                  "when it receives no more messages")
    return f"{note.get('status', 'no status')}: {note.get('detail', '')}{known}"
