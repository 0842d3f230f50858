"""The science-mode driver against a device that speaks its protocol, with every fault. About 15 s."""

import subprocess
import sys
import time

import device_parts as parts
import pytest
from science_mode_peer import checksum, framed, split

pytest.importorskip("pysciencemode")
pytest.importorskip("serial")

from pysciencemode.utils import packet_construction

from fesloop.errors import InputError, RunError
from plants.devices import science_mode_line
from plants.devices.driver import DeviceFault, stated_ms
from plants.devices.science_mode import ScienceMode
from plants.devices.science_mode_line import FrameReader

# Frames that another open driver lists (github.com/oscarys/pyRehaStim, docs/ComandosRehaMove.txt).
LISTED = {
    "f0817f81560002000f": (0, 2, b"\x00"),
    "f08117815c021e000100000040010f": (2, 30, bytes.fromhex("00010000004001")),
    "f081e08153032000015e050f": (3, 32, bytes.fromhex("00015e05")),
    "f0811d815704040f": (4, 4, b""),
}


@pytest.mark.parametrize("text", LISTED)
def test_the_peer_reads_and_makes_the_frames_that_others_send(text):
    frame = bytes.fromhex(text)
    number, command, content = LISTED[text]
    assert split(frame) == ([(number, command, content)], b"")
    assert framed(number, command, content) == frame


def test_the_peers_checksum_is_that_of_the_catalogue():
    assert checksum(b"123456789") == 0xF4  # CRC-8/SMBUS, reveng.sourceforge.io


@pytest.mark.parametrize("number", [0, 15, 129, 240, 255])
def test_the_driver_reads_what_the_device_sends(number):
    reader = FrameReader()
    sent = framed(number, 33, (0, 15, 129, 240, 85)) + framed(1, 38, (-2,))
    for byte in b"\x00\x0f" + sent:
        reader.feed(bytes((byte,)))
    assert reader.next() == (number, 33, bytes((0, 15, 129, 240, 85)))
    assert reader.next() == (1, 38, b"\xfe")
    assert reader.next() is None


@pytest.mark.parametrize("at", [2, 6, 7, 8])
def test_the_driver_notices_any_damaged_byte(at):
    frame = bytearray(framed(3, 33, (0,)))
    frame[at] ^= 0x04
    reader = FrameReader()
    reader.feed(bytes(frame))
    with pytest.raises(DeviceFault, match="wrong_checksum"):
        reader.next()


def test_the_peer_reads_what_the_library_sends():
    sent = packet_construction(7, "StartChannelListMode", [0, 1, 15, 10, 0, 0, 240, 129, 0, 0, 85, 86])
    assert split(sent) == ([(7, 32, bytes((0, 1, 15, 10, 0, 0, 240, 129, 0, 0, 85, 86)))], b"")


def test_packet_numbers_that_the_library_garbles_are_passed_over():
    sound = {number for number in range(256)
             if split(packet_construction(number, "Watchdog"))[0] == [(number, 4, b"")]}
    assert set(range(256)) - sound == science_mode_line._MISBUILT
    line = object.__new__(science_mode_line.ScienceModeLine)
    line._number = 0
    assert {line._next_number() for _ in range(600)} == sound


@pytest.mark.slow
def test_the_librarys_own_client_gets_on_with_the_peer(tmp_path):
    script = """
import sys
from pysciencemode import Channel, Device, Modes, Rehastim2
stimulator = Rehastim2(port=sys.argv[1])
channels = [Channel(Modes.SINGLE, 1, 30, 250, device_type=Device.Rehastim2)]
stimulator.init_channel(stimulation_interval=25, list_channels=channels)
stimulator.start_stimulation(stimulation_duration=0.2)
stimulator.end_stimulation()
stimulator.disconnect()
"""
    with parts.device(tmp_path) as device:
        subprocess.run([sys.executable, "-c", script, str(device.port)], check=True, timeout=120,
                       stdout=subprocess.DEVNULL)
        assert [row[1:] for row in device.log.rows()][:3] == [
            ("open", ""), ("give", "30/250"), ("give", "0/250")]


def test_the_device_gets_each_command_and_stops_at_the_end(tmp_path):
    with parts.device(tmp_path) as device:
        with parts.kept("science_mode", device.port) as kept:
            parts.command(kept, 0.2)
            parts.command(kept, 0.2, [(0.022, 500e-6), (0.0, 0.0)])
            assert 0.01 <= kept.answer_s < 0.1
        events = [row[1:] for row in device.log.rows()]
    assert events == [("open", ""), ("give", "20/300 10/250"), ("give", "22/500 0/0"), ("stop", "")]


@pytest.mark.slow
def test_a_device_that_was_just_in_use_is_taken_over(tmp_path):
    with parts.device(tmp_path) as device:
        for _ in range(2):
            with parts.kept("science_mode", device.port) as kept:
                parts.command(kept, 0.1)
        events = [row[1] for row in device.log.rows()]
    assert [event for event in events if event in ("give", "stop")] == ["give", "stop"] * 2


