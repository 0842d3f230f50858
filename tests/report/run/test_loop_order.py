"""Blocks stand in the order in which data goes round, each once, whatever the wiring."""

from hypothesis import given
from hypothesis import strategies as st

from fesloop.experiment.files.parse import load
from fesloop.show.report.run.experiment import columns

NAMES = st.lists(st.sampled_from("abcdefgh"), min_size=1, unique=True)
PORTS = st.sampled_from(["stimulation", "angles", "reference"])


def told(name):
    document = load(name).document()
    return columns(document["blocks"], document["wires"])


def test_a_learning_grasp_goes_round_as_data_does():
    found = told("grasp_ilc")
    assert found.down == ("controller", "grip", "safety", "stimulator", "electrodes", "muscles", "hand")
    sensing = ("imus", "tracker", "synergies", "reference")
    assert tuple(name for name in found.up if name in sensing) == sensing


def test_a_finger_goes_round_as_data_does():
    found = told("finger_ilc")
    assert found.down == ("reference", "controller", "safety", "patient")
    assert found.up == ("imus", "tracker")


@given(NAMES, st.data())
def test_every_block_has_one_place(names, data):
    plants = data.draw(st.sets(st.sampled_from(names)))
    ends = st.tuples(st.sampled_from(names), PORTS).map(".".join)
    wires = data.draw(st.lists(st.fixed_dictionaries({"from": ends, "to": ends}), max_size=12))
    blocks = {name: {"kind": "x"} if name in plants else {"kind": "x", "execution": {}} for name in names}
    found = columns(blocks, wires)
    assert sorted([*found.down, *found.up]) == sorted(names)
