"""Scores that nobody measured, for what is made of scores: the papers' own figures, or worse ones."""

import numpy as np

from fesloop.apps.reproduce import kortier2014, salchow2019
from fesloop.apps.reproduce.salchow2019 import METHODS

MOTIONS = ("flexion", "circles", "pinch", "rapid", "flat", "mould", *salchow2019.TABLE_6, *salchow2019.PAIRS)


def summary(rmse):
    return {"rmse": rmse, "mean": rmse, "std": 0.1, "low": 0.5 * rmse, "median": rmse, "high": 1.5 * rmse,
            "worst": 2.0 * rmse}


def salchow(motion, times=1.0):
    """A subject of a movement, `times` as far off as the paper's."""
    if motion in salchow2019.TABLE_6:
        return {method: summary(times * rmse)
                for method, rmse in zip(METHODS, salchow2019.TABLE_6[motion], strict=True)}
    rows = {pair: row for (name, pair), row in salchow2019.TABLE_7.items() if name == motion}
    return {method: {pair: summary(times * row[i]) for pair, row in rows.items()}
            for i, method in enumerate(METHODS)}


def salchow_traces(motion):
    times = np.arange(0.0, 26.0, 0.1)
    if motion == "P3":
        return {"times_s": times, "distance_cm": 1.0 + np.sin(times),
                "spans": np.array([[1.0, 5.0], [8.0, 12.0]])}
    tips = np.sin(times)[:, np.newaxis] * np.ones(3)
    return {"times_s": times, "estimate_cm": tips, "truth_cm": tips + 0.1}


def kortier(motion, times=1.0):
    if motion in kortier2014.TABLE_2:
        return {"rms_mm": times * np.tile(kortier2014.TABLE_2[motion], (10, 1))}
    if motion == "pinch":
        return {"rms_mm": np.full(100, times * kortier2014.PINCH_MM),
                "share": 0.01 * times * kortier2014.PINCH_SHARE}
    if motion == "rapid":
        return {"range_deg": times * kortier2014.RAPID_DEG, "true_range_deg": 80.0}
    spread, sd = kortier2014.TABLE_3[motion]
    return {"range_deg": times * spread, "sd_deg": times * sd}


def kortier_traces():
    times = np.arange(0.0, 5.0, 0.01)
    tips = np.sin(times)[:, np.newaxis] * np.ones(3)
    return {"times_s": times, "tip_mm": tips, "true_tip_mm": tips + 1.0, "pip_deg": times,
            "true_pip_deg": times, "rate_times_s": times, "rate_deg_s": times}


def spread(seed):
    """By which a subject's figures differ from the paper's: half of them a little more, half less."""
    return 1.0 + 0.02 * (-1.0) ** seed


def of_job(job):
    """What the scoring of a job of either paper might have kept: nearly the paper's own figures."""
    if job.key[0] == "traces":
        return kortier_traces() if job.experiment == "kortier2014" else salchow_traces(job.key[1])
    times = spread(job.seed)
    motion = next(each for each in job.key if each in MOTIONS)
    return kortier(motion, times) if job.experiment == "kortier2014" else salchow(motion, times)


def run_jobs(jobs, workers, progress=None):
    """In place of a cohort's."""
    if progress is not None:
        progress(1.0)
    return {job.key: of_job(job) for job in jobs}
