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


def beside(face, labels):
    """Points of the skin 1 to 2 mm beside the markers, or as far as the faces around a vertex go.

    Each is three corners of a face, the marker's vertex first, and their weights.
    """
    faces = [[int(corner.split("/")[0]) - 1 for corner in line.split()[1:]] for line in face.joined if line[:2] == "f "]
    around = {}
    for corners in faces:
        for i, v in enumerate(corners):
            around.setdefault(v, []).append((v, corners[(i + 1) % len(corners)], corners[i - 1]))
    numbers, unit, points = np.random.default_rng(11), 1e-3 / face.metres_per_unit, {}
    for label in labels:
        there = around[face.markers[label]]
        corners = there[numbers.integers(len(there))]
        a, b, c = face.rest[list(corners)]
        part = numbers.random()
        way = part * (b - a) + (1 - part) * (c - a)
        far = min(numbers.uniform(1, 2) * unit / np.linalg.norm(way), 0.9)
        points[label] = (corners, (1 - far, far * part, far * (1 - part)))
    return points


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


def flawed(face, pose, noise, slide):
    """A pose as a scanner would give it: noise of each vertex, and vertices that slid over the skin.

    Both are in millimetres. The slide is smooth: the sum of a few waves over the face, without its part along the
    normal of the skin.
    """
    numbers = np.random.default_rng(sum(pose.name.encode()))
    unit = 1e-3 / face.metres_per_unit
    size = np.ptp(face.rest, axis=0).max()
    moved = np.zeros_like(face.rest)
    for _ in range(6):
        wave, phase = numbers.standard_normal(3) * 6 / size, numbers.uniform(0, 2 * np.pi)
        moved += np.sin(face.rest @ wave + phase)[:, None] * numbers.standard_normal(3)
    normals = vertex_normals(pose.positions, face.joined)
    moved -= np.sum(moved * normals, axis=1, keepdims=True) * normals
    moved *= slide * unit / np.sqrt(np.mean(np.sum(moved**2, axis=1)))
    moved += noise * unit * numbers.standard_normal(moved.shape)
    return Pose(pose.name, pose.positions + moved)


def vertex_normals(positions, joined):
    """The normal of each vertex, from the first three corners of the faces around it."""
    faces = [line.split()[1:4] for line in joined if line.startswith("f ")]
    corners = np.array([[int(corner.split("/")[0]) - 1 for corner in face] for face in faces])
    a, b, c = positions[corners].transpose(1, 0, 2)
    normals = np.zeros_like(positions)
    np.add.at(normals, corners, np.cross(b - a, c - a)[:, None])
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
