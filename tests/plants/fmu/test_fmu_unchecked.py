"""Outputs of which the check could not see whether they are stale are named."""

import re

import pytest

from fesloop.apps.cli import main
from fesloop.loop.block import Context
from plants.fmu import Fmu


def names(fmu, **parameters):
    told = Fmu(path=str(fmu), **parameters).cautions(Context("plant"))
    assert all(status == "staleness_unchecked" for status, _ in told)
    return [detail.split(" for ")[1] for _, detail in told]


def test_outputs_that_move_need_no_caution(small2):
    assert names(small2()) == []


@pytest.mark.parametrize(("definitions", "words"), [
    (("AT_S=0", "MISDEED=m->u=0"), "y, w: they did not move"),
    (("AT_S=0", "MISDEED=m->u=0", "TELLS"), "y, w: they did not move"),
    (("AT_S=0", "MISDEED=m->u=0", "MOVES"), "y: they did not move"),
    (("ERROR_AT_S=0.01",), "y, w: the trial ended early: .*dry at"),
    (("AT_S=0.01", "MISDEED=raise(SIGSEGV)"), "y, w: in the trial at load, with artificial inputs"),
    pytest.param(("AT_S=0", "MISDEED=usleep(100000),m->u=0"), "y, w: [0-9]+ steps took all 2 s",
                 marks=pytest.mark.slow)])
def test_outputs_that_were_not_seen_to_move_are_named(small2, definitions, words):
    (detail,) = names(small2(*definitions))
    assert re.match(words, detail)


@pytest.mark.parametrize("command", ["check", "run"])
def test_check_and_run_say_so(small2, tmp_path, capsys, command):
    fmu = small2("AT_S=0", "MISDEED=m->u=0")
    path = tmp_path / "dead.toml"
    path.write_text('[experiment]\nname = "dead"\nduration_s = 0.1\n'
                    f'[blocks.plant]\nkind = "fmu"\npath = "{fmu}"\n'
                    'input_ports = [{ name = "u", shape = [1], unit = "rad", variables = ["u"] }]\n'
                    '[[wires]]\nfrom = "ref.angles"\nto = "plant.u"\n'
                    '[blocks.ref]\nkind = "minimum_jerk"\nrate = "50"\ntimes_s = [0.0, 0.05]\n'
                    'angles_deg = [[0], [40]]\n')
    main([command, str(path)] + (["--out", str(tmp_path)] if command == "run" else []))
    said = " ".join("".join(capsys.readouterr()).split())
    assert "staleness_unchecked" in said
    assert "could not be checked for" in said
