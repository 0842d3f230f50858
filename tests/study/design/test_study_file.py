import copy
import datetime
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.analysis.study.design.axes import Axis
from fesloop.analysis.study.design.cells import base_cells, cells_of
from fesloop.analysis.study.design.shipped_studies import described_studies, shipped_studies
from fesloop.analysis.study.design.study_file import read_study, study_of
from fesloop.errors import InputError

PLAIN = {"study": {"name": "plain", "experiment": "finger_pid_latency",
                   "metrics": {"error_deg": "joint_rmse_deg"}},
         "axes": {"latency_ms": {"values": [0, 20]}}}


def changed(**tables):
    """The plain document with other tables; those of `study` are put over it."""
    document = copy.deepcopy(PLAIN)
    about = tables.pop("study", {})
    if isinstance(about, dict):
        document["study"].update(about)
    return {**document, **tables}


def axis(**table):
    names = {"start": "from", "stop": "to"}
    return changed(axes={"latency_ms": {names.get(key, key): value for key, value in table.items()}})


def without(key):
    document = copy.deepcopy(PLAIN)
    del document["study"][key]
    return document


SPAN = {"start": 0, "stop": 1}


@pytest.mark.slow
@pytest.mark.parametrize(("document", "fault"), [
    (changed(study={"nam": "x"}), r"study\.nam: unknown key.*did you mean 'name'"),
    (changed(axis={}), r"axis: unknown key.*did you mean 'axes'"),
    ({"axes": {}}, "study: is missing"), (without("name"), r"study\.name: is missing"),
    (without("metrics"), r"study\.metrics: is missing"),
    (changed(study={"metrics": {}}), r"study\.metrics: there is none"),
    (changed(study={"metrics": {"e": "joint_rmse_deg:men"}}), r"metrics\.e: .*did you mean 'mean'"),
    (changed(study={"metrics": {"e": "a..b"}}), r"metrics\.e: 'a\.\.b'"),
    (changed(study={"metrics": {"e": ""}}), r"metrics\.e: ''"),
    (changed(study={"metrics": {"id": "joint_rmse_deg"}}), r"metrics\.id: is a column"),
    (changed(study={"name": "../out"}), r"study\.name: '\.\./out'"),
    (changed(study={"name": "a" * 61}), r"study\.name: 'a+'; allowed: letters"),
    (changed(study={"replicates": 0}), r"study\.replicates: 0"),
    (changed(study={"replicates": True}), r"study\.replicates: true is a boolean"),
    (changed(study={"seed": -1}), r"study\.seed: -1"), (changed(study={"seed": 2**63}), r"study\.seed: 9"),
    (changed(study={"settings": ["experiment.seed=7"]}), r"study\.settings: sets the seed"),
    (changed(study={"design": "latin"}), r"study\.design: \"latin\""),
    (changed(study={"samples": 3}), r"study\.samples: 3 in a grid"),
    (changed(study={"design": "sobol"}), r"study\.samples: 0"),
    (changed(study={"recordings": "some"}), r"study\.recordings: \"some\""),
    (axis(values=[0], fro=1), r"axes\.latency_ms\.fro: unknown key.*did you mean 'from'"),
    (axis(), r"axes\.latency_ms\.values: is missing or empty"),
    (axis(values=[]), r"latency_ms\.values: is missing or empty"),
    (axis(values=[1], options={"a": {}}), r"latency_ms\.options: is given as well as values"),
    (axis(values=[1], count=3, **SPAN), r"latency_ms\.from: is given as well as values"),
    (axis(key="a", options={"a": {}}), r"latency_ms\.key: is given as well as options"),
    (axis(values=[1, 1.0]), "the same value more than once"),
    (axis(values=[math.nan]), r"latency_ms\.values\[0\]: nan"),
    (axis(values=[math.inf]), r"latency_ms\.values\[0\]: inf"),
    (axis(values=[[1]]), r"latency_ms\.values\[0\]: \[1\] is a list"),
    (axis(key="latency_ms=3", values=[1]), r"latency_ms\.key: 'latency_ms=3' has a value"),
    (axis(key="experiment.seed", values=[1]), r"latency_ms\.key: sets the seed"),
    (axis(key='experiment."seed"', values=[1]), r"latency_ms\.key: sets the seed"),
    (axis(options={"a": {"settings": ["experiment.seed=2"]}}), r"options\.a\.settings: sets the seed"),
    (axis(**SPAN), r"latency_ms\.count: is missing"), (axis(count=1, **SPAN), r"latency_ms\.count: 1"),
    (axis(start=1, stop=1, count=2), r"latency_ms\.to: 1; allowed: a finite number above from, 1"),
    (axis(start=0, stop=math.inf, count=2), r"latency_ms\.to: inf"),
    (axis(start=math.nan, stop=1, count=2), r"latency_ms\.from: nan"),
    (axis(start=0, count=2), r"latency_ms\.to: is missing"),
    (axis(stop=1, values=[1]), r"latency_ms\.to: is given without from"),
    (axis(count=3, scale="log", **SPAN), r"latency_ms\.from: 0; allowed: a number above 0"),
    (axis(cohort={"patient": "sci_c6", "members": 0}), r"cohort\.members: 0"),
    (axis(cohort={"patient": "sci_c6"}), r"cohort\.members: is missing"),
    (changed(study={"design": "random", "samples": 4}, axes={"latency_ms": {"from": 0, "to": 1, "count": 2}}),
     r"latency_ms\.count: 2; allowed: none"),
    (changed(axes={"latency_ms": {"values": [1]}, "late": {"key": "latency_ms", "values": [2]}}),
     r"axes\.late\.key: axis 'latency_ms' sets 'latency_ms' as well"),
    (changed(axes={"a": {"from": 0, "to": 1, "count": 10**9}}), "1,000,000,000 cells x 1 replicates"),
    (changed(axes={"a": {"from": 0, "to": 1, "count": 10**30}}), "1,000,000,000,000,000,000,0.* cells"),
    (changed(axes={name: {"from": 0, "to": 1, "count": 1000} for name in "abc"}), "1,000,000,000 cells"),
    (axis(cohort={"patient": "sci_c6", "members": 10**12}), "1,000,000,000,000 cells"),
    (changed(study={"replicates": 10**9}), "2 cells x 1000000000 replicates"),
    (changed(study={"design": "sobol", "samples": 10**9}, axes={"latency_ms": {"from": 0, "to": 1}}),
     "1,000,000,000 cells"),
    (changed(figures=[{"name": "x", "kind": "pie", "metric": "error_deg", "x": "latency_ms"}]),
     r"figures\[0\]\.kind: \"pie\""),
    (changed(figures=[{"name": "x", "kind": "curves", "metric": "error", "x": "latency_ms"}]),
     r"figures\[0\]\.metric: the study keeps no metric 'error'"),
    (changed(figures=[{"name": "x", "kind": "curves", "metric": "error_deg", "x": "latncy_ms"}]),
     r"figures\[0\]\.x: .*did you mean 'latency_ms'"),
    (changed(figures=2 * [{"name": "x", "kind": "curves", "metric": "error_deg", "x": "latency_ms"}]),
     r"figures\[1\]\.name: 'x' is also the name of figures\[0\]"),
    (changed(axes={kind: {"cohort": {"patient": kind, "members": 3}} for kind in ("sci_c6", "stroke_mild")}),
     r"axes\.stroke_mild\.cohort: axis 'sci_c6' is a cohort as well"),
    (changed(prepare={"model": {"experiment": "identify_grasp", "axes": ["member"]}}),
     r"prepare\.model\.axes: there is no axis 'member'"),
    (changed(prepare={"model": {"experimen": "identify_grasp"}}), r"prepare\.model\.experimen"),
    (changed(prepare={"model": {"experiment": "identify_grasp",
                                "experiments": {"grasp_mcp": "identify_key"}}}),
     r"prepare\.model\.experiments: no run is of 'grasp_mcp'; allowed: finger_pid_latency"),
    (changed(forms={"full": 3}), "forms: is not a table of tables"),
    (changed(forms={"../a": {}}), r"forms\.\.\./a: is not a name"),
    (changed(axes=[1]), r"axes: \[1\] is a list")])
