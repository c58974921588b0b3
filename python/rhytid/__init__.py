"""Rhytid: from face scans and marker tracks to detailed facial animation.

>>> import rhytid
>>> face = rhytid.Face.open("face.toml")
>>> rig = face.solve()
>>> take = rhytid.Take.open("session.c3d", rig)
>>> animation = rig.play(take)
>>> animation[120].positions.shape
(26719, 3)
>>> animation.write("face.usd", strain=True)

Lengths are in the unit of the neutral mesh, in head space. Options are those of the program `rhytid`, with `_`
in place of `-`: `--fade-detail` is `fade_detail=True`. https://github.com/rhytid/rhytid/blob/main/docs/python.md
"""

from __future__ import annotations

import os as _os
import sys as _sys
import tempfile as _tempfile

from . import _commands, _rhytid
from ._commands import *
from ._commands import Result
from ._errors import (
    Cancelled,
    DeviceError,
    Error,
    FileError,
    InputError,
    InternalError,
    MissingFileError,
)
from ._picture import Picture, render
from ._rhytid import Animation, Animator, Face, Frame, LiveFrame, Receiver, Rig, Take

__version__: str = _rhytid.__version__

if _sys.platform == "linux":
    # Without it, libwayland writes lines that begin with “error:” when OpenGL's loader asks for a display.
    _os.environ.setdefault("XDG_RUNTIME_DIR", _tempfile.gettempdir())

# Drivers are tried in children, so that one that crashes does not end this process.
_rhytid.started_by([_sys.executable, "-S", _os.path.join(_os.path.dirname(__file__), "_start.py")])

#: The stages that `Animator.read` knows.
STAGES: tuple[str, ...] = tuple(_rhytid.stages())

__all__ = [
    "Animation",
    "Animator",
    "Cancelled",
    "DeviceError",
    "Error",
    "Face",
    "FileError",
    "Frame",
    "InputError",
    "InternalError",
    "LiveFrame",
    "MissingFileError",
    "Picture",
    "Receiver",
    "Result",
    "Rig",
    "STAGES",
    "Take",
    "render",
]
__all__ += _commands.__all__
