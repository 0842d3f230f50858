"""Whatever happens to loop, keeper or line, current at the device is zero in the stated time. About 35 s."""

import os
import random
import signal
import socket
import struct
import subprocess
import sys
import time
import zlib
from pathlib import Path

import device_parts as parts
import pytest
from device_parts import BUSY_MS, HOLD_MS

from fesloop.errors import RunError
from plants.devices.driver import stated_ms
from plants.devices.dry import Dry
from plants.devices.messages import command_bytes, read_answer, terms_bytes
from plants.devices.science_mode import ScienceMode

pytestmark = pytest.mark.realtime

CLASSES = {"dry": Dry, "science_mode": ScienceMode}
MOMENTS = range(3)


def some_time():
    """A random moment of a session; told where a test fails."""
    seconds = random.uniform(0.05, 0.4)
    print(f"after {seconds:.6f} s")
    time.sleep(seconds)


@pytest.fixture(params=["dry", "science_mode"])
def session(request, tmp_path):
    """(driver, port, log of the device)"""
    if request.param == "dry":
        yield "dry", tmp_path / "dry.log", parts.Log(tmp_path / "dry.log")
        return
    pytest.importorskip("pysciencemode")
    with parts.device(tmp_path) as device:
        yield "science_mode", device.port, device.log


def zero_ms(log, since_ns, patience_s=3.0):
    parts.wait_until(lambda: log.zero_after_ms(since_ns) is not None, patience_s)
    return log.zero_after_ms(since_ns)


@pytest.mark.parametrize("moment", MOMENTS)
def test_a_killed_loop_leaves_no_current(session, moment):
    driver, port, log = session
    with parts.loop_process(driver, port) as loop:
        log.wait_for("give")
        some_time()
        loop.kill()
        since = time.monotonic_ns()
        assert zero_ms(log, since) < stated_ms(CLASSES[driver], HOLD_MS)[0] + BUSY_MS
        loop.wait()
        assert "loop_ended" in loop.stderr.read()


@pytest.mark.slow
@pytest.mark.parametrize("moment", MOMENTS)
def test_a_stopped_loop_leaves_no_current_and_comes_back_to_be_told(session, moment):
    driver, port, log = session
    with parts.loop_process(driver, port) as loop:
        log.wait_for("give")
        some_time()
        loop.send_signal(signal.SIGSTOP)
        since = time.monotonic_ns()
        assert zero_ms(log, since) < stated_ms(CLASSES[driver], HOLD_MS)[0] + BUSY_MS
        loop.send_signal(signal.SIGCONT)
        _, said = loop.communicate(timeout=10)
    assert loop.returncode == 1
    assert "device: the device is stopped: command_timeout: no fresh command for 300 ms" in said
    assert log.rows()[-1][1] == "stop"


@pytest.mark.slow
@pytest.mark.parametrize("moment", MOMENTS)
def test_a_killed_keeper_leaves_no_current_at_the_device(tmp_path, moment):
    pytest.importorskip("pysciencemode")
    with parts.device(tmp_path) as device, parts.kept("science_mode", device.port) as kept:
        parts.command(kept, random.uniform(0.05, 0.4))
        kept.keeper.kill()
        since = time.monotonic_ns()
        with pytest.raises(RunError, match=r"keeper of the device has ended by itself \(signal 9\)"):
            parts.command(kept, 1.0)
        assert zero_ms(device.log, since) < stated_ms(ScienceMode, HOLD_MS)[1] + BUSY_MS


@pytest.mark.slow
@pytest.mark.parametrize("moment", MOMENTS)
def test_an_unplugged_device_stops_by_itself_and_is_named(tmp_path, moment):
    pytest.importorskip("pysciencemode")
    with parts.device(tmp_path) as device, parts.kept("science_mode", device.port) as kept:
        parts.command(kept, random.uniform(0.05, 0.4))
        since = device.go_wrong("unplug")
        with pytest.raises(RunError, match="unplugged: the line is gone"):
            parts.command(kept, 1.0)
        assert zero_ms(device.log, since) < stated_ms(ScienceMode, HOLD_MS)[1] + BUSY_MS


@pytest.mark.slow
def test_a_stopped_keeper_is_noticed_and_the_device_stops_by_itself(tmp_path):
    pytest.importorskip("pysciencemode")
    with parts.device(tmp_path) as device, parts.kept("science_mode", device.port) as kept:
        parts.command(kept, 0.2)
        kept.keeper.send_signal(signal.SIGSTOP)
        since = time.monotonic_ns()
        with pytest.raises(RunError, match="keeper of the device has not answered"):
            parts.command(kept, 3.0)
        assert zero_ms(device.log, since) < stated_ms(ScienceMode, HOLD_MS)[1] + BUSY_MS
        kept.keeper.send_signal(signal.SIGCONT)
        assert kept.keeper.poll() is None
        time.sleep(0.2)
        assert device.log.rows()[-1][1] == "stop"  # what was queued meanwhile is too old to be given


