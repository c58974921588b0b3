"""What each client in Python shares: a job comes in, and what was read of each file goes out.

    python with_NAME.py JOB

JOB is a JSON file: `files`, `rate` (frames per second), `frames` (how many) and `out`, a folder. A line of JSON is
printed for each file: `file`, its place in the list, and either an `error` or what was read. `out`/N.f64 gets the
positions and `out`/N.normals.f64 the normals, frames × vertices × 3 float64.
"""

import json
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Read:
    # Frames × vertices × 3 in metres, in the client's world.
    positions: np.ndarray
    # The same of normals, of any length.
    normals: np.ndarray | None = None
    # Each with `name`, `colour` (linear) and `texture`, the width and height of an image that was decoded.
    materials: list = field(default_factory=list)
    up: str = "Y"


def run(version, read):
    """Reads every file of the job with `read(path, job)`."""
    job = json.loads(Path(sys.argv[1]).read_text())
    for number, file in enumerate(job["files"]):
        try:
            found = read(Path(file), job)
            positions = np.asarray(found.positions, np.float64)
            if positions.ndim != 3 or positions.shape[1] == 0:
                raise ValueError("no vertices")
            line = {"up": found.up, "frames": len(positions), "vertices": positions.shape[1]}
            line |= {"materials": found.materials, "normals": found.normals is not None}
            positions.tofile(Path(job["out"]) / f"{number}.f64")
            if found.normals is not None:
                np.asarray(found.normals, np.float64).tofile(Path(job["out"]) / f"{number}.normals.f64")
        except Exception as error:
            # Clients fail in many ways on what they do not know.
            line = {"error": f"{type(error).__name__}: {error}".strip().splitlines()[0][:200]}
        print(json.dumps({"file": number, "version": version, **line}), flush=True)
