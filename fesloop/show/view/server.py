"""The viewer's server: a page, and frames as server-sent events, for browsers on this machine alone.

It listens on 127.0.0.1, answers no page of another name (a foreign page could have its own name resolve to
this machine: DNS rebinding), sends no frames into one, and takes nothing but GET. Frames are made when they
are sent: a browser that is slow gets fewer.
"""

from __future__ import annotations

import base64
import errno
import hashlib
import select
import socket
import sys
import time
from functools import cache
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from threading import BoundedSemaphore
from typing import Any
from urllib.parse import parse_qs, urlsplit

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from fesloop.errors import FesloopError, InputError
from fesloop.show.report.drawn import drawn_numbers
from fesloop.show.report.page import as_json, asset
from fesloop.show.report.parts import Page, Section
from fesloop.show.view.shown import FRAME_S, Play, Source, Start

_SCRIPT = "view.js"


@cache
def policy() -> str:
    """Content-Security-Policy: this one script, and frames from where the page is from."""
    digest = base64.b64encode(hashlib.sha256(asset(_SCRIPT).encode()).digest()).decode("ascii")
    return (f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data:; "
            "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")


def page_html(source: Source) -> str:
    """The page of a source."""
    figure = source.figure
    page = Page(title=source.title, sentence=figure.text, facts=(), trials=list(source.spans),
                shown=source.shown,
                sections=[Section(key="hand", title="Hand", parts=[figure])])
    readout = source.readout
    spans = {str(trial): [span.first_s, span.last_s] for trial, span in source.spans.items()}
    template = files("fesloop.show.view").joinpath("assets", "view.html.jinja").read_text(encoding="utf-8")
    made = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return made.from_string(template).render(
        page=page, figure=figure, notices=source.notices, style=Markup(asset("page.css")),
        script=Markup(asset(_SCRIPT)), licences=Markup(asset("licences.txt")),
        numbers=Markup(as_json(drawn_numbers(page))), spans=Markup(as_json(spans)),
        readout=Markup(as_json({"groups": readout.groups, "hands": list(readout.angles),
                                "channels": readout.channels})))


LOOPBACK = "127.0.0.1"
_NAMES = (LOOPBACK, "localhost")
_SILENT_S = 2.0
"""Time without a frame after which a comment is sent, so that a closed browser is noticed."""
_BUFFER_BYTES = 2**15
"""Send buffer of a connection (chosen: some ten frames; older ones are of no use)."""
_SLOWEST_S = 10.0
"""Time after which a browser that reads nothing is disconnected."""
_MOST = 32
"""Connections at once (chosen: a browser opens up to six): without a bound they could use up the resources of
the machine."""
_OWN = (None, "same-origin", "none")
"""Values of Sec-Fetch-Site (W3C, Fetch Metadata Request Headers) of requests that no foreign page makes."""


class ViewServer(ThreadingHTTPServer):
    """Serves one source.

    Parameters
    ----------
    source: what is shown.
    port: to listen on; 0 for a free one.

    Raises InputError where the port is taken or not one that may be had.
    """

    daemon_threads = True

    def __init__(self, source: Source, port: int = 0) -> None:
        self.source, self.ending = source, False
        self.page = page_html(source).encode()
        try:
            super().__init__((LOOPBACK, port), _Handler)
        except (OSError, OverflowError) as fault:
            taken = isinstance(fault, OSError) and fault.errno == errno.EADDRINUSE
            raise InputError(f"--port {port}", "is taken" if taken else f"cannot be had: {fault}",
                             "a free one, 1024 to 65535", "leave it out for any") from None
        self.hosts = {f"{name}:{self.server_port}" for name in _NAMES}
        self._free = BoundedSemaphore(_MOST)

    @property
    def address(self) -> str:
        """Address for a browser."""
        return f"http://{LOOPBACK}:{self.server_port}/"

    def process_request(self, request: Any, client_address: Any) -> None:
        """Handle a request in its own thread; close a connection beyond the greatest number."""
        if self._free.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Handle a request, then free its place."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Report errors, except those of a browser that disconnects."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    """Handler of one request."""

    server: ViewServer
    timeout = _SLOWEST_S
    server_version, sys_version = "fesloop", ""

    def do_GET(self) -> None:
        """Answer with the page, or with frames."""
        try:
            path = urlsplit(self.path)
        except ValueError:
            self._refuse(HTTPStatus.BAD_REQUEST, "that is no address")
            return
        origin = self.headers.get("Origin")
        if self.headers.get("Host") not in self.server.hosts or (
                origin is not None and origin.removeprefix("http://") not in self.server.hosts):
            self._refuse(HTTPStatus.MISDIRECTED_REQUEST, "this viewer answers its own page alone")
        elif path.path == "/":
            self._answer(HTTPStatus.OK, "text/html; charset=utf-8", self.server.page)
        elif path.path == "/frames" and self.headers.get("Sec-Fetch-Site") in _OWN:
            self._frames(path.query)
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "there is / and /frames")

    def _frames(self, query: str) -> None:
        try:
            play = self.server.source.play(start_of(query))
        except InputError as fault:
            self._refuse(HTTPStatus.BAD_REQUEST, str(fault))
            return
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER_BYTES)
        self._head(HTTPStatus.OK, "text/event-stream; charset=utf-8")
        try:
            self._send(play)
        except FesloopError as fault:
            self.wfile.write(_event("fault", " ".join(str(fault).split())))

    def _send(self, play: Play) -> None:
        """Send frames, at most every 33 ms, and none while earlier ones are still on their way."""
        began = sent = time.monotonic()
        while not self.server.ending:
            now = time.monotonic()
            _, writable, _ = select.select([], [self.connection], [], _SLOWEST_S)
            if not writable:
                return
            shown = play(time.monotonic() - began)
            if shown is not None:
                self.wfile.write(_event("frame", shown.as_json()))
                sent = now
            elif now - sent > _SILENT_S:
                self.wfile.write(b": nothing new\n\n")
                sent = now
            time.sleep(max(0.0, now + FRAME_S - time.monotonic()))

    def _answer(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self._head(status, kind, len(body))
        self.wfile.write(body)

    def _refuse(self, status: HTTPStatus, why: str) -> None:
        self._answer(status, "text/plain; charset=utf-8", f"{why}\n".encode())

    def _head(self, status: HTTPStatus, kind: str, length: int | None = None) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        if length is not None:
            self.send_header("Content-Length", str(length))
        for name, value in (("Content-Security-Policy", policy()), ("X-Content-Type-Options", "nosniff"),
                            ("Referrer-Policy", "no-referrer"), ("Cache-Control", "no-store"),
                            ("Cross-Origin-Resource-Policy", "same-origin")):
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing."""


def start_of(query: str) -> Start:
    """Parse the query of a request, such as `trial=1&at=2.5&speed=0.5`.

    Raises InputError for what is no number, or not finite.
    """
    fields = {key: values[-1] for key, values in parse_qs(query).items()}
    try:
        return Start(trial=int(fields.get("trial", "0")), at_s=_finite(fields.get("at", "0")),
                     speed=_finite(fields.get("speed", "1")))
    except ValueError:
        raise InputError("frames", f"{query[:100]!r}", "trial, at and speed, each a number") from None


def _finite(text: str) -> float:
    number = float(text)
    if not abs(number) < 1e9:
        raise ValueError(text)
    return number


def _event(name: str, line: str) -> bytes:
    return f"event: {name}\ndata: {line}\n\n".encode()
