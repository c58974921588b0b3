"""All that USD says of a stage, as values that compare."""

from pxr import Usd, UsdGeom

try:
    from pxr import UsdValidation
except ImportError:  # Came after 24.3.
    UsdValidation = None


def bits(value):
    """A value as something that compares bit for bit."""
    try:
        return memoryview(value).tobytes() if len(value) else b""
    except TypeError:
        return repr(value)


def codes(stage):
    first, last = int(stage.GetStartTimeCode()), int(stage.GetEndTimeCode())
    # Also before and behind, where USD holds, and halfway, where it interpolates, also from one part to the next.
    return [first - 3, *(first + i / 2 for i in range((last - first) * 2 + 1)), last + 3]


def dump(stage):
    found = {
        name: stage.GetMetadata(name)
        for name in ["startTimeCode", "endTimeCode", "timeCodesPerSecond", "framesPerSecond", "upAxis", "metersPerUnit"]
    }
    found["default prim"] = str(stage.GetDefaultPrim().GetPath())
    found["custom data"] = stage.GetDefaultPrim().GetCustomData()
    found["kind"] = Usd.ModelAPI(stage.GetDefaultPrim()).GetKind()
    for prim in stage.Traverse():
        found[str(prim.GetPath())] = (prim.GetTypeName(), prim.GetAppliedSchemas())
        for relationship in prim.GetRelationships():
            found[str(relationship.GetPath())] = relationship.GetTargets()
        for attribute in prim.GetAttributes():
            at = str(attribute.GetPath())
            found[at] = (str(attribute.GetTypeName()), attribute.GetVariability(), attribute.GetTimeSamples())
            found[at + " varies"] = attribute.ValueMightBeTimeVarying()
            found[at + " default"] = bits(attribute.Get())
            for code in codes(stage):
                found[f"{at} at {code}"] = bits(attribute.Get(code))
    mesh = next(UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    for code in codes(stage):
        counts, indices = mesh.GetFaceVertexCountsAttr().Get(code), mesh.GetFaceVertexIndicesAttr().Get(code)
        ok, reason = UsdGeom.Mesh.ValidateTopology(indices, counts, len(mesh.GetPointsAttr().Get(code)))
        assert ok, reason
    return found


def validate(stage):
    if UsdValidation is None:
        return []
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [error.GetErrorAsString() for error in UsdValidation.ValidationContext(validators).Validate(stage)]
