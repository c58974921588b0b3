"""The program `rhytid` without the rest of the package: the children in which drivers are tried run this file.

As it is started by its path, it finds `_rhytid` beside itself, whatever folder the user is in.
"""

import os
import sys

import _rhytid  # type: ignore[import-not-found]

_rhytid.started_by([sys.executable, "-S", __file__])
code = _rhytid.run(["rhytid", *sys.argv[1:]])
sys.stdout.flush()
# What libraries run at a process's exit might wait for drivers' threads.
os._exit(code)
