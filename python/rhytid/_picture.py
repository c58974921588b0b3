"""Pictures of a rig that plays a take."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy

from . import _rhytid
from ._commands import COMMANDS, Files, Result
from ._progress import Progress


class Picture:
    """A picture. A notebook shows it; `numpy.asarray` gives its pixels."""

    def __init__(self, png: bytes, result: Result) -> None:
        self._png = png
        #: What `rhytid render --json` prints.
        self.result = result

    @property
    def array(self) -> "numpy.ndarray[Any, numpy.dtype[numpy.uint8]]":
        """Height × width × 4: red, green, blue and opacity, 0 to 255."""
        height, width, pixels = _rhytid.decode_png(self._png)
        return numpy.frombuffer(pixels, numpy.uint8).reshape(height, width, 4)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture as PNG."""
        Path(path).write_bytes(self._png)

    def _repr_png_(self) -> bytes:
        return self._png

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        return self.array if dtype is None else self.array.astype(dtype)

    def __repr__(self) -> str:
        height, width, _ = self.array.shape
        return f"<rhytid.Picture: {width} × {height}>"


def render(rig: Any, take: Any, *, output: Any = None, progress: Progress = None, **options: Any) -> Any:
    """Draws frames of a take. Without `output`, returns a `Picture`: a sheet of frames.

    With `output`, writes the picture or film, and returns what `rhytid render --json` prints. The options are
    those of `rhytid render`.
    """
    if output is not None:
        return COMMANDS["render"](rig, take, output=output, progress=progress, **options)
    with Files("render") as files:
        path = files.path(".png")
        result = COMMANDS["render"](rig, take, output=path, progress=progress, **options)
        return Picture(path.read_bytes(), result)
