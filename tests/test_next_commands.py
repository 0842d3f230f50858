"""What is printed as `next:` can be typed: no placeholder is left, and names with blanks are quoted."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.apps.cli import main
from fesloop.apps.cli.parser import make_parser
from fesloop.experiment.files.layout import guide_of
from fesloop.experiment.files.parse import read
from fesloop.experiment.files.source import shipped

GUIDES = {name: guide_of(read(name)[1]) for name in shipped()}
LAYOUT = """rate = 50
pairs = [["a", "b"]]
[sensors.a]
gyr = [1, 2, 3]
acc = [4, 5, 6]
[sensors.b]
gyr = [7, 8, 9]
acc = [10, 11, 12]
"""


def next_lines(text):
    return [line.removeprefix("next:").strip() for line in text.splitlines() if line.startswith("next:")]


@given(name=st.sampled_from(sorted(GUIDES)), scored=st.booleans(),
       recording=st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), min_size=1),
       played=st.sampled_from(["lab.h5", "my lab/a b.csv", "it's.xdf", ""]),
       layout=st.sampled_from(["", "my lab/layout.toml"]))
@settings(max_examples=60, deadline=None)
def test_no_placeholder_is_printed_and_every_word_is_one(name, recording, played, layout, scored):
    given = [f"recording={played}"] * bool(played) + [f"blocks.recording.layout={layout}"] * bool(layout)
    for command in GUIDES[name].next_commands(recording, given, scored):
        words = shlex.split(command)
        assert not {"RUN.h5", "RECORDING", "recording=RECORDING"} & set(words)
        make_parser().parse_args(words[1:])
        if "RECORDING" in " ".join(GUIDES[name].try_next) and "recording=" in command:
            assert f"recording={played}" in words
            assert (f"blocks.recording.layout={layout}" in words) is bool(layout)


@pytest.mark.slow
@pytest.mark.parametrize("experiment", ["hil_replay", "replay"])
@pytest.mark.parametrize("with_layout", [True, False])
def test_what_a_run_of_a_recording_suggests_runs_as_printed(experiment, with_layout, tmp_path, capsys,
                                                            monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("my lab").mkdir()
    np.savetxt("my lab/a b.csv", np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 9.81], (40, 2)), delimiter=",")
    Path("my lab/layout.toml").write_text(LAYOUT)
    given = ["recording=my lab/a b.csv", "blocks.recording.layout=my lab/layout.toml"]
    if not with_layout:
        assert main(["import", "my lab/a b.csv", "my lab/a b.h5", "--layout", "my lab/layout.toml"]) == 0
        given = ["recording=my lab/a b.h5"]
    capsys.readouterr()
    sets = [word for setting in given for word in ("--set", setting)]
    assert main(["run", experiment, *sets, "--out", "my runs"]) == 0
    commands = next_lines(capsys.readouterr().err)
    assert commands
    assert not any("fit-error" in command for command in commands), "there is no reference"
    for command in commands:
        assert main(shlex.split(command)[1:]) == 0, command


def test_placeholders_are_known():
    for guide in GUIDES.values():
        for command in guide.try_next:
            assert set(re.findall(r"\b[A-Z]{3,}\b(?:\.h5)?", command)) <= {"RUN.h5", "RECORDING"}
