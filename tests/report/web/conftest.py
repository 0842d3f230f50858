"""Pages opened in Debian's Chromium, from a file, without a network."""

import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from fesloop.show.report.page import write_page

_READBACK = "GPU stall due to ReadPixels"
"""What Chromium says of its own way to show a canvas without a graphics card."""


@dataclass(slots=True)
class Opened:
    """What has opened pages asked for and said."""

    requests: list[str] = field(default_factory=list)
    said: list[str] = field(default_factory=list)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """The browser. Without one, tests are skipped; where everything is checked (CI) they fail."""
    path = shutil.which("chromium")
    if path is None:
        reason = "no chromium on the PATH (Debian: apt-get install chromium)"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(reason)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path)
        yield browser
        browser.close()


@pytest.fixture
def opened(chromium: Any, tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Open a page (of parts) in the browser; afterwards nothing was asked for, and nothing went wrong."""
    heard = Opened()
    contexts = []

    def open_page(page: Any, width: int = 1280, scheme: str = "light", **options: Any) -> Any:
        path = tmp_path / "page.html"
        write_page(page, path)
        context = chromium.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme,
                                       offline=True, **options)
        contexts.append(context)
        shown = context.new_page()
        shown.set_default_timeout(15_000)
        shown.on("request", lambda request: heard.requests.append(request.url))
        shown.on("console", lambda message: heard.said.append(f"{message.type}: {message.text}"))
        shown.on("pageerror", lambda error: heard.said.append(f"error: {error}"))
        shown.goto(path.as_uri())
        shown.wait_for_load_state("load")
        return shown

    yield open_page
    for context in contexts:
        context.close()
    itself = (tmp_path / "page.html").as_uri()
    asked = [url for url in heard.requests if not url.startswith(("data:", itself))]
    assert asked == []
    assert [text for text in heard.said if _READBACK not in text] == []
