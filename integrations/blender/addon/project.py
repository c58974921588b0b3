"""A face as a project folder, as the program and the library read it (docs/project-file.md). Needs no Blender."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

#: Files of examples that a folder may have.
MESHES = (".obj", ".ply", ".glb", ".gltf", ".usd", ".usda", ".usdc", ".usdz")


@dataclass(frozen=True)
class Handle:
    """A marker's place on the mesh: a vertex, or three vertices of a face with weights whose sum is 1."""

    label: str
    vertices: tuple[int, ...]
    weights: tuple[float, ...] = (1.0,)


@dataclass
class Example:
    name: str
    #: V × 3, in the neutral's space.
    positions: np.ndarray


@dataclass
class Face:
    """What a solve needs. Lengths are in the mesh's unit."""

    name: str
    #: V × 3.
    vertices: np.ndarray
    #: Each face's vertices.
    faces: list[tuple[int, ...]]
    metres_per_unit: float
    up: str
    handles: list[Handle] = field(default_factory=list)
    examples: list[Example] = field(default_factory=list)
    #: Meshes on the disk that are examples as well.
    files: list[Path] = field(default_factory=list)
    pins: list[int] = field(default_factory=list)


def obj(vertices: np.ndarray, faces: list[tuple[int, ...]]) -> str:
    """A mesh as OBJ. Nine digits give the same float32 back."""
    lines = ["v %.9g %.9g %.9g" % tuple(vertex) for vertex in vertices.tolist()]
    lines += ["f " + " ".join(str(vertex + 1) for vertex in face) for face in faces]
    return "\n".join(lines) + "\n"


def write_handles(path: Path, handles: list[Handle]) -> None:
    """Writes the table of the handles."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["label", "vertex", "vertex_2", "vertex_3", "weight", "weight_2", "weight_3"])
        for handle in handles:
            if len(handle.vertices) == 1:
                table.writerow([handle.label, handle.vertices[0], "", "", "", "", ""])
            else:
                table.writerow([handle.label, *handle.vertices, *map(repr, handle.weights)])


def read_handles(path: Path) -> list[Handle]:
    """Reads a table that the library wrote."""
    handles = []
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            names = [name for name in ("vertex", "vertex_2", "vertex_3") if row.get(name)]
            vertices = tuple(int(row[name]) for name in names)
            weights = (1.0,)
            if len(vertices) > 1:
                weights = tuple(float(row[name.replace("vertex", "weight")]) for name in names)
            handles.append(Handle(row["label"], vertices, weights))
    return handles


def meshes_of(folder: Path, neutral: str) -> list[Path]:
    """The meshes of a folder, by their names. The neutral's own file is none of the examples."""
    files = [file for file in sorted(folder.iterdir()) if file.suffix.lower() in MESHES]
    return [file for file in files if file.stem.lower() not in ("neutral", neutral.lower())]


def write(face: Face, folder: Path) -> Path:
    """Writes the folder. Returns the project file, `face.toml`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "neutral.obj").write_text(obj(face.vertices, face.faces))
    text = [
        "[mesh]",
        f"name = {quoted(face.name)}",
        'neutral = "neutral.obj"',
        f"units = {face.metres_per_unit!r}",
        f"up = {quoted(face.up)}",
        "",
        "[handles]",
        'vertices = "markers.csv"',
    ]
    if face.handles:
        write_handles(folder / "markers.csv", face.handles)
    for number, example in enumerate(face.examples):
        (folder / "poses").mkdir(exist_ok=True)
        file = f"poses/{number:03}.obj"
        (folder / file).write_text(obj(example.positions, face.faces))
        text += ["", "[[example]]", f"name = {quoted(example.name)}", f"mesh = {quoted(file)}"]
    for path in face.files:
        text += ["", "[[example]]", f"name = {quoted(path.stem)}", f"mesh = {quoted(path.resolve().as_posix())}"]
    if face.pins:
        (folder / "pins.csv").write_text("vertex\n" + "".join(f"{vertex}\n" for vertex in face.pins))
        text += ["", "[pins]", 'vertices = "pins.csv"']
    project = folder / "face.toml"
    project.write_text("\n".join(text) + "\n", encoding="utf-8")
    return project


def quoted(text: str) -> str:
    """A string of TOML, whose rules for quotes are those of JSON."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def write_weights(path: Path, property: str, vertices: np.ndarray, weights: np.ndarray) -> None:
    """Writes painted weights of V vertices as a PLY file."""
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {name}" for name in ("x", "y", "z", property)]
    header += ["element face 0", "property list uchar int vertex_indices", "end_header"]
    rows = np.c_[vertices, weights].astype("<f4")
    path.write_bytes("\n".join(header).encode() + b"\n" + rows.tobytes())
