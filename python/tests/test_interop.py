"""Meshes of other libraries in, and stages of USD out."""

import numpy as np
import trimesh
from pxr import Gf, Usd, UsdGeom, Vt

import rhytid


def test_a_mesh_of_trimesh_becomes_a_face(face):
    triangles = [[f[0], f[i], f[i + 1]] for f in face.faces for i in range(1, len(f) - 1)]
    mesh = trimesh.Trimesh(face.vertices, triangles, process=False)
    vertices = np.array([10, 500, 900])
    made = rhytid.Face(mesh.vertices, mesh.faces, dict(zip(["chin", "nose", "brow"], vertices)))
    rig = made.solve()
    assert np.allclose(rig.vertices, mesh.vertices, atol=1e-6)
    again = trimesh.Trimesh(rig.animator("cpu:0")(rig.handles), rig.triangles, process=False)
    assert abs(again.area / mesh.area - 1) < 1e-5


def test_a_mesh_of_usd_becomes_a_face_and_a_stage(face, tmp_path):
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/face")
    mesh.CreatePointsAttr(Vt.Vec3fArray([Gf.Vec3f(*map(float, v)) for v in face.vertices]))
    mesh.CreateFaceVertexCountsAttr([len(f) for f in face.faces])
    mesh.CreateFaceVertexIndicesAttr([v for f in face.faces for v in f])

    counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
    corners = np.split(np.array(mesh.GetFaceVertexIndicesAttr().Get()), np.cumsum(counts)[:-1])
    vertices = np.array(mesh.GetPointsAttr().Get())
    made = rhytid.Face(vertices, [c.tolist() for c in corners], [("chin", 10), ("nose", 500), ("brow", 900)])
    rig = made.solve()
    moved = np.repeat(rig.handles[None].astype(float), 5, axis=0)
    moved[:, 1, 2] += np.linspace(0, 0.5, 5)
    take = rhytid.Take(moved, rig.labels, rate=24)
    rig.play(take, device="cpu:0").write(tmp_path / "face.usda")

    written = Usd.Stage.Open(str(tmp_path / "face.usda"))
    points = next(UsdGeom.Mesh(p) for p in written.Traverse() if p.IsA(UsdGeom.Mesh)).GetPointsAttr()
    assert written.GetTimeCodesPerSecond() == 24 and len(points.GetTimeSamples()) == 5
    assert np.allclose(np.array(points.Get(4))[500], vertices[500] + [0, 0, 0.5], atol=1e-5)
