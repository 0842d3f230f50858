"""Commands and their options."""

from __future__ import annotations

import argparse
from typing import Any, NoReturn

from fesloop.errors import InputError, in_one_line

EPILOG = """exit codes: 0 done, 1 the run failed, 2 bad input, 130 interrupted

EXPERIMENT is the name of a shipped experiment (fesloop list), the path of a .toml file, or that of a
recording, which is then run again."""


class _Parser(argparse.ArgumentParser):
    """A parser that prints an error in one line."""

    def error(self, message: str) -> NoReturn:
        """Print the error and exit with code 2."""
        self.exit(2, f"fesloop: {in_one_line(message)}; see {self.prog} --help\n")


def make_parser() -> argparse.ArgumentParser:
    """Make the parser of `fesloop`."""
    parser: argparse.ArgumentParser = _Parser(
        prog="fesloop", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Closed-loop co-simulation of functional electrical stimulation of the hand.")
    parser.add_argument("--version", action=_Version)
    parser.add_argument("--traceback", action="store_true", help="show where an internal error arose")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    _add_list(commands)
    _add_explain(commands)
    _add_check(commands)
    _add_run(commands)
    _add_study(commands)
    _add_report(commands)
    _add_picture(commands)
    _add_film(commands)
    _add_view(commands)
    _add_import(commands)
    _add_export(commands)
    _add_reproduce(commands)
    _add_bench(commands)
    commands.add_parser("schema", help="print the JSON Schema of experiment files")
    _add_fmu(commands)
    _add_patient(commands)
    _add_identify(commands)
    _add_calibrate(commands)
    _add_fit_error(commands)
    _add_stream(commands)
    for command in (parser, *(commands.choices[name] for name in _PRINT_NUMBERS)):
        command.add_argument("--explain", metavar="METRIC", action=_Explain)
    return parser


_PRINT_NUMBERS = ("check", "run", "study", "import", "reproduce", "bench", "identify", "calibrate",
                  "fit-error")
"""Commands with the option --explain."""


class _Version(argparse.Action):
    """Prints the version, which is looked up only then."""

    def __init__(self, option_strings: list[str], dest: str) -> None:
        super().__init__(option_strings, dest, nargs=0, help="print the version")

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"fesloop {version('fesloop')}")
        parser.exit()


class _Explain(argparse.Action):
    """Prints the definition of a number and exits, as `fesloop explain` does."""

    def __init__(self, option_strings: list[str], dest: str, metavar: str) -> None:
        super().__init__(option_strings, dest, metavar=metavar, default=argparse.SUPPRESS,
                         help="print what a number is, in which unit, and when there is none; run nothing")

    def __call__(self, parser: argparse.ArgumentParser, _: object, metric: Any, *__: object) -> None:
        from fesloop.apps.cli.explain_command import execute

        try:
            parser.exit(execute(argparse.Namespace(metrics=[metric], json=False)))
        except InputError as fault:
            parser.exit(2, f"fesloop: {fault}\n")


_Commands = argparse._SubParsersAction  # the type has no public name