def test_the_keeper_says_what_it_was_granted(tmp_path):
    with parts.kept("dry", tmp_path / "dry.log") as kept:
        granted = "SCHED_FIFO, priority 99" in kept.granted
        assert (os.sched_getscheduler(kept.keeper.pid) & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO) == granted
        locked = int(next(line.split()[1] for line in Path(f"/proc/{kept.keeper.pid}/status").read_text()
                          .splitlines() if line.startswith("VmLck")))
        assert (locked > 0) == ("memory: locked" in kept.granted)


def test_ctrl_c_reaches_the_loop_alone_which_ends_in_good_order(tmp_path):
    log = parts.Log(tmp_path / "dry.log")
    script = f"import os, sys; os.setsid(); os.execv(sys.executable, [sys.executable, {parts.__file__!r}, " \
             f"'dry', {str(log.path)!r}, '1000'])"
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as loop:
        log.wait_for("give")
        os.killpg(loop.pid, signal.SIGINT)
        _, said = loop.communicate(timeout=10)
    assert said.strip() == "closed in good order"
    assert log.rows()[-1][1] == "stop"


def test_nothing_that_a_terminal_sends_ends_the_keeper(tmp_path):
    log = parts.Log(tmp_path / "dry.log")
    with parts.kept("dry", log.path) as kept:
        assert os.getsid(kept.keeper.pid) == kept.keeper.pid
        for number in (signal.SIGINT, signal.SIGHUP):
            kept.keeper.send_signal(number)
        parts.command(kept, 0.2)
        assert log.rows()[-1][1] == "give"


def test_a_keeper_told_to_end_stops_the_device_first(session):
    driver, port, log = session
    with parts.kept(driver, port) as kept:
        parts.command(kept, 0.2)
        kept.keeper.terminate()
        with pytest.raises(RunError, match="terminated: the keeper was terminated"):
            parts.command(kept, 1.0)
        assert kept.keeper.wait(2.0) == 0
    assert log.rows()[-1][1] == "stop"


def test_a_loop_that_falls_silent_finds_the_device_latched(tmp_path):
    log = parts.Log(tmp_path / "dry.log")
    with parts.kept("dry", log.path, hold_ms=60.0) as kept:
        kept.origin_ns = time.monotonic_ns()
        parts.command(kept, 0.1)
        last = time.monotonic_ns()
        kept.send(parts.PULSES)
        assert 60.0 <= zero_ms(log, last) < stated_ms(Dry, 60.0)[0] + BUSY_MS
        kept.send(parts.PULSES)
        with pytest.raises(RunError, match=r"command_timeout: no fresh command for 60 ms \(at 0\.\d+ s\)"):
            parts.command(kept, 0.2)
    assert [event for _, event, _ in log.rows()].count("stop") == 1
    assert log.rows()[-1][1] == "stop"


def test_a_loop_that_falls_silent_and_is_killed_then_has_both_told(tmp_path):
    log = parts.Log(tmp_path / "dry.log")
    with parts.loop_process("dry", log.path) as loop:
        log.wait_for("give")
        loop.send_signal(signal.SIGSTOP)
        log.wait_for("stop")
        loop.kill()
        _, said = loop.communicate(timeout=10)
    assert [line.split(": ")[2] for line in said.splitlines()] == ["command_timeout", "loop_ended"]


def test_the_keeper_ends_with_its_loop_though_another_process_holds_the_line(tmp_path):
    log = parts.Log(tmp_path / "dry.log")
    script = f"""
import os, sys, time
sys.path.insert(0, {str(Path(parts.__file__).parent)!r})
import device_parts as parts
kept = parts.KeptDevice.started("device", parts.terms("dry", {str(log.path)!r}, hold_ms=1000.0), 0.0, 1.0)
kept.send(parts.PULSES)
if os.fork() == 0:
    time.sleep(3.0)
    os._exit(0)
print(kept.keeper.pid, flush=True)
time.sleep(0.1)
os._exit(0)
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL) as loop:
        keeper = int(loop.stdout.readline())
        loop.wait()
        since = time.monotonic_ns()
        assert zero_ms(log, since, 0.9) < 300.0
        parts.wait_until(lambda: not is_alive(keeper), 2.0)


def is_alive(process):
    """Whether a process runs; one that nobody has reaped yet does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def sound(number=0, sent_ns=None, pulses=parts.PULSES):
    return command_bytes(number, time.monotonic_ns() if sent_ns is None else sent_ns, pulses)


