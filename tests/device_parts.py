"""A device's end of the line, and a loop that commands it, each a process that can be killed."""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fesloop.errors import RunError
from plants.devices.kept_device import KeptDevice
from plants.devices.messages import Terms

PULSES = [(0.02, 300e-6), (0.01, 250e-6)]
"""Two channels: 20 mA and 10 mA."""
PERIOD_S = 0.02
HOLD_MS = 300.0
"""Longer than usual: a machine that runs tests keeps a loop waiting now and then."""
BUSY_MS = 100.0
"""Time that such a machine may add to a stated time; `tests/hil_faults.py` checks the time itself."""
PATIENCE_S = 20.0
PEER = str(Path(__file__).with_name("science_mode_peer.py"))
DRIVERS = {"dry": "plants.devices.dry:Dry", "science_mode": "plants.devices.science_mode:ScienceMode"}


def terms(driver, port, *, hold_ms=HOLD_MS, loop=None, channels=2):
    return Terms(driver=DRIVERS.get(driver, driver), port=str(port), channels=channels, hertz=40.0,
                 charge_max=20e-6, hold_ms=hold_ms, loop=os.getpid() if loop is None else loop)


@contextmanager
def kept(driver, port, **other):
    """A device in a keeper's hands, for a loop that is this process."""
    device = KeptDevice.started("device", terms(driver, port, **other), 100.0, 6.0)
    try:
        yield device
    finally:
        device.reported = True
        device.close()


def command(device, seconds, pulses=PULSES):
    """Command the device as a loop does; a fault of the device's ends it."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        device.hear()
        device.send(pulses)
        time.sleep(PERIOD_S)
    device.hear()


@dataclass
class Log:
    """What a device would have given: (monotonic ns, event, pulses) a line."""

    path: Path

    def rows(self):
        return [(int(stamp), event, pulses) for stamp, event, pulses in
                (line.split("\t") for line in self.path.read_text().splitlines())]

    def zero_after_ms(self, since_ns):
        """From that instant to zero current for good; None while there is current."""
        current = [(stamp, event == "give" and any(float(p.split("/")[0]) > 0 for p in pulses.split()))
                   for stamp, event, pulses in self.rows()]
        assert any(on for _, on in current), "the device never gave anything"
        if current[-1][1]:
            return None
        last_on = max(i for i, (_, on) in enumerate(current) if on)
        return max(0.0, (current[last_on + 1][0] - since_ns) / 1e6)

    def wait_for(self, event, patience_s=PATIENCE_S):
        """Until such a line is there."""
        wait_until(lambda: self.path.exists() and any(row[1] == event for row in self.rows()), patience_s)


def wait_until(holds, patience_s=PATIENCE_S):
    until = time.monotonic() + patience_s
    while not holds():
        assert time.monotonic() < until, "waited in vain"
        time.sleep(0.005)


class Device:
    """The science-mode device behind a pseudo-terminal."""

    def __init__(self, folder):
        self.port, self.log = folder / "tty", Log(folder / "device.log")
        self.process = subprocess.Popen(
            [sys.executable, PEER, str(self.port), str(self.log.path)],
            stdin=subprocess.PIPE)
        self.log.wait_for("open")

    def go_wrong(self, how):
        """A fault on demand; the instant at which it was asked for, ns."""
        self.process.stdin.write(f"{how}\n".encode())
        self.process.stdin.flush()
        return time.monotonic_ns()

    def end(self):
        self.process.stdin.close()
        self.process.wait(PATIENCE_S)


@contextmanager
def device(folder):
    made = Device(folder)
    try:
        yield made
    finally:
        made.end()


@contextmanager
def loop_process(driver, port, hold_ms=HOLD_MS):
    """A process that commands a device for ever; what it says of its end goes to its standard error."""
    process = subprocess.Popen([sys.executable, __file__, driver, str(port), str(hold_ms)],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline().startswith("keeper "), process.stderr.read()
        yield process
    finally:
        process.kill()
        process.communicate()


def main():
    """Command a device until it ends."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # tests in the background ignore it
    driver, port, hold_ms = sys.argv[1:]
    this = KeptDevice.started("device", terms(driver, port, hold_ms=float(hold_ms)), 100.0, 6.0)
    print("keeper", this.keeper.pid, flush=True)
    try:
        command(this, 60.0)
    except RunError as fault:
        print(fault, file=sys.stderr, flush=True)
        raise SystemExit(1) from None
    except KeyboardInterrupt:
        this.close()
        print("closed in good order", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