@pytest.mark.slow
def test_an_idle_device_stays_connected(tmp_path):
    with parts.device(tmp_path) as device, parts.kept("science_mode", device.port) as kept:
        time.sleep(1.6)  # longer than the device's 1.2 s
        parts.command(kept, 0.1)
        assert device.log.rows()[-1][1] == "give"


@pytest.mark.slow
@pytest.mark.parametrize(("how", "status"), [
    ("silent", "no_answer"), ("wrong_checksum", "wrong_checksum"), ("refuse", "refused"),
    ("electrode_error", "electrode_error"), ("emergency_stop", "device_failed"), ("restart", "device_failed"),
    ("slow 150", "no_answer"), ("unplug", "unplugged")])
def test_every_fault_is_named_and_ends_current(tmp_path, how, status):
    with parts.device(tmp_path) as device, parts.kept("science_mode", device.port) as kept:
        parts.command(kept, 0.15)
        since = device.go_wrong(how)
        with pytest.raises(RunError, match=f"the device is stopped: {status}: "):
            parts.command(kept, 2.0)
        parts.wait_until(lambda: device.log.zero_after_ms(since) is not None)
        stated = stated_ms(ScienceMode, parts.HOLD_MS)[how == "unplug"]
        assert device.log.zero_after_ms(since) < stated + parts.BUSY_MS


def test_half_a_frame_does_not_hide_the_answer_to_a_stop(tmp_path):
    with parts.device(tmp_path) as device:
        driver = ScienceMode(str(device.port), 2, 40.0)
        driver.open()
        try:
            driver.give(parts.PULSES)
            driver._opened()._frames.feed(framed(1, 33, [0] * 60)[:-40])
            driver.stop()
        finally:
            driver.close()
        assert device.log.rows()[-1][1] == "stop"


class Flooding:
    """A port on which there is always more: a ms of the clock passes with every read."""

    def __init__(self, clock, said):
        self.clock, self.said, self.reads_s = clock, said, []

    def write(self, frame):
        pass

    def read(self, most):
        self.reads_s.append(self.clock[0])
        self.clock[0] += 0.001
        assert len(self.reads_s) < 1000, "the line is read for ever"
        return self.said


@pytest.fixture
def flooded(monkeypatch):
    """A line whose device never stops saying the same; answers are waited for 20 ms."""
    clock = [100.0]
    monkeypatch.setattr(science_mode_line.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(science_mode_line.select, "select", lambda ports, *_: (ports, [], []))

    def line(said):
        port = Flooding(clock, said)
        monkeypatch.setattr(science_mode_line.serial, "Serial", lambda *_, **__: port)
        return science_mode_line.ScienceModeLine("flooded", 0.02), port

    return line


WATCHDOG_ACK, HALF = framed(1, 5, ()), framed(1, 33, [0] * 60)[:-40]


@pytest.mark.parametrize("said", [WATCHDOG_ACK, HALF[:1], b"\x00"])
def test_a_device_that_floods_the_line_stretches_no_answer(flooded, said):
    """After the deadline the line is read once, for what came in time."""
    line, port = flooded(said)
    with pytest.raises(DeviceFault, match=r"no_answer: .* within 20 ms"):
        line.ask("StopChannelListMode", [])
    assert port.reads_s[-1] < 100.0 + 0.02 + 0.0015
    assert sum(at >= 100.02 for at in port.reads_s) <= 1
    port.reads_s.clear()
    line.listen()
    assert len(port.reads_s) <= 1


def test_a_device_that_says_nothing_but_rubbish_is_given_up_in_time(flooded):
    damaged = bytearray(WATCHDOG_ACK)
    damaged[2] ^= 0x04
    line, port = flooded(bytes(damaged))
    with pytest.raises(DeviceFault, match="no_answer: no Init"):
        line.connect(0.05)
    assert port.reads_s[-1] < 100.05 + 0.0015


@pytest.mark.slow
def test_a_slow_device_is_waited_for(tmp_path):
    with parts.device(tmp_path) as device, parts.kept("science_mode", device.port) as kept:
        device.go_wrong("slow 20")
        parts.command(kept, 0.4)
        assert kept.answer_s >= 0.03


def test_a_port_that_is_not_there_is_named(tmp_path):
    with pytest.raises(RunError, match=r"the device does not open: unplugged: .*nothing"), \
            parts.kept("science_mode", tmp_path / "nothing"):
        pass


@pytest.mark.parametrize(("port", "channels", "hertz", "fault"), [
    ("", 4, 40.0, "port: is missing"), ("/dev/x", 4, 30.0, "multiple of 0.5 ms"),
    ("/dev/x", 8, 50.0, "at most 40 with 8 channels"), ("/dev/nothing", 4, 40.0, "port: there is no")])
def test_what_the_device_cannot_do_is_refused(port, channels, hertz, fault):
    with pytest.raises(InputError, match=fault):
        ScienceMode.check(port, channels, hertz)


def test_a_missing_library_is_named(monkeypatch):
    monkeypatch.setattr("plants.devices.science_mode.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'fesloop\[stimulator\]'"):
        ScienceMode.check("/dev/x", 4, 40.0)
