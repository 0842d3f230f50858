"""Keeper: a separate process that alone holds a stimulator, and stops it when the loop sends no commands.

The keeper checks every command again: form, checksum, number, age, and pulses against the device's range and
the user's limit of charge. It stops the device, for the rest of its own life ("latched"), on

    command_timeout  no fresh command for `hold_ms`: none at all (the loop hangs or is stopped), or only
                     commands of instants that long ago (the loop is too slow)
    loop_ended       the end of the line, or of the loop's process
    malformed        an invalid or disordered message, or a command beyond the limits
    terminated       SIGTERM to the keeper itself
    ...              a fault of the device or of the line to it (`driver.FAULTS`)

The cause goes to the loop, and as a line to standard error, in case the loop is dead. A loop that resumes
finds the device latched. If the keeper hangs, it sends nothing, and the device's own watchdog ends
stimulation; therefore no thread here keeps the connection alive in parallel to the checks below.

SIGINT and SIGHUP from a terminal are ignored, as they address the loop, which then ends the keeper properly.
Few modules are imported here, so that the process starts soon.
"""

from __future__ import annotations

import math
import os
import select
import signal
import socket
import sys
import time
from contextlib import suppress
from types import FrameType

from fesloop.loop.machine import realtime_privileges
from fesloop.posix import attainable
from plants.devices.driver import DeviceFault, Pulses, StimulatorDriver, driver_at, driver_faults
from plants.devices.messages import (
    MOST_BYTES,
    Answer,
    Command,
    Malformed,
    Terms,
    answer_bytes,
    is_note,
    note_bytes,
    packets,
    read_command,
    read_terms,
)
from plants.stimulator import Preset

_ROUND_OFF = 1e-6


def wrong_pulses(pulses: Pulses, device: Preset, charge_max: float) -> str:
    """Description of the first pulse beyond a limit, or "".

    `charge_max`: the user's limit of a phase's charge, C.
    """
    more = 1.0 + _ROUND_OFF
    for channel, (current, width) in enumerate(pulses):
        if not (math.isfinite(current) and math.isfinite(width) and current >= 0.0 and width >= 0.0):
            return f"channel {channel}: {current} A, {width} s"
        if current > 1e-3 * device.current_max_ma * more or width > 1e-6 * device.width_max_us * more:
            return f"channel {channel}: {1e3 * current:g} mA, {1e6 * width:g} us are beyond the device"
        if current * width > charge_max * more:
            return f"channel {channel}: {1e6 * current * width:g} uC are beyond {1e6 * charge_max:g}"
    return ""


_NS_PER_MS = 1_000_000
_STOPS = 3
"""Number of tries of a stop that the device does not confirm (chosen: a disturbance of a byte is short)."""
_PRIORITY = 99
"""Priority in SCHED_FIFO, or the highest attainable (chosen: above any loop, so that none delays it)."""
_LOOK_MS = 20.0
"""Longest interval between checks for SIGTERM."""


