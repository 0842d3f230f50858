"""Scores that nobody measured, for what is made of scores: the papers' own figures, or worse ones."""

from collections import Counter

import numpy as np

from fesloop.apps.reproduce import kortier2014, salchow2019
from fesloop.apps.reproduce.salchow2019 import DISTANCES, METHODS, PAIRS, TIPS, distance_key, tip_key

MOTIONS = ("flexion", "circles", "pinch", "rapid", "flat", "mould", *TIPS, *PAIRS)


def summary(rmse):
    return {"rmse": rmse, "mean": rmse, "std": 0.1, "low": 0.5 * rmse, "median": rmse, "high": 1.5 * rmse,
            "worst": 2.0 * rmse}


def salchow(motion, times=1.0):
    """A subject of a movement, `times` as far off as the paper's."""
    figures = salchow2019.FIGURES
    if motion in TIPS:
        return {method: summary(times * figures[tip_key(motion, method)].value) for method in METHODS}
    return {method: {pair: summary(times * figures[distance_key(motion, pair, method)].value)
                     for name, pair in DISTANCES if name == motion} for method in METHODS}


def salchow_traces(motion):
    times = np.arange(0.0, 26.0, 0.1)
    if motion == "P3":
        return {"times_s": times, "distance_cm": 1.0 + np.sin(times),
                "spans": np.array([[1.0, 5.0], [8.0, 12.0]])}
    tips = np.sin(times)[:, np.newaxis] * np.ones(3)
    return {"times_s": times, "estimate_cm": tips, "truth_cm": tips + 0.1}


def kortier(motion, times=1.0):
    def value(key):
        return times * kortier2014.FIGURES[key].value

    if motion in ("flexion", "circles"):
        tip = [value(kortier2014.tip_key(motion, axis)) for axis in ("x", "y", "z", "distance")]
        return {"rms_mm": np.tile(tip, (10, 1))}
    if motion == "pinch":
        return {"rms_mm": np.full(100, value(kortier2014.PINCH)),
                "share": 0.01 * value(kortier2014.PINCH_SHARE)}
    if motion == "rapid":
        return {"range_deg": value(kortier2014.RAPID), "true_range_deg": 80.0}
    return {f"{what}_deg": value(kortier2014.angle_key(motion, what)) for what in ("range", "sd")}


def kortier_traces():
    times = np.arange(0.0, 5.0, 0.01)
    tips = np.sin(times)[:, np.newaxis] * np.ones(3)
    return {"times_s": times, "tip_mm": tips, "true_tip_mm": tips + 1.0, "pip_deg": times,
            "true_pip_deg": times, "rate_times_s": times, "rate_deg_s": times}


def spread(paper):
    """By which a simulated paper's figures differ from the published: half are a little more, half less."""
    return 1.0 + 0.02 * (-1.0) ** paper


def of_job(job, paper=0):
    """What the scoring of a job of a simulated paper might have kept: nearly the published figures."""
    motion = next(each for each in job.key if each in MOTIONS)
    if job.score is kortier2014.traces:
        return kortier_traces()
    if job.score in (salchow2019.tip_traces, salchow2019.distance_traces):
        return salchow_traces(motion)
    times = spread(paper)
    return kortier(motion, times) if job.experiment == "kortier2014" else salchow(motion, times)


def run_jobs(attempts, workers, progress=None):
    """In place of a cohort's."""
    if progress is not None:
        progress(1.0)
    papers = Counter()
    kept = {}
    for attempt in attempts:
        kept[attempt.key] = {"kept": of_job(attempt.job, papers[attempt.job.key])}
        papers[attempt.job.key] += 1
    return kept
