"""Own tables of stimulated muscle: units and directions do not matter, faults have line and column."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
import scipy.constants
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from stimulation_parts import require_same

from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.streams.stimulation import open_stimulation
from fesloop.streams.stimulation.summary import doubts_about
from fesloop.streams.stimulation.table import UNITS

IN_A_FOLDER = settings(max_examples=60, deadline=None,
                       suppress_health_check=[HealthCheck.function_scoped_fixture])
HEAD = ('person = "P1"\nfrequency_hz = 40\nmuscles = ["biceps", "flexor carpi radialis"]\ntorque = "device"\n'
        'baseline = "passive"\n')
DIMENSIONS = {"current": "current", "pulse_width": "time", "time": "time", "elbow_flexion": "angle",
              "elbow_flexion_reference": "angle", "elbow_torque": "torque", "wrist_flexion": "angle",
              "wrist_flexion_reference": "angle", "wrist_torque": "torque"}
"""Quantities of the steady table with their dimensions; `*_torque` is called after the joint's direction."""


def steady(visits=6, seed=1):
    """Columns of isometric trials in SI units by quantity: two postures in turn, three trials a visit."""
    rng, n = np.random.default_rng(seed), 3 * visits
    visit = np.repeat(np.arange(visits), 3)
    muscle = ["passive", "biceps", "flexor carpi radialis"] * visits
    on = np.array([name != "passive" for name in muscle])
    elbow, wrist = np.radians([-60.0, -5.0])[visit % 2], np.radians([10.0, -10.0])[visit % 2]
    return {"muscle": muscle, "visit": visit, "time": 3.0 * np.arange(n), "current": 0.06 * on,
            "pulse_width": 3e-5 * on, "elbow_flexion_reference": elbow,
            "elbow_flexion": elbow + rng.normal(0.0, 0.01, n), "elbow_torque": rng.normal(0.0, 2.0, n),
            "wrist_flexion_reference": wrist, "wrist_flexion": wrist + rng.normal(0.0, 0.01, n),
            "wrist_torque": rng.normal(0.0, 0.2, n)}


def column(quantity, unit, opposite=False):
    """Name of a column as a table has it."""
    name = quantity.replace("_torque", "_flexion")
    return f"{name.replace('flexion', 'extension') if opposite else name}_{unit}"


def as_table(quantities, units=(), opposite=()):
    """Names and rows of text cells; by default deg, us, mA, N m, s."""
    usual = {"current": "ma", "pulse_width": "us", "time": "s"}
    of_kind = {"angle": "deg", "torque": "nm"}
    names, cells = [], []
    for quantity, values in quantities.items():
        if quantity not in DIMENSIONS:
            names.append(quantity)
            cells.append([str(value) for value in values])
            continue
        dimension = DIMENSIONS[quantity]
        unit = dict(units).get(quantity) or usual.get(quantity) or of_kind[dimension]
        turned = quantity in opposite
        names.append(column(quantity, unit, turned))
        cells.append([repr(float(value) * (-1.0 if turned else 1.0) / UNITS[dimension][unit.lower()])
                      for value in values])
    return names, [list(row) for row in zip(*cells, strict=True)]


def write(folder, names, rows, head=HEAD, tables='steady = "trials.csv"\n', name="trials.csv"):
    with (folder / name).open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    (folder / "p1.toml").write_text(head + tables)
    return folder / "p1.toml"


