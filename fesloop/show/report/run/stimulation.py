"""Section of a report on stimulation: channels over time, and charge of each element of the arrays."""


from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.joints import held
from fesloop.experiment.metrics.stimulation import given_signal
from fesloop.hand.movements import muscle
from fesloop.show.picture.arrays import CUT_DEG, motor_points, placed_labels, unrolled
from fesloop.show.report import svg
from fesloop.show.report.parts import Drawing, Notice, Paragraph, Part, Section, Strips
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.thinning import Course, course
from fesloop.show.report.run.words import listed, rounded

Array = NDArray[np.float64]
_PORT = "stimulation"


def final_stimulation(known: Known) -> str:
    """Name of the recorded stimulation closest to the patient; empty if none is recorded.

    It is the signal that commands the stimulator, or else one that no other block passes on.
    """
    if known.cast is not None and known.cast.stimulator is not None and known.cast.stimulation:
        return known.cast.stimulation
    every = sorted(name for name in known.signals if name.endswith(f".{_PORT}"))
    wires = known.recording.experiment.get("wires", [])
    passed_on = {wire["from"] for wire in wires
                 if wire["to"].endswith(f".{_PORT}") and wire["to"] in every}
    return next((name for name in every if name not in passed_on), "")


def element_charge(known: Known, trial: int) -> tuple[Array, Array | None] | None:
    """Charge (elements,), C, of one phase of all pulses in a trial, and its parts (channels, elements).

    The parts are None if the charge of channels is unknown. The result is None if charges, the assignment of
    channels to elements, or the pulse rate are unknown.
    """
    if known.cast is None or known.cast.stimulator is None:
        return None
    name = known.cast.stimulator.name
    if f"{name}.charge" in known.signals:
        pulses, by_channel = _pulses_a_row(known, f"{name}.charge", trial), _by_channel(known, trial)
        if pulses is not None and by_channel is not None:
            return pulses * by_channel.sum(axis=0), pulses * by_channel
    if f"{name}.element_charge" in known.signals:
        pulses = _pulses_a_row(known, f"{name}.element_charge", trial)
        total = _sum(known, f"{name}.element_charge", trial)
        return None if pulses is None or total is None else (pulses * total, None)
    return None


def _pulses_a_row(known: Known, name: str, trial: int) -> float | None:
    """Pulses of a channel per row of the stimulator's charges; None if unknown.

    It is below 1 because the charge of a pulse is repeated in every slot until the channel's next pulse.
    """
    assert known.cast is not None
    assert known.cast.stimulator is not None
    part = known.cast.stimulator.part
    if not hasattr(part, "frequency_hz"):
        return None
    first = next(known.recording.tables([name], trial)[0].pieces(), None)
    if first is None or len(first.times_ns) < 2:
        return None
    return float(Fraction(part.frequency_hz)) * 1e-9 * float(first.times_ns[1] - first.times_ns[0])


def _by_channel(known: Known, trial: int) -> Array | None:
    """Charge (channels, elements), C, summed over rows and distributed as the channels were switched."""
    cast = known.cast
    assert cast is not None
    assert cast.stimulator is not None
    charge = f"{cast.stimulator.name}.charge"
    if cast.multiplexing:
        recorded = cast.multiplexing in known.signals
        return _switched(known, charge, cast.multiplexing, trial) if recorded else None
    total = _sum(known, charge, trial)
    part = cast.stimulator.part
    if total is None or not hasattr(type(part), "shares"):
        return None
    if hasattr(part, "resolve"):
        part = part.resolve({_PORT: (len(total), 2)})
    shares: Array = part.shares
    return total[:, np.newaxis] * shares


def _switched(known: Known, charge: str, multiplexing: str, trial: int) -> Array | None:
    switched = known.recording.column(multiplexing, trial)
    total: Array | None = None
    for table in known.recording.tables([charge], trial):
        for piece in table.pieces():
            given = np.flatnonzero(piece.values[0].any(axis=1))
            shares = np.nan_to_num(held(switched, piece.times_ns[given]))
            sums = np.einsum("tc,tce->ce", piece.values[0][given], shares)
            total = sums if total is None else total + sums
    return total