def _add_list(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("list", help="shipped experiments, studies, block kinds and patients")
    command.add_argument("--json", action="store_true", help="print one JSON object")


def _add_explain(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("explain", help="define a printed number: its unit, and when there is none")
    command.add_argument("metrics", metavar="METRIC", nargs="*",
                         help="as printed, such as grip_margin or 'split_rmse_deg tracker' "
                         "(default: list all)")
    command.add_argument("--json", action="store_true", help="print one JSON object")


def _add_experiment(command: argparse.ArgumentParser) -> None:
    command.add_argument("experiment", metavar="EXPERIMENT", help="name or path")
    command.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], dest="settings",
                         help="change a key of the file, such as blocks.pid.kp=0.5, an alias, or the "
                         "option of a variant (fesloop check shows them)")
    command.add_argument("--seed", type=int, metavar="N", help="seed (default: that of the file)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_check(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("check", help="validate; print wiring and latency budget; run nothing")
    _add_experiment(command)


def _add_run(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("run", help="run an experiment and score its recording")
    _add_experiment(command)
    command.add_argument("--out", metavar="DIR", default="runs",
                         help="folder of the recording (default: runs)")
    command.add_argument("--realtime", action="store_true", help="keep in step with the wall clock")
    command.add_argument("--late", choices=("catch-up", "skip", "stop"), help="in real time, how late "
                         "ticks are treated (default: catch-up)")
    command.add_argument("--priority", type=int, metavar="N", help="in real time, run in the scheduling "
                         "class SCHED_FIFO with this priority, 1 to 98 (default: none)")


def _add_study(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("study", help="run an experiment over axes and replicates")
    command.add_argument("study", metavar="STUDY", help="name (fesloop list) or path of a study file")
    command.add_argument("--form", metavar="NAME", default="", help="another form of the study, such as full")
    command.add_argument("--workers", type=int, metavar="N", help="processes here (default: one a core)")
    command.add_argument("--scheduler", metavar="ADDRESS", help="run on the Dask cluster at this address")
    command.add_argument("--out", metavar="DIR", default="studies",
                         help="folder of results, in a folder of the study's name (default: studies)")
    command.add_argument("--dry-run", action="store_true",
                         help="print the number of runs, time and disk space; run only a few to measure them")
    command.add_argument("--retry-failed", action="store_true", help="run failed ones again")
    command.add_argument("--mix-versions", action="store_true",
                         help="continue results of other versions of code or libraries")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_report(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("report", help="write a run, several runs, a study, or a recording of "
                                  "stimulated muscle as one HTML file")
    command.add_argument("sources", metavar="RUN-OR-STUDY", nargs="+",
                         help="recordings of runs; or a study: its folder or study.sqlite; or a file of "
                         "fesloop import --stimulation")
    command.add_argument("--out", metavar="FILE", help="the page (default: beside its source, such as "
                         "runs/grasp_ilc-1.html)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_picture(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("picture", help="draw the hand, the arrays and time courses of a recording")
    command.add_argument("recording", metavar="RUN.h5",
                         help="a file that fesloop run or fesloop import --stimulation wrote")
    command.add_argument("--at", metavar="SECONDS", type=float, nargs="+", default=[],
                         help="times to draw (default: up to four whose postures differ most)")
    command.add_argument("--trial", type=int, metavar="N", help="counted from 0 (default: the best)")
    command.add_argument("--out", metavar="DIR", default="pictures",
                         help="folder of the pictures (default: pictures)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_film(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("film", help="film the hand, its estimate and stimulation of a recording")
    command.add_argument("recording", metavar="RUN.h5", help="a file that fesloop run wrote")
    command.add_argument("--out", metavar="FILE", help="a file .mp4 (extra film) or .gif (default: RUN.mp4)")
    command.add_argument("--trial", type=int, metavar="N", help="counted from 0 (default: the best)")
    command.add_argument("--from", type=float, metavar="SECONDS", dest="begin",
                         help="first instant (default: the trial's first)")
    command.add_argument("--until", type=float, metavar="SECONDS", help="last instant (default: its last)")
    command.add_argument("--fps", type=float, metavar="HZ",
                         help="pictures per second (default: 30; of .gif 20)")
    command.add_argument("--size", metavar="WIDTHxHEIGHT", default="1280x720",
                         help="pixels (default: 1280x720); upright, the hand stands above the stimulation")
    command.add_argument("--speed", type=float, metavar="TIMES", default=1.0,
                         help="1 is real time (default), 0.25 slow motion")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_view(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("view", help="watch the hand of a recording, a loop or a live stream")
    command.add_argument("source", metavar="RUN.h5", nargs="?",
                         help="recording of a run, which may be under way")
    command.add_argument("--stream", metavar="NAME", help="instead of a recording, a live stream (Lab "
                         "Streaming Layer) of joint angles or of segments' orientations")
    command.add_argument("--side", choices=("left", "right"),
                         help="side of the hand of a stream (default: right)")
    command.add_argument("--network", choices=("loopback", "lab"),
                         help="source of the stream: this machine (default), or other computers too")
    command.add_argument("--port", type=int, metavar="N", default=0, help="port (default: a free one)")
    command.add_argument("--open", action="store_true", help="open a browser")


def _add_import(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("import", help="write a recording of inertial sensors, or of stimulated "
                                  "muscle, as a file of fesloop's own, or a system of FMUs as an experiment")
    command.add_argument("source", metavar="SOURCE",
                         help="XDF, Motion-BIDS (folder or *_motion.tsv), MATLAB 5 or 7.3, .npz, a table; of "
                         "stimulated muscle: .npz of a published set, or TOML that describes tables; "
                         "a system of FMUs: .ssp")
    command.add_argument("target", metavar="TARGET", nargs="?",
                         help="the file to write, such as motion.h5; of an .ssp a new folder")
    command.add_argument("--out", metavar="TARGET", dest="out", help="the same")
    command.add_argument("--inspect", action="store_true", help="print streams, rates, gaps and units of "
                         "SOURCE, and write a layout to start from, as TARGET (default: "
                         "SOURCE with .layout.toml in place of its ending)")
    command.add_argument("--stimulation", action="store_true", help="SOURCE holds torque, force or movement "
                         "against pulse width and current (docs/howto/stimulation_recordings.md)")
    command.add_argument("--rate", metavar="HZ", help="of an .ssp: communication points (default: 1000)")
    command.add_argument("--layout", metavar="FILE",
                         help="layout of SOURCE, for files that do not describe themselves; it may "
                         "name further files of the same recording (docs/files.md)")
    command.add_argument("--sensor-set", metavar="NAME",
                         help="sensors to read, where SOURCE holds several sets: streams of XDF or tracking "
                         "systems of Motion-BIDS, separated by commas")
    command.add_argument("--resample", metavar="HZ",
                         help="bring streams of sensors on different clocks to common instants at this rate")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_export(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("export", help="write a recording in the format of another tool, or a "
                                  "controller as C or as an FMU")
    command.add_argument("recording", metavar="RUN.h5|EXPERIMENT",
                         help="a file that fesloop run wrote; for a block the name or path of an experiment")
    command.add_argument("--format", required=True, metavar="FORMAT",
                         help="motion-bids, xdf, mat, mot, sto or csv; of a block c or fmu")
    command.add_argument("--block", metavar="NAME", help="block of the experiment, of the kind pid, "
                         "tuned_pid, ilc or mpc")
    command.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], dest="settings",
                         help="change a key of the experiment, as in fesloop run")
    command.add_argument("--trial", type=int, metavar="N", help="counted from 0 (default: all)")
    command.add_argument("--signals", metavar="A.B,C.D",
                         help="signals (default: all that the format can hold)")
    command.add_argument(
        "--out",
        metavar="PATH",
        help="new folder or, for one file, its name (default: exports/RUN-FORMAT, of a block "
        "exports/EXPERIMENT-BLOCK-FORMAT)",
    )
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_reproduce(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("reproduce", help="repeat a paper's experiments on virtual subjects")
    command.add_argument("paper", metavar="PAPER",
                         help="kortier2014, salchow2019; claims of our own: hour, array_search, "
                         "grasp_ilc, grasp_trackers, grasp_mpc, three_trials, linear_theory, "
                         "error_replay, people")
    command.add_argument("--subjects", type=int, metavar="N", help="subjects (default: the full cohort)")
    command.add_argument("--workers", type=int, metavar="N", help="processes (default: one a core)")
    command.add_argument("--out", metavar="DIR", default="reproduced",
                         help="folder of tables and figures (default: reproduced)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_bench(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("bench", help="measure every speed claim on this machine")
    command.add_argument("name", metavar="NAME", nargs="?", help="one bench (default: all)")
    command.add_argument("--short", action="store_true", help="the short form of benches that have one")
    command.add_argument("--priority", type=int, metavar="N", default=0, help="for benches in real time, "
                         "as in fesloop run (default: none)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_fmu(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("fmu", help="write plants as FMUs")
    verbs = command.add_subparsers(dest="verb", metavar="VERB", required=True)
    build = verbs.add_parser("build", help="write a plant as an FMU (source, and binary with a compiler)")
    build.add_argument("plant", metavar="PLANT", nargs="?", default="finger", help="default: finger")
    build.add_argument("--out", metavar="DIR", default=".", help="folder of the FMU (default: here)")
    build.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_patient(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("patient", help="print a patient, sampled from a preset, as a file")
    command.add_argument("file", metavar="PATIENT", help="a preset (fesloop list), or a .toml file")
    command.add_argument("--cohort", type=int, metavar="SEED", help="seed of the cohort (default: 0)")
    command.add_argument("--member", type=int, metavar="N", help="its member (default: the preset itself)")
    command.add_argument("--day", type=int, metavar="N", help="day (default: none in particular)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_identify(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("identify", help="fit a patient's model for controllers to a recording, "
                                  "or a person to a recording of stimulation")
    command.add_argument("recording", metavar="RUN.h5", help="recording of an experiment such as "
                         "identify_patient; with --stimulation, of fesloop import --stimulation")
    command.add_argument("--stimulation", action="store_true",
                         help="fit the torque that stimulation evokes in a person's arm, by posture")
    command.add_argument("--patient", metavar="FILE",
                         help="with --stimulation: write a virtual patient with the person's muscles, too")
    command.add_argument("--out", metavar="FILE",
                         help="the file to write (default: model.toml; with --stimulation, beside the "
                         "recording, such as p1_person.json)")
    command.add_argument("--measured", metavar="SIGNAL", default="",
                         help="signal to be predicted (default: that of the block of kind synergies)")
    command.add_argument("--method", choices=("subspace", "fir"), default="subspace",
                         help="identification of the linear dynamics (default: subspace)")
    command.add_argument("--opened-deg", type=float, metavar="DEG", help="after sweep_grasp: finger flexion "
                         "of the opened hand that elements are chosen for (default: 18)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_calibrate(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("calibrate", help="joint axes, sensor orientations, clock offsets and "
                                  "frames from a recording")
    command.add_argument("recording", metavar="RECORDING", help="inertial sensors, in any format that "
                         "fesloop import reads")
    command.add_argument("--layout", metavar="FILE", help="layout of a table (as of fesloop import)")
    command.add_argument("--sensor-set", metavar="NAME", help="set of sensors (as of fesloop import)")
    command.add_argument("--joint", metavar="PARENT-CHILD", action="append", default=[], dest="joints",
                         help="a hinge between two sensors (default: every pair of the recording)")
    command.add_argument("--low-pass", metavar="HZ", type=float, default=0.0,
                         help="filter samples first, for sensors on soft tissue (default: no)")
    command.add_argument("--flat", metavar=("BEGIN", "END"), type=float, nargs=2,
                         help="seconds in which the hand rests flat, back upwards; gives sensors' rotations")
    command.add_argument("--side", choices=("left", "right"), default="right", help="hand (default: right)")
    command.add_argument("--markers", metavar="FILE", default="",
                         help="table of marker positions: time_s, and NAME_x, NAME_y, NAME_z in m")
    command.add_argument("--marker", metavar="NAME", default="",
                         help="marker whose arcs show the centre of rotation")
    command.add_argument("--arcs", metavar=("BEGIN", "END"), type=float, nargs=2,
                         help="seconds of these arcs on the markers' clock (default: the whole file)")
    command.add_argument("--sensor", metavar="NAME", default="",
                         help="sensor that moves with the marker; gives the clocks' offset (default: the "
                         "sensor of the marker's name)")
    command.add_argument("--rotation", metavar=("W", "X", "Y", "Z"), type=float, nargs=4,
                         help="rotation from the markers' frame to a frame with its origin in the centre")
    command.add_argument("--fixture", metavar="FILE", default="", help="table of the positions of resting "
                         "markers in the target frame; takes the place of --rotation")
    command.add_argument("--markers-out", metavar="FILE", default="",
                         help="write the markers in the target frame, on the sensors' clock")
    command.add_argument("--out", metavar="FILE", default="calibration.toml",
                         help="calibration file (default: calibration.toml)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_stream(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("stream", help="play a recording as a live stream (Lab Streaming Layer)")
    command.add_argument("recording", metavar="RECORDING",
                         help="a file of a known format, or hand: simulated sensors of a moving hand")
    command.add_argument("--name", default="imus", help="name of the stream (default: imus)")
    command.add_argument("--sensor-set", metavar="SET", help="set to play, where the file holds several")
    command.add_argument("--rate", metavar="HZ", help="play at another rate (default: as recorded)")
    command.add_argument("--loop", action="store_true", help="start again after the end")
    command.add_argument("--duration", metavar="SECONDS", type=float, help="end after this time")
    command.add_argument("--fault", metavar="KIND@START[+LENGTH][xVALUE]", action="append", default=[],
                         help="simulate a fault for a while, such as freeze@5+0.5; kinds: stop, vanish, "
                         "freeze, repeat, jump, clock, reorder, nan, rate")
    command.add_argument("--network", choices=("loopback", "lab"), default="loopback",
                         help="who may receive it: this machine (default), or other computers too")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_fit_error(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("fit-error", help="fit a tracker's error process to a recording with a "
                                  "reference")
    command.add_argument("recordings", metavar="RUN-OR-RECORDING", nargs="+",
                         help="a run (.h5) whose tracker is scored against a reference or the truth, or a "
                         "recording with a reference, to be played through hil_replay; several have one "
                         "process")
    command.add_argument("target", metavar="TARGET.toml", help="the file of the process")
    command.add_argument("--tracker", metavar="KIND", default="",
                         help="for a recording: its tracker (default: that of hil_replay; constrained for "
                         "the sensors of chain5)")
    command.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], dest="settings",
                         help="for a recording: change a key of hil_replay")
    command.add_argument("--reference-late", type=float, metavar="MS", default=0.0,
                         help="delay of the stamps of the recording's reference (default: 0)")
    command.add_argument("--seed", type=int, metavar="N", help="seed of the runs that validate it")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")