def test_every_fault_of_a_study_is_named_without_a_cell_being_made(document, fault):
    with pytest.raises(InputError, match=fault) as raised:
        study_of(document)
    assert all(len(line) < 500 for line in str(raised.value).splitlines())


@pytest.mark.parametrize("name", ["cell", "replicate", "seed", "id", "status", "cause", "wall_s", "recording",
                                  "error_deg"])
def test_no_axis_has_the_name_of_a_column_of_results(name):
    with pytest.raises(InputError, match=rf"axes\.{name}: is a column"):
        study_of(changed(axes={name: {"key": "latency_ms", "values": [1]}}))


def test_faults_of_several_tables_are_named_at_once():
    with pytest.raises(InputError) as raised:
        study_of(changed(study={"metrics": {"e": "x:foo"}}, axes={"a": {}, "b": {"values": [1, 1]}}))
    assert len(str(raised.value).splitlines()) == 3


def test_a_file_names_itself_in_every_fault(tmp_path):
    file = tmp_path / "broken.toml"
    for content, fault in ((b"[study", "is not TOML"), (b"\xff", "is not UTF-8"),
                           (b"[study]\nnam = 1", "study.nam")):
        file.write_bytes(content)
        with pytest.raises(InputError, match=rf"broken\.toml.*{fault}"):
            read_study(file)
    with pytest.raises(InputError, match=r"none\.toml: cannot be read: No such file"):
        read_study(tmp_path / "none.toml")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        read_study(tmp_path)


