"""What a client read of a file, beside Rhytid's own frames."""

import struct
from dataclasses import dataclass

import face
import numpy as np


@dataclass
class Truth:
    # Frames × V × 3 in metres, Y up.
    positions: np.ndarray
    normals: np.ndarray


@dataclass
class Row:
    """A row of the table. Numbers are None where nothing was read."""

    client: str
    kind: str
    frames: int = 0
    # Over all frames that were read, in millimetres and degrees.
    worst: float | None = None
    worst_normal: float | None = None
    # Of the two materials of the face: those with their look, the colour or the image.
    looks: int = 0
    error: str = ""


def truth(cache):
    """The frames in a point cache with the head's motion baked in. Normals are computed from its positions."""
    content = cache.read_bytes()
    magic, _, vertices, _, _, frames = struct.unpack("<12siiffi", content[:32])
    assert magic == b"POINTCACHE2\0", "no point cache"
    positions = np.frombuffer(content, "<f4", offset=32).reshape(frames, vertices, 3).astype(float)
    return Truth(face.METRES_PER_UNIT * positions, normals(positions))


def normals(positions):
    """Of each vertex: the sum of its triangles' cross products, of length 1. Quads are cut from their first corner."""
    quads, _ = face.faces()
    sums = np.zeros_like(positions)
    for corners in (quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]):
        a, b, c = (positions[:, corners[:, i]] for i in range(3))
        product = np.cross(b - a, c - a)
        for i in range(3):
            for frame in range(len(positions)):
                np.add.at(sums[frame], corners[:, i], product[frame])
    return sums / np.linalg.norm(sums, axis=-1, keepdims=True)


def row(client, kind, line, out, expected):
    """The row of a client's line about a file."""
    if "error" in line:
        return Row(client, kind.name, error=line["error"])
    if "frames" not in line:
        # It judges a file, and shows none.
        return Row(client, kind.name)
    shape = (line["frames"], line["vertices"], 3)
    found = y_up(np.fromfile(out / f"{line['file']}.f64").reshape(shape), line["up"])
    which = match(found[0], expected.positions[0])
    worst = 1e3 * np.linalg.norm(found - expected.positions[: len(found), which], axis=-1)
    result = Row(client, kind.name, line["frames"], float(worst.max()), looks=looks(line["materials"]))
    if line["normals"]:
        directions = y_up(np.fromfile(out / f"{line['file']}.normals.f64").reshape(shape), line["up"])
        result.worst_normal = worst_angle(directions, expected.normals[: len(found), which])
    return result


def y_up(vectors, up):
    return vectors if up == "Y" else np.stack([vectors[..., 0], vectors[..., 2], -vectors[..., 1]], axis=-1)


def match(found, expected):
    """The vertex that each shown one is: that of the same number, or else the nearest one in the first frame.

    Clients put the parts of materials one after the other, and double vertices between them.
    """
    if len(found) == len(expected):
        return np.arange(len(expected))
    far = np.linalg.norm(np.nan_to_num(found)[:, None] - expected[None], axis=-1)
    return far.argmin(axis=1)


def worst_angle(found, expected):
    length = np.linalg.norm(found, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = np.linalg.norm(found / length - expected, axis=-1)
    # A normal without a direction is as wrong as one can be.
    angles = np.degrees(2 * np.arcsin(np.clip(apart / 2, 0, 1)))
    return float(np.nan_to_num(angles, nan=180.0).max())


def looks(materials):
    """How many of the face's two materials have their look."""
    has_texture = any(one["texture"] and list(one["texture"]) == list(face.TEXTURE) for one in materials)
    near = lambda colour: np.allclose(colour, face.LIPS, atol=0.005)
    has_colour = any(one["colour"] and near(one["colour"]) for one in materials)
    return int(has_texture) + int(has_colour)
