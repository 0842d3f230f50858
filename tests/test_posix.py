"""What is tied to Linux is behind one module: no other names it, and without it the rest works."""

import ast
import os
import subprocess
import sys

import pytest
from house import ROOT, modules

from fesloop.apps.cli import main
from fesloop.posix import is_linux

MODULES = frozenset((
    "crypt", "fcntl", "grp", "posix", "pty", "pwd", "readline", "resource", "syslog", "termios", "tty"))
OF = {
    "os": {
        "O_CLOEXEC", "O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "WNOHANG", "chown", "eventfd", "fchmod",
        "fchown", "fork", "forkpty", "getegid", "geteuid", "getgid", "getgroups", "getloadavg", "getpgid",
        "getpriority", "getsid", "getuid", "killpg", "lchown", "memfd_create", "mkfifo", "mknod", "mlock",
        "mlockall", "nice", "openpty", "pidfd_open", "pipe2", "posix_fadvise", "posix_fallocate",
        "posix_spawn", "pread", "preadv", "pwrite", "pwritev", "sendfile", "set_blocking", "setgid",
        "setpgid", "setpriority", "setsid", "setuid", "statvfs", "sysconf", "ttyname", "uname", "wait",
        "wait3", "wait4", "waitid", "waitpid"},
    "signal": {
        "SIGALRM", "SIGCHLD", "SIGCONT", "SIGHUP", "SIGKILL", "SIGPIPE", "SIGQUIT", "SIGRTMIN", "SIGSTOP",
        "SIGTTIN", "SIGTTOU", "SIGUSR1", "SIGUSR2", "SIGXCPU", "alarm", "pause", "pthread_kill",
        "pthread_sigmask", "setitimer", "siginterrupt", "sigtimedwait", "sigwait"},
    "select": {
        "devpoll", "epoll", "kqueue", "poll"},
    "socket": {
        "AF_UNIX", "MSG_DONTWAIT", "SCM_RIGHTS", "SOCK_SEQPACKET", "recv_fds", "send_fds"}}
ARGUMENTS = frozenset(("pass_fds", "preexec_fn", "process_group", "extra_groups", "umask"))
PATHS = ("/proc", "/dev/", "/sys/", "/etc/", "/tmp")
STARTS = ("fork", "forkserver")
"""Start methods of processes; all others are spawned, as there is nothing else on Windows."""
THE_MODULE = "fesloop.posix"
OF_LINUX = {"plants.devices.keeper", "plants.devices.kept_device", "plants.devices.messages",
            "plants.devices.science_mode_line", "plants.fmu.own_process", "fesloop.apps.bench.realtime",
            "fesloop.apps.bench.shipped", "fesloop.apps.bench._study_runs", "fesloop.apps.bench.view"}
"""Modules that need Linux as a whole, reached after `require_linux` or `is_linux` alone."""


def tied(path):
    """Lines of a module that name what only POSIX has."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        found = ""
        if isinstance(node, ast.Import):
            found = " ".join(each.name for each in node.names if each.name.partition(".")[0] in MODULES)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = {each.name for each in node.names}
            found = node.module if node.module in MODULES else " ".join(names & OF.get(node.module, set()))
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            known = OF.get(node.value.id, ())
            if node.attr in known or (known and node.attr.lower().startswith("sched_")):
                found = f"{node.value.id}.{node.attr}"
        elif isinstance(node, ast.keyword) and node.arg in ARGUMENTS:
            found = f"{node.arg}="
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and (
                (node.value.startswith(PATHS) and "\n" not in node.value) or node.value in STARTS):
            found = repr(node.value)
        if found:
            yield f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', '')}: {found}"


def test_one_module_names_what_only_posix_has():
    known = modules()
    assert {THE_MODULE, *OF_LINUX} <= known.keys()
    found = [line for name, path in known.items() if name not in (THE_MODULE, *OF_LINUX)
             for line in tied(path)]
    assert not found, "\n".join(found)
    unneeded = [name for name in (THE_MODULE, *OF_LINUX) if not list(tied(known[name]))]
    assert unneeded == [], "these are not tied to Linux any more"


@pytest.mark.parametrize("line", [
    "import fcntl", "import resource as r", "from termios import tcflush", "import os\nos.fork()",
    "from os import fork", "import os\nos.sched_yield()", "import signal\nx = signal.SIGALRM",
    "f(pass_fds=[3])", "open('/proc/self/stat')", "get_context('fork')", "import select\nselect.poll()"])
def test_what_is_tied_to_posix_is_found(line, tmp_path, monkeypatch):
    monkeypatch.setattr(f"{__name__}.ROOT", tmp_path)
    (tmp_path / "a.py").write_text(line + "\n")
    assert len(list(tied(tmp_path / "a.py"))) == 1


def test_every_process_is_spawned():
    for name, path in modules().items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Call):
                continue
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called in ("get_context", "set_start_method"):
                assert [each.value for each in node.args] == ["spawn"], name
            if called == "ProcessPoolExecutor":
                assert "mp_context" in {each.arg for each in node.keywords}, name
            if getattr(getattr(node.func, "value", None), "id", "") == "multiprocessing":
                assert called not in ("Process", "Pool", "Queue", "Pipe"), name


def test_modules_of_linux_are_imported_by_each_other_or_late():
    known = modules()
    for name in known.keys() - OF_LINUX:
        early = [each for each in ast.parse(known[name].read_text(encoding="utf-8")).body
                 if isinstance(each, ast.ImportFrom)]
        for target in {each.module for each in early} & OF_LINUX:
            # Two can be imported anywhere: they call what Linux has while a device is open. Benches are asked
            # for by `fesloop bench`, which refuses these.
            assert target in ("plants.devices.messages", "plants.devices.kept_device") \
                or name.startswith("fesloop.apps.bench."), (name, target)


_PYTHONS = ("waitpid", "WNOHANG", "set_blocking", "uname", "getuid", "geteuid", "statvfs", "sendfile")
"""What Python's own library, made for this system, calls."""
ELSEWHERE = f"""
import os, select, signal, socket, subprocess, sys, tempfile, multiprocessing.resource_tracker, asyncio
import multiprocessing.connection, concurrent.futures.process
for name in {sorted(MODULES - {"posix", "pwd", "grp", "readline"})!r}:
    sys.modules[name] = None
for module, names in ((os, {sorted(OF["os"])!r}), (signal, {sorted(OF["signal"] - {"SIGKILL"})!r}),
                      (select, {sorted(OF["select"])!r}),
                      (socket, ["AF_UNIX", "SOCK_SEQPACKET", "MSG_DONTWAIT"])):
    for name in [*names, *(each for each in dir(os) if each.lower().startswith("sched_") and module is os)]:
        if hasattr(module, name) and name not in {_PYTHONS!r}:
            delattr(module, name)
import fesloop.posix
class Windows:
    platform = "win32"
fesloop.posix.sys = Windows
from fesloop.apps.cli import main
"""
"""Takes away what Windows lacks."""