def _sum(known: Known, name: str, trial: int) -> Array | None:
    """Sum over all rows of a trial; None without rows."""
    total: Array | None = None
    for table in known.recording.tables([name], trial):
        for piece in table.pieces():
            sums = piece.values[0].sum(axis=0)
            total = sums if total is None else total + sums
    return total


_SCALE = 2.6
"""Pixels a mm, where the page is as wide as the drawing."""
_AROUND_MM, _POINT_MM = 12.0, 2.0
_LARGER = 1.7
"""Letters are so much larger than those of the printed picture, whose labels keep out of each other's way."""
_LETTER, _HEIGHT = 7.2, 13.0
_ACTIVE = 0.05
"""Muscles below this activation are not named (chosen): there are more than there is room for."""


def arrays_svg(electrodes: Any, charge: Array | None, highest: float, shares: Array | None,
               strongest: Array | None) -> str:
    """The drawing.

    Parameters
    ----------
    electrodes: the block; its `places` (elements, 3): around, along, radius, mm; its `radius_mm`; and where
        it has them its `motor_points` (muscle, around_deg, along_mm).
    charge: (elements,), C. highest: that of the deepest colour. shares: (channels, elements), C, of each
        channel. strongest: (29,), greatest activation of each muscle. None for what is not known.
    """
    places, points = unrolled(electrodes.places, electrodes.radius_mm), motor_points(electrodes)
    along = np.concatenate([places[:, 1], [place[1] for place in points.values()]])
    turn = 2.0 * np.pi * electrodes.radius_mm
    corner = np.array([np.deg2rad(CUT_DEG) * electrodes.radius_mm, along.min() - _AROUND_MM])
    size = np.array([turn, along.max() + _AROUND_MM - corner[1]])
    places = np.column_stack((_SCALE * (places[:, :2] - corner), _SCALE * places[:, 2]))
    spots = {name: _SCALE * (place - corner) for name, place in points.items()}
    wide, high = (_SCALE * size).tolist()
    pieces = [*_skin(wide, high), *_elements(places, charge, highest, shares),
              *_points(spots, strongest)]
    return svg.drawing(wide, high + 20.0, pieces)


def _skin(wide: float, high: float) -> Iterator[str]:
    """Dorsal and volar halves with their labels."""
    for x, name in ((0.0, "back"), (0.5 * wide, "front")):
        yield svg.rect(x + 0.5, 0.5, 0.5 * wide - 1.0, high - 1.0, "paper stroke-plain", radius=4.0)
        yield svg.text(x + 8.0, 16.0, f"{name} of the forearm", kind="faint", size=12.0)
    yield svg.text(wide - 8.0, 16.0, "elbow ↑", kind="faint", size=12.0, anchor="end")
    yield svg.text(wide - 8.0, high - 6.0, "wrist ↓", kind="faint", size=12.0, anchor="end")
    for share, name, anchor in ((0.0, "ulnar", "start"), (0.5, "radial", "middle"), (1.0, "ulnar", "end")):
        yield svg.text(share * wide, high + 15.0, name, kind="faint", size=12.0, anchor=anchor)


def _elements(places: Array, charge: Array | None, highest: float, shares: Array | None) -> Iterator[str]:
    """Circles of elements in the colour of the channel that gave most charge; deeper means more."""
    for element, (x, y, radius) in enumerate(places.tolist()):
        given = 0.0 if charge is None else float(charge[element])
        words = f"element {element}"
        if charge is not None:
            words += f": {rounded(1e6 * given) if given else 0} µC"
        yield svg.circle(x, y, radius, "paper stroke-plain", width=0.8, tooltip=words)
        if given > 0.0 and highest > 0.0:
            role = "plain"
            if shares is not None:
                channel = int(np.argmax(shares[:, element]))
                role, words = f"channel-{channel % 8}", f"{words}, channel {channel}"
            yield svg.circle(x, y, radius, f"fill-{role}", opacity=0.2 + 0.8 * given / highest, tooltip=words)
        yield svg.text(x, y + 0.85 * radius, str(element), kind="faint", size=9.0, anchor="middle")


