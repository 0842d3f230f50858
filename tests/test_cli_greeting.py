"""`fesloop` without arguments: what a newcomer reads first fits a screen, and all of it can be typed."""

import re
import shlex
import subprocess
import sys

import pytest

from fesloop.analysis.study.design.study_file import read_study
from fesloop.apps.cli import main
from fesloop.apps.cli.parser import make_parser
from fesloop.experiment.files.layout import guide_of
from fesloop.experiment.files.parse import load, read


@pytest.fixture
def greeting(capsys):
    assert main([]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def commands(greeting):
    """What can be typed as it stands."""
    found = re.findall(r"fesloop (?:run|study|list|report)[a-z0-9_ ./-]*?(?=  |$|\()", greeting, re.MULTILINE)
    return [make_parser().parse_args(shlex.split(each)[1:]) for each in found]


def test_it_fits_a_terminal_of_24_lines_and_80_columns(greeting):
    lines = greeting.splitlines()
    assert len(lines) < 24  # the prompt stands below
    assert max(map(len, lines)) <= 80


def test_there_is_a_command_for_each_job_and_one_for_studies(greeting):
    given = commands(greeting)
    experiments = [args.experiment for args in given if args.command == "run"]
    jobs = [guide_of(read(name)[1]).job for name in experiments]
    assert jobs == ["closed_loop", "array_search", "hardware"]
    for name in experiments:
        assert load(name).name == name
    studies = [args.study for args in given if args.command == "study"]
    assert [read_study(name).name for name in studies] == studies != []
    assert [args.command for args in given].count("list") == 1


def test_what_it_says_of_time_is_what_the_files_say(greeting):
    told = re.findall(r"fesloop run (\w+).*?\(about (\d+) s\)", greeting)
    assert len(told) == 3
    for name, seconds in told:
        assert float(seconds) == guide_of(read(name)[1]).takes_s


def test_none_of_the_three_jobs_needs_more_than_was_installed(greeting):
    for args in commands(greeting):
        if args.command == "run":
            needs = guide_of(read(args.experiment)[1]).needs
            assert not [need for need in needs if need != "real time" or not args.realtime]


def test_it_is_what_the_program_says_by_itself_and_no_command():
    done = subprocess.run([sys.executable, "-m", "fesloop"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("fesloop: ")
    assert main([]) == 0
    with pytest.raises(SystemExit) as refused:
        main(["--traceback"])
    assert refused.value.code == 2