def damaged():
    message = bytearray(sound(1))
    message[20] ^= 1
    return bytes(message)


MALFORMED = {
    "nonsense": lambda: b"nonsense",
    "too long": lambda: b"C" * 5000,
    "damaged": damaged,
    "of other channels": lambda: sound(pulses=[*parts.PULSES, (0.0, 0.0)]),
    "nan": lambda: sound(pulses=[(float("nan"), 3e-4), (0.0, 0.0)]),
    "infinite": lambda: sound(pulses=[(0.01, float("inf")), (0.0, 0.0)]),
    "negative": lambda: sound(pulses=[(-0.01, 3e-4), (0.0, 0.0)]),
    "beyond the current": lambda: sound(pulses=[(0.128, 1e-4), (0.0, 0.0)]),
    "beyond the width": lambda: sound(pulses=[(0.01, 501e-6), (0.0, 0.0)]),
    "beyond the charge": lambda: sound(pulses=[(0.1, 201e-6), (0.0, 0.0)]),
    "from the future": lambda: sound(sent_ns=time.monotonic_ns() + 10**10),
}


@pytest.fixture
def bare_keeper(tmp_path):
    """A keeper of the dry device, its line in the test's hand, and the log."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.settimeout(5.0)
    with subprocess.Popen([sys.executable, "-m", "plants.devices.keeper", str(theirs.fileno())],
                          pass_fds=(theirs.fileno(),), stderr=subprocess.DEVNULL) as keeper:
        theirs.close()
        ours.send(terms_bytes(parts.terms("dry", tmp_path / "dry.log", hold_ms=1000.0)))
        assert read_answer(ours.recv(4096))["ready"]
        with ours:
            yield keeper, ours, parts.Log(tmp_path / "dry.log")


@pytest.mark.parametrize("what", MALFORMED)
def test_a_malformed_message_stops_the_device(bare_keeper, what):
    _, line, log = bare_keeper
    line.send(sound())
    assert line.recv(4096)[:1] == b"A"
    message = MALFORMED[what]()
    if message[:1] == b"C" and len(message) == len(sound()) and what != "damaged":
        body = message[:1] + struct.pack("<Q", 1) + message[9:-4]
        message = body + struct.pack("<I", zlib.crc32(body))
    line.send(message)
    assert b'"malformed"' in line.recv(4096)
    line.send(sound(2))
    time.sleep(0.1)
    assert [event for _, event, _ in log.rows()] == ["open", "give", "stop"]


@pytest.mark.parametrize(("second", "status"), [(0, b"malformed"), (1, b"command_timeout")])
def test_a_repeated_or_belated_command_stops_the_device(bare_keeper, second, status):
    _, line, log = bare_keeper
    line.send(sound(0))
    assert line.recv(4096)[:1] == b"A"
    line.send(sound(second, sent_ns=time.monotonic_ns() - 2 * 10**9))
    assert status in line.recv(4096)
    assert log.rows()[-1][1] == "stop"


def test_a_keeper_without_a_loop_ends(tmp_path):
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with subprocess.Popen([sys.executable, "-m", "plants.devices.keeper", str(theirs.fileno())],
                          pass_fds=(theirs.fileno(),)) as keeper:
        theirs.close()
        ours.close()
        assert keeper.wait(5.0) == 0


def test_a_stop_that_is_not_confirmed_is_said_again(tmp_path, monkeypatch):
    (tmp_path / "stubborn.py").write_text("""
from plants.devices.driver import DeviceFault
from plants.devices.dry import Dry
class Stubborn(Dry):
    asked = 0
    def stop(self):
        self.asked += 1
        if self.asked < 3:
            raise DeviceFault("no_answer", "not yet")
        super().stop()
""")
    monkeypatch.syspath_prepend(str(tmp_path))
    log = parts.Log(tmp_path / "dry.log")
    kept = parts.KeptDevice.started("device", parts.terms("stubborn:Stubborn", log.path), 0.0, 1.0)
    parts.command(kept, 0.1)
    kept.close()  # raises where zero current is not confirmed
    assert log.rows()[-1][1] == "stop"


def test_a_driver_that_breaks_is_a_fault_of_the_device(tmp_path, monkeypatch):
    (tmp_path / "breaking.py").write_text("""
from plants.devices.dry import Dry
class Breaking(Dry):
    def give(self, pulses):
        super().give(pulses)
        raise ZeroDivisionError("oh")
""")
    log = parts.Log(tmp_path / "dry.log")
    monkeypatch.syspath_prepend(str(tmp_path))
    with parts.kept("breaking:Breaking", log.path) as kept, \
            pytest.raises(RunError, match="device_failed: ZeroDivisionError: oh"):
        parts.command(kept, 1.0)
    assert log.rows()[-1][1] == "stop"
