"""Descriptions of live streams' channels, and the choice of channels for an output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.streams.labels import Kind, Reading, factor, not_understood, read_label

_AXES = "xyz"


class Channel(NamedTuple):
    """One channel as its stream describes it; empty text for what it does not say."""

    label: str
    unit: str
    type: str


class Picked(NamedTuple):
    """Channels of one output, in its shape, and the factors of their numbers to SI."""

    channels: NDArray[np.int64]
    factors: NDArray[np.float64]

    def of(self, sample: NDArray[Any]) -> NDArray[np.float64]:
        """The output in SI, from a sample of all channels."""
        return np.asarray(sample[self.channels] * self.factors, dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True)
class Declared:
    """The layout of a stream that does not describe its channels.

    Attributes
    ----------
    kinds: triads of each sensor in their order, x, y, z each.
    order: "by_sensor" (all triads of the first sensor, then of the next) or "by_kind".
    gyr_unit, acc_unit, mag_unit, angle_unit: of the numbers; also of described channels that state no unit.
        Empty: such channels are refused.
    """

    kinds: tuple[Kind, ...] = ()
    order: Literal["by_sensor", "by_kind"] = "by_sensor"
    gyr_unit: str = ""
    acc_unit: str = ""
    mag_unit: str = ""
    angle_unit: str = ""

    def unit(self, kind: str) -> str:
        """Declared unit of "gyr", "acc", "mag" or "angle"."""
        return str(getattr(self, f"{kind}_unit"))


def channels_of(info: Any) -> tuple[Channel, ...]:
    """Channels in a stream's description (pylsl's StreamInfo, complete), () for none."""
    found = []
    channel = info.desc().child("channels").child("channel")
    while not channel.empty():
        found.append(Channel(channel.child_value("label"), channel.child_value("unit"),
                             channel.child_value("type")))
        channel = channel.next_sibling("channel")
    return tuple(found)


def pick_inertial(channels: Sequence[Channel], count: int, kinds: Sequence[Kind], sensors: int,
                  names: Sequence[str], declared: Declared, where: str) -> dict[Kind, Picked]:
    """The channels of n sensors, (n, 3) a kind.

    Parameters
    ----------
    channels: as described; () where the stream describes none.
    count: how many channels the stream has.
    kinds: to choose channels of.
    sensors: n.
    names: of the sensors, in the order of the outputs; () takes those of the stream in their order.
    declared: where there is no description.
    where: the stream, for messages.

    Raises InputError where the stream does not fit.
    """
    if not channels:
        return _declared_triads(count, kinds, sensors, declared, where)
    if len(channels) != count:
        raise InputError(where, f"describes {len(channels)} channels and has {count}", "one each")
    axes, others = _axes(channels)
    unread = not_understood(others)
    found = list(dict.fromkeys(sensor for sensor, _, _ in axes))
    chosen = list(names) or found
    absent = [name for name in chosen if name not in found]
    if absent:
        raise InputError(where, f"has no sensor {absent[0]!r}", ", ".join(found) or "labels such as "
                         "F2p_gyr_x", unread)
    for (sensor, kind, axis), numbers in axes.items():
        if sensor in chosen and kind in kinds:
            _require_one(numbers, channels, f"{sensor} {kind} {axis}".strip(), where)
    if len(chosen) != sensors:
        raise InputError(where, f"has {len(chosen)} sensors ({', '.join(found)})", f"sensors = {sensors}",
                         "; ".join(filter(None, ("choose some by sensor_names", unread))))
    picked: dict[Kind, Picked] = {}
    for kind in kinds:
        missing = [f"{sensor} {kind} {axis}" for sensor in chosen for axis in _AXES
                   if Reading(sensor, kind, axis) not in axes]
        if missing:
            raise InputError(where, f"has no channel {missing[0]!r}", f"{kind} x, y, z of every sensor",
                             unread)
        triads = np.array([[axes[Reading(sensor, kind, axis)][0] for axis in _AXES] for sensor in chosen])
        picked[kind] = Picked(triads, _factors(channels, triads, kind, declared, where))
    return picked


def pick_angles(channels: Sequence[Channel], count: int, joints: Sequence[str], declared: Declared,
                where: str) -> Picked:
    """The channels of named joints, (k,); by their labels where there are some, else in their order.

    Raises InputError where the stream does not fit.
    """
    if not channels:
        if count != len(joints):
            raise InputError(where, f"has {count} channels", f"{len(joints)}, one a joint")
        numbers = np.arange(count)
        unit = factor("angle", declared.angle_unit, f"{where}: layout.angle_unit")
        return Picked(numbers, np.full(count, unit))
    labels = [channel.label for channel in channels]
    absent = [joint for joint in joints if joint not in labels]
    if absent:
        raise InputError(where, f"has no channel {absent[0]!r}", ", ".join(labels))
    for joint in joints:
        _require_one([k for k, label in enumerate(labels) if label == joint], channels, joint, where)
    numbers = np.array([labels.index(joint) for joint in joints])
    return Picked(numbers, _factors(channels, numbers, "angle", declared, where))


def _axes(channels: Sequence[Channel]) -> tuple[dict[Reading, list[int]], list[str]]:
    """Channel numbers by sensor, kind and axis, and the labels of those that are of no such kind."""
    axes: dict[Reading, list[int]] = {}
    others = []
    for number, channel in enumerate(channels):
        read = read_label(channel.label, channel.type)
        if read is None:
            others.append(channel.label or f"channel {number + 1}")
        else:
            axes.setdefault(read, []).append(number)
    return axes, others


def _require_one(numbers: Sequence[int], channels: Sequence[Channel], meant: str, where: str) -> None:
    """Raise InputError where several channels have the same meaning."""
    if len(numbers) > 1:
        first = " and ".join(f"{channels[number].label!r} (number {number + 1})" for number in numbers[:2])
        raise InputError(where, f"has {len(numbers)} channels of {meant}: {first}"
                         + (" and others" if len(numbers) > 2 else ""), "one",
                         "give each a label of its own at the sender")


def _declared_triads(count: int, kinds: Sequence[Kind], sensors: int, declared: Declared,
                     where: str) -> dict[Kind, Picked]:
    if not declared.kinds:
        raise InputError(where, f"does not describe its {count} channels", "labels such as F2p_gyr_x",
                         "declare them: layout = { kinds = ..., gyr_unit = ..., ... }")
    size = 3 * len(declared.kinds) * sensors
    if count != size:
        raise InputError(where, f"has {count} channels", f"{size}: {sensors} sensors of "
                         + ", ".join(declared.kinds))
    by_sensor = declared.order == "by_sensor"
    shape = (sensors, len(declared.kinds), 3) if by_sensor else (len(declared.kinds), sensors, 3)
    numbers = np.arange(count).reshape(shape)
    picked: dict[Kind, Picked] = {}
    for kind in kinds:
        if kind not in declared.kinds:
            raise InputError("layout.kinds", f"{', '.join(declared.kinds)} lack {kind}", ", ".join(kinds))
        unit = factor(kind, declared.unit(kind), f"layout.{kind}_unit")
        at = declared.kinds.index(kind)
        triads = numbers[:, at] if by_sensor else numbers[at]
        picked[kind] = Picked(triads, np.full(triads.shape, unit))
    return picked


def _factors(channels: Sequence[Channel], numbers: NDArray[np.int64], kind: str, declared: Declared,
             where: str) -> NDArray[np.float64]:
    """Factors to SI of channels, by the unit that they state, else the declared one."""
    units = [factor(kind, channels[number].unit or declared.unit(kind),
                    f"{where}: channel {channels[number].label!r}") for number in numbers.ravel().tolist()]
    return np.array(units).reshape(numbers.shape)
