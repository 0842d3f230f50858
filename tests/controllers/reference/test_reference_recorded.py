import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from controllers.reference import Recorded
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document, load
from fesloop.experiment.recording.reading import Recording
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context, Tick

TIMES = np.array([2.0, 2.5, 3.5, 4.0])
WRIST, FINGERS = np.array([-20.0, 0.0, 20.0, 30.0]), np.array([30.0, 10.0, 50.0, 60.0])


def degrees(block, times_s, output=0):
    told = []
    for time in times_s:
        tick = Tick()
        tick.time_ns = round(time * 1e9)
        told.append(np.degrees(block.step(block.init(Context("reference")), (), tick)[output]))
    return np.array(told)


@pytest.fixture
def csv(tmp_path):
    path = tmp_path / "told.csv"
    rows = np.stack([TIMES, WRIST, np.radians(FINGERS), np.zeros(4)], axis=-1)
    lines = [",".join(repr(float(cell)) for cell in row) for row in rows]
    path.write_text("time_s,wrist_extension_deg,finger_flexion_rad,note\n" + "\n".join(lines) + "\n")
    return path


def test_lines_between_samples_from_the_first_instant_on_and_standing_still_beyond(csv):
    block = Recorded(file=str(csv))
    assert block.rows == ("wrist_extension", "finger_flexion")
    np.testing.assert_allclose(degrees(block, [0.0, 0.25, 1.0, 2.0, 9.0]),
                               [[-20, 30], [-10, 20], [10, 30], [30, 60], [30, 60]], atol=1e-9)


def test_rows_in_the_order_in_which_they_are_asked_for(csv):
    block = Recorded(file=str(csv), rows=("finger_flexion", "wrist_extension"))
    np.testing.assert_allclose(degrees(block, [0.0, 1.0]), [[30, -20], [30, 10]], atol=1e-9)


@settings(deadline=None)
@given(st.floats(0.0, 1.9), st.floats(0.01, 3.0), st.floats(0.0, 2.0), st.floats(0.1, 10.0),
       st.floats(0.0, 20.0))
def test_a_part_shifted_and_stretched_is_the_file_at_other_instants(told, start, length, shift, stretch, at):
    block = Recorded(file=str(told), start_s=start, duration_s=length, shift_s=shift, stretch=stretch)
    within = min(max((at - shift) / stretch, 0.0), length)
    expected = [np.interp(TIMES[0] + start + within, TIMES, values) for values in (WRIST, FINGERS)]
    np.testing.assert_allclose(degrees(block, [at])[0], expected, atol=1e-4)


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    path = tmp_path_factory.mktemp("told") / "told.npz"
    np.savez(path, time_s=TIMES, wrist_extension_deg=WRIST, finger_flexion_deg=FINGERS, note=np.array("mine"))
    return path


def test_every_kind_of_file_says_the_same(tmp_path, csv, told):
    savemat(tmp_path / "told.mat", {"time_ms": 1e3 * TIMES, "wrist_extension_deg": WRIST,
                                    "finger_flexion_deg": FINGERS})
    times = np.linspace(0.0, 2.5, 11)
    for path in (told, tmp_path / "told.mat"):
        np.testing.assert_allclose(degrees(Recorded(file=str(path)), times),
                                   degrees(Recorded(file=str(csv)), times), atol=1e-9)


def test_preview_is_what_it_will_say_then(csv):
    block = Recorded(file=str(csv), preview=20, preview_period_ms=50.0)
    np.testing.assert_allclose(degrees(block, [0.3], output=1)[0],
                               degrees(block, 0.3 + 0.05 * np.arange(1, 21)), atol=1e-9)


def test_synergies_of_recorded_joints(tmp_path):
    freedoms = hand_tree(HandSize()).freedoms
    angles = np.random.default_rng(0).uniform(-10.0, 10.0, (4, 23))
    path = tmp_path / "joints.npz"
    np.savez(path, time_s=TIMES, **{f"{name}_deg": row for name, row in zip(freedoms, angles.T, strict=True)})
    block = Recorded(file=str(path), rows=("wrist_extension", "F2_flexion"))
    joints = angles[:, [freedoms.index(f"F2_{joint}_flexion") for joint in ("mcp", "pip")]]
    expected = np.stack([-angles[:, freedoms.index("wrist_flexion")], joints.mean(axis=1)], axis=-1)
    np.testing.assert_allclose(degrees(block, TIMES - TIMES[0]), expected, atol=1e-9)


