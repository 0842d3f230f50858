"""What follows the pages of docs/ writes what they name, runs what they run, and says where one fails."""

import subprocess
import sys
from pathlib import Path

RUNNER = Path(__file__).resolve().parents[1] / ".ci" / "docs.py"
PAGE = """# A page

`notes/a.txt`

```text
seven
```

```sh
cat notes/a.txt > copy.txt
```

```console
$ false
```

```python
from pathlib import Path

assert Path("copy.txt").read_text() == "seven\\n"
print("as it should be")
```
"""


def follow(page, text):
    page.write_text(text)
    return subprocess.run([sys.executable, RUNNER, page], capture_output=True, text=True, timeout=60)


def test_files_are_written_and_what_is_to_be_run_is_run_in_order(tmp_path):
    done = follow(tmp_path / "page.md", PAGE)
    assert done.returncode == 0, done.stderr
    assert "page.md: ok" in done.stdout
    assert sorted(each.name for each in tmp_path.iterdir()) == ["page.md"]


def test_a_page_ends_where_a_command_fails_and_says_which(tmp_path):
    done = follow(tmp_path / "page.md", PAGE.replace("cat notes/a.txt", "cat notes/b.txt"))
    assert done.returncode == 1
    assert "page.md: failed in" in done.stderr
    assert "cat notes/b.txt > copy.txt" in done.stderr
    assert "b.txt: No such file" in done.stderr, "what was printed before it"
    assert "as it should be" not in done.stderr


def test_other_pages_are_followed_where_one_fails(tmp_path):
    sound, bad = tmp_path / "sound.md", tmp_path / "bad.md"
    sound.write_text(PAGE)
    bad.write_text("```sh\nfalse\n```\n")
    done = subprocess.run([sys.executable, RUNNER, bad, sound], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "sound.md: ok" in done.stdout
    assert "bad.md: failed in\nfalse" in done.stderr


def test_what_runs_in_real_time_gets_a_second_try(tmp_path):
    folder = tmp_path / ".ci"
    folder.mkdir()
    for name in ("docs.py", "patience.py"):
        (folder / name).write_text((RUNNER.parent / name).read_text())
    page = tmp_path / "page.md"
    page.write_text("```sh\nfesloop() { test -e tried || ! touch tried; }\nfesloop run a --realtime\n```\n")
    follow = [sys.executable, str(folder / "docs.py"), str(page)]
    assert subprocess.run(follow).returncode == 0
    page.write_text("```sh\nfesloop() { test -e tried || ! touch tried; }\nfesloop run a\n```\n")
    assert subprocess.run(follow).returncode == 1
