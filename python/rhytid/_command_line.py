"""The script `rhytid`, and `python -m rhytid`."""

from __future__ import annotations

import os
import sys

from . import _rhytid


def main() -> None:
    """Runs the program with this process's words, and ends the process."""
    code = _rhytid.run(["rhytid", *sys.argv[1:]])
    sys.stdout.flush()
    # What libraries run at a process's exit might wait for drivers' threads.
    os._exit(code)
