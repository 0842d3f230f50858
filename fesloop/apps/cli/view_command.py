"""`fesloop view`."""

from __future__ import annotations

import signal
import sys
import threading
import webbrowser
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from fesloop.errors import InputError
from fesloop.posix import lower_priority

if TYPE_CHECKING:
    from fesloop.show.view.server import ViewServer
    from fesloop.show.view.shown import Source


def execute(args: Namespace) -> int:
    """Serve the page until a signal ends it."""
    from fesloop.show.view.server import ViewServer

    if (args.source is None) == (args.stream is None):
        raise InputError("view", "both a recording and a stream" if args.source else "no source",
                         "a recording, or --stream NAME")
    _require_fitting(args)
    lower_priority()  # a loop that runs on this machine comes first
    source = _source(args)
    try:
        server = ViewServer(source, args.port)
        for notice in source.notices:
            print(f"fesloop: {notice}", file=sys.stderr)
        with _ending(server):
            print(f"{source.title}: {server.address}\nCtrl-C ends it", file=sys.stderr, flush=True)
            if args.open:
                webbrowser.open(server.address)
            server.serve_forever()
    finally:
        source.close()
    return 0


def _require_fitting(args: Namespace) -> None:
    """Raise InputError for options of streams with a recording, which knows its side and needs no network."""
    for option, value in (("--side", args.side), ("--network", args.network)):
        if args.source is not None and value is not None:
            raise InputError(option, f"{value}, with a recording", "with --stream only", "leave it out")


def _source(args: Namespace) -> Source:
    if args.stream is None:
        from fesloop.show.view.sources import open_recording

        return open_recording(Path(args.source))
    from fesloop.show.view.posture_stream import PostureStream

    return PostureStream(args.stream, args.side or "right", args.network or "loopback")


@contextmanager
def _ending(server: ViewServer) -> Iterator[None]:
    """Context in which SIGINT and SIGTERM end the server."""
    def end(*_: object) -> None:
        server.ending = True
        threading.Thread(target=server.shutdown, daemon=True).start()

    before = {number: signal.signal(number, end) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        server.server_close()
        for number, handler in before.items():
            signal.signal(number, handler)
