"""Commands that keep in step with the wall clock, tried once more where they fail."""


def patient(commands: str) -> str:
    """Lines of shell in which what runs in real time gets a second try.

    A machine that does other things as well may stall for longer than a stimulator's keeper waits, which then
    ends the run, rightly.
    """
    return "\n".join(f"{line} || {line.split(' & ')[-1]}" if _in_real_time(line) else line
                     for line in commands.split("\n"))


def _in_real_time(line: str) -> bool:
    return line.startswith("fesloop ") and " --realtime" in line and not line.endswith("\\")
