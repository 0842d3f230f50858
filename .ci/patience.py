"""Repeats commands that keep in step with the wall clock once where they fail."""


def patient(commands: str) -> str:
    """Lines of shell, each that runs in real time followed by a second try.

    A busy machine may stall for longer than the keeper of a stimulator waits, which then ends the run.
    """
    return "\n".join(f"{line} || {line.split(' & ')[-1]}" if _in_real_time(line) else line
                     for line in commands.split("\n"))


def _in_real_time(line: str) -> bool:
    return line.startswith("fesloop ") and " --realtime" in line and not line.endswith("\\")
