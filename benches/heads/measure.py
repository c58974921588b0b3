"""Runs the program on a face with a truth, as a user would: files in, JSON out."""

import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from face import Face, write_obj


@dataclass
class Case:
    """One measurement: which examples and markers a rig has, and on which poses it is measured."""

    examples: list
    labels: list[str]
    poses: list
    # Millimetres, of each axis of each marker in the take.
    noise: float = 0.0
    # Where the markers are, if they are not at the vertices of the face: three corners and their weights by label.
    points: dict | None = None
    # Whether the table of handles says that they are at the vertices nevertheless.
    taken_for_vertices: bool = False
    # Lines that are added to the project file.
    settings: str = ""
    # Another face of the same topology, whose examples are the prior.
    prior: Face | None = None


def write(folder, face, case):
    """The files of a case: project, meshes, handles, take and truth."""
    write_obj(folder / "neutral.obj", face.rest, face.joined)
    points = case.points or {label: ([face.markers[label]] * 3, (1, 0, 0)) for label in case.labels}
    corners = np.array([points[label][0] for label in case.labels])
    weights = np.array([points[label][1] for label in case.labels])
    if case.points and not case.taken_for_vertices:
        table = "label,vertex,vertex_2,vertex_3,weight,weight_2,weight_3\n"
        for label, three, of_three in zip(case.labels, corners, weights):
            table += f"{label},{','.join(map(str, three))},{','.join(f'{w:.9g}' for w in of_three)}\n"
    else:
        table = "label,vertex\n" + "".join(f"{label},{three[0]}\n" for label, three in zip(case.labels, corners))
    (folder / "markers.csv").write_text(table)
    project = f'[mesh]\nneutral = "neutral.obj"\nunits = {face.metres_per_unit}\n[handles]\nvertices = "markers.csv"\n{case.settings}\n'
    for example in case.examples:
        write_obj(folder / f"{example.name}.obj", example.positions, face.joined)
        project += f'[[example]]\nname = "{example.name}"\nmesh = "{example.name}.obj"\n'
    if case.prior:
        generic = folder / "generic"
        generic.mkdir()
        for name, positions in [("neutral", case.prior.rest)] + [(e.name, e.positions) for e in case.prior.examples]:
            write_obj(generic / f"{name}.obj", positions, face.joined)
        project += '[prior]\nfrom = "generic"\n'
    (folder / "face.toml").write_text(project)
    truth = np.array([pose.positions for pose in case.poses])
    np.save(folder / "truth.npy", truth.astype(np.float32))
    numbers = np.random.default_rng(7)
    markers = np.einsum("fhca,hc->fha", truth[:, corners], weights)
    markers = markers + case.noise * 1e-3 / face.metres_per_unit * numbers.standard_normal(markers.shape)
    header = ["time"] + [f"{label}_{axis}" for label in case.labels for axis in "xyz"]
    with open(folder / "take.csv", "w") as out:
        out.write(",".join(header) + "\n")
        for i, frame in enumerate(markers):
            out.write(",".join([f"{i / 30:.6f}"] + [f"{x:.9g}" for x in frame.ravel()]) + "\n")


def run(program, face, case, command, *options):
    """What a command says of a case, which has its files in the folder of the command."""
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder), face, case)
        told = [program, command, "face.toml", *options, "--json", "--quiet"]
        done = subprocess.run(told, capture_output=True, text=True, cwd=folder)
        if done.returncode != 0:
            raise SystemExit(f"{face.name}: rhytid {command} failed: {done.stderr}")
        return json.loads(done.stdout)


def measure(program, face, case):
    """What `rhytid evaluate` says of a case."""
    return run(program, face, case, "evaluate", "--take", "take.csv", "--truth", "truth.npy")


def worst_foretold(program, face, case):
    """The largest error of a left-out example beside its shell, by `rhytid evaluate`."""
    examples = run(program, face, case, "evaluate")["leave_one_out"]["examples"]
    return max(example["rms_mm"] / example["shell_rms_mm"] for example in examples)


def prior_weight(program, face, case):
    """How much `rhytid solve` takes of a prior."""
    return run(program, face, case, "solve")["prior"]["weight"]


def errors(found):
    """RMS in mm of every method."""
    return {method["method"]: method["rms_mm"] for method in found["truth"]}