class Keeper:
    """Holder of an open device on behalf of a loop.

    Parameters
    ----------
    terms: settings from the loop. device: opened driver, without current. line: socket to the loop.
    loop: file that becomes readable when the loop's process ends.
    """

    def __init__(self, terms: Terms, device: StimulatorDriver, line: socket.socket, loop: int) -> None:
        self._terms, self._device, self._line = terms, device, line
        self._hold_ns = round(terms.hold_ms * _NS_PER_MS)
        self._poll = select.poll()
        self._poll.register(line, select.POLLIN)
        self._poll.register(loop, select.POLLIN)
        self._loop = loop
        self._number = -1
        self._fresh_ns = -1
        self._latched = self._over = False
        self._attended_ns = time.monotonic_ns()

    def end_when_asked(self, number: int, frame: FrameType | None) -> None:
        """Handle SIGTERM: stop the device, then end the process."""
        self._over = True

    def keep(self) -> None:
        """Run until the loop ends or releases the device; the device is stopped in every case."""
        try:
            while not self._over:
                self._look()
        finally:
            self._latch("terminated", "the keeper was terminated" if self._over else "the keeper failed")

    def _look(self) -> None:
        """Wait for the next event and handle it."""
        ready = {file for file, _ in self._poll.poll(self._patience_ms())}
        self._require_fresh()
        if self._line.fileno() in ready:
            self._hear()
        elif self._loop in ready:
            self._latch("loop_ended", "the loop's process has ended")
            self._over = True
        if not self._latched:
            self._attend()

    def _patience_ms(self) -> float:
        """Longest wait: until `attend` is due, or the newest command is too old."""
        if self._latched:
            return _LOOK_MS
        until = self._attended_ns + round(self._device.attend_ms * _NS_PER_MS)
        if self._fresh_ns >= 0:
            until = min(until, self._fresh_ns + self._hold_ns)
        return min(_LOOK_MS, max(0.0, (until - time.monotonic_ns()) / _NS_PER_MS) + 0.1)

    def _require_fresh(self, why: str = "") -> None:
        if not self._latched and 0 <= self._fresh_ns < time.monotonic_ns() - self._hold_ns:
            self._latch("command_timeout", f"no fresh command for {self._terms.hold_ms:g} ms{why}")

    def _hear(self) -> None:
        """Read all messages on the line; of several commands, the newest goes to the device."""
        newest = None
        for message in packets(self._line):
            if not message:
                self._latch("loop_ended", "the loop has closed the line")
                self._over = True
                return
            if is_note(message):
                self._end()
                return
            try:
                newest = self._checked(message)
            except Malformed as fault:
                self._latch("malformed", str(fault))
        if newest is not None:
            self._fresh_ns = newest.of_ns
            behind_ms = (time.monotonic_ns() - newest.of_ns) / _NS_PER_MS
            self._require_fresh(f": the loop is too slow, {behind_ms:.0f} ms behind the wall clock")
        if newest is not None and not self._latched:
            self._give(newest)

    def _checked(self, message: bytes) -> Command:
        """Decode and check a command; Malformed if it is invalid."""
        command = read_command(message, self._terms.channels)
        age_ns = time.monotonic_ns() - command.of_ns
        if command.number <= self._number or age_ns < 0:
            raise Malformed(f"command {command.number} after {self._number}, of "
                            f"{age_ns / _NS_PER_MS:.3f} ms ago")
        wrong = wrong_pulses(command.pulses, self._device.preset, self._terms.charge_max)
        if wrong:
            raise Malformed(f"command {command.number}: {wrong}")
        self._number = command.number
        return command

    def _give(self, command: Command) -> None:
        try:
            with driver_faults():
                self._device.give(command.pulses)
        except DeviceFault as fault:
            self._latch(fault.status, fault.detail)
            return
        self._tell(answer_bytes(Answer(command.number, time.monotonic_ns())))

    def _attend(self) -> None:
        now = time.monotonic_ns()
        if now - self._attended_ns < self._device.attend_ms * _NS_PER_MS:
            return
        self._attended_ns = now
        try:
            with driver_faults():
                self._device.attend()
        except DeviceFault as fault:
            self._latch(fault.status, fault.detail)

    def _end(self) -> None:
        """The loop is done with the device in good order."""
        self._over = True
        if not self._latched:
            self._latched = True
            self._tell(note_bytes(ended=True, stopped=self._stop()))
            self._device.close()

    def _latch(self, status: str, detail: str) -> None:
        """Set zero current permanently and report the cause; the first cause counts."""
        if self._latched:
            if status == "loop_ended":  # a big process takes long to end, and falls silent first
                _say(f"{status}: {detail}")
            return
        self._latched = True
        stopped = self._stop()
        self._tell(note_bytes(status=status, detail=detail, stopped=stopped, at_ns=time.monotonic_ns()))
        known = "" if stopped else (f"; the device has not confirmed it: by itself it stops "
                                    f"{self._device.alone_ms:g} ms after what it heard last")
        _say(f"{status}: {detail}{known}")
        self._device.close()

    def _stop(self) -> bool:
        """Set zero current; whether the device confirms it."""
        for _ in range(_STOPS):
            try:
                with driver_faults():
                    self._device.stop()
            except DeviceFault:
                continue
            return True
        return False

    def _tell(self, message: bytes) -> None:
        """Send a message to the loop, if it still exists."""
        with suppress(OSError):
            self._line.send(message, socket.MSG_DONTWAIT)


def _say(cause: str) -> None:
    """Print the cause on standard error, in case the loop cannot."""
    with suppress(OSError):
        print(f"fesloop: the stimulator is stopped: {cause}", file=sys.stderr, flush=True)


def main(line_file: int) -> None:
    """Run the keeper of the device that the first message on the line names."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    line = socket.socket(fileno=line_file)
    first = line.recv(MOST_BYTES)
    if not first:
        return
    terms = read_terms(first)
    try:
        loop = os.pidfd_open(terms.loop)
    except ProcessLookupError:
        return
    try:
        with driver_faults():
            device = driver_at(terms.driver)(terms.port, terms.channels, terms.hertz)
            device.open()
    except DeviceFault as fault:
        with suppress(OSError):
            line.send(note_bytes(status=fault.status, detail=fault.detail, stopped=True, at_ns=0))
        return
    keeper = Keeper(terms, device, line, loop)
    signal.signal(signal.SIGTERM, keeper.end_when_asked)
    with realtime_privileges(True, attainable(_PRIORITY)) as granted:
        with suppress(OSError):
            line.send(note_bytes(ready=True, memory=granted.memory, scheduling=granted.scheduling))
        keeper.keep()


if __name__ == "__main__":
    main(int(sys.argv[1]))
