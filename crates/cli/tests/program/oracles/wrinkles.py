"""Computes wrinkle activations from a rig file and a take, by another way than Rhytid, and compares what files have with them.

    python wrinkles.py JOB

JOB is a JSON file with a list of `cases`. Each has `rig`, a rig file of the learned method; `take`, its CSV; `groups`, a dict of lists of
examples, or null for each example by itself; `first`, the take's frame that the file begins with; and `usd`, an animation with the primvars.
Printed for each: how many frames and channels there were, the largest activation, and how far off any is at most.

Here the system of a vertex is solved as a whole by NumPy, for all vertices at once, where Rhytid factorises each by itself.
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom


def safetensors(path):
    """The metadata and the arrays of a file: a length, a JSON header and raw arrays."""
    data = Path(path).read_bytes()
    begin = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:begin])
    about = json.loads(header.pop("__metadata__")["rhytid"])
    kinds = {"F32": np.float32, "U32": np.uint32}

    def array(entry):
        first, end = (begin + offset for offset in entry["data_offsets"])
        return np.frombuffer(data[first:end], kinds[entry["dtype"]]).reshape(entry["shape"])

    return about, {name: array(entry) for name, entry in header.items()}


class Rig:
    def __init__(self, path):
        self.about, get = safetensors(path)
        self.labels, self.examples = self.about["labels"], self.about["examples"]
        assert self.about["learned"]["wrinkle_strains"] == "vectors"
        rest, handles = get["rest"].astype(float), get["handles"]
        self.edges = get["strain_edges"]
        self.rest_handles = rest[handles]
        ends = self.rest_handles[self.edges]
        self.lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        self.poses = get["example_handles"].reshape(len(self.examples), -1, 3).astype(float)
        vertices, features = len(rest), len(self.edges) + len(handles)
        # ω as a whole matrix, V × features.
        self.weights = np.zeros((vertices, features))
        rows = np.arange(vertices)[:, None]
        np.add.at(self.weights, (rows, get["influence_edges"]), 0.9 * get["influence_weights"].astype(float))
        np.add.at(self.weights, (rows, len(self.edges) + get["anchors"]), get["anchor_weights"].astype(float))
        self.has_wrinkles = get["influence_weights"].max(axis=1) > 0
        self.vectors = np.stack([self.strains(pose) for pose in self.poses])
        reach = self.about["learned"].get("reach", np.inf)
        self.limits = reach * np.linalg.norm(self.vectors, axis=2).max(axis=0)
        # What the examples alone say: their lengths, V × P, and the system of each vertex.
        count, zero = len(self.vectors), np.zeros_like(self.vectors[0])
        self.example_lengths = np.stack([self.distances(vector, zero) for vector in self.vectors], axis=1)
        between = np.stack([[self.distances(a, b) for b in self.vectors] for a in self.vectors])
        lengths = self.example_lengths
        self.gram = lengths[:, :, None] + lengths[:, None, :] - np.moveaxis(between, 2, 0)
        self.trace = np.trace(self.gram, axis1=1, axis2=2)
        self.gram += (self.about["learned"]["wrinkle_ridge"] * self.trace / count)[:, None, None] * np.eye(count)

    def strains(self, pose):
        u = pose - self.rest_handles
        of_edges = (u[self.edges[:, 1]] - u[self.edges[:, 0]]) / self.lengths[:, None]
        return np.concatenate([of_edges, u / self.lengths.mean()])

    def distances(self, a, b):
        return np.sqrt(self.weights @ np.sum((a - b) ** 2, axis=1))

    def activations(self, pose):
        frame = self.strains(pose)
        size = np.linalg.norm(frame, axis=1)
        frame = frame * np.where(size > self.limits, self.limits / np.maximum(size, 1e-300), 1.0)[:, None]
        zero = np.zeros_like(frame)
        lengths = self.example_lengths
        of_frame = np.stack([self.distances(frame, vector) for vector in self.vectors], axis=1)
        right = self.distances(frame, zero)[:, None] + lengths - of_frame
        sound = self.has_wrinkles & (self.trace > 0)
        found = np.zeros(lengths.shape)
        found[sound] = np.linalg.solve(self.gram[sound], right[sound][..., None])[..., 0]
        # An example counts where it strains the skin; what has no wrinkles is not strained.
        lengths = lengths * self.has_wrinkles[:, None]
        most = np.sort(lengths, axis=0)[int(0.995 * len(lengths))]
        part = np.clip((lengths / most - 0.02) / 0.08, 0, 1)
        return found * part**2 * (3 - 2 * part)


def take(path, labels):
    with open(path, newline="") as f:
        rows = list(csv.DictReader(f))
    return np.array([[[float(row[f"{label}_{axis}"]) for axis in "xyz"] for label in labels] for row in rows], dtype=np.float32)


def name(text):
    return "wrinkle_" + "".join(c if c.isascii() and c.isalnum() else "_" for c in text)


def compare(case):
    rig = Rig(case["rig"])
    poses = take(case["take"], rig.labels)
    stage = Usd.Stage.Open(case["usd"])
    (mesh,) = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    groups = case["groups"] or {example: [example] for example in rig.examples}
    primvars = UsdGeom.PrimvarsAPI(mesh)
    codes = UsdGeom.Mesh(mesh).GetPointsAttr().GetTimeSamples()
    largest = worst = 0.0
    for k, code in enumerate(codes):
        each = rig.activations(poses[case["first"] + k].astype(float))
        for group, examples in groups.items():
            primvar = primvars.GetPrimvar(name(group))
            assert primvar.GetInterpolation() == "vertex" and str(primvar.GetTypeName()) == "float[]", group
            found = np.array(primvar.Get(code))
            expected = np.clip(sum(each[:, rig.examples.index(example)] for example in examples), 0, 1)
            worst = max(worst, float(np.max(np.abs(found - expected))))
            largest = max(largest, float(found.max()))
    return {"frames": len(codes), "channels": len(groups), "largest": largest, "worst": worst}


job = json.loads(Path(sys.argv[1]).read_text())
print(json.dumps([compare(case) for case in job["cases"]]))
