"""Stimulation: what channels were commanded and gave over time, and what each element was given."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fesloop.experiment.withheld import given_signal
from fesloop.show.report.parts import Drawing, Notice, Paragraph, Part, Section, Strips
from fesloop.show.report.run.arrays import arrays_svg
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.stimulated import element_charge, final_stimulation
from fesloop.show.report.run.thinning import Course, course
from fesloop.show.report.run.words import listed, told

_COLOURS = 8
"""As many channels as have colours of their own."""
_MC = 1e-3
_LEGEND = ("Elements on the unrolled forearm have the colour of the channel that gave them most, the deeper "
           "the more charge. Dots are motor points, filled and named where their muscle was active.")
_SHOWN = (("Current", "current, mA", 1e3), ("Pulse width", "width, µs", 1e6))


def stimulation_section(known: Known) -> Section | None:
    """None for a run that stimulates nothing."""
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
            parts.append(Paragraph(text=f"No channel gave a pulse in trial {listed(idle)}."))
    else:
        parts.append(Notice(text="The channels are not shown: no stimulation is recorded."))
    return Section(key="stimulation", title="Stimulation", parts=[*parts, *_arrays(known)])


def _what_is_shown(known: Known, name: str, given: str | None) -> str:
    """Which signal is a command, and which is what the patient got."""
    if given:
        return (f"Charge is what the device gave (`{given}`, one phase of a channel's newest pulse). Current "
                f"and pulse width are what `{name}` commanded: the device rounds and limits them, and gives "
                "no pulse shorter than it can.")
    if known.cast is not None and known.cast.stimulator is not None:
        return (f"Current and pulse width are what `{name}` commanded. What of it "
                f"`{known.cast.stimulator.name}` gave is not recorded.")
    return f"As put out by `{name}`, the last signal before the patient."


def _channels(known: Known, name: str, given: str | None, trial: int) -> Iterator[Part]:
    """Charge that was given, and current and pulse width, of every channel that is used in a trial."""
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
    names = {channel: f"channel {channel}{'' if gave[channel] else ', no pulse given'}" for channel in used}
    shown: list[tuple[Course, str, str, str, float, tuple[int, ...]]] = []
    if charge is not None:
        shown.append((charge, "charge", "Charge of a pulse, given", "charge, µC", 1e6, ()))
    after = "" if charge is None else ", commanded"
    shown += [(found, str(port), f"{title}{after}", label, factor, (port,))
              for port, (title, label, factor) in enumerate(_SHOWN)]
    for of, key, title, label, factor, port in shown:
        lines = [of.line(names[channel], f"channel-{channel % _COLOURS}", (channel, *port), factor, "steps")
                 for channel in used]
        most = [float(np.nanmax(line.y if line.high is None else line.high)) for line in lines]
        greatest = listed([f"{line.name} up to {told(each)}" for line, each in zip(lines, most, strict=True)])
        yield Strips(key=f"stimulation-{key}-{trial}", title=title, x_label="time, s", y_label=label,
                     lines=lines, trial=trial, timed=True, limits=(0.0, 1.05 * max(most) or 1.0),
                     text=f"{label}{after if of is found else ''}, in trial {trial}: {greatest}{rest}.")


def _highest(found: Course) -> np.ndarray:
    """The greatest value of each point."""
    return found.mean if found.high is None else found.high


def _arrays(known: Known) -> Iterator[Part]:
    """The arrays of each drawn trial, in one scale of charge."""
    if known.cast is None or known.cast.electrodes is None:
        return
    given = {trial: element_charge(known, trial) for trial in known.trials}
    highest = max((float(each[0].max()) for each in given.values() if each is not None), default=0.0)
    if all(each is None for each in given.values()):
        if known.score.get("search"):
            return
        yield Notice(text="Elements are not coloured: the stimulator's charges are not recorded, or how its "
                          "channels lie on the elements is not.")
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
    in_all = f"{told(1e3 * total)} mC" if total >= _MC else f"{told(1e6 * total)} µC"
    return f"Charge of each element in the trial, one phase: {in_all} in all"


def _strongest(known: Known, trial: int) -> np.ndarray | None:
    """Greatest activation of each muscle in a trial, (29,)."""
    name = f"{known.cast.muscles}.activation" if known.cast is not None and known.cast.muscles else ""
    found: Course | None = course(known.recording, name, trial) if name in known.signals else None
    if found is None or found.mean.ndim != 2:
        return None
    return np.asarray(np.nan_to_num(_highest(found)).max(axis=0))


def _in_words(charge: np.ndarray | None) -> str:
    text = "Elements of the arrays on the unrolled forearm, the elbow at the top, and the motor points."
    if charge is not None and charge.any():
        most = np.argsort(-charge)[:3]
        text += " Most charge: " + listed([f"element {element} ({told(1e6 * float(charge[element]))} µC)"
                                           for element in most.tolist() if charge[element] > 0.0]) + "."
    return text
