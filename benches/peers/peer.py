"""What the peers in Python share: a rig's arrays, and the conversation with the program that times them.

A peer is started with a folder that holds the rig's arrays and `handles` (frames x H x 3), each as a .npy file. It
evaluates the first frame and then the batch of all, which also warms it up, writes what came out beside the arrays,
and prints one line of JSON that says what it is. From then on, each line it reads, `frame` or `batch`, is answered by
one line of JSON: the milliseconds of one more evaluation, by part.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np


class Rig:
    """A rig's arrays, in the shapes of docs/rig-file.md, and what every peer makes of them before any frame."""

    def __init__(self, folder):
        for path in folder.glob("*.npy"):
            setattr(self, path.stem, np.load(path))
        self.vertices, self.influences = self.influence_edges.shape
        self.rest_lengths = self.edge_lengths(self.handle_rest[None])[0]

    def edge_lengths(self, handles):
        """Frames x F, in float64: there are few edges, and strain is a small difference of lengths."""
        ends = handles.astype(np.float64)[:, self.strain_edges]
        return np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=-1)

    def squared_differences(self, handles):
        """Frames x F x N: (f - f_j)^2 depends on frame, edge and centre alone."""
        features = (self.edge_lengths(handles) - self.rest_lengths) / self.rest_lengths
        differences = features[:, :, None] - self.pose_features.T.astype(np.float64)
        return (differences * differences).astype(np.float32)


class Stopwatch:
    """The milliseconds of each part of an evaluation, and of all."""

    def __init__(self):
        self.start = self.last = time.perf_counter()
        self.parts = {}

    def lap(self, part):
        now = time.perf_counter()
        self.parts[part] = self.parts.get(part, 0.0) + (now - self.last) * 1e3
        self.last = now

    def total(self):
        return {**self.parts, "whole": (time.perf_counter() - self.start) * 1e3}


def serve(make_evaluate, name, detail):
    """`make_evaluate(rig)` gives a function from handles (frames x H x 3) and a stopwatch to the positions and
    normals of those frames, each frames x V x 3."""
    folder = Path(sys.argv[1])
    rig = Rig(folder)
    evaluate = make_evaluate(rig)
    handles = {"frame": rig.handles_over_time[:1], "batch": rig.handles_over_time}
    for what, frames in handles.items():
        positions, normals = evaluate(frames, Stopwatch())
        np.save(folder / f"{what}_positions.npy", positions)
        np.save(folder / f"{what}_normals.npy", normals)
    print(json.dumps({"name": name, "detail": detail}), flush=True)
    for line in sys.stdin:
        watch = Stopwatch()
        evaluate(handles[line.strip()], watch)
        print(json.dumps(watch.total()), flush=True)
