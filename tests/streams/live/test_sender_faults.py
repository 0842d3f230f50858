"""What a sender sends while it is out of order."""

import pytest

from fesloop.errors import InputError
from fesloop.streams.live.sender import FAULTS, FaultySender, SenderFault

RATE = 100.0


def sent(fault, count=30):
    """(row, stamp in samples, lost) of what leaves for each of `count` samples, faults from 0.1 to 0.2 s."""
    sender = FaultySender([SenderFault.parse(fault)], RATE)
    return [[(s.row, round(s.stamp_s * RATE), s.lost) for s in sender.sendings(k, k / RATE, k / RATE)]
            for k in range(count)]


def usual(rows):
    return [[(k, k, False)] for k in rows]


@pytest.mark.parametrize(("fault", "during"), [
    ("stop@0.1+0.1", [[]] * 10),
    ("vanish@0.1+0.1", [[]] * 10),
    ("freeze@0.1+0.1", [[(9, k, False)] for k in range(10, 20)]),
    ("repeat@0.1+0.1", [[(9, 9, False)]] * 10),
    ("jump@0.1+0.1x0.5", [[(k + 50, k, False)] for k in range(10, 20)]),
    ("clock@0.1+0.1x-2", [[(k, k - 200, False)] for k in range(10, 20)]),
    ("nan@0.1+0.1", [[(k, k, True)] for k in range(10, 20)]),
    ("reorder@0.1+0.1", [part for k in range(10, 20, 2) for part in ([], [(k + 1, k + 1, False),
                                                                          (k, k, False)])]),
    ("rate@0.1+0.1", usual(range(10, 20))),
])
def test_each_fault_is_what_it_says_while_it_lasts(fault, during):
    found = sent(fault)
    assert found[:10] == usual(range(10))
    assert found[10:20] == during
    assert found[20:] == usual(range(20, 30))


def test_nothing_is_lost_where_reordering_ends_within_a_pair():
    found = sent("reorder@0.1+0.05")
    assert sorted(row for sendings in found for row, _, _ in sendings) == list(range(30))


def test_another_rate_is_a_matter_of_pace():
    sender = FaultySender([SenderFault.parse("rate@1+1x0.5")], RATE)
    assert [sender.pace(time_s) for time_s in (0.99, 1.0, 1.99, 2.0)] == [1.0, 0.5, 0.5, 1.0]


def test_every_kind_can_be_said():
    for kind in FAULTS:
        assert SenderFault.parse(f"{kind}@3").length_s == 1.0


@pytest.mark.parametrize("text", ["", "stop", "stop@", "halt@3", "stop@1+x", "rate@1x0", "stop@1..2",
                                  "nan@-1", "stop@1+1x3"])
def test_what_is_no_fault_is_refused(text):
    with pytest.raises(InputError, match="--fault"):
        SenderFault.parse(text)