def _points(spots: dict[str, Array], strongest: Array | None) -> Iterator[str]:
    """Motor points; those of active muscles are filled and named."""
    active = {name: float(strongest[muscle(name)]) for name in spots
              if strongest is not None and strongest[muscle(name)] >= _ACTIVE}
    for name, (x, y) in spots.items():
        share = active.get(name)
        words = f"motor point of {name}" + (f", activated to {100.0 * share:.0f} %" if share else "")
        kind = "fill-plain" if share else "paper stroke-plain"
        yield svg.circle(x, y, _SCALE * _POINT_MM, kind, tooltip=words)
    shrunk = {name: spots[name] / (_SCALE * _LARGER) for name in active}
    for name, place in placed_labels(shrunk, {name: name for name in active}, _POINT_MM / _LARGER).items():
        x, y = (_SCALE * _LARGER * place).tolist()
        wide = _LETTER * len(name)
        yield svg.rect(x - 0.5 * wide, y - 0.5 * _HEIGHT, wide, _HEIGHT, "paper", radius=3.0, opacity=0.75)
        yield svg.text(x, y + 4.0, name, size=11.5, anchor="middle", bold=True)


_COLOURS = 8
"""Number of channels with colours of their own."""
_MC = 1e-3
_LEGEND = ("Elements on the unrolled forearm have the colour of the channel that delivered most charge; "
           "deeper means more charge. Dots are motor points; those of active muscles are filled and named.")
_SHOWN = (("Current", "current, mA", 1e3), ("Pulse width", "width, µs", 1e6))


def stimulation_section(known: Known) -> Section | None:
    """Section on stimulation; None for a run without it."""
    name = final_stimulation(known)
    arrays = known.cast is not None and known.cast.electrodes is not None
    if not name and not arrays:
        return None
    parts: list[Part] = []
    if name:
        given = given_signal(known.recording, name)
        parts.append(Paragraph(text=_what_is_shown(known, name, given)))
        charts = {trial: list(_channels(known, name, given, trial)) for trial in known.trials}
        parts += [chart for each in charts.values() for chart in each]
        idle = [str(trial) for trial, each in charts.items() if not each]
        if idle:
            parts.append(Paragraph(text=f"No channel delivered a pulse in trial {listed(idle)}."))
    else:
        parts.append(Notice(text="Channels are not shown: no stimulation is recorded."))
    return Section(key="stimulation", title="Stimulation", parts=[*parts, *_arrays(known)])


def _what_is_shown(known: Known, name: str, given: str | None) -> str:
    """Sentence on which signals are commands and which are delivered charge."""
    if given:
        return (f"Charge is that of one phase of a channel's newest delivered pulse (`{given}`). Current "
                f"and pulse width are those that `{name}` commanded: the device rounds and limits them, and "
                "delivers no pulse below its least width.")
    if known.cast is not None and known.cast.stimulator is not None:
        return (f"Current and pulse width are those that `{name}` commanded. The charge that "
                f"`{known.cast.stimulator.name}` delivered is not recorded.")
    return f"As put out by `{name}`, the last signal before the patient."


