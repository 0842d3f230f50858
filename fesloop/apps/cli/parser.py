"""The commands and their options."""

from __future__ import annotations

import argparse
from typing import NoReturn

from fesloop.errors import in_one_line

EPILOG = """exit codes: 0 done, 1 the run failed, 2 bad input, 130 interrupted

EXPERIMENT is the name of a shipped experiment (fesloop list), the path of a .toml file, or that of a
recording, which is then repeated."""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, as all of fesloop's."""

    def error(self, message: str) -> NoReturn:
        """End with exit code 2."""
        self.exit(2, f"fesloop: {in_one_line(message)}; {self.prog} --help shows what there is\n")


def make_parser() -> argparse.ArgumentParser:
    """The parser of `fesloop`."""
    parser: argparse.ArgumentParser = _Parser(
        prog="fesloop", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Closed-loop co-simulation of functional electrical stimulation of the hand.")
    parser.add_argument("--version", action=_Version)
    parser.add_argument("--traceback", action="store_true", help="show where an internal error arose")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    _add_list(commands)
    _add_check(commands)
    _add_run(commands)
    _add_study(commands)
    _add_report(commands)
    _add_picture(commands)
    _add_view(commands)
    _add_import(commands)
    _add_export(commands)
    _add_reproduce(commands)
    _add_bench(commands)
    commands.add_parser("schema", help="print the JSON Schema of experiment files")
    _add_fmu(commands)
    _add_patient(commands)
    _add_identify(commands)
    _add_fit_error(commands)
    _add_stream(commands)
    return parser


class _Version(argparse.Action):
    """Look the version up only when asked for."""

    def __init__(self, option_strings: list[str], dest: str) -> None:
        super().__init__(option_strings, dest, nargs=0, help="print the version")

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"fesloop {version('fesloop')}")
        parser.exit()


_Commands = argparse._SubParsersAction  # the type has no public name