@pytest.fixture(scope="module")
def a_run(tmp_path_factory):
    """A recording of a grasp's reference, and of a finger's angles."""
    phases = [{"name": "rest", "duration_s": 0.2, "deg": {"wrist_extension": -20, "finger_flexion": 30}},
              {"name": "open", "duration_s": 0.3, "deg": {"wrist_extension": 20}}]
    document = {"experiment": {"name": "told", "duration_s": 0.6, "trials": 2},
                "blocks": {"wanted": {"kind": "grasp_phases", "rate": "40", "phases": phases,
                                      "rows": ["wrist_extension", "finger_flexion"]},
                           "pulses": {"kind": "programme", "rate": "40", "times_s": [0.0],
                                      "current_ma": [[40, 0, 0, 0]], "width_us": [[300, 0, 0, 0]]},
                           "finger": {"kind": "finger"}},
                "wires": [{"from": "pulses.stimulation", "to": "finger.stimulation"}]}
    return from_document(document).run(out=tmp_path_factory.mktemp("runs")).recording


def test_a_recorded_signal_comes_back_with_its_rows(a_run):
    block = Recorded(file=str(a_run), signal="wanted.angles", trial=1)
    assert block.rows == ("wrist_extension", "finger_flexion")
    with Recording(a_run) as recording:
        signal = recording.signal("wanted.angles", 1)
    np.testing.assert_allclose(degrees(block, signal.times_ns / 1e9), np.degrees(signal.values), atol=1e-9)


def test_columns_without_names_are_named_by_rows(a_run):
    rows = ("F2_mcp_flexion", "F2_pip_flexion", "F2_dip_flexion")
    block = Recorded(file=str(a_run), signal="finger.angles", rows=rows)
    with Recording(a_run) as recording:
        np.testing.assert_allclose(degrees(block, [0.0])[0],
                                   np.degrees(recording.signal("finger.angles").values[0]), atol=1e-9)
    with pytest.raises(InputError, match=r"rows: 0 names, and .* has none; allowed: 3"):
        Recorded(file=str(a_run), signal="finger.angles")


@pytest.mark.parametrize(("changed", "named"), [
    ({"signal": ""}, "signal: is not given, and .*told-1.h5 holds several; allowed: .*wanted.angles"),
    ({"signal": "wantd.angles"}, "told-1.h5: wantd.angles: is not recorded; .* did you mean 'wanted.angles'"),
    ({"signal": "wanted.phase"}, "unit '1' and shape .*allowed: angles: unit 'rad'"),
    ({"trial": 2}, "told-1.h5: trial: 2; allowed: 0 to 1"),
    ({"trial": -1}, "trial: -1"),
    ({"rows": ("wrist_extention",)}, "'wrist_extention' is not in .*did you mean 'wrist_extension'"),
    ({"rows": ("thumb_flexion",)}, "'thumb_flexion' is not in"),
])
def test_names_what_a_recording_does_not_have(a_run, changed, named):
    with pytest.raises(InputError, match=named):
        Recorded(**{"file": str(a_run), "signal": "wanted.angles"} | changed)


def test_a_run_is_repeated_only_while_the_file_says_the_same(tmp_path, csv):
    document = {"experiment": {"name": "repeated", "duration_s": 0.2},
                "blocks": {"reference": {"kind": "recorded", "rate": "50", "file": str(csv)}}}
    first = from_document(document).run(out=tmp_path)
    again = load(str(first.recording)).run(out=tmp_path)
    with Recording(first.recording) as a, Recording(again.recording) as b:
        assert a.digest() == b.digest()
        assert len(a.experiment["blocks"]["reference"]["fingerprint"]) == 64
    text = csv.read_text()
    csv.write_text(text.replace("-20.0", "-20.5"))
    with pytest.raises(InputError, match=r"told.csv: has changed.*leave fingerprint out"):
        load(str(first.recording))
    csv.write_text(text)
    assert load(str(first.recording)) == from_document(document)


CONTENT = {"time_s": TIMES, "wrist_extension_deg": WRIST, "finger_flexion_deg": FINGERS}


