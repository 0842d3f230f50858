"""Patches over random experiment files, held against files written by hand and against each other."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.experiment.files.overlay import key_parts, key_text, keyed, patched, plain_lists
from fesloop.experiment.files.variants import combined, cut_off

NAMES = ["pid", "hand", "imus", "tracker", "finger"]
values = st.one_of(st.integers(0, 2), st.booleans(), st.sampled_from([0.0, 1.0, "x"]),
                   st.lists(st.integers(0, 1), max_size=2))
tables = st.dictionaries(st.sampled_from(["kind", "p", "q"]),
                         values | st.dictionaries(st.sampled_from("rs"), values, max_size=2), max_size=3)
blocks = st.dictionaries(st.sampled_from(NAMES), tables, min_size=1)


@pytest.mark.parametrize(("old", "new", "made"), [
    ({"kind": "finger", "curve": "linear"}, {"file": "mine.toml"}, {"file": "mine.toml"}),
    ({"file": "mine.toml"}, {"kind": "finger"}, {"kind": "finger"}),
    ({"kind": "finger", "curve": "linear"}, {"kind": "other"}, {"kind": "other"}),
    ({"kind": "finger", "curve": "linear"}, {"kind": "finger", "p": 1},
     {"kind": "finger", "curve": "linear", "p": 1}),
    ({"kind": "finger", "curve": "linear"}, {"curve": "x"}, {"kind": "finger", "curve": "x"})])
def test_a_table_of_another_kind_within_a_block_or_wire_replaces_the_old_one(old, new, made):
    base = {"blocks": {"pid": {"kind": "a", "q": 1, "model": old}},
            "wires": [{"from": "a.y", "to": "b.u", "jitter": old}]}
    patch = {"blocks": {"pid": {"kind": "b", "model": new}},
             "wires": [{"from": "a.y", "to": "b.u", "jitter": new}]}
    found = plain_lists(patched(keyed(base), patch, ""))
    assert found["blocks"]["pid"] == {"kind": "b", "q": 1, "model": made}
    assert found["wires"][0]["jitter"] == made


@st.composite
def documents(draw):
    """A file whose wires, signals and aliases lead to blocks that are there."""
    made = {"experiment": draw(tables), "blocks": draw(blocks)}
    known = sorted(made["blocks"])
    ends = st.tuples(st.sampled_from(known), st.sampled_from(known))
    latency = st.dictionaries(st.just("latency_ms"), values, max_size=1)
    made["wires"] = [{"from": f"{source}.y", "to": f"{target}.u", **draw(latency)}
                     for source, target in draw(st.lists(ends, unique=True, max_size=5))]
    made["record"] = {"leave_out": [f"{name}.y" for name in draw(st.sets(st.sampled_from(known)))]}
    made["aliases"] = {name: f"blocks.{name}.p" for name in known if "p" in made["blocks"][name]}
    made["aliases"] |= {f"late{i}": f'wires."{wire["from"]}->{wire["to"]}".latency_ms'
                        for i, wire in enumerate(made["wires"])}
    return made


def leaves(value, path=()):
    """Values that are no tables, by their paths; tables without any by theirs."""
    if not isinstance(value, dict) or not value:
        return {path: repr(value)}
    return {where: leaf for key, item in value.items() for where, leaf in leaves(item, (*path, key)).items()}


def alike(one, other):
    return leaves(keyed(one)) == leaves(keyed(other))


def patch_between(old, new):
    """A patch that makes one file of another, by comparing them."""
    was, wanted = keyed(old), keyed(new)
    patch = {"remove": [], "blocks": {}, "experiment": {}, "record": new["record"], "aliases": new["aliases"]}
    for name in was["blocks"]:
        if name not in wanted["blocks"]:
            patch["remove"].append(f"blocks.{name}")
    for top in ("experiment", "blocks"):
        _compare(was[top], wanted[top], (top,), patch["remove"], patch[top])
    gone = set(was["blocks"]) - set(wanted["blocks"])
    for ends, wire in was["wires"].items():
        left = not gone & {wire["from"].partition(".")[0], wire["to"].partition(".")[0]}
        if left and (ends not in wanted["wires"] or "latency_ms" not in wanted["wires"][ends]):
            patch["remove"].insert(0, f'wires."{ends}"')
    patch["remove"] = [*(f"aliases.{name}" for name in was["aliases"] if name not in wanted["aliases"]),
                       *patch["remove"]]
    patch["wires"] = new["wires"]
    return patch


def _compare(old, new, path, removed, told):
    for key in old:
        if key not in new and path != ("blocks",):
            removed.append(key_text((*path, key)))
    for key, value in new.items():
        if key in old and isinstance(value, dict) and isinstance(old[key], dict):
            _compare(old[key], value, (*path, key), removed, told.setdefault(key, {}))
        else:
            told[key] = value
            if key in old:
                removed.append(key_text((*path, key)))


@given(documents(), documents())
def test_a_patch_makes_what_could_be_written_by_hand(old, new):
    patch = patch_between(old, new)
    made = plain_lists(patched(keyed(old), patch, "here"))
    assert alike(made, new)


@given(documents(), st.data())
def test_with_a_block_goes_all_that_leads_to_it_and_nothing_else(document, data):
    gone = data.draw(st.sets(st.sampled_from(sorted(document["blocks"])), min_size=1))
    made = plain_lists(patched(keyed(document), {"remove": [f"blocks.{name}" for name in gone]}, "here"))

    def is_left(signal):
        return signal.partition(".")[0] not in gone

    assert made["blocks"] == {name: table for name, table in document["blocks"].items() if name not in gone}
    assert made["wires"] == [wire for wire in document["wires"]
                             if is_left(wire["from"]) and is_left(wire["to"])]
    assert made["record"]["leave_out"] == [name for name in document["record"]["leave_out"] if is_left(name)]
    for target in made["aliases"].values():
        here = keyed(made)
        for part in key_parts(target)[:-1]:
            here = here[part]


@pytest.mark.slow
@given(documents(), documents(), documents())
def test_two_patches_are_one_in_either_order_or_refuse_each_other_in_both(base, one, other):
    first, second = (patched(keyed(base), patch_between(base, new), "here") for new in (one, other))
    found = []
    for pair in ((first, second), (second, first)):
        try:
            found.append(plain_lists(combined(keyed(base), *pair)))
        except InputError as fault:
            found.append(fault)
    if isinstance(found[0], InputError):
        assert isinstance(found[1], InputError)
    else:
        assert alike(*found)
        old, left, right, both = (leaves(each) for each in (keyed(base), first, second, keyed(found[0])))
        for path in left.keys() & right.keys() & both.keys() & old.keys():
            assert both[path] == (left[path] if left[path] != old[path] else right[path])


@given(documents(), st.sampled_from(NAMES), st.sampled_from(NAMES))
def test_patches_of_different_blocks_are_as_one_after_the_other(document, one, other):
    if one == other:
        return
    patches = [{"blocks": {name: {"kind": "new", "p": {"r": 3}}}} for name in (one, other)]
    base = keyed(document)
    apart = combined(base, *(patched(base, patch, "here") for patch in patches))
    assert leaves(apart) == leaves(patched(patched(base, patches[0], "here"), patches[1], "here"))


@pytest.mark.parametrize(("key", "found"), [
    ("blocks.hnd", "there is no 'blocks.hnd'; allowed: hand, pid; did you mean 'hand'?"),
    ("blocks.hand.object.mass", "there is no 'blocks.hand.object'; allowed: kind"),
    ("blocks.hand.kind.x", "there is no 'blocks.hand.kind.x'"),
    ("block.hand", "there is no 'block'; allowed: experiment, record, blocks, wires; did you mean 'blocks'?"),
    ('wires."hand.y->pid.v"', "'wires.\"hand.y->pid.v\"'; allowed: hand.y->pid.u"),
    ("", "allowed: experiment"),
])
def test_what_is_not_there_cannot_be_removed(key, found):
    document = {"experiment": {}, "record": {}, "blocks": {"hand": {"kind": "hand"}, "pid": {"kind": "pid"}},
                "wires": [{"from": "hand.y", "to": "pid.u"}]}
    with pytest.raises(InputError, match=r"^here.remove\[0\]: ") as refused:
        patched(keyed(document), {"remove": [key]}, "here")
    assert found in str(refused.value)


def test_a_wire_to_a_block_that_another_patch_takes_out_is_found():
    base = keyed({"blocks": {"hand": {}, "pid": {}, "imus": {}}, "wires": []})
    wired = patched(base, {"wires": [{"from": "hand.y", "to": "imus.u"}]}, "here")
    gone = patched(base, {"remove": ["blocks.hand"]}, "here")
    assert cut_off(base, wired, gone) == "hand.y->imus.u"
    assert cut_off(base, gone, wired) == ""


def test_two_wires_between_the_same_ports_stay_two_for_the_check():
    wires = [{"from": "a.y", "to": "b.u"}, {"from": "a.y", "to": "b.u", "latency_ms": 1}]
    assert plain_lists(patched(keyed({"wires": wires}), {}, "here"))["wires"] == wires
