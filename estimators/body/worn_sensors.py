"""A tracker's tree of sensors held against what the source of its samples states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar, cast

from estimators.body.body import Body
from estimators.body.joint_angles import Pairs
from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.signals import Sensors

T = TypeVar("T")
_CHAIN = 5
"""Sensors that trackers take for the chain of the set chain5 where nothing is said of them."""


def stated_by(sources: Mapping[str, Sensors]) -> Sensors:
    """What all inputs of a tracker state of their sensors; raises InputError where they differ."""
    (name, first), *others = sources.items()
    for other, stated in others:
        if stated != first:
            raise InputError(other, f"comes from {_listed(stated)}, {name} from {_listed(first)}",
                             "the same sensors")
    return first


def _listed(stated: Sensors) -> str:
    pairs = ", ".join(map(stated.pair_name, stated.pairs))
    return ", ".join(stated.names) + (f" ({pairs})" if pairs else "")


def stated_pairs(own: Pairs, stated: Sensors) -> Pairs:
    """The pairs of sensors that are joints: the tracker's own, of the stated ones, or all of these.

    Raises InputError for a pair that is not stated, and for three or more sensors of which none is.
    """
    if not stated.pairs:
        if not own and len(stated.names) > 2:
            raise InputError("pairs", f"which of the sensors {', '.join(stated.names)} are neighbours is not "
                             "stated", "(parent, child) of each joint",
                             "give pairs here, such as [[0, 1], [0, 2]], or in the recording's layout")
        return own
    for pair in own:
        if tuple(pair) not in stated.pairs:
            ends = f" ({stated.pair_name(pair)})" if all(0 <= k < len(stated.names) for k in pair) else ""
            raise InputError("pairs", f"{list(pair)}{ends} is none of the recording's pairs", ", ".join(
                f"{list(each)} ({stated.pair_name(each)})" for each in stated.pairs),
                             "mend the pairs here, or in the recording's layout")
    return own or stated.pairs


def stated_segments(sensed: tuple[str, ...], known: Sequence[str], stated: Sensors) -> tuple[str, ...]:
    """The segments that sensors sit on: the names of the sensors, where these are segments.

    Raises InputError where the tracker names others.
    """
    if not all(name in known for name in stated.names):
        return sensed
    if sensed and sensed != stated.names:
        raise InputError("sensed", f"names {', '.join(sensed)}", ", ".join(stated.names),
                         "the samples come from sensors of these names: leave sensed out, or mend it")
    return stated.names


def require_stated_tree(parents: Mapping[int, set[int]], stated: Sensors, where: str) -> None:
    """Raise InputError where a tracker hangs a sensor on another one than the recording states.

    `parents`: of each sensor those that the tracker hangs it on; of some that have none it may be empty.
    """
    for child, own in parents.items():
        given = {parent for parent, each in stated.pairs if each == child}
        if given and not own & given:
            has = (" and ".join(stated.names[k] for k in sorted(own)) or "nothing")
            raise InputError(where, f"hangs {stated.names[child]} on {has}", "as the recording states it: "
                             + ", ".join(map(stated.pair_name, stated.pairs)),
                             "mend the tracker's tree, or the pairs in the recording's layout")


def parents_in(body: Body) -> dict[int, set[int]]:
    """Of each sensor that of the nearest segment towards the root that has one."""
    found: dict[int, set[int]] = {}
    layout = body.tree.layout
    for number, segment in enumerate(body.sensed.tolist()):
        parent = int(layout[segment, 0])
        while parent >= 0 and body.sensors[parent] < 0:
            parent = int(layout[parent, 0])
        found[number] = {int(body.sensors[parent])} if parent >= 0 else set()
    return found


def worn_as_stated(tracker: T, stated: Sensors) -> T:
    """A tracker of a body, or of joints alone, whose sensors sit on the segments that they are named after.

    Where their names are no segments, the tracker says what they sit on. Raises InputError where it hangs a
    sensor on another one than is stated, and where nothing is stated of five sensors that it would take for
    a chain.
    """
    given: Any = tracker
    tree = SegmentTree(given.segments) if given.segments else hand_tree(given.hand)
    joints = getattr(given, "joints", ())
    sensed = given.sensed if joints else stated_segments(given.sensed, tree.names, stated)
    worn = bool(joints or sensed or given.segments or given.hand != HandSize())
    sensors = given.sensors or len(stated.names)
    if not worn and sensors == _CHAIN and not stated.pairs:
        raise InputError("sensed", f"is empty, and which of {', '.join(stated.names)} are neighbours is not "
                         "stated", "a segment each, or pairs in the recording's layout")
    told = replace(given, sensed=sensed, sensors=sensors)
    if told.body is not None:
        require_stated_tree(parents_in(told.body), stated, "sensed" if sensed else "segments")
    else:
        parents: dict[int, set[int]] = {}
        for parent, child in told.table.ends.tolist():
            parents.setdefault(child, set()).add(parent)
        require_stated_tree(parents, stated, "joints")
    return cast(T, told)
