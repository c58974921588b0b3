"""Writes what USD reads from FILE: points, then normals, of every time code, to OUT as raw floats.

Prints the time codes; every validator that USD has must report nothing.
"""

import sys

from pxr import Usd, UsdGeom, UsdValidation

stage = Usd.Stage.Open(sys.argv[1])
validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
errors = UsdValidation.ValidationContext(validators).Validate(stage)
assert validators and not errors, [error.GetErrorAsString() for error in errors]
mesh = UsdGeom.Mesh(stage.GetDefaultPrim().GetChildren()[0])
codes = mesh.GetPointsAttr().GetTimeSamples()
assert codes == mesh.GetNormalsAttr().GetTimeSamples() == mesh.GetExtentAttr().GetTimeSamples()
with open(sys.argv[2], "wb") as out:
    for attribute in (mesh.GetPointsAttr(), mesh.GetNormalsAttr()):
        for code in codes:
            out.write(memoryview(attribute.Get(code)).tobytes())
print(*codes)
