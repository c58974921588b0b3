"""Writes where USD puts the mesh of FILE into the world: positions, then normals, of every time code, to OUT as raw doubles.

Velocities, if there are any, follow as they are.
"""

import struct
import sys

from pxr import Gf, Usd, UsdGeom

stage = Usd.Stage.Open(sys.argv[1])
mesh = UsdGeom.Mesh(stage.GetDefaultPrim().GetChildren()[0])
codes = mesh.GetPointsAttr().GetTimeSamples()
with open(sys.argv[2], "wb") as out:

    def write(vectors):
        for vector in vectors:
            out.write(struct.pack("<3d", *vector))

    for attribute in (mesh.GetPointsAttr(), mesh.GetNormalsAttr()):
        is_points = attribute.GetName() == "points"
        for code in codes:
            matrix = UsdGeom.Xformable(mesh).ComputeLocalToWorldTransform(code)
            turn = matrix.Transform if is_points else matrix.TransformDir
            write(turn(Gf.Vec3d(vector)) for vector in attribute.Get(code))
    if mesh.GetVelocitiesAttr().HasAuthoredValue():
        for code in codes:
            write(mesh.GetVelocitiesAttr().Get(code))
