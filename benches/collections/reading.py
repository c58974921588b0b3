"""What a program read of a mesh, and whether two readings agree."""

from dataclasses import dataclass, field

import numpy as np


class Refused(Exception):
    """A reference cannot read a file."""


@dataclass
class Reading:
    # N×3.
    positions: np.ndarray
    # The corners of each face, then the vertex of each corner.
    counts: np.ndarray
    corners: np.ndarray
    # Of each corner, with NaN where it has none. None: the mesh has no texture coordinates.
    uvs: np.ndarray | None = None
    # N×3 displacements by the names of shapes. None: the program does not read shapes.
    shapes: dict | None = field(default=None)


def of_json(line):
    """The reading in a line of the example mesh_json."""
    positions = np.array(line["positions"], float).reshape(-1, 3)
    uvs = line["uvs"]
    shapes = {}
    for shape in line["shapes"]:
        moved = np.zeros_like(positions)
        for vertex, by in shape["moved"]:
            moved[vertex] += by
        shapes[shape["name"]] = moved
    return Reading(
        positions,
        np.array(line["counts"], int),
        np.array(line["corners"], int),
        None if uvs is None else np.array(uvs, float).reshape(-1, 2),
        shapes,
    )


def difference(found, expected):
    """What differs first, as a phrase. None if nothing does. Positions are single floats of the file's size."""
    if len(found.positions) != len(expected.positions):
        return f"{len(found.positions)} vertices, expected {len(expected.positions)}"
    if not near(found.positions, expected.positions, size(expected.positions)):
        worst = np.abs(found.positions - expected.positions).max(axis=1)
        return f"vertex {int(np.argmax(worst))} is off by {worst.max():.3g} of {size(expected.positions):.3g}"
    if not np.array_equal(found.counts, expected.counts):
        return f"{len(found.counts)} faces, expected {len(expected.counts)} or of other sizes"
    if not np.array_equal(found.corners, expected.corners):
        return f"corner {int(np.argmax(found.corners != expected.corners))} has another vertex"
    return uv_difference(found.uvs, expected.uvs) or shape_difference(found, expected)


def uv_difference(found, expected):
    if expected is None or not np.isfinite(expected).any():
        return None if found is None else "texture coordinates that nobody else sees"
    if found is None:
        return "no texture coordinates"
    known = np.isfinite(expected).all(axis=1)
    if not near(found[known], expected[known], max(1.0, np.abs(expected[known]).max())):
        worst = np.abs(found - expected).max(axis=1)
        corner = int(np.nanargmax(np.where(known, worst, -1)))
        return f"texture coordinate of corner {corner}: {found[corner]}, expected {expected[corner]}"
    return None


def shape_difference(found, expected):
    if expected.shapes is None:
        return None
    if list(found.shapes) != list(expected.shapes):
        return f"shapes {list(found.shapes)[:4]}, expected {list(expected.shapes)[:4]}"
    for name, moved in expected.shapes.items():
        if not near(found.shapes[name], moved, size(expected.positions)):
            return f"the shape {name} is off by {np.abs(found.shapes[name] - moved).max():.3g}"
    return None


def loose_difference(found, expected):
    """What differs without any order: the triangles' number and the box around the surface."""
    triangles = [int((reading.counts - 2).sum()) for reading in (found, expected)]
    if triangles[0] != triangles[1]:
        return f"{triangles[0]} triangles, expected {triangles[1]}"
    boxes = []
    for reading in (found, expected):
        used = reading.positions[reading.corners]
        boxes.append(np.array([used.min(axis=0), used.max(axis=0)]))
    return None if near(*boxes, size(expected.positions)) else f"the box {boxes[0].tolist()}, not {boxes[1].tolist()}"


def size(positions):
    return max(np.abs(positions).max(initial=0), 1e-12)


def near(found, expected, scale):
    return found.shape == expected.shape and bool((np.abs(found - expected) <= 1e-5 * scale).all())
