"""`fesloop stream`."""

from __future__ import annotations

import signal
import sys
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from fesloop.apps.cli.output import print_doubts, print_json
from fesloop.errors import InputError
from fesloop.streams.doubts import all_doubts
from fesloop.streams.files import open_recording
from fesloop.streams.live.library import open_library
from fesloop.streams.live.sender import SenderFault, StreamSender, inertial

HAND = "hand"


def execute(args: Namespace) -> int:
    """Play a recording until it ends, the time is over, or a signal stops it."""
    if args.duration is not None and not args.duration > 0.0:
        raise InputError("--duration", f"{args.duration:g}", "seconds above 0")
    if args.recording == HAND and args.sensor_set is not None:
        raise InputError("--sensor-set", f"{args.sensor_set!r}, but {HAND} has one set", "none")
    faults = tuple(SenderFault.parse(text) for text in args.fault)
    open_library(args.network)
    if args.recording == HAND:
        from fesloop.experiment.moving_hand import moving_hand

        recording = moving_hand()
    else:
        recording = open_recording(args.recording, args.sensor_set)
        print_doubts(args.recording, all_doubts(recording))
    played = inertial(recording, args.rate)
    sender = StreamSender(played=played, stream=args.name, network=args.network, repeat=args.loop,
                          faults=faults)
    kinds = "gyr, acc, mag" if recording.mag is not None else "gyr, acc"
    print(f"stream {args.name!r}: {len(recording.sensors)} sensors ({kinds}) at {played.rate_hz:g} Hz; "
          "Ctrl-C ends it", file=sys.stderr, flush=True)
    with _stoppable() as stopped:
        sent = sender.send(args.duration, lambda: not stopped)
    if args.json:
        print_json({"stream": args.name, "sensors": list(recording.sensors), "rate_hz": played.rate_hz,
                    "sent": sent})
    return 0


@contextmanager
def _stoppable() -> Iterator[list[int]]:
    """Context in which SIGINT and SIGTERM are collected in a list, to be checked between two samples."""
    received: list[int] = []

    def receive(number: int, frame: FrameType | None) -> None:
        received.append(number)

    before = {number: signal.signal(number, receive) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
