"""FMUs that cannot be used: one line each that says what and what to do, and nothing left behind."""

import re
import stat
import tempfile
import zipfile

import pytest

from fesloop.errors import InputError
from plants.fmu import Fmu
from plants.fmu.ports import FmuPort


@pytest.fixture(autouse=True)
def own_temporary_folder(tmp_path, monkeypatch):
    """A temporary folder of the test's own, which must be empty at its end."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield
    assert list(folder.iterdir()) == []


def refusal(**parameters):
    """The one line with which an FMU is refused."""
    with pytest.raises(InputError) as caught:
        Fmu(**parameters)
    text = str(caught.value)
    assert "\n" not in text
    return text


def with_entry(source, target, name, content=b"x", mode=None):
    """A copy of an archive with one more entry, its name as given."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for entry in old.infolist():
            new.writestr(entry, old.read(entry))
        info = zipfile.ZipInfo("placeholder")
        info.filename = name
        if mode is not None:
            info.create_system, info.external_attr = 3, mode << 16
        new.writestr(info, content)
    return target


def without(source, target, name):
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for entry in old.infolist():
            if not entry.filename.startswith(name):
                new.writestr(entry, old.read(entry))
    return target


def edited(source, target, old_text, new_text):
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for entry in old.infolist():
            content = old.read(entry)
            if entry.filename == "modelDescription.xml":
                assert old_text.encode() in content
                content = content.replace(old_text.encode(), new_text.encode())
            new.writestr(entry, content)
    return target


def test_a_missing_file(tmp_path):
    assert "path: " in refusal(path=str(tmp_path / "none.fmu"))


@pytest.mark.parametrize("content", [b"", b"no zip at all", b"PK\x03\x04 cut short"])
def test_not_a_zip(tmp_path, content):
    path = tmp_path / "bad.fmu"
    path.write_bytes(content)
    assert f"{path} is not a zip archive" in refusal(path=str(path))