def test_a_date_is_the_text_it_was():
    study = study_of(axis(values=[datetime.date(2026, 1, 2)]))
    assert [cell.levels for cell in cells_of(study)] == [{"latency_ms": "2026-01-02"}]


def test_experiments_are_found_beside_the_study_file_or_are_shipped(tmp_path):
    (tmp_path / "a.toml").write_text(
        '[study]\nname = "a"\nexperiment = "mine.toml"\nmetrics = { e = "e" }\n'
        '[axes.x]\noptions.far = { experiment = "../far/b.toml" }\n'
        'options.ours = { experiment = "finger_mpc" }\n'
        "options.base = {}\n")
    cells = list(cells_of(read_study(tmp_path / "a.toml")))
    assert [cell.experiment for cell in cells] == [
        str(tmp_path / "../far/b.toml"), "finger_mpc", str(tmp_path / "mine.toml")]


def test_a_base_that_every_option_replaces_is_tried_only_where_an_option_names_it():
    def bases(*experiments):
        options = {f"o{i}": {"experiment": each} if each else {} for i, each in enumerate(experiments)}
        study = study_of(axis(options=options))
        return [cell.experiment for cell in base_cells(study)]

    assert bases("finger_mpc", None) == ["finger_pid_latency", "finger_mpc"]
    assert bases("finger_mpc", "finger_control") == ["finger_mpc", "finger_control"]
    assert bases("finger_mpc", "finger_pid_latency") == ["finger_mpc", "finger_pid_latency"]


def test_forms_are_patches_over_the_file_which_is_a_form_itself():
    document = changed(study={"replicates": 2}, forms={
        "full": {"cost": "an hour", "study": {"replicates": 5},
                 "axes": {"latency_ms": {"values": [0, 1, 2]}}},
        "typo": {"studdy": {}}, "priced": {"cost": 3}, "broken": {"study": {"replicates": 0}}})
    small, full = study_of(document), study_of(document, "full")
    assert (small.name, small.runs, small.cost) == ("plain", 4, "")
    assert (full.name, full.runs, full.cost) == ("plain-full", 15, "an hour")
    assert small.document == changed(study={"replicates": 2})
    assert small.document == study_of(changed(study={"replicates": 2})).document != full.document
    for form, fault in (("ful", "--form ful: .*mean 'full'"), ("typo", r"forms\.typo\.studdy: unknown"),
                        ("priced", r"forms\.priced\.cost: 3"), ("broken", r"study\.replicates: 0")):
        with pytest.raises(InputError, match=fault):
            study_of(document, form)


