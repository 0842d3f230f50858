"""Tables of published figures: what the papers print, and one line for each fault of a table."""

import math

import numpy as np
import pytest

from fesloop.apps.reproduce import kortier2014, salchow2019
from fesloop.apps.reproduce.published import read
from fesloop.errors import InputError

HEAD = "table,row,value,unit,n,of,spread,each,half\n"
A, B = "T,a,1.5,cm,2,subjects,,1.0 2.0,fitted\n", "T,b,3,cm,10,trials,0.4,,predicted\n"
EXPECTED = ("T: a", "T: b")


@pytest.mark.parametrize("paper", [kortier2014, salchow2019], ids=["kortier2014", "salchow2019"])
def test_values_of_subjects_have_the_printed_mean(paper):
    """To the rounding of both: half a digit of the last decimal each."""
    several = [figure for figure in paper.FIGURES.values() if figure.each]
    assert len(several) == (4 if paper is kortier2014 else 18)
    for figure in several:
        assert np.mean(figure.each) == pytest.approx(figure.value, abs=0.1 + 1e-9), figure.key


def test_halves_have_no_movement_in_common():
    for paper, fitted in ((kortier2014, {"flexion", "flat"}),
                          (salchow2019, {"A-F1", "A-F2", "A-F3", "P1", "P3"})):
        halves = {half: {figure.row.replace(",", " ").split()[0] for figure in paper.FIGURES.values()
                         if figure.half == half} for half in ("fitted", "predicted")}
        assert halves["fitted"] == fitted
        assert not halves["fitted"] & halves["predicted"]
        assert halves["predicted"]


@pytest.mark.parametrize("paper", [kortier2014, salchow2019], ids=["kortier2014", "salchow2019"])
def test_the_papers_own_figures_have_every_pattern(paper):
    own = {key: np.array([figure.value]) for key, figure in paper.FIGURES.items()}
    assert {pattern.statement: pattern.occurs(own).tolist() for pattern in paper.PATTERNS} == {
        pattern.statement: [True] for pattern in paper.PATTERNS}


def test_a_spread_is_printed_or_that_of_the_subjects():
    figures = read(HEAD + A + "\n" + B, "it.csv", EXPECTED)
    assert figures["T: a"].spread == pytest.approx(math.sqrt(0.5))
    assert (figures["T: a"].each, figures["T: a"].subjects) == ((1.0, 2.0), 2)
    assert (figures["T: b"].spread, figures["T: b"].subjects, figures["T: b"].half) == (0.4, 1, "predicted")
    alone = read(HEAD + "T,a,1.5,cm,1,subjects,,,fitted\n", "it.csv", ["T: a"])["T: a"]
    assert math.isnan(alone.spread)


@pytest.mark.parametrize(("text", "told"), [
    (HEAD + A, "it.csv: 1 missing: T: b"),
    (HEAD, "it.csv: 2 missing: T: a, T: b"),
    ("", "it.csv, line 1: no columns; allowed: table, row"),
    (A + B, "it.csv, line 1: columns T, a"),
    (HEAD + A + B + A, "it.csv, line 4: 'T: a' is listed twice"),
    (HEAD + A + B.replace("T,b", "T,c"), "it.csv, line 3: 'T: c' is no figure that is reproduced"),
    (HEAD + A + B.replace("predicted", "guessed"), "it.csv, line 3, half: 'guessed'; allowed: fitted, pred"),
    (HEAD + A + B.replace("predicted", ""), "it.csv, line 3, half: ''"),
    (HEAD + A + B.replace("0.4", "-0.4"), "it.csv, line 3, spread: '-0.4'; allowed: a number above 0"),
    (HEAD + A + B.replace("0.4", "nan"), "it.csv, line 3, spread: 'nan'"),
    (HEAD + A + B.replace("b,3,", "b,x,"), "it.csv, line 3, value: 'x'"),
    (HEAD + A + B.replace("b,3,", "b,,"), "it.csv, line 3, value: ''"),
    (HEAD + A + B.replace("10", "2.5"), "it.csv, line 3, n: 2.5; allowed: a whole number from 1"),
    (HEAD + A + B.replace("trials", "rabbits"), "it.csv, line 3, of: 'rabbits'"),
    (HEAD + A.replace("1.0 2.0", "1.0"), "it.csv, line 2: 1 values in each, n 2"),
    (HEAD + A.replace(",,1.0", ",0.5,1.0"), "it.csv, line 2: 2 values in each, n 2, spread '0.5'"),
    (HEAD + A.replace("1.0 2.0", "1.0 -2.0"), "it.csv, line 2, each: '-2.0'"),
    (HEAD + A + B[:-1] + ",more\n", "it.csv, line 3: 10 cells; allowed: 9"),
    (HEAD + A + "T,b,3\n", "it.csv, line 3: 3 cells"),
    (HEAD + A + 'T,"b', "it.csv, line 3: unexpected end of data"),
])
def test_a_fault_of_a_table_is_one_line(text, told):
    with pytest.raises(InputError) as fault:
        read(text, "it.csv", EXPECTED)
    assert str(fault.value).startswith(told)
    assert "\n" not in str(fault.value)
