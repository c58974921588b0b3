"""A small face as a project of Rhytid: two materials, one with a texture, three expressions, and a take."""

import csv
import struct
import zlib
from pathlib import Path

import numpy as np

COLUMNS, ROWS = 25, 29
FRAMES = 10
RATE = 24.0
# The number of the take's first frame in files that count frames.
FIRST = 0
# Linear, as MTL and glTF have it.
LIPS = (0.5, 0.05, 0.1)
TEXTURE = (64, 64)
# How many centimetres are a metre.
METRES_PER_UNIT = 0.01

PROJECT = """\
[mesh]
name = "face"
neutral = "neutral.obj"
units = "cm"
up = "y"
[handles]
vertices = "markers.csv"
[[example]]
name = "smile"
mesh = "smile.obj"
[[example]]
name = "brows"
mesh = "brows.obj"
[[example]]
name = "jaw"
mesh = "jaw.obj"
"""


def neutral():
    """V×3 in centimetres: a mask with a nose that is a little beside the middle, so that no mirror image fits."""
    x, y = np.meshgrid(np.linspace(-7, 7, COLUMNS), np.linspace(-9, 9, ROWS))
    z = 8 * np.sqrt(1 - (x / 9) ** 2 * 0.9 - (y / 11) ** 2 * 0.5) + 1.8 * bump(x, y, 0.3, 0, 1.1, 1.8)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3)


def bump(x, y, at_x, at_y, wide, high):
    return np.exp(-(((x - at_x) / wide) ** 2) - ((y - at_y) / high) ** 2)


def expressions(rest):
    """The displacement of each expression, V×3."""
    x, y = rest[:, 0], rest[:, 1]
    corner = bump(x, y, -2.6, -4, 1.8, 1.8) - bump(x, y, 2.6, -4, 1.8, 1.8)
    wrinkles = 0.06 * np.sin(5 * x) * np.abs(corner)
    smile = np.stack([-0.7 * corner, 0.6 * np.abs(corner), wrinkles - 0.3 * np.abs(corner)], axis=-1)
    brow = bump(x, y, 0.5, 5, 4.5, 1.8)
    brows = np.stack([0 * x, 0.9 * brow, 0.06 * np.sin(6 * y) * brow], axis=-1)
    chin = bump(x, y, 0, -8, 4.5, 3.0)
    jaw = np.stack([0 * x, -1.6 * chin, -0.5 * chin], axis=-1)
    return {"smile": smile, "brows": brows, "jaw": jaw}


def faces():
    """Quads, and whether each is of the lips."""
    start = (np.arange(ROWS - 1)[:, None] * COLUMNS + np.arange(COLUMNS - 1)).reshape(-1)
    quads = np.stack([start, start + 1, start + COLUMNS + 1, start + COLUMNS], axis=-1)
    middle = neutral()[quads].mean(axis=1)
    return quads, (np.abs(middle[:, 0]) < 2.4) & (np.abs(middle[:, 1] + 4) < 1.0)


def write(folder):
    """Writes the project `face.toml` and the take `take.csv`, with all that they name."""
    folder = Path(folder)
    rest = neutral()
    shapes = expressions(rest)
    write_obj(folder / "neutral.obj", rest)
    for name, displacement in shapes.items():
        write_obj(folder / f"{name}.obj", rest + displacement)
    lips = "newmtl lips\nKd {} {} {}\n".format(*LIPS)
    (folder / "neutral.mtl").write_text(f"newmtl skin\nKd 1 1 1\nmap_Kd skin.png\n{lips}")
    write_png(folder / "skin.png")
    (folder / "face.toml").write_text(PROJECT)
    handles = markers()
    with open(folder / "markers.csv", "w", newline="") as file:
        csv.writer(file).writerows([("label", "vertex"), *handles.items()])
    write_take(folder / "take.csv", rest, shapes, handles)


def markers():
    rows, columns = np.linspace(4, ROWS - 5, 6).astype(int), np.linspace(4, COLUMNS - 5, 5).astype(int)
    return {f"m{row}_{column}": int(row * COLUMNS + column) for row in rows for column in columns}


def write_obj(path, positions):
    quads, of_lips = faces()
    lines = ["mtllib neutral.mtl"] + ["v {:.6f} {:.6f} {:.6f}".format(*point) for point in positions]
    u, v = np.meshgrid(np.linspace(0.01, 0.99, COLUMNS), np.linspace(0.01, 0.99, ROWS))
    lines += ["vt {:.6f} {:.6f}".format(*point) for point in np.stack([u, v], axis=-1).reshape(-1, 2)]
    # The lips have texture coordinates of their own, as behind a seam.
    lines += ["vt {:.6f} {:.6f}".format(a / 2, b / 2) for a, b in zip(u.flat, v.flat)]
    for name, chosen, offset in (("skin", ~of_lips, 0), ("lips", of_lips, len(positions))):
        lines.append(f"usemtl {name}")
        lines += ["f " + " ".join(f"{i + 1}/{i + 1 + offset}" for i in quad) for quad in quads[chosen]]
    path.write_text("\n".join(lines) + "\n")


def write_png(path):
    """A texture in two colours, by hand: no package is needed for it."""
    width, height = TEXTURE
    y, x = np.mgrid[:height, :width]
    pixels = np.where(((x // 8 + y // 8) % 2 == 0)[..., None], (200, 150, 120), (180, 130, 105)).astype(np.uint8)
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    png = b"\x89PNG\r\n\x1a\n"
    for name, content in chunks:
        png += struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
    path.write_bytes(png)


def weights(frame):
    """How far each expression goes in a frame."""
    part = frame / (FRAMES - 1)
    return {"smile": np.sin(np.pi * part), "brows": part, "jaw": 0.8 * np.sin(2 * np.pi * part) ** 2}


def head(frame):
    """The head's rotation as a quaternion, the scalar first, and its position in centimetres."""
    half = np.radians(2.0 * frame) / 2
    axis = np.array([2, 6, 3]) / 7
    return [np.cos(half), *(np.sin(half) * axis)], [0.4 * frame, 5 - 0.3 * frame, 0.2 * frame]


def write_take(path, rest, shapes, handles):
    with open(path, "w", newline="") as file:
        rows = csv.writer(file)
        names = [f"{label}_{axis}" for label in handles for axis in "xyz"]
        pose = ["head_qw", "head_qx", "head_qy", "head_qz", "head_tx", "head_ty", "head_tz"]
        rows.writerow(["time", *names, *pose])
        for frame in range(FRAMES):
            moved = rest + sum(weight * shapes[name] for name, weight in weights(frame).items())
            points = moved[list(handles.values())].reshape(-1)
            quaternion, position = head(frame)
            rows.writerow([f"{x:.9g}" for x in [frame / RATE, *points, *quaternion, *position]])
