"""A face as the measurements need it: a neutral, examples, markers, and poses with a known truth."""

import csv
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Pose:
    """All vertices of the neutral somewhere else, V×3 in mesh units."""

    name: str
    positions: np.ndarray


@dataclass
class Face:
    """A head of the table. Everything is in mesh units."""

    name: str
    metres_per_unit: float
    rest: np.ndarray
    # The lines of an OBJ file that say how the vertices are joined.
    joined: list[str]
    # The vertices of the markers by their labels, at most 89.
    markers: dict[str, int]
    # In the order in which they are used.
    examples: list[Pose]
    # Poses that nobody scanned; the rig is measured on them.
    unseen: list[Pose] = field(default_factory=list)
    # What the unseen poses are: a capture, mixtures of the examples.
    unseen_are: str = ""


def read_obj(path):
    """The positions of an OBJ file, and its other lines."""
    positions, joined = [], []
    for line in Path(path).read_text().splitlines():
        if line.startswith("v "):
            positions.append([float(x) for x in line.split()[1:4]])
        elif line.startswith(("vt ", "f ", "g ", "o ")):
            joined.append(line)
    return np.array(positions), joined


def read_positions(path):
    return read_obj(path)[0]


def write_obj(path, positions, joined):
    with open(path, "w") as out:
        out.writelines("v {:.9g} {:.9g} {:.9g}\n".format(*x) for x in positions)
        out.writelines(line + "\n" for line in joined)


def read_markers(path):
    with open(path, newline="") as rows:
        return {row["label"]: int(row["vertex"]) for row in csv.DictReader(rows)}


def spread(positions, candidates, count, first=()):
    """The `count` farthest points: each is the candidate that is farthest from all before it."""
    chosen = list(first) or [candidates[0]]
    nearest = np.full(len(candidates), np.inf)
    for v in chosen:
        nearest = np.minimum(nearest, np.linalg.norm(positions[candidates] - positions[v], axis=1))
    while len(chosen) < count:
        chosen.append(candidates[int(np.argmax(nearest))])
        to_last = np.linalg.norm(positions[candidates] - positions[chosen[-1]], axis=1)
        nearest = np.minimum(nearest, to_last)
    return chosen


def fewer_markers(face, count):
    """`count` of the face's markers, spread over it."""
    labels = list(face.markers)
    places = face.rest[[face.markers[label] for label in labels]]
    return [labels[i] for i in spread(places, list(range(len(labels))), count)]


def unlike_first(rest, vertices, poses):
    """The poses in the order in which they add most: each is farthest from rest and from all before it."""
    at = np.array([pose.positions[vertices] for pose in poses])
    nearest = np.linalg.norm(at - rest[vertices], axis=(1, 2))
    ordered = []
    for _ in poses:
        best = int(np.argmax(nearest))
        ordered.append(poses[best])
        nearest = np.minimum(nearest, np.linalg.norm(at - at[best], axis=(1, 2)))
        nearest[best] = -1
    return ordered
