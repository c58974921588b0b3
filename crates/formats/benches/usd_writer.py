"""USD's own side of `usd_writer.rs`: `write` writes FOLDER/theirs.usd from FOLDER/arrays.bin and tells the time,
`compare` compares it with FOLDER/ours.usd."""

import json
import mmap
import os
import resource
import sys
import time
from pathlib import Path

from pxr import Sdf, Usd, UsdGeom, Vt

ACTION, FOLDER, SIDE, FRAMES = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
VERTICES = SIDE * SIDE


def arrays():
    """Points and normals of each frame."""
    with open(FOLDER / "arrays.bin", "rb") as file:
        view = memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
    size = 12 * VERTICES
    for start in range(0, 2 * size * FRAMES, 2 * size):
        parts = (view[at : at + size].cast("f", (VERTICES, 3)) for at in (start, start + size))
        yield tuple(Vt.Vec3fArray.FromBuffer(part) for part in parts)


def topology():
    corners = ((y * SIDE + x, y * SIDE + x + 1, (y + 1) * SIDE + x + 1, (y + 1) * SIDE + x)
               for y in range(SIDE - 1) for x in range(SIDE - 1))
    return [4] * (SIDE - 1) ** 2, [v for face in corners for v in face]


def write():
    path = FOLDER / "theirs.usd"
    counts, indices = (Vt.IntArray(numbers) for numbers in topology())
    spent = 0.0
    for frame, (points, normals) in enumerate(arrays()):
        extent = UsdGeom.PointBased.ComputeExtent(points)
        start = time.perf_counter()
        if frame == 0:
            stage = Usd.Stage.CreateNew(str(path))
            layer = stage.GetRootLayer()
            root = UsdGeom.Xform.Define(stage, "/face")
            stage.SetDefaultPrim(root.GetPrim())
            mesh = UsdGeom.Mesh.Define(stage, "/face/face_mesh")
            mesh.CreateFaceVertexCountsAttr(counts)
            mesh.CreateFaceVertexIndicesAttr(indices)
            attributes = mesh.CreatePointsAttr(points), mesh.CreateNormalsAttr(normals), mesh.CreateExtentAttr(extent)
            paths = [attribute.GetPath() for attribute in attributes]
        for path_of_attribute, value in zip(paths, (points, normals, extent)):
            # The layer's own function: the stage's would look the attribute up again each time.
            layer.SetTimeSample(path_of_attribute, 1.0 + frame, value)
        spent += time.perf_counter() - start
    start = time.perf_counter()
    layer.Save()
    saved = time.perf_counter()
    with open(path, "rb") as file:
        os.fsync(file.fileno())
    synced = time.perf_counter()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    return {"author": spent, "save": saved - start, "sync": synced - saved, "peak": peak}


def compare():
    stages = [Usd.Stage.Open(str(FOLDER / name)) for name in ("ours.usd", "theirs.usd")]
    meshes = [stage.GetPrimAtPath("/face/face_mesh") for stage in stages]
    count = 0
    for name in ("points", "normals", "extent", "faceVertexCounts", "faceVertexIndices"):
        ours, theirs = (mesh.GetAttribute(name) for mesh in meshes)
        times = theirs.GetTimeSamples()
        assert ours.GetTimeSamples() == times, f"{name} has samples at {ours.GetTimeSamples()}"
        for at in [Usd.TimeCode.Default(), *times]:
            found, expected = (bytes(memoryview(attribute.Get(at))) for attribute in (ours, theirs))
            assert found == expected, f"{name} differs at {at}"
            count += 1
    assert count > 3 * FRAMES, f"only {count} arrays"
    return {"compared": f"USD finds all {count} arrays alike, bit for bit"}


print(json.dumps({"write": write, "compare": compare}[ACTION]()))
