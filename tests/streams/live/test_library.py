"""liblsl is opened when it is needed, searches this machine alone, and sends nothing to another one."""

import os
import re
import subprocess
import sys
import textwrap
from importlib.util import find_spec
from pathlib import Path
from shutil import which

import pytest

needs_pylsl = pytest.mark.skipif(find_spec("pylsl") is None, reason="pylsl is not installed")
needs_linux = pytest.mark.skipif(not Path("/proc/self/net/tcp").exists(),
                                 reason="sockets are read from /proc")
SOCKETS = """
import os
def opened():
    '''(protocol, address) of every socket of this process that has a port of its own.'''
    own = set()
    for n in os.listdir("/proc/self/fd"):
        try:
            own.add(os.readlink(f"/proc/self/fd/{n}"))
        except OSError:
            pass
    found = set()
    for protocol in ("tcp", "tcp6", "udp", "udp6"):
        with open(f"/proc/self/net/{protocol}") as table:
            for row in list(table)[1:]:
                local, inode = row.split()[1], row.split()[9]
                if f"socket:[{inode}]" in own:
                    found.add((protocol, local.split(":")[0]))
    return found
"""


def python(script, **environment):
    """Run a script in a process of its own; what it prints."""
    done = subprocess.run([sys.executable, "-c", SOCKETS + textwrap.dedent(script)], capture_output=True,
                          text=True, timeout=60, env={**os.environ, **environment})
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_nothing_of_lsl_is_imported_before_a_stream_is_opened():
    assert python("""
        import sys, fesloop
        from fesloop.experiment.registry import find
        find("lsl_inlet")(stream="imus", sensors=2); find("lsl_outlet")(stream="out", rows=1)
        print("pylsl" in sys.modules)
        """).strip() == "False"


def refused_with(folder):
    """What a process says that opens the library with the pylsl of a folder."""
    return python("""
        from fesloop.errors import InputError
        from fesloop.streams.live.library import open_library
        try:
            open_library()
        except InputError as fault:
            print(fault)
        """, PYTHONPATH=str(folder))


def test_a_missing_library_is_one_line_that_says_what_to_do(tmp_path):
    (tmp_path / "pylsl.py").write_text("raise ImportError")
    told = refused_with(tmp_path)
    assert told.count("\n") == 1
    assert "pip install 'fesloop[lsl]'" in told


def test_a_wheel_without_its_library_is_told_apart(tmp_path):
    (tmp_path / "pylsl.py").write_text("raise RuntimeError('LSL binary library file was not found.\\nlong')")
    told = refused_with(tmp_path)
    assert told.count("\n") == 1
    assert "not liblsl for this platform" in told
    assert "PYLSL_LIB" in told


PLAY = """
    from threading import Thread
    from fesloop.streams.live.library import open_library
    pylsl = open_library()
    seen, found = set(), []
    outlets = [pylsl.StreamOutlet(pylsl.StreamInfo(f"stream {n}", "x", 2, 100, "float32", f"id {n}"))
               for n in range(3)]
    seen |= opened()
    search = Thread(target=lambda: found.extend(pylsl.resolve_byprop("name", "stream 1", timeout=5.0)))
    search.start()
    while search.is_alive():
        seen |= opened()
    inlet = pylsl.StreamInlet(found[0], recover=False)
    inlet.open_stream(timeout=5.0)
    inlet.time_correction(timeout=5.0)
    seen |= opened()
    print(len(found), sorted(seen))
    """


@pytest.mark.slow
@needs_pylsl
@needs_linux
def test_the_port_of_discovery_is_of_the_loopback_address_and_ip_version_6_is_off():
    """Data and time servers are of every address, which no setting of liblsl changes (docs/hardware.md)."""
    found, sockets = python(PLAY).split(" ", 1)
    assert found == "1"
    assert ("udp", "0100007F") in eval(sockets)
    assert {protocol for protocol, _ in eval(sockets)} == {"tcp", "udp"}


@pytest.mark.slow
@needs_pylsl
@pytest.mark.skipif(which("strace") is None, reason="strace is not installed")
def test_nothing_is_sent_to_another_computer(tmp_path):
    log = tmp_path / "calls"
    subprocess.run(["strace", "-f", "-e", "trace=sendto,sendmsg,sendmmsg,connect", "-o", str(log),
                    sys.executable, "-c", SOCKETS + textwrap.dedent(PLAY)], check=True, timeout=120,
                   capture_output=True)
    targets = re.findall(r"(?:inet_addr\(|inet_pton\(AF_INET6, )\"([^\"]*)", log.read_text())
    assert len(targets) > 5
    assert set(targets) == {"127.0.0.1"}


@needs_pylsl
@needs_linux
def test_other_computers_are_let_in_where_that_is_said():
    told = python("""
        from fesloop.errors import InputError
        from fesloop.streams.live.library import open_library
        pylsl = open_library("lab")
        outlet = pylsl.StreamOutlet(pylsl.StreamInfo("stream", "x", 2, 100, "float32", "id"))
        print(("tcp", "00000000") in opened())
        try:
            open_library("loopback")
        except InputError as fault:
            print(fault)
        """).splitlines()
    assert told[0] == "True"
    assert "one network a run" in told[1]