@pytest.mark.parametrize(("changed", "named"), [
    ({"time_s": None}, "time_s: is missing"),
    ({"time_s": None, "times_s": TIMES}, "did you mean 'times_s'|time_s: is missing"),
    ({"time_ms": TIMES}, "time_s and time_ms: both there"),
    ({"time_s": TIMES[::-1]}, "times: sample 1 at 3.5 s is not after 4 s.*sort the file"),
    ({"time_s": np.array([2.0, 2.5, 2.5, 4.0])}, "sample 2 at 2.5 s is not after 2.5 s"),
    ({"time_s": np.array([2.0, np.nan, 3.0, 4.0])}, "times: 1 of 4 samples are not finite"),
    ({"finger_flexion_deg": FINGERS[:3]}, r"finger_flexion_deg: has shape \(3,\); allowed: \(4\)"),
    ({"finger_flexion_deg": np.array(["a"] * 4)}, "finger_flexion_deg: holds str32 values"),
    ({"finger_flexion_deg": FINGERS * [1.0, np.nan, 1.0, 1.0]},
     "finger_flexion at 2.5 s: nan; allowed: a finite angle"),
    ({"finger_flexion_deg": np.where(TIMES == 3.5, 110.0, FINGERS)},
     "finger_flexion at 3.5 s: 110 deg is outside the range of motion of .*; allowed: -32.5 to 95 deg"),
    ({"finger_flexion_rad": FINGERS}, "finger_flexion: is given in deg and in rad"),
    ({"claw_deg": FINGERS}, "rows: 'claw'.*give range_deg"),
    ({"finger_flexion_deg": None, "wrist_extension_deg": None, "finger_flexion": FINGERS},
     "holds no angles, but time_s, finger_flexion; allowed: columns named after rows and unit"),
])
def test_names_what_is_wrong_with_a_file(tmp_path, changed, named):
    path = tmp_path / "told.npz"
    np.savez(path, **{key: value for key, value in (CONTENT | changed).items() if value is not None})
    with pytest.raises(InputError, match=named) as told:
        Recorded(file=str(path))
    assert "told.npz" in str(told.value) or "rows" in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(("text", "named"), [
    ("", "line 1"), ("time_s,time_s\n1,2\n", "each once"),
    ("time_s,finger_flexion_deg\n0,1\n1\n", "line 3: 1 cells; allowed: 2"),
    ("time_s;finger_flexion_deg\n0;1\n1;1,5\n", "line 3: finger_flexion_deg is '1,5'; allowed: a number"),
    ("time_s,finger_flexion_deg\n0,1\n1,\n", "finger_flexion at 1 s: nan"),
    ("time_s,finger_flexion_deg\n0,1\n", "times: 1 instants"),
    ("time_s,finger_flexion_deg\n", "has shape"),
    ("time_s,finger_flexion_deg\n0," + 200_000 * "1", "is no CSV"), ('"time_s"a\n', "is no CSV"),
])
def test_names_the_line_of_a_csv(tmp_path, text, named):
    path = tmp_path / "told.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=f"told.csv.*{named}"):
        Recorded(file=str(path))


@pytest.mark.parametrize(("changed", "named"), [
    ({"start_s": 2.0}, "start_s: 2 is past the end"), ({"start_s": -1.0}, "start_s"),
    ({"duration_s": 0.0}, "duration_s"), ({"shift_s": -1.0}, "shift_s"), ({"stretch": 0.0}, "stretch"),
    ({"stretch": float("inf")}, "stretch"), ({"signal": "a.b"}, "signal: given for .*not a recording"),
    ({"trial": 1}, "trial: given for"), ({"preview": -1}, "preview"), ({"file": "none.csv"}, "none.csv"),
    ({"file": "."}, "cannot be read"), ({"range_deg": {"finger_flexion": (0.0, 40.0)}}, "60 deg is outside"),
    ({"fingerprint": "00"}, "has changed"),
])
def test_names_what_cannot_be(csv, changed, named):
    with pytest.raises(InputError, match=named):
        Recorded(**{"file": str(csv)} | changed)


def test_what_is_left_out_may_be_anything(csv):
    part = Recorded(file=str(csv), duration_s=1.0, range_deg={"finger_flexion": (0.0, 40.0)})
    reached = np.degrees(part.course.at(np.linspace(0.0, 5.0, 501))[:, part.rows.index("finger_flexion")])
    assert reached.min() >= 0.0
    assert reached.max() <= 40.0


@settings(deadline=None)
@given(st.binary(max_size=200))
def test_no_file_ends_in_anything_but_one_line(told, content):
    path = told.parent / "any.csv"
    path.write_bytes(content)
    with pytest.raises(InputError) as fault:
        Recorded(file=str(path))
    assert "\n" not in str(fault.value)
