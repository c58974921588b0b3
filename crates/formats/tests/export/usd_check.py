"""Opens each FOLDER/*/face.usda with USD and compares it with the arrays and numbers beside it.

Arrays are compared bit for bit. Every validator that USD has must report nothing.
"""

import json
import struct
import sys
from pathlib import Path

from pxr import Kind, Usd, UsdGeom, UsdValidation


def validate(stage):
    """What all of USD's validators say of a stage."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) >= 20, f"only {len(validators)} validators are registered"
    context = UsdValidation.ValidationContext(validators)
    return [error.GetErrorAsString() for error in context.Validate(stage)]


def check_that_validators_complain():
    """A stage without metadata must not pass, or the silence about ours would mean nothing."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Mesh.Define(stage, "/mesh")
    complaints = " ".join(validate(stage))
    for expected in ["metersPerUnit", "upAxis", "defaultPrim"]:
        assert expected in complaints, f"the validators do not miss {expected}: {complaints}"


def bits(array):
    return memoryview(array).tobytes()


def equal(what, found, expected):
    assert found == expected, f"{what}: found {found!r:.300}, expected {expected!r:.300}"


def extent(blob):
    """Smallest and largest coordinates of float triples, as two tuples."""
    points = list(struct.iter_unpack("<fff", blob))
    return [tuple(pick(p[i] for p in points) for i in range(3)) for pick in (min, max)]


def check(folder):
    expected = json.loads((folder / "expected.json").read_text())
    blob = lambda name: (folder / name).read_bytes()
    stage = Usd.Stage.Open(str(folder / "face.usda"))
    equal("validation", validate(stage), [])

    frames = expected["frames"]
    first = expected["first_time_code"]
    codes = [first + frame for frame in range(frames)]
    equal("startTimeCode", stage.GetStartTimeCode(), codes[0])
    equal("endTimeCode", stage.GetEndTimeCode(), codes[-1])
    equal("timeCodesPerSecond", stage.GetTimeCodesPerSecond(), expected["rate"])
    equal("framesPerSecond", stage.GetFramesPerSecond(), expected["rate"])
    equal("metersPerUnit", UsdGeom.GetStageMetersPerUnit(stage), expected["metres_per_unit"])
    equal("upAxis", UsdGeom.GetStageUpAxis(stage), expected["up_axis"].upper())

    root = stage.GetDefaultPrim()
    equal("default prim", root.GetPath(), "/" + expected["identifier"])
    equal("prim types", [p.GetTypeName() for p in stage.Traverse()], ["Xform", "Mesh"])
    equal("kind", Usd.ModelAPI(root).GetKind(), Kind.Tokens.component)
    mesh = UsdGeom.Mesh(root.GetChildren()[0])
    equal("mesh", mesh.GetPrim().GetName(), expected["identifier"] + "_mesh")
    equal("subdivisionScheme", mesh.GetSubdivisionSchemeAttr().Get(), "none")
    equal("orientation", mesh.GetOrientationAttr().Get(), "rightHanded")
    counts, indices = mesh.GetFaceVertexCountsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
    equal("faceVertexCounts", list(counts), expected["counts"])
    equal("faceVertexIndices", list(indices), expected["indices"])
    ok, reason = UsdGeom.Mesh.ValidateTopology(indices, counts, expected["vertices"])
    assert ok, reason

    equal("normals interpolation", mesh.GetNormalsInterpolation(), "vertex")
    for attribute, rest, moving in [
        (mesh.GetPointsAttr(), blob("rest.bin"), blob("points.bin")),
        (mesh.GetNormalsAttr(), blob("rest_normals.bin"), blob("normals.bin")),
    ]:
        name = attribute.GetName()
        equal(name + " samples", attribute.GetTimeSamples(), codes)
        equal(name + " default", bits(attribute.Get()), rest)
        found = b"".join(bits(attribute.Get(code)) for code in codes)
        equal(name, found, moving)

    attribute = mesh.GetExtentAttr()
    equal("extent samples", attribute.GetTimeSamples(), codes)
    equal("extent default", [tuple(v) for v in attribute.Get()], extent(blob("rest.bin")))
    size = 12 * expected["vertices"]
    for frame, code in enumerate(codes):
        points = blob("points.bin")[frame * size : (frame + 1) * size]
        equal(f"extent at {code}", [tuple(v) for v in attribute.Get(code)], extent(points))

    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    if not (folder / "uvs.bin").exists():
        assert not st, "found primvars:st, expected none"
        return
    corners = expected["uv_corners"]
    equal("st type", st.GetTypeName(), "texCoord2f[]")
    equal("st", bits(st.Get()), blob("uvs.bin"))
    equal("st samples", st.GetTimeSamples(), [])
    equal("st interpolation", st.GetInterpolation(), "vertex" if corners is None else "faceVarying")
    equal("st is indexed", st.IsIndexed(), corners is not None)
    if corners is not None:
        equal("st indices", list(st.GetIndices()), corners)


check_that_validators_complain()
folders = sorted(path.parent for path in Path(sys.argv[1]).glob("*/face.usda"))
for folder in folders:
    try:
        check(folder)
    except Exception as error:
        sys.exit(f"{folder}: {error}")
print(f"{len(folders)} files hold what was expected")
