"""Where commands leave the file that they make: nothing that is there is written over."""

import pytest

from fesloop.apps.cli import main
from fesloop.apps.cli.output import free_target
from fesloop.errors import InputError

COMMANDS = (lambda target: ["fit-error", "absent.npz", target],
            lambda target: ["identify", "absent.h5", "--out", target])


@pytest.mark.parametrize("command", COMMANDS)
def test_what_is_there_is_left_alone_and_told_before_the_work(command, tmp_path, capsys):
    target = tmp_path / "made.toml"
    assert main(command(str(target))) == 2
    assert "absent" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    target.write_text("of last week")
    assert main(command(str(target))) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert f"{target}: exists already; allowed: a new name; give another name, or remove the file" in told
    assert target.read_text() == "of last week"


def test_folders_are_made_and_a_link_that_leads_nowhere_is_something(tmp_path):
    assert free_target(f"{tmp_path}/a/b/model.toml", "--out") == tmp_path / "a" / "b" / "model.toml"
    assert list((tmp_path / "a" / "b").iterdir()) == []
    (tmp_path / "link.toml").symlink_to(tmp_path / "nothing")
    for name in ("link.toml", "a"):
        with pytest.raises(InputError, match=f"--out {name}: exists already"):
            free_target(str(tmp_path / name), f"--out {name}")


def test_where_nothing_can_be_made_is_told_at_once(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"--out x: cannot be written: .*; allowed: a path in a writable"):
        free_target(str(tmp_path / "file" / "model.toml"), "--out x")
