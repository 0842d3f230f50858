"""Layouts: no column is used twice, however it is named, and pairs lead from the root outwards."""

import re

import numpy as np
import pytest
import xdf_files
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from fesloop.errors import InputError
from fesloop.loop.signals import Sensors
from fesloop.streams.files import open_recording
from fesloop.streams.formats.layout import Layout, SensorLayout

NAMES = "abcd"
KINDS = ("gyr", "acc", "mag")
STILL = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 9.81, 2e-5, 0.0, -4e-5])
SAFE = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def written(folder, kind, places):
    """A file of two sensors and its layout, in which triples of columns, from 0, are named in either way."""
    table = np.tile(STILL, (20, 2))
    if kind == "table":
        names = [f"c{k}" for k in range(18)]
        np.savetxt(folder / "lab.csv", table, delimiter=",", header=",".join(names), comments="")
        path, time = folder / "lab.csv", "rate = 100\n"
    elif kind == "variables":
        path, time = folder / "lab.mat", "rate = 100\n"
        savemat(path, {"all": table})
    else:
        path, time = folder / "lab.xdf", 'time = "imu"\n'
        path.write_bytes(xdf_files.motion_file(units=[""] * 9))
    text = time
    for sensor, kinds in places.items():
        text += f"[sensors.{sensor}]\n"
        for quantity, (columns, named) in kinds.items():
            if kind == "variables":
                told = f'{{variable = "all", columns = {[k + 1 for k in columns]}}}'
            elif named and kind == "table":
                told = str([f"c{k}" for k in columns])
            else:
                told = str([k + 1 for k in columns])
            text += f"{quantity} = {told}\n"
    (folder / "layout.toml").write_text(text)
    return path, folder / "layout.toml"


@given(kind=st.sampled_from(["table", "variables"]), named=st.lists(st.booleans(), min_size=6, max_size=6),
       copied=st.none() | st.tuples(st.integers(0, 5), st.integers(0, 17)))
@SAFE
def test_columns_are_taken_once_whether_named_or_numbered(tmp_path, kind, named, copied):
    """`copied`: which triple's first column is replaced by which column."""
    triples = [[3 * k, 3 * k + 1, 3 * k + 2] for k in range(6)]
    own = copied is None or triples[copied[0]][0] == copied[1]
    if copied:
        triples[copied[0]][0] = copied[1]
    places = {sensor: {quantity: (triples[3 * i + j], named[3 * i + j]) for j, quantity in enumerate(KINDS)}
              for i, sensor in enumerate(("hand", "F2p"))}
    path, layout = written(tmp_path, kind, places)
    if own:
        assert open_recording(path, layout=layout).sensors == ("hand", "F2p")
        return
    with pytest.raises(InputError, match=rf"names column {copied[1] + 1} (of all )?(twice|as well as)"):
        open_recording(path, layout=layout)


def test_channels_of_a_stream_and_the_time_are_taken_once(tmp_path):
    places = {"hand": {"gyr": ([0, 1, 2], False), "acc": ([3, 4, 2], False)}}
    path, layout = written(tmp_path, "xdf", places)
    words = r"sensors\.hand\.acc: names column 3 of imu as well as sensors\.hand\.gyr"
    with pytest.raises(InputError, match=words):
        open_recording(path, layout=layout)
    path, layout = written(tmp_path, "table", places)
    layout.write_text(layout.read_text().replace("rate = 100", "time = 1"))
    with pytest.raises(InputError, match=r"sensors\.hand\.gyr: names column 1 as well as time"):
        open_recording(path, layout=layout)


def test_sensors_on_one_segment_may_share_its_orientation_and_nothing_else(tmp_path):
    table = np.hstack([np.tile(STILL, (20, 2)), np.tile([1.0, 0.0, 0.0, 0.0], (20, 1))])
    np.savetxt(tmp_path / "lab.csv", table, delimiter=",")
    text = ("rate = 100\n[text]\nheader = 0\n[sensors.a]\ngyr = [1, 2, 3]\nacc = [4, 5, 6]\n"
            "orientation = [19, 20, 21, 22]\n[sensors.b]\ngyr = [10, 11, 12]\nacc = [13, 14, 15]\n"
            "orientation = [19, 20, 21, 22]\n")
    (tmp_path / "layout.toml").write_text(text)
    assert open_recording(tmp_path / "lab.csv", layout=tmp_path / "layout.toml").reference is not None
    for wrong, words in (("[19, 20, 21, 21]", "column 21 twice"),
                         ("[19, 1, 2, 3]", r"as well as sensors\.a\.gyr")):
        (tmp_path / "layout.toml").write_text(text.replace("[19, 20, 21, 22]", wrong))
        with pytest.raises(InputError, match=r"sensors\.a\.orientation: names .*" + words):
            open_recording(tmp_path / "lab.csv", layout=tmp_path / "layout.toml")


def acyclic(pairs):
    """Whether sensors can be put in an order in which every parent comes first, by removing roots."""
    left, nodes = set(pairs), set(range(len(NAMES)))
    while roots := {node for node in nodes if all(child != node for _, child in left)}:
        nodes -= roots
        left = {pair for pair in left if pair[0] in nodes}
    return not nodes


@given(pairs=st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), max_size=6))
@settings(max_examples=200, deadline=None)
def test_pairs_are_refused_where_one_is_listed_twice_or_they_close_a_loop(pairs):
    sensors = {name: SensorLayout(gyr=(1, 2, 3), acc=(4, 5, 6)) for name in NAMES}
    named = tuple((NAMES[parent], NAMES[child]) for parent, child in pairs)
    makers = (lambda: Layout(rate=100, sensors=sensors, pairs=named),
              lambda: Sensors(tuple(NAMES), tuple(pairs)))
    for make in makers:
        if len(set(pairs)) == len(pairs) and acyclic(pairs):
            assert len(make().pairs) == len(pairs)
            continue
        with pytest.raises(InputError, match=r"paired with itself|listed twice|close a loop") as caught:
            make()
        assert caught.value.where == "pairs"
        assert re.search("'[abcd]'", str(caught.value))
