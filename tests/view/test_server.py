"""The viewer's server: who may ask, what is answered, and what slow or vanishing browsers do to it."""

import contextlib
import itertools
import json
import socket
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from view_parts import HERE, ToldSource, asked, events, serving

from fesloop.errors import InputError
from fesloop.show.view.server import ViewServer, start_of
from fesloop.show.view.shown import Shown, Start


@pytest.fixture(scope="module")
def server():
    with serving(ToldSource()) as found:
        yield found


def test_it_listens_on_the_loopback_address_alone(server):
    assert server.socket.getsockname()[0] == "127.0.0.1"
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as own:
        own.settimeout(5.0)
        # Any other address of 127/8 leads to this machine, and nobody listens there.
        with pytest.raises(ConnectionRefusedError):
            own.connect(("127.0.0.2", server.server_port))


@pytest.mark.parametrize("host", ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1",
                                  "localhost.evil.example:{port}", "", "[::1]:{port}"])
@pytest.mark.parametrize("path", ["/", "/frames"])
def test_a_page_of_another_name_gets_nothing(server, host, path):
    status, _, body = asked(server, path, Host=host.format(port=server.server_port))
    assert status == 421
    assert len(body) < 100


def test_a_foreign_page_gets_no_frames(server):
    port = server.server_port
    assert asked(server, "/frames", Origin="http://evil.example")[0] == 421
    assert asked(server, "/frames", Origin="null")[0] == 421
    assert asked(server, "/", Host=f"localhost:{port}", Origin=f"http://localhost:{port}")[0] == 200


def test_a_foreign_page_cannot_have_frames_as_a_picture_either(server):
    # No Origin comes with what a page embeds.
    for site in ("cross-site", "same-site"):
        assert asked(server, "/frames", **{"Sec-Fetch-Site": site})[0] == 404
    assert asked(server, "/", **{"Sec-Fetch-Site": "cross-site"})[0] == 200  # a link to the viewer


def test_what_is_no_address_is_refused_and_said_nowhere_else(server, capfd):
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=10.0) as odd:
        odd.sendall(f"GET http://[ HTTP/1.0\r\nHost: 127.0.0.1:{server.server_port}\r\n\r\n".encode())
        assert odd.recv(100).split()[1] == b"400"
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_connections_are_bounded_and_free_again_when_they_are_over():
    with serving(ToldSource()) as server:
        address = ("127.0.0.1", server.server_port)
        idle = [socket.create_connection(address, timeout=10.0) for _ in range(40)]
        assert [connection.recv(1) for connection in idle[32:]] == [b""] * 8
        for connection in idle:
            connection.close()
        deadline = time.monotonic() + 120.0
        while time.monotonic() < deadline:
            with contextlib.suppress(OSError):
                if asked(server, "/")[0] == 200:
                    break
        assert asked(server, "/")[0] == 200


@pytest.mark.slow
def test_a_viewer_that_has_nothing_new_is_heard_of_nonetheless():
    source = ToldSource()
    source.play = lambda start: lambda elapsed_s: None
    with serving(source) as server, socket.create_connection(
            ("127.0.0.1", server.server_port), timeout=10.0) as silent:
        silent.sendall(f"GET /frames HTTP/1.0\r\nHost: 127.0.0.1:{server.server_port}\r\n\r\n".encode())
        text = b""
        while b": nothing new" not in text:
            received = silent.recv(1000)
            assert received, f"the server hung up after {text!r}"
            text += received


def test_the_page_may_run_its_script_and_ask_its_server_alone(server):
    status, headers, body = asked(server, "/")
    assert status == 200
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "connect-src 'self'" in policy
    assert "Access-Control-Allow-Origin" not in headers
    assert "somebody&#39;s &lt;hand&gt;" in body
    assert "<hand>" not in body


@pytest.mark.parametrize(("method", "path", "status"), [
    ("GET", "/../etc/passwd", 404), ("GET", "/frame", 404), ("POST", "/frames", 501), ("PUT", "/", 501),
    ("GET", "/frames?trial=9", 400), ("GET", "/frames?speed=fast", 400), ("GET", "/frames?at=nan", 400),
    ("GET", "/frames?at=1e400", 400)])
def test_what_it_does_not_have(server, method, path, status):
    assert asked(server, path, method=method)[0] == status


@settings(max_examples=25)
@given(st.text(max_size=40))
def test_a_query_is_a_start_or_refused(query):
    try:
        found = start_of(query)
    except InputError:
        return
    assert isinstance(found, Start)


def test_frames_are_those_asked_for_and_no_more_than_thirty_a_second(server):
    with events(server.server_port, "?trial=0&at=2&speed=0.5") as frames:
        began = time.monotonic()
        got = [next(frames) for _ in range(20)]
        took = time.monotonic() - began
    assert took > 19 / 30 - 0.05
    times = [frame["time_s"] for frame in got]
    assert times == sorted(times)
    assert 2.0 <= times[0] < times[-1] < 2.0 + 0.5 * (took + 5.0)
    for frame in got:
        assert frame["hands"]["truth"][0][4] == pytest.approx(frame["time_s"], abs=1e-4)


@pytest.mark.slow
def test_a_browser_that_does_not_read_gets_fewer_frames_and_then_new_ones():
    source = ToldSource(padding="x" * 50_000)
    with serving(source) as server:
        with socket.create_connection(("127.0.0.1", server.server_port)) as slow:
            slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            slow.sendall(f"GET /frames HTTP/1.0\r\nHost: 127.0.0.1:{server.server_port}\r\n\r\n".encode())
            time.sleep(2.5)
            held = source.made
            # What sockets hold, and not the 75 frames that were due.
            assert held < 50
            slow.settimeout(10.0)
            text = b""
            while text.count(b"event: frame") < held + 5:
                text += slow.recv(1 << 20)
        whole = text.split(b"event: frame\ndata: ")[1:-1]
        times = [json.loads(part)["time_s"] for part in whole]
        assert max(after - before for before, after in itertools.pairwise(times)) > 1.0


def test_a_browser_that_closes_midway_leaves_the_others_alone(server, capfd):
    with events(server.server_port) as stays:
        next(stays)
        for _ in range(5):
            with events(server.server_port) as goes:
                next(goes)
        assert [next(stays)["trial"] for _ in range(10)] == [0] * 10
    assert capfd.readouterr().err == ""


def test_a_port_that_is_taken_or_is_none(server):
    for port in (server.server_port, -1, 70_000):
        with pytest.raises(InputError, match=f"--port {port}"):
            ViewServer(ToldSource(), port)


def test_a_pose_that_is_not_known_is_null():
    lost = HERE.copy()
    lost[2] = float("nan")
    shown = Shown(trial=0, time_s=1.0, hands={"truth": [HERE, lost]}, objects=[lost])
    told = json.loads(shown.as_json())
    assert told["hands"] == {"truth": [HERE.tolist(), None]}
    assert told["objects"] == [None]
