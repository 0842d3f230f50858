"""The loop's end of a kept device: starts the keeper, sends commands, hears what became of them."""

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
"""For the keeper's process to be there (chosen: 100 times what it takes on a quiet machine)."""
_BUSY_ANSWERS = 4.0
"""Answers of the device that a keeper waits for at most: to a command under way, and to three stops."""
_MS_PER_S = 1e3


@dataclass(slots=True, eq=False)
class KeptDevice:
    """A device in the hands of a keeper. Holds a process and a line: it cannot be copied or saved.

    Attributes
    ----------
    name: of the block, for messages.
    line: to the keeper.
    keeper: its process.
    answer_ms: the device's, for the time that a keeper may be busy.
    hold_ms: after so long without a fresh command the keeper stops the device.
    number: of the command sent last.
    sent: instants of the commands under way, by number.
    answer_s: from sending to the device's answer, of the newest command answered.
    origin_ns: monotonic clock at t = 0; 0 before it is known.
    told: whether the loop knows that the device is stopped, or its keeper gone.
    granted: what the operating system grants the keeper, in words.
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
    told: bool = False
    granted: str = ""

    @classmethod
    def started(cls, name: str, terms: Terms, answer_ms: float, open_s: float) -> KeptDevice:
        """A keeper that has the device open and gives nothing; RunError where it cannot.

        The keeper finds the same modules as this process, and has a session of its own: what a terminal
        sends to everybody in front of it, such as Ctrl-C, is for the loop alone.
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
        told = self._read(self._packet() or b"")
        if isinstance(told, Answer) or not told.get("ready"):
            raise RunError(f"{self.name}: the device does not open: {_cause(told)}")
        self.granted = f"memory: {told.get('memory')}; scheduling: {told.get('scheduling')}"

    def send(self, pulses: Pulses, of_ns: int | None = None) -> None:
        """A command, now; never waits. RunError where the keeper is gone, or too busy to be one.

        `of_ns`: instant of the loop that it belongs to (monotonic clock); None: this one.
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
        """Take the answers that have come. RunError, with the cause, where the device is stopped."""
        while (message := self._packet()) is not None:
            if not message:
                raise self._failure(self._keepers_end())
            told = self._read(message)
            if not isinstance(told, Answer):
                raise self._failure(f"the device is stopped: {_cause(told)}{self._when(told)}")
            self._answered(told)
        self._require_answers()

    def _packet(self) -> bytes | None:
        """The next message from the keeper; empty at the end of the line, None while there is none.

        Where the keeper ends with a command unread, the line tells that first, and what it said after.
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
        """Older commands that the keeper passed over are answered with it."""
        sent_ns = self.sent.get(answer.number, answer.taken_ns)
        self.answer_s = (answer.taken_ns - sent_ns) / (_MS_PER_S * NS_PER_MS)
        self.sent = {number: at for number, at in self.sent.items() if number > answer.number}

    def _require_answers(self) -> None:
        """A keeper that answers nothing for so long hangs, and the device is left to itself."""
        if self.sent:
            oldest, newest = min(self.sent.values()), max(self.sent.values())
            waited_ms = (newest - oldest) / NS_PER_MS
            if waited_ms > self.hold_ms + self._busy_ms:
                raise self._failure(f"the keeper of the device has not answered for {waited_ms:.0f} ms; "
                                    "the device's own watchdog ends stimulation")

    @property
    def _busy_ms(self) -> float:
        """The longest that a keeper in good health says nothing."""
        return _BUSY_ANSWERS * self.answer_ms + SLACK_MS

    def _failure(self, what: str) -> RunError:
        """What ends the run."""
        self.told = True
        return RunError(f"{self.name}: {what}")

    def _read(self, message: bytes) -> Answer | dict[str, Any]:
        if not message:
            return {"status": "keeper_ended", "detail": self._keepers_end()}
        try:
            return read_answer(message)
        except Malformed as fault:
            return {"status": "malformed", "detail": f"the keeper said: {fault}"}

    def _keepers_end(self) -> str:
        with suppress(subprocess.TimeoutExpired):
            self.keeper.wait(1.0)
        code = self.keeper.returncode
        how = f"exit code {code}" if code is None or code >= 0 else f"signal {-code}"
        return (f"the keeper of the device has ended by itself ({how}); the device's own watchdog ends "
                "stimulation")

    def _when(self, told: dict[str, Any]) -> str:
        """The instant of a stop, on the loop's clock."""
        at_ns = told.get("at_ns", 0) - self.origin_ns
        return f" (at {at_ns / (_MS_PER_S * NS_PER_MS):.3f} s)" if self.origin_ns and at_ns > 0 else ""

    def close(self) -> None:
        """Zero current and an end to the keeper.

        Raises RunError where the device did not confirm zero current, and for a fault of the device that
        nobody has been told of yet. Silence is none after the last command.
        """
        if self.line.fileno() < 0:
            return
        told: dict[str, Any] = {}
        try:
            with suppress(OSError):
                self.line.send(note_bytes(end=True))
            told = self._last_words()
        finally:
            self._let_go()
        if self.told:
            return
        if not told.get("stopped"):
            raise RunError(f"{self.name}: the device has not confirmed zero current; it stops by itself when "
                           "it hears nothing more")
        if told.get("status", "command_timeout") != "command_timeout":
            raise RunError(f"{self.name}: the device failed at the end: {_cause(told)}")

    def _last_words(self) -> dict[str, Any]:
        """The keeper's note of how the device was left; empty where none comes."""
        until = time.monotonic() + (self._busy_ms + 4.0 * SLACK_MS) / _MS_PER_S
        poll = select.poll()
        poll.register(self.line, select.POLLIN)
        while (left_s := until - time.monotonic()) > 0.0 and poll.poll(left_s * _MS_PER_S):
            message = self._packet()
            if not message:
                return {}
            told = self._read(message)
            if not isinstance(told, Answer):
                return told
        return {}

    def _let_go(self) -> None:
        """End the line, and with it the keeper; one that does not end is ended."""
        self.line.close()
        try:
            self.keeper.wait((self._busy_ms + 10.0 * SLACK_MS) / _MS_PER_S)
        except subprocess.TimeoutExpired:
            self.keeper.kill()
            self.keeper.wait()


def _cause(told: Answer | dict[str, Any]) -> str:
    """What the keeper told, in words."""
    if isinstance(told, Answer):
        return "the keeper answered what was not asked"
    known = "" if told.get("stopped", True) else ("; it has not confirmed zero current, and stops by itself "
                                                  "when it hears nothing more")
    return f"{told.get('status', 'no status')}: {told.get('detail', '')}{known}"
