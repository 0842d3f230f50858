"""What every shipped experiment says of itself: of which job it is, what it takes and needs, what comes next.

About 30 s: each is loaded with and without what it needs.
"""

import re
import shlex
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest
from recording_files import write

import fesloop
from fesloop.analysis.study.design.study_file import read_study
from fesloop.apps.cli.parser import make_parser
from fesloop.errors import InputError
from fesloop.experiment import running
from fesloop.experiment.files.layout import RUN, guide_of
from fesloop.experiment.files.parse import from_document, read
from fesloop.experiment.files.source import shipped
from fesloop.loop.realtime import is_live
from plants.myohand import model

MODULES = {"search": ("sklearn", "sklearn.gaussian_process", "optuna"), "lsl": ("pylsl",),
           "myohand": ("myo_sim",), "stimulator": ("pysciencemode", "serial")}
GUIDES = {name: guide_of(read(name)[1]) for name in shipped()}
GIVEN = {"a recording": "recording", "a run": "recording", "an error process": "error"}
"""What must be given, and by which setting."""


def extras(needs):
    return {need.removeprefix("extra ") for need in needs if need.startswith("extra ")}


@pytest.fixture
def bare(monkeypatch):
    """An installation without any extra."""
    for names in MODULES.values():
        for name in names:
            monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr("fesloop.streams.live.library._opened", {})  # and what another test has loaded
    model.loaded.cache_clear()  # another test may have had MyoHand


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """(a run of a finger, a recording of sensors): what settings of commands may name."""
    folder = tmp_path_factory.mktemp("recorded")
    run = fesloop.load("finger_control", ["experiment.duration_s=1"]).run(folder).recording
    return SimpleNamespace(run=run, sensors=write(folder, "broad"))


def test_every_shipped_experiment_has_a_guide():
    assert all(GUIDES.values())
    declared = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text())
    known = set(declared["project"]["optional-dependencies"])
    for guide in GUIDES.values():
        assert extras([*guide.needs, *guide.needs_with.values()]) <= known & set(MODULES)
        assert 1 <= len(guide.try_next) <= 2
        assert len(set(guide.try_next)) == len(guide.try_next)


@pytest.mark.parametrize("name", GUIDES)
def test_what_has_no_extra_loads_without_any_and_what_has_one_says_so(name, bare):
    guide = GUIDES[name]
    missing = [each for each in guide.needs if each in GIVEN]
    needed = extras(guide.needs)
    if missing:
        with pytest.raises(InputError, match=f"--set {GIVEN[missing[0]]}="):
            fesloop.load(name)
    elif "search" in needed:
        with pytest.raises(InputError, match=r"fesloop\[search\]"):
            fesloop.load(name)
    else:
        assert fesloop.load(name).name == name


def test_a_live_stream_needs_its_library(bare, tmp_path):
    assert [name for name, guide in GUIDES.items() if "a live stream" in guide.needs] == ["hil_live"]
    assert "lsl" in extras(GUIDES["hil_live"].needs)
    with pytest.raises(InputError, match=r"fesloop\[lsl\]"):
        running.run(fesloop.load("hil_live"), tmp_path, realtime=True)


@pytest.mark.parametrize(("name", "setting", "need"), [
    (name, setting, need) for name, guide in GUIDES.items() for setting, need in guide.needs_with.items()
    if need.startswith("extra ")])
def test_a_setting_that_needs_an_extra_says_which(name, setting, need, bare, tmp_path):
    """When it is loaded; a device, which may be absent then, when the run begins."""
    with pytest.raises(InputError, match=rf"fesloop\[{need.removeprefix('extra ')}\]"):
        running.run(fesloop.load(name, [setting]), tmp_path, realtime=True)


def options(document, variant):
    return set(document.get("variants", {}).get(variant, {}))


@pytest.mark.parametrize("name", GUIDES)
def test_settings_that_need_more_are_all_named(name):
    """Against the files' own variants and aliases: another hand, an FMU, a search of another kind."""
    document, told = read(name)[1], set(GUIDES[name].needs_with)
    aliases = document.get("aliases", {})
    other_hand = aliases.get("plant") == "blocks.hand.kind" or "myohand" in options(document, "plant")
    assert ("plant=myohand" in told) is other_hand
    assert ("plant=fmu" in told) is ("fmu" in options(document, "plant"))
    searches = "strategy" in aliases and "search" not in extras(GUIDES[name].needs)
    assert ("strategy=gaussian_process" in told) is searches


@pytest.mark.parametrize("name", [
    name for name, guide in GUIDES.items()
    if not GIVEN.keys() & set(guide.needs) and "search" not in extras(guide.needs)])
def test_real_time_and_a_compiler_are_needed_where_it_is_said(name):
    experiment = fesloop.load(name)
    live = any(is_live(node) for node in experiment.wiring.nodes)
    assert ("real time" in GUIDES[name].needs) is live
    kinds = {block["kind"] for block in experiment.document()["blocks"].values()}
    assert ("a C compiler" in GUIDES[name].needs) is ("fmu" in kinds)


@pytest.mark.parametrize("name", ["finger_control", "grasp_ilc", "identify_grasp"])
def test_a_guide_is_no_part_of_the_experiment(name):
    document = read(name)[1]
    plain = from_document({key: table for key, table in document.items() if key != "guide"})
    assert plain == fesloop.load(name)
    assert "guide" not in fesloop.load(name).document()


COMMANDS = sorted({command for guide in GUIDES.values() for command in guide.try_next})


@pytest.mark.parametrize("command", COMMANDS)
def test_what_to_try_next_can_be_tried(command, recorded):
    """Loaded as it stands; models that a command before it makes are another's here."""
    args = make_parser().parse_args(shlex.split(command)[1:])
    if args.command in ("run", "check"):
        known = {"model=own_model.toml": "any_patient=true", "fmu=models/finger.fmu": "latency_ms=1",
                 "model=swept.toml": "any_patient=true", "channels=model": "channels=usual",
                 f"recording={RUN}": f"recording={recorded.run}",
                 "recording=RECORDING": f"recording={recorded.sensors}"}
        settings = [known.get(each, each) for each in args.settings]
        if args.experiment == "hil_twin":
            settings[0] = f"recording={recorded.run}"
        if "search" in extras(GUIDES[args.experiment].needs):
            pytest.importorskip("sklearn", reason="the extra `search`")
        assert fesloop.load(args.experiment, settings).name == args.experiment
    elif args.command == "study":
        assert read_study(args.study).name == args.study
    else:
        assert args.command in ("identify", "picture", "fit-error", "fmu", "stream", "reproduce")


def test_placeholders_stand_for_recordings_alone():
    for command in COMMANDS:
        assert set(re.findall(r"\b[A-Z]{3,}\b(?:\.h5)?", command)) <= {RUN, "RECORDING"}


@pytest.mark.parametrize("name", ["grasp_ilc", "grasp_mpc", "grasp_emg", "pinch_mpc", "key_mpc"])
def test_every_grasp_has_a_short_name_for_its_number_of_trials(name):
    assert read(name)[1]["aliases"]["trials"] == "experiment.trials"