def refusal(path):
    """The one line that refuses a file."""
    with pytest.raises(InputError) as caught:
        open_stimulation(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


UNITS_OF_ALL = st.fixed_dictionaries({
    quantity: st.sampled_from(sorted(UNITS[dimension]) + [unit.upper() for unit in UNITS[dimension]])
    for quantity, dimension in DIMENSIONS.items()})


@given(units=UNITS_OF_ALL, opposite=st.sets(st.sampled_from(
    [quantity for quantity in DIMENSIONS if "_" in quantity and quantity != "pulse_width"])),
    shuffled=st.randoms(use_true_random=False))
@IN_A_FOLDER
def test_units_directions_and_order_of_columns_do_not_matter(tmp_path, units, opposite, shuffled):
    known = steady()
    names, rows = as_table(known, units.items(), opposite)
    places = list(range(len(names)))
    shuffled.shuffle(places)
    found = open_stimulation(write(tmp_path, [names[i] for i in places],
                                   [[row[i] for i in places] for row in rows]))
    joints = {joint: found.joints.index(f"{joint}_flexion") for joint in ("elbow", "wrist")}
    trials = found.steady
    for joint, j in joints.items():
        for values, quantity in ((trials.angle_rad, f"{joint}_flexion"),
                                 (trials.reference_rad, f"{joint}_flexion_reference"),
                                 (trials.device_torque_nm, f"{joint}_torque")):
            np.testing.assert_allclose(values[:, j], known[quantity], rtol=1e-12, atol=1e-15)
    for values, quantity in ((trials.current_a, "current"), (trials.pulse_width_s, "pulse_width"),
                             (trials.time_s, "time")):
        np.testing.assert_allclose(values, known[quantity], rtol=1e-12)
    np.testing.assert_array_equal(trials.muscle, [-1, 0, 1] * 6)
    np.testing.assert_array_equal(trials.order, [0, 1, 2] * 6)
    np.testing.assert_array_equal(trials.repeat, np.repeat([0, 0, 1, 1, 2, 2], 3))
    codes = [trials.posture[trials.visit == visit][0] for visit in range(6)]
    assert codes == (["01", "10"] if joints["elbow"] == 0 else ["10", "01"]) * 3
    assert len(doubts_about(found)) == 0


def test_factors_of_units_are_those_of_the_si():
    c = scipy.constants
    expected = {
        "current": {"a": 1.0, "ma": c.milli, "ua": c.micro},
        "time": {"s": 1.0, "ms": c.milli, "us": c.micro, "min": c.minute},
        "angle": {"rad": 1.0, "deg": c.degree}, "torque": {"nm": 1.0, "mnm": c.milli, "ncm": c.centi},
        "stiffness": {"nm_rad": 1.0, "nm_deg": 1.0 / c.degree}, "force": {"n": 1.0, "mn": c.milli},
        "length": {"m": 1.0, "cm": c.centi, "mm": c.milli, "um": c.micro}}
    assert {name: pytest.approx(units) for name, units in expected.items()} == UNITS


def test_the_torque_of_a_muscle_is_evoked_as_it_is(tmp_path):
    names, rows = as_table(steady())
    by_device = open_stimulation(write(tmp_path, names, rows)).steady.evoked_nm
    head = HEAD.replace('"device"', '"muscle"')
    by_muscle = open_stimulation(write(tmp_path, names, rows, head)).steady.evoked_nm
    np.testing.assert_allclose(by_muscle, -by_device)
    j = 0
    torque = steady()["elbow_torque"].reshape(-1, 3)
    np.testing.assert_allclose(by_device[:, j], -(torque - torque[:, :1]).ravel(), atol=1e-12)


@given(data=st.data())
@IN_A_FOLDER
def test_a_faulty_table_is_refused_with_its_place(tmp_path, data):
    names, rows = as_table(steady())
    places = [i for i, name in enumerate(names) if name != "muscle"]
    needed = [i for i, name in enumerate(names) if name not in ("time_s",) and "reference" not in name]
    kind = data.draw(st.sampled_from([
        "missing column", "no number", "missing number", "short row", "unknown muscle", "torque", "current",
        "width", "unit", "twice", "opposite", "no direction"]))
    row = data.draw(st.integers(0, len(rows) - 1))
    line = f"trials.csv: line {row + 2}"
    if kind == "missing column":
        i = data.draw(st.sampled_from(needed))
        expected = [f"has no column {names[i]!r}"]
        names, rows = names[:i] + names[i + 1:], [each[:i] + each[i + 1:] for each in rows]
    elif kind == "no number":
        i = data.draw(st.sampled_from(places))
        rows[row][i] = data.draw(st.sampled_from(["abc", "1,5", "1 000", "--", "12deg"]))
        expected = [line, f"column {names[i]!r}", "is no number"]
    elif kind == "missing number":
        i = data.draw(st.sampled_from([i for i in needed if names[i] != "muscle"]))
        rows[row][i] = data.draw(st.sampled_from(["", "NaN", "n/a"]))
        expected = [line, f"column {names[i]!r}", "is missing"]
    elif kind == "short row":
        rows[row] = rows[row][:-1]
        expected = [line, f"has {len(names) - 1} columns, {len(names)} are named"]
    elif kind == "unknown muscle":
        rows[row][names.index("muscle")] = "bicpes"
        expected = [line, "column 'muscle'", "'bicpes' is no muscle", "did you mean 'biceps'?"]
    elif kind in ("torque", "current", "width"):
        name, value = {"torque": ("elbow_flexion_nm", data.draw(st.floats(146.0, 1e9))),
                       "current": ("current_ma", data.draw(st.floats(201.0, 1e9) | st.floats(-1e9, -1e-3))),
                       "width": ("pulse_width_us", data.draw(st.floats(2001.0, 1e9)))}[kind]
        rows[row][names.index(name)] = repr(value)
        expected = [line, f"column {name!r}", "is beyond what", "check the unit"]
    elif kind == "unit":
        i = data.draw(st.sampled_from([names.index(name) for name in ("current_ma", "pulse_width_us")]))
        names[i] = names[i].rsplit("_", 1)[0] + data.draw(st.sampled_from(["_deg", "_nm", "_km", ""]))
        expected = [f"trials.csv: column {names[i]!r}"]
    elif kind in ("twice", "opposite"):
        again = {"twice": "elbow_flexion_mnm", "opposite": "elbow_extension_nm"}[kind]
        names, rows = [*names, again], [[*each, "1"] for each in rows]
        expected = [f"column {again!r}", "says the same as column 'elbow_flexion_nm'"]
    else:
        names[names.index("wrist_flexion_deg")] = "wrist_deg"
        expected = ["column 'wrist_deg'", "does not say which way is positive"]
    found = refusal(write(tmp_path, names, rows))
    for part in expected:
        assert part in found, found


@pytest.mark.parametrize(("change", "fault"), [
    (lambda t: t.update(visit=np.repeat([0, 0, 1], 6)), "visit 0: is in 2 postures"),
    (lambda t: t.update(visit=[0.5, *t["visit"][1:]]), "line 2: column 'visit': 0.5 is no whole number"),
    (lambda t: t.update(current=np.full(18, 0.06), pulse_width=np.full(18, 3e-5)),
     "trials.csv: line 2: is passive, but has pulses of 30 us and 60 mA"),
    (lambda t: t.update(pulse_width=t["pulse_width"] * 1e-6), "check the unit of pulse width"),
    (lambda t: t.update(elbow_flexion=-t["elbow_flexion"]), "trials.csv: line 2: elbow_flexion: is at 5"),
    (lambda t: t.update(muscle=["biceps"] * 18, current=np.full(18, 0.06)), "has no passive trial"),
])
def test_what_rows_contradict_is_named(tmp_path, change, fault):
    known = steady()
    change(known)
    assert fault in refusal(write(tmp_path, *as_table(known)))


@pytest.mark.parametrize(("head", "tables", "fault"), [
    (HEAD, "", "steady: no table is named"),
    (HEAD.replace('torque = "device"\n', ""), 'steady = "trials.csv"\n', "torque: is missing"),
    (HEAD.replace('"device"', '"load cell"'), 'steady = "trials.csv"\n', "torque"),
    (HEAD + "frequencyhz = 2\n", 'steady = "trials.csv"\n', "frequencyhz"),
    (HEAD.replace("= 40", '= "forty"'), 'steady = "trials.csv"\n', "frequency_hz"),
    (HEAD, 'steady = "others.csv"\n', "others.csv: cannot be read"),
    (HEAD, 'steady = "trials.csv"\n[electrodes]\nbiceb = "5 cm"\n', "did you mean 'biceps'?"),
    (HEAD, 'steady = "trials.csv"\n[widths.biceps]\nlowest_us = 40\nhighest_us = 30\ncurrent_ma = 60\n',
     "30 is not above lowest_us, 40"),
    (HEAD, 'steady = "trials.csv"\n[device]\nfriction_nm = {knee_flexion = 1.0}\n', "is no joint of the"),
    (HEAD, 'steady = "trials.csv"\n[device]\nfriction_nm = {elbow_flexion = -1.0}\n', "-1"),
    (HEAD + "person = 3\n", 'steady = "trials.csv"\n', "is not TOML"),
])
def test_a_description_with_faults_is_refused(tmp_path, head, tables, fault):
    path = write(tmp_path, *as_table(steady()), head, tables)
    found = refusal(path)
    assert fault in found
    assert "p1.toml" in found or "others.csv" in found


@given(text=st.text(st.sampled_from('muscle,visit_degnmelbow flexion"0123\n.;-'), max_size=200)
       | st.binary(max_size=200))
@settings(IN_A_FOLDER, max_examples=150)
def test_anything_else_is_refused(tmp_path, text):
    (tmp_path / "p1.toml").write_text(HEAD + 'steady = "trials.csv"\n')
    (tmp_path / "trials.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    assert "trials.csv" in refusal(tmp_path / "p1.toml")


def samples(n=50, recordings=("one", "two")):
    """Names and rows of a table of courses, a row a sample."""
    names = ["recording", "muscle", "time_s", "current_ma", "pulse_width_us", "elbow_flexion_deg",
             "elbow_flexion_nm"]
    return names, [[name, "biceps", f"{0.01 * k:.2f}", "60", str(k % 30), "-45.1", f"{-0.01 * k:.3f}"]
                   for name in recordings for k in range(n)]


def test_courses_movements_and_forces_are_read(tmp_path):
    write(tmp_path, *samples(), name="courses.csv")
    write(tmp_path, ["recording", "time_ms", "biceps_current_ma", "biceps_pulse_width_us",
                     "flexor carpi radialis_current_ma", "flexor carpi radialis_pulse_width_us",
                     "elbow_flexion_deg", "elbow_flexion_planned_nm"],
          [["reach", str(20 * k), "60", "30", "45", "0", str(k), "0.5"] for k in range(5)], name="moves.csv")
    path = write(tmp_path, ["recording", "muscle", "time_s", "force_n", "length_mm", "pulse"],
                 [["hop", "biceps", f"{2.0 + 0.001 * k:.3f}", str(k), "40", str(int(k in (1, 3)))]
                  for k in range(5)], name="forces.csv",
                 tables='courses = "courses.csv"\nmovements = "moves.csv"\nforces = "forces.csv"\n')
    found = open_stimulation(path)
    assert [course.name for course in found.courses] == ["one", "two"]
    course, movement, force = found.courses[1], found.movements[0], found.forces[0]
    assert (course.period_s, course.current_a, course.muscle) == (0.01, 0.06, 0)
    np.testing.assert_allclose(course.evoked_nm(0.0, 0.005)[:, 0], 0.01 * np.arange(50), atol=1e-12)
    np.testing.assert_allclose(movement.current_a, [0.06, 0.045])
    np.testing.assert_allclose(movement.pulse_width_s, [[3e-5, 0.0]] * 5)
    assert movement.period_s == pytest.approx(0.02)
    assert np.isnan(movement.device_torque_nm).all()
    np.testing.assert_allclose(np.degrees(movement.angle_rad[:, 0]), np.arange(5.0))
    np.testing.assert_allclose(force.pulses_s, [0.001, 0.003], atol=1e-12)
    assert (force.start_s, force.length_m[0]) == (2.0, 0.04)


@pytest.mark.parametrize(("row", "at", "value", "fault"), [
    (20, 2, "0.33", "line 22: column 'time_s': is not evenly spaced"),
    (70, 3, "61", "line 72: column 'current_ma': changes within its recording"),
    (3, 1, "flexor carpi radialis", "line 5: column 'muscle': changes within its recording"),
    (3, 4, "-3", "line 5: column 'pulse_width_us': -3 us is beyond"),
    (3, 5, "200", "line 5: column 'elbow_flexion_deg': 200 deg is beyond"),
])
def test_faults_of_courses_are_named(tmp_path, row, at, value, fault):
    names, rows = samples()
    rows[row][at] = value
    assert fault in refusal(write(tmp_path, names, rows, tables='courses = "trials.csv"\n'))


def test_a_published_person_as_tables_is_the_same_person(recordings, tmp_path):
    known = open_stimulation(recordings / "fes_exo" / "S9006.npz")
    trials, muscles = known.steady, known.muscles
    names = ["muscle", "posture", "visit", "order", "repeat", "time_s", "current_a", "pulse_width_s"]
    of_joints = {"rad": trials.angle_rad, "reference_rad": trials.reference_rad,
                 "nm": trials.device_torque_nm, "sd_nm": trials.device_torque_sd_nm,
                 "creep_nm": trials.creep_nm, "stiffness_nm_rad": trials.stiffness_nm_rad}
    names += [f"{joint}_{what}" for what in of_joints for joint in known.joints]
    numbers = np.column_stack([trials.time_s, trials.current_a, trials.pulse_width_s, *of_joints.values()])
    rows = [["passive" if trials.muscle[k] < 0 else muscles[trials.muscle[k]], trials.posture[k],
             *(str(each[k]) for each in (trials.visit, trials.order, trials.repeat)),
             *(repr(value) for value in numbers[k].tolist())] for k in range(len(trials))]
    head = f'person = "S9006"\nfrequency_hz = 40\ntorque = "device"\nmuscles = {json.dumps(muscles)}\n'
    found = open_stimulation(write(tmp_path, names, rows, head)).steady
    require_same(found, replace(trials, trace_nm=None, trace_period_s=0.0))


def test_joints_must_agree_between_tables(tmp_path):
    names, rows = samples()
    write(tmp_path, names, rows, name="courses.csv")
    path = write(tmp_path, *as_table(steady()), tables='steady = "trials.csv"\ncourses = "courses.csv"\n')
    assert "courses.csv: has no column of wrist_flexion" in refusal(path)


def test_tables_with_semicolons_and_decimal_commas(tmp_path):
    names, rows = as_table(steady())
    expected = open_stimulation(write(tmp_path, names, rows)).steady
    lines = [";".join(names), *(";".join(cell.replace(".", ",") for cell in row) for row in rows)]
    (tmp_path / "trials.csv").write_text("\ufeff" + "\n".join(lines))
    text = '[text]\nseparator = ";"\ndecimal = ","\n'
    (tmp_path / "p1.toml").write_text(f'{HEAD}steady = "trials.csv"\n{text}')
    found = open_stimulation(tmp_path / "p1.toml").steady
    np.testing.assert_array_equal(found.device_torque_nm, expected.device_torque_nm)


@pytest.mark.parametrize(("visits", "changed", "doubt"), [
    (2, {}, "no_repeats"),
    (6, {"elbow_flexion_reference": np.zeros(18), "elbow_flexion": np.zeros(18),
         "wrist_flexion_reference": np.zeros(18), "wrist_flexion": np.zeros(18)}, "one_posture"),
    (6, {"elbow_torque": np.repeat(np.arange(6.0), 3) + np.tile([0.0, 1.0, 1.0], 6)}, "stuck"),
])
def test_what_a_recording_cannot_show_is_said(tmp_path, visits, changed, doubt):
    path = write(tmp_path, *as_table({**steady(visits), **changed}))
    assert list(doubts_about(open_stimulation(path))) == [doubt]


def test_degrees_that_are_radians_and_short_visits_are_doubted(tmp_path):
    known = steady()
    head = HEAD.replace('baseline = "passive"\n', "")
    names, rows = as_table(known, [(q, "rad") for q, d in DIMENSIONS.items() if d == "angle"])
    path = write(tmp_path, [name.replace("_rad", "_deg") for name in names], rows, head)
    doubts = doubts_about(open_stimulation(path))
    assert list(doubts) == ["small_angles", "short_visits"]
    assert doubts["short_visits"].startswith("has 6 visits of fewer than 5 trials")


def test_the_command_imports_a_table_and_says_what_it_holds(tmp_path, capsys):
    path = write(tmp_path, *as_table(steady()))
    path.rename(tmp_path / "trials.toml")
    assert main(["import", "--stimulation", str(tmp_path / "trials.csv"), "--out", str(tmp_path / "p1.h5"),
                 "--json"]) == 0
    out = json.loads(capsys.readouterr().out)
    assert (out["steady"]["trials"], out["steady"]["postures"], out["steady"]["repeats"]) == (18, 2, [3, 3])
    scatter = open_stimulation(tmp_path / "p1.h5").steady.repeatability()
    assert list(out["steady"]["snr"].values()) == pytest.approx(list(scatter.snr))
    assert main(["import", "--stimulation", str(tmp_path / "trials.toml"), str(tmp_path / "p2.h5")]) == 0
    assert "18 isometric trials (6 passive, 2 postures, 2 muscles, 3 repeats)" in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [
    ["--stimulation", "trials.csv"], ["--stimulation", "trials.csv", "a.h5", "--out", "b.h5"],
    ["--stimulation", "trials.csv", "a.h5", "--resample", "100"],
    ["--stimulation", "nowhere.csv", "a.h5"], ["--stimulation", "trials.csv", "a.h5"],
])
def test_a_wrong_command_is_one_line(tmp_path, capsys, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "trials.csv").write_text("muscle,visit\n")
    assert main(["import", *arguments]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
