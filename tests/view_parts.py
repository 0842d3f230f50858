"""A hand that somebody thought of, to be looked at without a recording."""

import http.client
import json
import threading
from contextlib import contextmanager

import numpy as np

from fesloop.errors import InputError
from fesloop.show.picture.hand_mesh import Mesh
from fesloop.show.report.parts import Figure3d, Frames
from fesloop.show.view.readout import Readout
from fesloop.show.view.server import ViewServer
from fesloop.show.view.shown import Shown, Span

TRIANGLE = Mesh(vertices=0.05 * np.eye(3), faces=np.array([[0, 1, 2]], dtype=np.int32))
HERE = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


class ToldSource:
    """One triangle that moves east by a metre a second; `play` fails as it is told to."""

    def __init__(self, spans=None, padding="", notices=()):
        self.title, self.padding, self.notices = "somebody's <hand>", padding, notices
        self.spans = {0: Span(first_s=0.0, last_s=9.0)} if spans is None else spans
        frames = Frames(start_s=0.0, step_s=1.0, hands={"truth": HERE[np.newaxis, np.newaxis]},
                        objects=np.empty((1, 0, 7)))
        self.figure = Figure3d(key="hand", trials={0: frames}, shapes={"truth": [TRIANGLE]},
                               text="A triangle.")
        self.made = self.closed = 0
        self.shown, self.readout = min(self.spans, default=0), Readout()

    def play(self, start):
        if start.trial not in (self.spans or [0]):
            raise InputError("trial", f"{start.trial}", "0")

        def at(elapsed_s):
            self.made += 1
            time_s = start.at_s + start.speed * elapsed_s
            pose = HERE + np.array([0.0, 0.0, 0.0, 0.0, time_s, 0.0, 0.0])
            return Shown(trial=start.trial, time_s=time_s, hands={"truth": pose[np.newaxis]},
                         objects=np.empty((0, 7)), note=self.padding)

        return at

    def close(self):
        self.closed += 1


@contextmanager
def serving(source, port=0):
    """A server under way in a thread of its own."""
    server = ViewServer(source, port)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.ending = True
        server.shutdown()
        server.server_close()
        thread.join()


def asked(server, path, **headers):
    """Status, headers and body of an answer."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    connection.request(headers.pop("method", "GET"), path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, dict(answer.getheaders()), body.decode()


@contextmanager
def events(port, query=""):
    """Frames as they come, each as the page would read it."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    connection.request("GET", f"/frames{query}")
    answer = connection.getresponse()
    assert answer.status == 200
    assert answer.getheader("Content-Type").startswith("text/event-stream")

    def frames():
        name = ""
        while line := answer.readline():
            key, _, value = line.decode().rstrip("\n").partition(": ")
            if key == "event":
                name = value
            elif key == "data":
                assert name == "frame", value
                yield json.loads(value)

    try:
        yield frames()
    finally:
        connection.close()