def _add_list(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("list", help="shipped experiments and block kinds, a line each")
    command.add_argument("--json", action="store_true", help="print one JSON object")


def _add_experiment(command: argparse.ArgumentParser) -> None:
    command.add_argument("experiment", metavar="EXPERIMENT", help="name or path")
    command.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], dest="settings",
                         help="change a key of the file, such as blocks.pid.kp=0.5, or what it has a "
                         "short name for: an alias, or an option of a variant (fesloop check shows them)")
    command.add_argument("--seed", type=int, metavar="N", help="take the place of the file's seed")
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
    command.add_argument("--late", choices=("catch-up", "skip", "stop"), help="in real time, what becomes of "
                         "ticks that are late (default: catch-up)")
    command.add_argument("--priority", type=int, metavar="N", help="in real time, ask for the scheduling "
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
                         help="say how many runs, how long, how much disk, and run none but a few to know")
    command.add_argument("--retry-failed", action="store_true", help="run failed ones again")
    command.add_argument("--mix-versions", action="store_true",
                         help="go on with results of other code or libraries")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_report(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("report", help="a run, several side by side, or a study as one HTML file")
    command.add_argument("sources", metavar="RUN-OR-STUDY", nargs="+",
                         help="files that fesloop run wrote; or a study: its folder or study.sqlite")
    command.add_argument("--out", metavar="FILE", help="the page (default: beside what it is of, such as "
                         "runs/grasp_ilc-1.html)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_picture(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("picture", help="draw the hand, the arrays and time courses of a recording")
    command.add_argument("recording", metavar="RUN.h5", help="a file that fesloop run wrote")
    command.add_argument("--at", metavar="SECONDS", type=float, nargs="+", default=[],
                         help="instants to draw (default: up to four whose postures differ most)")
    command.add_argument("--trial", type=int, metavar="N", help="counted from 0 (default: the last)")
    command.add_argument("--out", metavar="DIR", default="pictures",
                         help="folder of the pictures (default: pictures)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_view(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("view", help="watch the hand of a recording, a running loop or a stream")
    command.add_argument("source", metavar="RUN.h5", nargs="?",
                         help="a file that fesloop run wrote, or is writing")
    command.add_argument("--stream", metavar="NAME", help="in its place a live stream (Lab Streaming Layer) "
                         "of joint angles or of segments' orientations")
    command.add_argument("--side", choices=("left", "right"),
                         help="of the hand that a stream is of (default: right)")
    command.add_argument("--network", choices=("loopback", "lab"),
                         help="where the stream comes from: this machine (default), or other computers too")
    command.add_argument("--port", type=int, metavar="N", default=0, help="of the page (default: a free one)")
    command.add_argument("--open", action="store_true", help="open a browser")


def _add_import(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("import", help="write a recording of inertial sensors as a motion file")
    command.add_argument("source", metavar="SOURCE",
                         help="XDF, Motion-BIDS (folder or *_motion.tsv), MATLAB 5 or 7.3, .npz, a table")
    command.add_argument("target", metavar="TARGET", help="the file to write, such as motion.h5")
    command.add_argument("--layout", metavar="FILE",
                         help="what stands where in SOURCE, for files that do not say it themselves")
    command.add_argument("--sensor-set", metavar="NAME",
                         help="which sensors, where SOURCE holds several sets: streams of XDF, or tracking "
                         "systems of Motion-BIDS, with commas between")
    command.add_argument("--resample", metavar="HZ",
                         help="bring streams of sensors on different clocks to common instants at this rate")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_export(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("export", help="write a recording as files of other tools")
    command.add_argument("recording", metavar="RUN.h5", help="a file that fesloop run wrote")
    command.add_argument("--format", required=True, metavar="FORMAT",
                         help="motion-bids, xdf, mat, mot, sto or csv")
    command.add_argument("--trial", type=int, metavar="N", help="counted from 0 (default: all)")
    command.add_argument("--signals", metavar="A.B,C.D",
                         help="names (default: all that the format is for)")
    command.add_argument("--out", metavar="PATH",
                         help="folder to be made, or, for one file, its name (default: exports/RUN-FORMAT)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_reproduce(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("reproduce", help="a paper's experiments on virtual subjects")
    command.add_argument("paper", metavar="PAPER",
                         help="kortier2014, salchow2019; our own claims: hour, array_search, grasp_ilc, "
                         "grasp_trackers, grasp_mpc, linear_theory, error_replay")
    command.add_argument("--subjects", type=int, metavar="N", help="how many (default: the full cohort)")
    command.add_argument("--workers", type=int, metavar="N", help="processes (default: one a core)")
    command.add_argument("--out", metavar="DIR", default="reproduced",
                         help="folder of tables and figures (default: reproduced)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_bench(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("bench", help="measure every speed claim, here and now")
    command.add_argument("name", metavar="NAME", nargs="?", help="one bench (default: all)")
    command.add_argument("--short", action="store_true", help="the short form of benches that have one")
    command.add_argument("--priority", type=int, metavar="N", default=0, help="of benches in real time: "
                         "as of fesloop run (default: none)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_fmu(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("fmu", help="plants as FMUs")
    verbs = command.add_subparsers(dest="verb", metavar="VERB", required=True)
    build = verbs.add_parser("build", help="write a plant as an FMU (source, and binary with a compiler)")
    build.add_argument("plant", metavar="PLANT", nargs="?", default="finger", help="default: finger")
    build.add_argument("--out", metavar="DIR", default=".", help="folder of the FMU (default: here)")
    build.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_patient(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("patient", help="print a patient, drawn from a preset, as a file")
    command.add_argument("file", metavar="PATIENT", help="a preset (fesloop list), or a .toml file")
    command.add_argument("--cohort", type=int, metavar="SEED", help="which cohort (default: 0)")
    command.add_argument("--member", type=int, metavar="N", help="which member of it (default: the preset)")
    command.add_argument("--day", type=int, metavar="N", help="which day (default: none in particular)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_identify(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("identify", help="a patient's model for controllers, from a recording")
    command.add_argument("recording", metavar="RUN.h5", help="of an identification experiment, such as "
                         "identify_patient")
    command.add_argument("--out", metavar="FILE", default="model.toml",
                         help="the model file (default: model.toml)")
    command.add_argument("--measured", metavar="SIGNAL", default="",
                         help="what is to be predicted (default: that of the block of kind synergies)")
    command.add_argument("--method", choices=("subspace", "fir"), default="subspace",
                         help="of the linear dynamics (default: subspace)")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_stream(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("stream", help="play a recording as a live stream (Lab Streaming Layer)")
    command.add_argument("recording", metavar="RECORDING",
                         help="a file of a known format, or hand: sensors of a hand that moves, computed")
    command.add_argument("--name", default="imus", help="of the stream (default: imus)")
    command.add_argument("--sensor-set", metavar="SET", help="which, where the file holds several")
    command.add_argument("--rate", metavar="HZ", help="play at another rate (default: as recorded)")
    command.add_argument("--loop", action="store_true", help="begin anew after the end")
    command.add_argument("--duration", metavar="SECONDS", type=float, help="end after so long")
    command.add_argument("--fault", metavar="KIND@START[+LENGTH][xVALUE]", action="append", default=[],
                         help="go wrong for a while, such as freeze@5+0.5; kinds: stop, vanish, freeze, "
                         "repeat, jump, clock, reorder, nan, rate")
    command.add_argument("--network", choices=("loopback", "lab"), default="loopback",
                         help="who may hear it: this machine (default), or other computers too")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")


def _add_fit_error(commands: _Commands[argparse.ArgumentParser]) -> None:
    command = commands.add_parser("fit-error", help="a tracker's error as a process, from a recording with a "
                                  "reference")
    command.add_argument("recording", metavar="RUN-OR-RECORDING", help="a run (.h5) whose tracker is scored "
                         "against a reference or the truth, or a recording with a reference, to be played "
                         "through hil_replay")
    command.add_argument("target", metavar="TARGET.toml", help="the file of the process")
    command.add_argument("--tracker", metavar="KIND", default="",
                         help="of a recording: what tracks it (default: that of hil_replay; constrained for "
                         "the sensors of chain5)")
    command.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], dest="settings",
                         help="of a recording: change a key of hil_replay")
    command.add_argument("--reference-late", type=float, metavar="MS", default=0.0,
                         help="by how much the stamps of the recording's reference are late")
    command.add_argument("--seed", type=int, metavar="N", help="of the runs by which it is judged")
    command.add_argument("--json", action="store_true", help="print one JSON object on standard output")
