"""A page with one part of every kind, made of numbers that are known beforehand."""

import numpy as np

from fesloop.show.picture.hand_mesh import Mesh
from fesloop.show.report.parts import (
    Bars,
    Chart,
    Code,
    Drawing,
    Figure3d,
    Fold,
    Frames,
    HeatMap,
    Line,
    Mark,
    Notice,
    Page,
    Paragraph,
    Section,
    Solid,
    Strips,
    Table,
)

TRIALS = (1, 2, 3)
FRAMES, STEP_S = 101, 0.02
"""Of each trial's motion: two seconds."""
SEGMENTS = 17


def ball(radius, around=24, along=12):
    """A sphere's mesh."""
    latitude, longitude = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, along + 1),
                                      np.linspace(0, 2 * np.pi, around, endpoint=False), indexing="ij")
    vertices = radius * np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude),
                                  np.sin(latitude)], axis=-1).reshape(-1, 3)
    faces = []
    for row in range(along):
        for column in range(around):
            a, b = row * around + column, row * around + (column + 1) % around
            faces += [(a, b, b + around), (a, b + around, a + around)]
    return Mesh(vertices=vertices, faces=np.array(faces, dtype=np.int32))


def motion(trial):
    """Segments in a row that rise, each trial faster; the estimate beside them."""
    truth = np.zeros((FRAMES, SEGMENTS, 7))
    truth[..., 0] = 1.0
    truth[..., 4] = np.arange(SEGMENTS) * 0.012
    truth[..., 6] = 0.04 * trial * np.linspace(0, 1, FRAMES)[:, np.newaxis]
    estimate = truth.copy()
    estimate[..., 5] += 0.02
    still = np.tile([1.0, 0.0, 0.0, 0.0, 0.1, 0.1, 0.0], (FRAMES, 1, 1))
    return Frames(start_s=0.0, step_s=STEP_S, hands={"truth": truth, "estimate": estimate}, objects=still)


def hand():
    """As heavy to draw as a real hand: some 20,000 triangles."""
    meshes = [ball(0.012) for _ in range(SEGMENTS)]
    cup = Solid(kind="cylinder", half_sizes=(0.02, 0.02, 0.04), role="object", moves=True)
    return Figure3d(key="hand", trials={trial: motion(trial) for trial in TRIALS},
                    shapes={"truth": meshes, "estimate": meshes}, objects=[cup])


def joint(name, trial):
    """Reference, truth with a gap, estimate with a band, over the two seconds of a trial."""
    x = np.linspace(0.0, 2.0, 200)
    angle = 30.0 * trial * np.sin(x)
    gap = np.where((x > 0.9) & (x < 1.1), np.nan, angle)
    marks = [Mark(text="hold", at=0.5, until=1.0), Mark(text="slip", at=1.5, until=1.5)]
    return Chart(key=f"{name}-{trial}", title=name, x_label="time, s", y_label="angle, deg", timed=True,
                 trial=trial, marks=marks,
                 lines=[Line(name="reference", role="reference", x=x, y=angle + 1.0, style="dashed"),
                        Line(name="truth", role="truth", x=x, y=gap),
                        Line(name="estimate", role="estimate", x=x, y=angle, low=angle - 2, high=angle + 2)],
                 text="The angle rises.")


CHANNELS = 8


def channels(count=CHANNELS):
    """Currents that begin one after the other and are all as high: in one frame one would hide the others."""
    x = np.linspace(0.0, 2.0, 201)
    return Strips(key="channels", title="Current", x_label="time, s", y_label="current, mA", timed=True,
                  trial=3, limits=(0.0, 25.0), text="All up to 20 mA.",
                  lines=[Line(name=f"channel {number}", role=f"channel-{number % 8}", style="steps", x=x,
                              y=np.where(x > 0.1 * number, 20.0, 0.0)) for number in range(count)])


def error():
    """One point a trial."""
    return Chart(key="error", title="Error per trial", x_label="trial", y_label="error, deg",
                 lines=[Line(name="error", role="plain", x=np.array([1.0, 2.0, 3.0]),
                             y=np.array([9.0, 4.0, 2.0]), low=np.array([8.0, 3.0, 1.0]),
                             high=np.array([10.0, 5.0, 3.0]))])


def curve():
    """Kinds along x, and beside it numbers a decade apart."""
    kinds = Chart(key="kinds", title="Error by tracker", x_label="tracker", y_label="error, deg",
                  x_levels=["vqf", "ideal"], lines=[Line(name="error", role="plain", style="points",
                                                         x=np.array([0.0, 1.0]), y=np.array([3.0, 1.0]))])
    decades = Chart(key="decades", title="Error by noise", x_label="noise", y_label="error, deg", x_log=True,
                    lines=[Line(name="mean", role="plain", x=np.array([0.1, 1.0, 10.0]),
                                y=np.array([3.0, 1.0, 4.0]))])
    return [kinds, decades]


def heat_map():
    """Two rows of three, one of them without a value, and a bound."""
    return HeatMap(key="heat", title="Error by delay and gain", x_label="delay, ms", y_label="gain",
                   x_levels=["0", "20", "40"], y_levels=["low", "high"],
                   values=np.array([[1.0, 2.0, np.nan], [4.0, 5.0, 6.0]]),
                   cells=[["1", "2", "–"], ["4", "5", "6"]],
                   told=[["1 deg", "2 deg", "no run"], ["4 deg", "5 deg", "6 deg"]],
                   value_label="error, deg", low=1.0, high=6.0,
                   contours=[Line(name="bound", role="theory", x=np.array([0.0, 2.0]),
                                  y=np.array([1.0, 0.0]))])


def bars():
    """Stacked, and side by side."""
    values = {"controller": [3.0, 2.0], "tracker": [1.0, 0.5]}
    roles = {"controller": "controller", "tracker": "tracker"}
    return [Bars(key=key, title=key, x_label="error, deg", names=["index", "middle"], values=values,
                 roles=roles, stacked=key == "stacked") for key in ("stacked", "beside")]


def drawing(svg='<svg viewBox="0 0 40 20"><rect class="fill-truth" width="40" height="20"/></svg>'):
    """A rectangle."""
    return Drawing(key="wiring", title="Wiring", svg=svg, text="One block.")


def page(**other):
    """The page, with other values where they are given."""
    metrics = Table(title="Metrics", columns=["metric", "value"], rows=[["error", "1.25"], ["rest", "–"]])
    joints = [joint(name, trial) for trial in TRIALS for name in ("index", "middle")]
    sections = [
        Section(key="result", title="Result", parts=[error(), *curve()]),
        Section(key="motion", title="The hand", parts=[hand()]),
        Section(key="tracking", title="Tracking by joint", parts=[
            Paragraph(text="Angles of `index` and `middle`."), *joints,
            Fold(title="Other joints", parts=[joint("wrist", trial) for trial in TRIALS])]),
        Section(key="stimulation", title="Stimulation", parts=[channels()]),
        Section(key="shares", title="Shares", parts=[*bars(), metrics]),
        Section(key="study", title="Study", parts=[heat_map()]),
        Section(key="what", title="Experiment", parts=[
            drawing(), Notice(text="Fatigue was not recorded."),
            Fold(title="Experiment", parts=[Code(text="[block.hand]\nkind = 'hand'\n")])]),
    ]
    return Page(**{"title": "made_up", "sentence": "The error fell from 9 to `2` deg.",
                   "facts": [("seed", "7")], "sections": sections, "trials": TRIALS, "shown": 3} | other)
