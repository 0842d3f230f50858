"""Roles of the blocks in a recording: hand, trackers, electrodes, stimulator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, get_args, get_type_hints

from fesloop.errors import InputError
from fesloop.experiment import registry
from fesloop.forms.schema import make
from fesloop.hand.anthropometry import HandSize
from fesloop.loop.block import is_plant
from fesloop.show.picture.signals import Described

_PLACE = ("kind", "rate", "clock", "offset_ms", "execution")
"""Keys of a block's table that are no parameters of its kind."""


@dataclass(frozen=True, slots=True, eq=False)
class Player:
    """A block of the recording: its name, and the object that is made from its table."""

    name: str
    part: Any

    @property
    def hand_size(self) -> HandSize:
        """Size of a hand or of a tracker's hand: its `size` if it has one, else its parameter `hand`."""
        own = getattr(self.part, "size", None)
        return own if isinstance(own, HandSize) else self.part.hand


@dataclass(frozen=True, slots=True, eq=False)
class Cast:
    """Blocks of a recording by role, found by the attributes of their kinds and by wires.

    Attributes
    ----------
    hand: the plant with a parameter `hand` of type HandSize.
    trackers: blocks with such a parameter and a recorded output `angles`.
    electrodes: the block with places of elements (`places`) and an output `recruitment`.
    stimulator: what is wired to the electrodes' `elements`.
    muscles: name of the block that puts out `activation`; empty where none does.
    stimulation: signal that commands the stimulator, or without one the plant that is scored, else any of
        that port's name; empty where none is.
    multiplexing: signal that switches the stimulator's channels; empty where none is.
    rotation: signal of forearm rotation that the electrodes receive; empty where there is none.
    """

    hand: Player | None
    trackers: tuple[Player, ...]
    electrodes: Player | None
    stimulator: Player | None
    muscles: str
    stimulation: str
    multiplexing: str
    rotation: str


def cast_of(recording: Described) -> Cast:
    """The parts of a recording.

    Raises InputError for a block whose kind is not installed any more or has other parameters by now.
    """
    blocks: Mapping[str, Any] = recording.experiment["blocks"]
    classes = {name: registry.find(table["kind"]) for name, table in blocks.items()
               if table["kind"] in registry.kinds()}
    signals = recording.signals

    def player(name: str) -> Player | None:
        return Player(name, _made(name, blocks[name], classes[name])) if name in classes else None

    handed = [name for name, kind in classes.items() if _has_hand(kind)]
    plants = [name for name in handed if is_plant(classes[name])]
    trackers = [name for name in handed if name not in plants and f"{name}.angles" in signals]
    arrays = [name for name, kind in classes.items() if hasattr(kind, "places") and _is(name, "recruitment",
                                                                                       recording)]
    electrodes = arrays[0] if arrays else ""
    stimulator = source_of(recording, f"{electrodes}.elements").partition(".")[0]
    muscles = [signal.partition(".")[0] for signal in signals if signal.endswith(".activation")]
    scored = str(recording.experiment.get("score", {}).get("truth", "")).partition(".")[0]
    stimulation = source_of(recording, f"{stimulator or scored}.stimulation")
    every = [signal for signal in signals if signal.endswith(".stimulation")]
    return Cast(player(plants[0]) if plants else None,
                tuple(found for name in trackers if (found := player(name)) is not None),
                player(electrodes), player(stimulator), muscles[0] if muscles else "",
                stimulation if stimulation in signals else next(iter(every), ""),
                source_of(recording, f"{stimulator}.multiplexing"),
                source_of(recording, f"{electrodes}.posture"))


def _has_hand(kind: type[Any]) -> bool:
    """Return whether a kind has a parameter `hand` of type HandSize."""
    if not any(field.name == "hand" for field in fields(kind)):
        return False
    declared = get_type_hints(kind)["hand"]
    return declared is HandSize or HandSize in get_args(declared)


def _is(name: str, port: str, recording: Described) -> bool:
    """Return whether a block has an output, recorded or not."""
    left_out = recording.experiment.get("record", {}).get("leave_out", [])
    return f"{name}.{port}" in [*recording.signals, *left_out]


def source_of(recording: Described, target: str) -> str:
    """Name of the signal that is wired to an input; empty without one."""
    wires = recording.experiment.get("wires", [])
    return next((str(wire["from"]) for wire in wires if wire["to"] == target), "")


def _made(name: str, table: Mapping[str, Any], kind: type[Any]) -> Any:
    parameters = {key: value for key, value in table.items() if key not in _PLACE}
    try:
        return make(kind, parameters, {}, f"blocks.{name}")
    except (KeyError, TypeError) as fault:
        raise InputError(f"blocks.{name}", f"its kind no longer takes what it was run with: {fault}",
                         remedy="draw with the version of its package that it was run with") from None
