"""Computes principal strains from triangles, by another way than Rhytid, and compares what files have with them.

    python strain.py JOB

JOB is a JSON file with a list of `cases`. Each has `triangles` (a file of uint32), and either `usd`, a file whose mesh has the
primvars, or the files `rest` and `positions` (float32) and `strains` (float64; frames × vertices × 2). Printed for each: how many frames
there were, the largest strain in them, and how far strains and directions are off at most.

A triangle's deformation gradient is 3×3 here, from the pseudoinverse of its edges at rest; it is turned into a vertex's plane by
Rodrigues' formula, and the eigenvalues are those of the 3×3 mean of FᵀF, of which one is 0, along the normal.
"""

import json
import sys
from pathlib import Path

import numpy as np

# Where both strains are nearly alike, directions mean nothing.
APART = 0.01
# Where nothing is left of a direction, neither does that one.
CRUSHED = -0.99


def edges(points, triangles):
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.stack([b - a, c - a], axis=2)


class Rest:
    """A mesh at rest."""

    def __init__(self, points, triangles):
        self.vertices = len(points)
        sides = edges(points, triangles)
        longest = np.max([np.linalg.norm(s, axis=1) for s in (sides[..., 0], sides[..., 1], sides[..., 1] - sides[..., 0])], 0)
        normals = np.cross(sides[..., 0], sides[..., 1])
        areas = np.linalg.norm(normals, axis=1)
        sound = areas > 1e-6 * longest**2
        self.triangles, self.sides = triangles[sound], sides[sound]
        self.areas = areas[sound]
        self.inverse = np.linalg.pinv(self.sides)
        self.normals = normals[sound] / self.areas[:, None]
        at_vertices = self.to_vertices(np.broadcast_to(normals[sound][:, None], (len(self.areas), 3, 3)))
        length = np.linalg.norm(at_vertices, axis=1)
        self.has_any = length > 0
        at_vertices[self.has_any] /= length[self.has_any, None]
        # For each corner the rotation from its triangle's normal to its vertex's.
        to = at_vertices[self.triangles]
        axis = np.cross(self.normals[:, None], to)
        k = np.zeros((*axis.shape[:2], 3, 3))
        k[..., 0, 1], k[..., 0, 2], k[..., 1, 2] = -axis[..., 2], axis[..., 1], -axis[..., 0]
        k -= np.swapaxes(k, 2, 3)
        cosine = np.einsum("ti,tci->tc", self.normals, to)
        self.turns = np.eye(3) + k + k @ k / (1 + cosine)[..., None, None]

    def to_vertices(self, of_corners):
        """The sum over each vertex's corners."""
        sums = np.zeros((self.vertices, *of_corners.shape[2:]))
        np.add.at(sums, self.triangles, of_corners)
        return sums

    def strains(self, points):
        """V × 2 principal strains and V × 3 directions of each, and what the triangles around allow them to be."""
        gradient = edges(points, self.triangles) @ self.inverse
        metric = np.swapaxes(gradient, 1, 2) @ gradient
        back = np.swapaxes(self.turns, 2, 3)
        weights = self.areas[:, None, None, None]
        total = self.to_vertices(np.broadcast_to(self.areas[:, None], self.triangles.shape))
        total[total == 0] = 1
        mean = self.to_vertices(weights * (self.turns @ metric[:, None] @ back)) / total[:, None, None]
        pushed = self.to_vertices(weights * (gradient[:, None] @ back))
        values, vectors = np.linalg.eigh(mean)
        found = np.sqrt(np.maximum(values[:, [2, 1]], 0)) - 1
        first = np.einsum("vij,vj->vi", pushed, vectors[..., 2])
        second = np.einsum("vij,vj->vi", pushed, vectors[..., 1])
        first /= np.maximum(np.linalg.norm(first, axis=1), 1e-300)[:, None]
        second -= np.sum(first * second, axis=1)[:, None] * first
        second /= np.maximum(np.linalg.norm(second, axis=1), 1e-300)[:, None]
        # The stretches of each triangle by itself, from its first fundamental forms.
        moved = edges(points, self.triangles)
        forms = np.linalg.inv(np.swapaxes(self.sides, 1, 2) @ self.sides) @ (np.swapaxes(moved, 1, 2) @ moved)
        stretches = np.sqrt(np.maximum(np.linalg.eigvals(forms).real, 0))
        most, least = np.full(self.vertices, -np.inf), np.full(self.vertices, np.inf)
        np.maximum.at(most, self.triangles, stretches.max(1)[:, None])
        np.minimum.at(least, self.triangles, stretches.min(1)[:, None])
        found[~self.has_any] = 0
        return found, first, second, (least[self.has_any] - 1, most[self.has_any] - 1)


def compare(rest, frames):
    """Of frames of points, strains and, where there are any, two directions each."""
    worst, worst_direction, largest, count = 0.0, 0.0, 0.0, 0
    for points, strains, *directions in frames:
        expected, first, second, (least, most) = rest.strains(points)
        assert (expected[rest.has_any, 0] <= most + 1e-6).all() and (expected[rest.has_any, 1] >= least - 1e-6).all()
        worst = max(worst, np.abs(strains - expected).max())
        largest = max(largest, np.abs(expected).max())
        clear = (expected[:, 0] - expected[:, 1] > APART) & (expected[:, 1] > CRUSHED)
        for found, along in zip(directions, (first, second)):
            lengths = np.linalg.norm(found[rest.has_any], axis=1)
            assert (np.abs(lengths - 1) < 1e-5).all() | (expected[rest.has_any][np.abs(lengths - 1) >= 1e-5, 1] < CRUSHED).all()
            assert (found[~rest.has_any] == 0).all()
            off = np.linalg.norm(np.cross(found[clear], along[clear]), axis=1)
            worst_direction = max(worst_direction, off.max(initial=0.0))
        count += 1
    return {"frames": count, "largest": largest, "worst": worst, "worst_direction": worst_direction}


def usd_case(case, triangles):
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(case["usd"])
    [mesh] = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    primvars = UsdGeom.PrimvarsAPI(mesh)
    names = ("strain", "strainDirection1", "strainDirection2")
    for name in names:
        assert primvars.GetPrimvar(name).GetInterpolation() == "vertex", name
        assert primvars.GetPrimvar(name).GetTimeSamples() == mesh.GetPointsAttr().GetTimeSamples(), name
    attributes = [mesh.GetPointsAttr(), *(primvars.GetPrimvar(name) for name in names)]
    rest = Rest(np.array(mesh.GetPointsAttr().Get(), dtype=float), triangles)
    codes = mesh.GetPointsAttr().GetTimeSamples()
    return compare(rest, ([np.array(a.Get(code), dtype=float) for a in attributes] for code in codes))


def raw_case(case, triangles):
    read = lambda name, kind: np.fromfile(case[name], kind).astype(float)
    points = read("rest", np.float32).reshape(-1, 3)
    positions = read("positions", np.float32).reshape(-1, *points.shape)
    strains = read("strains", np.float64).reshape(len(positions), len(points), 2)
    return compare(Rest(points, triangles), zip(positions, strains))


job = json.loads(Path(sys.argv[1]).read_text())
results = []
for case in job["cases"]:
    triangles = np.fromfile(case["triangles"], np.uint32).astype(int).reshape(-1, 3)
    results.append((usd_case if "usd" in case else raw_case)(case, triangles))
print(json.dumps(results))
