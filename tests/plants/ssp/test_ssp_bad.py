"""Each fault of an SSP archive is one line that names the file and the element, and leaves nothing behind."""

from __future__ import annotations

import zipfile

import pytest
from ssp_parts import archived, binding, component, connection, connectors, described, system

import fesloop
from fesloop.apps.cli import main
from plants.ssp.experiment import import_ssp

BOTH = {"u": "input", "y": "output"}
TWO = [component("a", BOTH), component("b", BOTH)]


@pytest.fixture(scope="module")
def lag(small2):
    return small2()


def edited(fmu, target, *changes):
    """The FMU with a changed description."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(target, "w") as archive:
        for name in source.namelist():
            content = source.read(name)
            if name == "modelDescription.xml":
                text = content.decode()
                for old, new in changes:
                    assert old in text
                    text = text.replace(old, new)
                content = text.encode()
            archive.writestr(name, content)
    return target


def refused(tmp_path, capsys, text, files):
    """The line that the command prints."""
    ssp = archived(tmp_path / "bad.ssp", text, files)
    assert main(["import", str(ssp), str(tmp_path / "out")]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "Traceback" not in told
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())
    return told


@pytest.mark.parametrize(
    ("elements", "wires", "message"),
    [
        (
            [component("a", BOTH, "resources/none.fmu")],
            [],
            "component a: names the FMU 'resources/none.fmu', which is not",
        ),
        (TWO, [connection("a.yy", "b.u")], "connection of a.yy: there is no connector 'yy'"),
        (TWO, [connection("c.y", "b.u")], "connection of c.y: there is no element 'c'"),
        (TWO, [connection("a.u", "b.u")], "a.u is of the kind 'input'; allowed: an output"),
        (TWO, [connection("a.y", "b.u"), connection("b.y", "b.u")], "b.u is fed by a.y too"),
        (
            [component("a", {"x": "input", "y": "output"})],
            [],
            "connector a.x: is an input, in resources/lag.fmu it has",
        ),
        ([component("a", {"speed": "input"})], [], "connector a.speed: is no variable of resources/lag.fmu"),
        ([component("a", BOTH), component("a", BOTH)], [], "element a: is listed twice"),
        (
            [component("a", BOTH, inside=binding({"nothing": 1.0}))],
            [],
            "parameter a.nothing: is no variable of resources/lag.fmu",
        ),
        (TWO, [connection("a.y", "b.u", '<ssc:LinearTransformation factor="0"/>')], "has the factor 0"),
        (
            TWO,
            [connection("a.y", "b.u", "<ssc:BooleanMappingTransformation/>")],
            "BooleanMappingTransformation",
        ),
    ],
)
def test_faults_of_the_structure(lag, tmp_path, capsys, elements, wires, message):
    told = refused(tmp_path, capsys, described(system("bad", elements, wires), version="2.0"),
                   {"resources/lag.fmu": lag})
    assert message in told
    assert "bad.ssp" in told


def test_a_description_against_the_schema_names_line_and_element(lag, tmp_path, capsys):
    text = described(system("bad", [component("a", BOTH)], [])).replace('kind="input"', 'kind="inward"')
    assert "SystemStructure.ssd, line 3: is not valid SSP" in refused(
        tmp_path, capsys, text, {"resources/lag.fmu": lag}
    )


@pytest.mark.parametrize(("text", "message"), [
    ("<ssd", "is no XML"), ("<a/>", "has the version ''"),
    (described(system("s", [], []), version="3.0"), "has the version '3.0' of SSP; allowed: 1.0, 1.1, 2.0"),
    ('<!DOCTYPE a [<!ENTITY e SYSTEM "file:///etc/passwd">]><a version="2.0">&e;</a>', "has no System")])
def test_what_is_no_description(tmp_path, capsys, text, message):
    assert message in refused(tmp_path, capsys, text, {})


def test_units_that_cannot_be_converted_and_connectors_in_other_units(lag, tmp_path, capsys):
    ampere = ("<ModelVariables>", '<UnitDefinitions><Unit name="A"><BaseUnit A="1"/></Unit><Unit name="mm">'
              '<BaseUnit m="1" factor="0.001"/></Unit></UnitDefinitions><ModelVariables>')
    first = edited(lag, tmp_path / "first.fmu", ampere, (
        '<Real/></ScalarVariable>\n    <ScalarVariable name="steps"',
        '<Real unit="mm"/></ScalarVariable>\n    <ScalarVariable name="steps"'))
    second = edited(
        lag,
        tmp_path / "second.fmu",
        ampere,
        (
            '<Real start="0"/></ScalarVariable>\n    <ScalarVariable name="y"',
            '<Real start="0" unit="A"/></ScalarVariable>\n    <ScalarVariable name="y"',
        ),
    )
    files = {"resources/first.fmu": first, "resources/second.fmu": second}
    parts = [
        component("a", {"y": "output"}, "resources/first.fmu"),
        component("b", BOTH, "resources/second.fmu"),
    ]
    wire = [connection("a.y", "b.u")]
    told = refused(tmp_path, capsys, described(system("s", parts, wire)), files)
    assert "connection a.y -> b.u: the units 'mm' and 'A' are of different quantities" in told
    (tmp_path / "bad.ssp").unlink()
    parts[0] = component("a", {"y": "output"}, "resources/first.fmu", units={"y": "m"})
    told = refused(tmp_path, capsys, described(system("s", parts, [])), files)
    assert "connector a.y: is in 'm', in resources/first.fmu it is in 'mm'" in told


def test_an_algebraic_loop_names_its_connectors(lag, tmp_path, capsys):
    direct = edited(
        lag,
        tmp_path / "direct.fmu",
        (
            '<Unknown index="2"/><Unknown index="3"/><Unknown index="9"/>',
            '<Unknown index="2" dependencies="1"/><Unknown index="3" dependencies=""/>'
            '<Unknown index="9" dependencies=""/>',
        ),
    )
    text = described(system("loop", TWO, [connection("a.y", "b.u"), connection("b.y", "a.u")]))
    told = refused(tmp_path, capsys, text, {"resources/lag.fmu": direct})
    assert "algebraic loop: b.u <- a.u <- b.u depend on each other" in told or "a.u <- b.u <- a.u" in told


def test_what_is_no_archive_a_full_folder_and_a_bad_rate(lag, tmp_path):
    (tmp_path / "text.ssp").write_text("no zip")
    ssp = archived(tmp_path / "good.ssp", described(system("s", TWO, [connection("a.y", "b.u")])),
                   {"resources/lag.fmu": lag})
    for source, message in (
        ("none.ssp", "cannot be read: No such file"),
        ("text.ssp", "it is no zip archive"),
    ):
        with pytest.raises(fesloop.InputError, match=message):
            import_ssp(tmp_path / source, tmp_path / "out")
    with pytest.raises(fesloop.InputError, match="is not empty"):
        import_ssp(ssp, tmp_path)
    with pytest.raises(fesloop.InputError, match="--rate"):
        import_ssp(ssp, tmp_path / "out", "fast")
    with zipfile.ZipFile(ssp, "a") as archive:
        archive.writestr("../outside", "")
    with pytest.raises(fesloop.InputError, match="would be written outside"):
        import_ssp(ssp, tmp_path / "out")


def test_options_of_recordings_are_refused(tmp_path, capsys):
    assert main(["import", "a.ssp", "b", "--layout", "x.toml"]) == 2
    assert main(["import", "a.xdf", "b.h5", "--rate", "100"]) == 2
    told = capsys.readouterr().err
    assert "--layout: is of recordings" in told
    assert "--rate: is of systems of FMUs" in told


def test_an_input_fed_from_outside_holds_its_start_value_and_is_noted(lag, tmp_path, capsys):
    text = described(
        system("s", [component("a", BOTH)], [connection("given", "a.u")], connectors({"given": "input"}))
    )
    ssp = archived(tmp_path / "open.ssp", text, {"resources/lag.fmu": lag})
    assert main(["import", str(ssp), str(tmp_path / "out")]) == 0
    assert "a.u is fed from outside the system: its start value holds" in capsys.readouterr().err
    assert main(["check", str(tmp_path / "out" / "s.toml")]) == 0