@pytest.mark.skipif(not is_linux(), reason="takes away what Linux has")
@pytest.mark.parametrize(("commands", "said"), [
    ([["run", "finger_control", "--set", "experiment.duration_s=1"], ["report", "runs/finger_control-1.h5"],
      ["export", "runs/finger_control-1.h5", "--format", "csv", "--out", "csv"],
      ["export", "finger_control", "--block", "controller", "--format", "c", "--out", "c"]], ""),
    ([["run", "hil_error_replay", "--realtime", "--priority", "3", "--set", "tracker=ideal", "--set",
       "experiment.duration_s=1"]], "refused: win32 has no SCHED_FIFO"),
    ([["import", "lab.csv", "lab.h5", "--layout", "layout.toml"],
      ["run", "replay", "--set", "recording=lab.h5"]], ""),
    pytest.param([["fmu", "build", "--out", "models"], ["run", "finger_fmu", "--set", "fmu=models/finger.fmu",
                                                       "--set", "experiment.duration_s=2"]], "",
                 marks=pytest.mark.slow),
    ([["run", "hil_dry_stimulator", "--realtime"]], "blocks.device: the process that holds a stimulator "
     "needs Linux, and this is win32; allowed: Linux; run it on"),
    ([["bench", "realtime"]], "bench realtime: what it measures needs Linux")])
def test_without_what_only_linux_has_commands_work_or_say_so_in_one_line(commands, said, tmp_path):
    rows = "\n".join(",".join(["0", "0", "0", "0", "0", "9.81"] * 2) for _ in range(60))
    (tmp_path / "lab.csv").write_text(rows + "\n")
    (tmp_path / "layout.toml").write_text(
        'rate = 50\npairs = [["a", "b"]]\n[sensors.a]\ngyr = [1, 2, 3]\nacc = [4, 5, 6]\n'
        "[sensors.b]\ngyr = [7, 8, 9]\nacc = [10, 11, 12]\n")
    for command in commands:
        path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
        done = subprocess.run([sys.executable, "-c", f"{ELSEWHERE}sys.exit(main({command!r}))"], cwd=tmp_path,
                              capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONPATH": path})
        refused = said and not said.startswith("refused")
        assert (done.returncode == 2) == bool(refused), done.stderr[-2000:]
        assert done.returncode in (0, 2), done.stderr[-2000:]
        assert "Traceback" not in done.stderr
        if refused:
            assert len(done.stderr.splitlines()) == 1
        assert said in " ".join((done.stderr + done.stdout).split())


def test_an_fmu_that_is_to_be_isolated_is_refused_elsewhere(capsys, monkeypatch):
    monkeypatch.setattr("fesloop.posix.is_linux", lambda: False)
    assert main(["check", "finger_fmu", "--set", "blocks.finger.isolate=true"]) == 2
    assert "isolate: a process of the FMU's own needs Linux" in capsys.readouterr().err
