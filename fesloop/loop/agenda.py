"""What a loop does next: ticks of blocks, and samplings of plants that must keep their place among them."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from heapq import heapify, heapreplace

from fesloop.loop.clock import NS_PER_MS, Clock, RateClock
from fesloop.loop.publish import Sampler
from fesloop.loop.stations import BlockStation


class Agenda:
    """Stations by when they are due; those due at one instant go by their number in the firing order."""

    __slots__ = ("_heap",)

    def __init__(self, stations: Iterable[tuple[int, BlockStation | Sampler]]) -> None:
        self._heap = [(station.due, number, station) for number, station in stations]
        heapify(self._heap)

    def run_until(self, time_ns: int) -> None:
        """Fire everything due at or before `time_ns`."""
        heap = self._heap
        while heap and heap[0][0] <= time_ns:
            now, number, station = heap[0]
            heapreplace(heap, (station.fire(now), number, station))

    def arrive(self, clock: RateClock, time_ns: int, skipping: Collection[str]) -> None:
        """Let a clock of arrivals tick at `time_ns`; the blocks of these names let the tick pass."""
        for place, (_, number, station) in enumerate(self._heap):
            if station.clock == clock:
                station.due = time_ns
                if isinstance(station, BlockStation) and station.name in skipping:
                    station.skip("its message came late")
                self._heap[place] = station.due, number, station
        heapify(self._heap)

    def skip_until(self, time_ns: int, clocks: Collection[Clock]) -> set[int]:
        """Skip ticks of blocks on these clocks where the next is due by `time_ns` too; their instants."""
        skipped: set[int] = set()
        for place, (_, number, station) in enumerate(self._heap):
            if isinstance(station, BlockStation) and station.clock in clocks:
                while station.clock.tick(station.index + 1) <= time_ns:
                    skipped.add(station.due)
                    station.skip(f"{(time_ns - station.due) / NS_PER_MS:.3f} ms late")
                self._heap[place] = station.due, number, station
        heapify(self._heap)
        return skipped
