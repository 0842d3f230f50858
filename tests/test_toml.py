"""TOML whose numbers or nesting have no end is refused in a line, in every file and on the command line."""

from pathlib import Path

import pytest

from fesloop.apps.cli import main
from fesloop.forms.toml import TomlError, TooLargeError, tables_of

SMALL = Path(__file__).parent / "experiment" / "small.toml"


def test_what_a_float_holds_is_read():
    assert tables_of(f"a = {10**308}\nb = [-1, 2.5]") == {"a": 10**308, "b": [-1, 2.5]}
    with pytest.raises(TooLargeError, match=r"^a\.b\[1\] is beyond 1\.8e\+308$"):
        tables_of(f"[a]\nb = [1, -{10**400}]")
    with pytest.raises(TooLargeError, match="a whole number is beyond"):
        tables_of("a = " + "1" * 5000)
    with pytest.raises(TomlError, match="nested too deeply"):
        tables_of("a = " + "[" * 5000)
    with pytest.raises(TomlError, match="line 1, column 5"):
        tables_of("a = ?")


@pytest.mark.parametrize("command", ["check {}", "study {} --dry-run", "patient {}"])
@pytest.mark.parametrize("value", ["1" * 400, "1" * 5000, "[" * 3000 + "]" * 3000])
def test_a_file_with_such_a_value_is_refused(tmp_path, capsys, command, value):
    file = tmp_path / "given.toml"
    file.write_text(f"value = {value}\n{SMALL.read_text()}")
    assert main(command.format(file).split()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is not TOML: " in line
    assert len(line) < len(str(file)) + 100


@pytest.mark.parametrize("key", ["score.after_s", "experiment.duration_s", "wires.1.latency_ms", "gain",
                                 "blocks.pid.recruitment.chronaxie_us"])
@pytest.mark.parametrize("digits", [400, 5000])
def test_such_a_setting_is_refused(capsys, key, digits):
    assert main(["check", str(SMALL), "--set", f"{key}={'1' * digits}"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"fesloop: --set {key}: ")
    assert line.endswith("is beyond 1.8e+308")
