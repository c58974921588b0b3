"""Compares two exports of one animation: the second has metres as its unit, and the same points and places."""

import sys

from pxr import Usd, UsdGeom
from usd_validate import validate

plain, scaled = [Usd.Stage.Open(path) for path in sys.argv[1:]]
complaints = validate(sys.argv[2])
assert not complaints, complaints
unit = UsdGeom.GetStageMetersPerUnit(plain)
assert unit != 1 and UsdGeom.GetStageMetersPerUnit(scaled) == 1
of = lambda stage: UsdGeom.Mesh(next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)))
codes = UsdGeom.Xformable(plain.GetDefaultPrim()).GetOrderedXformOps()[0].GetTimeSamples()
for code in codes:
    a, b = [of(stage).GetPointsAttr().Get(code) for stage in (plain, scaled)]
    assert a == b, "the points are others"
    a, b = [UsdGeom.Xformable(of(stage)).ComputeLocalToWorldTransform(code) for stage in (plain, scaled)]
    for point in of(plain).GetPointsAttr().Get(code):
        off = (a.Transform(point) * unit - b.Transform(point)).GetLength()
        assert off < 1e-9, f"a point is off by {off} m at {code}"
print(f"{len(codes)} frames have the same size in metres")
