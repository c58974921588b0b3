"""Runs the tests in one Blender: the module `bpy`, with the extension installed from its zip as a user does.

    python run.py PACKAGE [test_file …]

PACKAGE is a folder that has the Python package `rhytid` with its compiled half.
"""

from __future__ import annotations

import os
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]


def main() -> int:
    package = Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        # Before bpy is imported: nothing of this user's Blender is read or written.
        os.environ["BLENDER_USER_RESOURCES"] = os.path.join(folder, "user")
        import support

        support.install(package, Path(folder))
        names = sys.argv[2:] or [path.stem for path in sorted(HERE.glob("test_*.py"))]
        tests = unittest.defaultTestLoader.loadTestsFromNames(names)
        result = unittest.TextTestRunner(verbosity=2).run(tests)
        print(f"{result.testsRun} tests, {len(result.skipped)} skipped")
    return 0 if result.wasSuccessful() and result.testsRun > 0 else 1


if __name__ == "__main__":
    # What libraries run at a process's exit might wait for drivers' threads.
    code = main()
    sys.stdout.flush()
    os._exit(code)