def _channels(known: Known, name: str, given: str | None, trial: int) -> Iterator[Part]:
    """Strips of delivered charge, current and pulse width of the channels used in a trial."""
    found = course(known.recording, name, trial)
    if found is None or found.mean.ndim != 3 or found.mean.shape[2] != 2:
        return
    highest = _highest(found)
    charged = np.nan_to_num(highest[..., 0] * highest[..., 1]).max(axis=0) > 0.0
    charge = course(known.recording, given, trial) if given else None
    if charge is not None and charge.mean.shape[1:] != charged.shape:
        charge = None
    gave = charged if charge is None else np.nan_to_num(_highest(charge)).max(axis=0) > 0.0
    used = np.flatnonzero(charged | gave).tolist()
    if not used:
        return
    idle = sorted(set(range(len(charged))) - set(used))
    rest = f"; idle: {listed([str(channel) for channel in idle])}" if idle else ""
    names = {channel: f"channel {channel}{'' if gave[channel] else ', no pulse delivered'}"
             for channel in used}
    shown: list[tuple[Course, str, str, str, float, tuple[int, ...]]] = []
    if charge is not None:
        shown.append((charge, "charge", "Charge of a pulse, delivered", "charge, µC", 1e6, ()))
    after = "" if charge is None else ", commanded"
    shown += [(found, str(port), f"{title}{after}", label, factor, (port,))
              for port, (title, label, factor) in enumerate(_SHOWN)]
    for of, key, title, label, factor, port in shown:
        lines = [of.line(names[channel], f"channel-{channel % _COLOURS}", (channel, *port), factor, "steps")
                 for channel in used]
        most = [float(np.nanmax(line.y if line.high is None else line.high)) for line in lines]
        greatest = listed([f"{line.name} up to {rounded(each)}"
                           for line, each in zip(lines, most, strict=True)])
        yield Strips(key=f"stimulation-{key}-{trial}", title=title, x_label="time, s", y_label=label,
                     lines=lines, trial=trial, timed=True, limits=(0.0, 1.05 * max(most) or 1.0),
                     text=f"{label}{after if of is found else ''}, in trial {trial}: {greatest}{rest}.")


def _highest(found: Course) -> np.ndarray:
    """Greatest value at each point."""
    return found.mean if found.high is None else found.high


def _arrays(known: Known) -> Iterator[Part]:
    """Drawings of the arrays in the shown trials, in one scale of charge."""
    if known.cast is None or known.cast.electrodes is None:
        return
    given = {trial: element_charge(known, trial) for trial in known.trials}
    highest = max((float(each[0].max()) for each in given.values() if each is not None), default=0.0)
    if all(each is None for each in given.values()):
        if known.score.get("search"):
            return
        yield Notice(text="Elements are not coloured: the stimulator's charges, or the assignment of its "
                          "channels to elements, are not recorded.")
    else:
        yield Paragraph(text=_LEGEND)
    for trial, each in given.items():
        charge, shares = (None, None) if each is None else each
        strongest = _strongest(known, trial)
        yield Drawing(key=f"arrays-{trial}", title=_title(charge), trial=trial,
                      svg=arrays_svg(known.cast.electrodes.part, charge, highest, shares, strongest),
                      text=_in_words(charge))


def _title(charge: np.ndarray | None) -> str:
    if charge is None:
        return "The arrays on the unrolled forearm"
    total = float(charge.sum())
    in_all = f"{rounded(1e3 * total)} mC" if total >= _MC else f"{rounded(1e6 * total)} µC"
    return f"Charge of each element in the trial, one phase: {in_all} in total"


def _strongest(known: Known, trial: int) -> np.ndarray | None:
    """Greatest activation (29,) of each muscle in a trial."""
    name = f"{known.cast.muscles}.activation" if known.cast is not None and known.cast.muscles else ""
    found: Course | None = course(known.recording, name, trial) if name in known.signals else None
    if found is None or found.mean.ndim != 2:
        return None
    return np.asarray(np.nan_to_num(_highest(found)).max(axis=0))


def _in_words(charge: np.ndarray | None) -> str:
    text = "Elements of the arrays on the unrolled forearm, the elbow at the top, and the motor points."
    if charge is not None and charge.any():
        most = np.argsort(-charge)[:3]
        text += " Most charge: " + listed([f"element {element} ({rounded(1e6 * float(charge[element]))} µC)"
                                           for element in most.tolist() if charge[element] > 0.0]) + "."
    return text
