"""Files of moving pictures: MP4 (H.264) by PyAV, GIF by Pillow."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError

Picture = NDArray[np.uint8]
Write = Callable[[Path, Iterable[Picture], Fraction], None]
_QUALITY = "18"
"""Constant rate factor of H.264 (chosen: no loss is visible on a projector)."""
_GIF_COLOURS = 128
_GIF_TICKS_HZ = 100
"""A GIF counts time in hundredths of a second."""
FASTEST_HZ = {".mp4": 120, ".gif": 50}
"""Most pictures a second, by suffix; browsers slow down quicker GIFs."""


def writer_of(out: Path) -> Write:
    """Function that writes pictures (height, width, 3) to a file of this name, at a number a second.

    Raises InputError for another suffix, or if the library is not installed.
    """
    suffix = out.suffix.lower()
    if suffix == ".gif":
        return _write_gif
    if suffix != ".mp4":
        raise InputError(f"--out {out}", f"{suffix or 'no suffix'} is no format of films", ".mp4 or .gif",
                         f"name it {out.with_suffix('.mp4').name}")
    try:
        import av  # noqa: F401
    except ImportError:
        raise InputError(f"--out {out}", "PyAV, which writes MP4, is not installed",
                         "the extra film, or a name that ends in .gif",
                         "pip install 'fesloop[film]'") from None
    return _write_mp4


def _write_mp4(path: Path, pictures: Iterable[Picture], fps: Fraction) -> None:
    """Write H.264 in the form that slides and browsers play."""
    import av

    if "libx264" not in av.codecs_available:
        raise RunError("this build of PyAV has no encoder of H.264 (libx264); reinstall av from PyPI, "
                       "or write a .gif")
    with av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"}) as file:
        stream = file.add_stream("libx264", rate=fps, options={"crf": _QUALITY, "preset": "medium"})
        stream.pix_fmt = "yuv420p"
        for number, picture in enumerate(pictures):
            if number == 0:
                stream.height, stream.width = picture.shape[:2]
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        file.mux(stream.encode(None))


def _write_gif(path: Path, pictures: Iterable[Picture], fps: Fraction) -> None:
    """Write a GIF that repeats for ever, one palette for each picture."""
    from PIL import Image

    def quantized() -> Iterator[Any]:
        for number, picture in enumerate(pictures):
            image = Image.fromarray(picture).quantize(_GIF_COLOURS, dither=Image.Dither.NONE)
            # Rounding the instants instead of the durations keeps the film in real time.
            ticks = [round((number + end) * _GIF_TICKS_HZ / fps) for end in (0, 1)]
            image.info["duration"] = 10 * (ticks[1] - ticks[0])
            yield image

    images = list(quantized())
    images[0].save(path, format="GIF", save_all=True, append_images=images[1:], loop=0, disposal=1,
                   duration=[image.info["duration"] for image in images])