def test_a_truncated_or_flipped_archive(tmp_path, small2):
    content = small2().read_bytes()
    path = tmp_path / "bad.fmu"
    path.write_bytes(content[: len(content) // 2])
    assert "is not a zip archive" in refusal(path=str(path))
    path.write_bytes(content[:2000] + bytes(byte ^ 255 for byte in content[2000:2100]) + content[2100:])
    assert "cannot be extracted" in refusal(path=str(path))


@pytest.mark.parametrize("name", ["../evil", "binaries/../../evil", "/tmp/evil", "C:/evil", "..\\evil"])
def test_names_that_escape(tmp_path, small2, name):
    path = with_entry(small2(), tmp_path / "bad.fmu", name)
    text = refusal(path=str(path))
    assert "would be written outside its folder" in text
    assert "nothing was extracted" in text
    assert not (tmp_path / "evil").exists()


def test_a_symbolic_link(tmp_path, small2):
    path = with_entry(small2(), tmp_path / "bad.fmu", "resources/link", b"/etc", stat.S_IFLNK | 0o777)
    assert "is a link or device" in refusal(path=str(path))


def test_a_library_name_that_escapes(tmp_path, small2):
    path = edited(small2(), tmp_path / "bad.fmu", 'modelIdentifier="small"', 'modelIdentifier="../small"')
    assert "modelIdentifier '../small'" in refusal(path=str(path))


def test_no_description_and_an_invalid_one(tmp_path, small2):
    path = without(small2(), tmp_path / "none.fmu", "modelDescription.xml")
    assert "contains no modelDescription.xml" in refusal(path=str(path))
    path = edited(small2(), tmp_path / "broken.fmu", "</ModelVariables>", "")
    assert "cannot be read" in refusal(path=str(path))
    path = edited(small2(), tmp_path / "invalid.fmu", 'causality="input"', 'causality="imput"')
    assert "is invalid" in refusal(path=str(path))


def test_no_binary_for_this_platform(tmp_path, small2):
    path = without(small2(), tmp_path / "none.fmu", "binaries/")
    assert "contains no binary for linux64; it contains none" in refusal(path=str(path))
    path = with_entry(path, tmp_path / "windows.fmu", "binaries/win64/small.dll")
    assert "it contains win64" in refusal(path=str(path))
    path = with_entry(path, tmp_path / "sources.fmu", "sources/small.c")
    assert "compile its C sources" in refusal(path=str(path))


def test_interfaces_that_are_not_there(tmp_path, small2, small3):
    assert "interface: " in refusal(path=str(small2()), interface="model_exchange")
    assert "has co_simulation, not model_exchange" in refusal(path=str(small3()), interface="model_exchange")
    path = edited(small2(), tmp_path / "one.fmu", 'fmiVersion="2.0"', 'fmiVersion="1.0"')
    assert refusal(path=str(path))


@pytest.mark.parametrize(("definition", "words"), [
    ("CRASH", "in initialisation it was killed by SIGSEGV"),
    ("ABORT", "in initialisation it was killed by SIGABRT"),
    ("REFUSE", "fmi2ExitInitializationMode returned fmi2Error at 0 s: no licence for small")])
def test_trouble_in_initialisation(small2, definition, words):
    assert words in refusal(path=str(small2(definition)))


@pytest.mark.slow
def test_initialisation_without_end(small2):
    text = refusal(path=str(small2("HANG")), probe_timeout_s=8.0)
    assert "in initialisation it did not finish within 8 s" in text


@pytest.mark.slow
@pytest.mark.parametrize("definitions", [("INTERNAL_STEP_S=0.01",), ("INTERNAL_STEP_S=0.01", "TELLS")])
def test_stale_outputs_are_found_at_load(small2, definitions):
    fmu = str(small2(*definitions))
    text = refusal(path=fmu, step_rate="1000")
    assert "step_rate: " in text
    assert "communication step, 1 ms" in text
    assert ("internal step, 10 ms" if "TELLS" in definitions else "internal step, about 10 ms") in text
    Fmu(path=fmu, step_rate="100")
    Fmu(path=fmu, step_rate="50")


def test_a_square_wave_is_not_stale(small2):
    Fmu(path=str(small2("SQUARE_S=0.02")), step_rate="1000")


@pytest.mark.slow
def test_stale_outputs_of_fmi3_by_what_it_says(small3):
    assert "internal step, 10 ms" in refusal(path=str(small3("INTERNAL_STEP_S=0.01")), step_rate="400")
    assert "internal step, 20 ms" in refusal(
        path=str(small3(extra='fixedInternalStepSize="0.02"')), step_rate="1000")


def test_ports_and_starts_that_do_not_fit(small2):
    fmu = str(small2())
    wanted = {"path": fmu}
    assert "did you mean 'u'" in refusal(**wanted, input_ports=(FmuPort(name="u", variables=("uu",)),))
    assert "output_ports[0].shape" in refusal(
        **wanted, output_ports=(FmuPort(name="y", variables=("y", "steps"), shape=(3,)),))
    assert "two ports are named 'y'" in refusal(**wanted, output_ports=(
        FmuPort(name="y", variables=("y",)), FmuPort(name="y", variables=("steps",))))
    assert "starts.mass: " in refusal(**wanted, starts={"mass": 1.0})
    assert "starts.u: True" in refusal(**wanted, starts={"u": True})
    assert "substeps: 0" in refusal(**wanted, substeps=0)
    assert "probe_timeout_s: inf" in refusal(**wanted, probe_timeout_s=float("inf"))
    assert "step_rate: " in refusal(**wanted, step_rate="-5")


@pytest.mark.slow
def test_the_archive_that_was_checked_is_the_one_that_is_resumed(tmp_path, small2):
    import pickle

    from fesloop.errors import SnapshotError
    from fesloop.loop.block import Context

    path = tmp_path / "plant.fmu"
    path.write_bytes(small2().read_bytes())
    plant = Fmu(path=str(path), step_rate="100")
    state = plant.init(Context("plant"))
    saved = pickle.dumps(state)
    path.write_bytes(small2("FORGETS").read_bytes())
    with pytest.raises(SnapshotError, match="has changed"):
        pickle.loads(saved)
    plant.close(state)


@pytest.mark.slow
def test_an_archive_that_would_fill_the_disk_is_refused_before_anything_is_written(tmp_path, small2):
    path = tmp_path / "bomb.fmu"
    path.write_bytes(small2().read_bytes())
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive, archive.open("zeros", "w") as member:
        for _ in range(300):
            member.write(bytes(10**6))
    assert path.stat().st_size < 10**6
    text = refusal(path=str(path))
    assert "would unpack to 300 MB" in text
    assert "allowed: 268 MB" in text


ONCE = 'canBeInstantiatedOnlyOncePerProcess="true"'


def test_one_that_can_be_instantiated_once_in_a_process_has_processes_of_its_own(small2):
    fmu = str(small2(state=ONCE))
    assert refusal(path=fmu, isolate=False).startswith(
        f"isolate: False, but {fmu} declares that it can be instantiated only once in a process")
    Fmu(path=fmu)
    Fmu(path=fmu, isolate=True)


def test_one_that_finds_too_little_memory_is_refused_with_the_memory_that_it_had(small2):
    fmu = str(small2("NEEDS_MB=50"))
    text = refusal(path=fmu, memory_mb=20)
    words = r"could not be instantiated: .*; memory may be too small: memory_mb left it ([0-9.]+) MB;"
    assert 10.0 < float(re.search(words, text)[1]) <= 20.0
    assert text.endswith("check its start values and memory_mb")
    Fmu(path=fmu, memory_mb=80)
    assert "memory" not in refusal(path=str(small2("REFUSE"))).partition("; allowed")[0]