def test_shipped_studies_are_sound_in_every_form():
    described = described_studies()
    assert list(described) == shipped_studies()
    for name, forms in described.items():
        for form in forms:
            study = read_study(name, form)
            assert study.about.description
            assert study.cost or not form
            next(cells_of(study))


numbers = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=False)
positive = st.floats(min_value=0.0, exclude_min=True, allow_infinity=False, allow_subnormal=False)


@st.composite
def spans(draw, **more):
    scale = draw(st.sampled_from(["linear", "log"]))
    ends = draw(st.lists(positive if scale == "log" else numbers, min_size=2, max_size=2, unique=True))
    ends.sort()
    made = Axis(start=ends[0], stop=ends[1], scale=scale, **{key: draw(each) for key, each in more.items()})
    assert not list(made.faults("x", sampled="count" not in more))
    return made


@given(spans(count=st.integers(2, 9)))
def test_levels_go_from_one_end_to_the_other_in_even_steps(span):
    levels = [span.level("x", number).value for number in range(span.count_of_levels("x"))]
    assert len(levels) == span.count
    assert levels == sorted(levels)
    for end, given_end in ((levels[0], span.start), (levels[-1], span.stop)):
        assert end == pytest.approx(given_end, rel=1e-11, abs=5e-324)
    steps = [math.log(level) if span.scale == "log" else level / 4.0 for level in levels]
    middle = (steps[0] + (steps[-1] - steps[0]) / (len(levels) - 1))
    size = max(abs(steps[0]), abs(steps[-1]), 1.0 if span.scale == "log" else 0.0)
    assert steps[1] == pytest.approx(middle, abs=1e-9 * size + 1e-300)


@given(spans(), st.floats(0.0, 1.0, exclude_max=True))
def test_what_is_drawn_lies_within_the_bounds(span, share):
    value = span.sampled("x", share).value
    assert span.start <= value <= span.stop
    assert span.sampled("x", share).settings == (f"x={value!r}",)


@given(st.lists(st.integers(), min_size=1, unique=True), st.floats(0.0, 1.0, exclude_max=True))
def test_listed_levels_are_drawn_alike(values, share):
    made = Axis(values=tuple(values))
    assert made.sampled("x", share).value == values[int(share * len(values))]


@pytest.mark.slow
@settings(deadline=None)
@given(st.lists(st.integers(1, 4), max_size=3), st.integers(1, 5))
def test_a_grid_has_each_place_once_the_last_axis_changing_fastest(counts, replicates):
    axes = {f"x{i}": {"values": list(range(count))} for i, count in enumerate(counts)}
    study = study_of(changed(study={"replicates": replicates}, axes=axes))
    places = [tuple(cell.levels.values()) for cell in cells_of(study)]
    assert len(places) == len(set(places)) == study.cells == math.prod(counts)
    assert places == sorted(places)
    assert study.runs == study.cells * replicates


@settings(deadline=None, max_examples=25)
@given(st.sampled_from(["random", "sobol"]), st.integers(1, 40), st.integers(1, 40), st.integers(0, 3))
def test_a_longer_sequence_begins_with_the_shorter(design, one, other, seed):
    def places(samples):
        study = study_of(changed(
            study={"design": design, "samples": samples, "seed": seed},
            axes={"a": {"from": 1, "to": 2}, "b": {"from": 1e-3, "to": 10, "scale": "log"},
                  "c": {"values": ["x", "y"]}}))
        found = [cell.levels for cell in cells_of(study)]
        assert len(found) == samples == study.cells
        return found

    short, long = sorted((one, other))
    assert places(long)[:short] == places(short)


def test_a_sobol_sequence_fills_every_part_of_the_span_alike():
    """Of 2^k points one lies in each of 2^k equal parts; independent ones leave a third of them empty."""
    def filled(design):
        study = study_of(changed(study={"design": design, "samples": 64}, axes={"a": {"from": 0, "to": 64}}))
        return len({int(cell.levels["a"]) for cell in cells_of(study)})

    assert filled("sobol") == 64
    assert filled("random") < 55
