"""Opens each FOLDER/*/face.{usd,usdc,usda,usdz} with USD and compares it with the arrays and numbers beside it.

Arrays are compared bit for bit. Every validator that this version of USD has must report nothing, and all four files
of a folder must flatten to the same text.
"""

import json
import re
import struct
import sys
from pathlib import Path

from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdShade
from usd_validate import check_that_validators_complain, validate

EXTENSIONS = ["usd", "usdc", "usda", "usdz"]


def bits(array):
    return memoryview(array).tobytes()


def equal(what, found, expected):
    assert found == expected, f"{what}: found {found!r:.300}, expected {expected!r:.300}"


def extent(blob):
    """Smallest and largest coordinates of float triples, as two tuples."""
    points = list(struct.iter_unpack("<fff", blob))
    return [tuple(pick(p[i] for p in points) for i in range(3)) for pick in (min, max)]


def check(folder, extension):
    expected = json.loads((folder / "expected.json").read_text())
    blob = lambda name: (folder / name).read_bytes()
    path = str(folder / f"face.{extension}")
    equal("validation", validate(path), [])
    stage = Usd.Stage.Open(path)
    if extension in ["usd", "usdc"]:
        equal("version of the crate", Path(path).read_bytes()[:16], b"PXR-USDC\0\x08\0\0\0\0\0\0")

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
    shown = [prim.GetDisplayName() for prim in (root, root.GetChildren()[0])]
    is_other = expected["identifier"] != expected["name"] and expected["name"]
    equal("display names", shown, [expected["name"]] * 2 if is_other else ["", ""])
    equal("kind", Usd.ModelAPI(root).GetKind(), Kind.Tokens.component)
    equal("recipe", root.GetCustomDataByKey("rhytid"), expected["recipe"])
    mesh = UsdGeom.Mesh(root.GetChildren()[0])
    equal("mesh", mesh.GetPrim().GetName(), expected["identifier"] + "_mesh")
    equal("subdivisionScheme", mesh.GetSubdivisionSchemeAttr().Get(), "none")
    equal("orientation", mesh.GetOrientationAttr().Get(), "rightHanded")
    equal("doubleSided", mesh.GetDoubleSidedAttr().Get(), True)
    counts, indices = mesh.GetFaceVertexCountsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
    equal("faceVertexCounts", list(counts), expected["counts"])
    equal("faceVertexIndices", list(indices), expected["indices"])
    ok, reason = UsdGeom.Mesh.ValidateTopology(indices, counts, expected["vertices"])
    assert ok, reason

    animated = [(mesh.GetPointsAttr(), blob("rest.bin"), blob("points.bin"))]
    if expected["with_normals"]:
        equal("normals interpolation", mesh.GetNormalsInterpolation(), "vertex")
        animated.append((mesh.GetNormalsAttr(), blob("rest_normals.bin"), blob("normals.bin")))
    else:
        assert not mesh.GetNormalsAttr().HasAuthoredValue(), "found normals, expected none"
    channels = {channel["name"]: channel for channel in expected["channels"]}
    if channels.pop("velocities", None):
        animated.append((mesh.GetVelocitiesAttr(), None, blob("velocities.bin")))
    else:
        assert not mesh.GetVelocitiesAttr().HasAuthoredValue(), "found velocities, expected none"
    found = {primvar.GetPrimvarName() for primvar in UsdGeom.PrimvarsAPI(mesh).GetAuthoredPrimvars()} - {"st"}
    equal("primvars", found, set(channels))
    for name, channel in channels.items():
        primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar(name)
        equal(name + " interpolation", primvar.GetInterpolation(), "vertex")
        types = {1: "float[]", 2: "float2[]", 3: "vector3f[]" if channel["is_direction"] else "float3[]"}
        equal(name + " type", str(primvar.GetTypeName()), types[channel["width"]])
        animated.append((primvar.GetAttr(), None, blob(f"{name}.bin")))
    for attribute, rest, moving in animated:
        name = attribute.GetName()
        equal(name + " samples", attribute.GetTimeSamples(), codes)
        equal(name + " default", rest and bits(attribute.Get()), rest)
        found = b"".join(bits(attribute.Get(code)) for code in codes)
        equal(name, found, moving)

    attribute = mesh.GetExtentAttr()
    equal("extent samples", attribute.GetTimeSamples(), codes)
    equal("extent default", [tuple(v) for v in attribute.Get()], extent(blob("rest.bin")))
    size = 12 * expected["vertices"]
    for frame, code in enumerate(codes):
        points = blob("points.bin")[frame * size : (frame + 1) * size]
        equal(f"extent at {code}", [tuple(v) for v in attribute.Get(code)], extent(points))

    check_st(mesh, folder, expected["uv_corners"])
    check_materials(root, mesh, expected["materials"])
    check_head(root, mesh, codes, expected["head"])


def check_st(mesh, folder, corners):
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    if not (folder / "uvs.bin").exists():
        assert not st, "found primvars:st, expected none"
        return
    equal("st type", st.GetTypeName(), "texCoord2f[]")
    equal("st", bits(st.Get()), (folder / "uvs.bin").read_bytes())
    equal("st samples", st.GetTimeSamples(), [])
    equal("st interpolation", st.GetInterpolation(), "vertex" if corners is None else "faceVarying")
    equal("st is indexed", st.IsIndexed(), corners is not None)
    if corners is not None:
        equal("st indices", list(st.GetIndices()), corners)


def check_materials(root, mesh, expected):
    """Each face is bound to the material that has its name."""
    subsets = UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
    if expected is None:
        equal("subsets", subsets, [])
        material, _ = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()
        equal("material", material.GetPrim().GetCustomDataByKey("name"), "skin")
        return
    named = len([m for m in expected["of_face"] if m < len(expected["names"])])
    has_all = named == len(expected["of_face"])
    equal("subsets", len(subsets), len(expected["names"]) + (not has_all))
    ok, reason = UsdGeom.Subset.ValidateFamily(mesh, "face", "materialBind")
    assert ok, reason
    equal("family type", UsdGeom.Subset.GetFamilyType(mesh, "materialBind"), "partition")
    found = [None] * len(expected["of_face"])
    for subset in subsets:
        material, _ = UsdShade.MaterialBindingAPI(subset).ComputeBoundMaterial()
        shader, _, _ = material.ComputeSurfaceSource()
        equal("shader", shader.GetIdAttr().Get(), "UsdPreviewSurface")
        name = material.GetPrim().GetCustomDataByKey("name")
        assert re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", material.GetPrim().GetName())
        for face in subset.GetIndicesAttr().Get():
            found[face] = name
    names = dict(enumerate(expected["names"]))
    # The only case with faces beside its materials has one that is called as the default.
    equal("materials", found, [names.get(m, "skin_1") for m in expected["of_face"]])


def check_head(root, mesh, codes, expected):
    """What stands on the mesh goes where the rotation and translation take it."""
    if expected is None:
        equal("xformOpOrder", UsdGeom.Xformable(root).GetOrderedXformOps(), [])
        return
    (op,) = UsdGeom.Xformable(root).GetOrderedXformOps()
    equal("time samples of the head", op.GetTimeSamples(), codes)
    for code, ([x, y, z, w], translation) in zip(codes, expected):
        to_world = UsdGeom.Xformable(mesh).ComputeLocalToWorldTransform(code)
        point = Gf.Vec3d(1.5, -2.5, 0.25)
        turned = Gf.Rotation(Gf.Quatd(w, x, y, z)).TransformDir(point)
        off = (to_world.Transform(point) - (turned + Gf.Vec3d(*translation))).GetLength()
        assert off < 1e-12, f"the head is off by {off} at {code}"


def flat(path):
    text = Usd.Stage.Open(str(path)).Flatten().ExportToString()
    # Tells where it was flattened from.
    return re.sub(r'doc = """[^"]*"""|doc = "[^"]*"', "", text)


check_that_validators_complain()
folders = sorted(path.parent for path in Path(sys.argv[1]).glob("*/expected.json"))
for folder in folders:
    for extension in EXTENSIONS:
        try:
            check(folder, extension)
        except Exception as error:
            sys.exit(f"{folder}, {extension}: {type(error).__name__}: {error}")
    texts = {flat(folder / f"face.{extension}") for extension in EXTENSIONS}
    equal(f"{folder}: different texts when flattened", len(texts), 1)
    layers = [Sdf.Layer.FindOrOpen(str(folder / f"face.{e}")).ExportToString() for e in ("usda", "usdc")]
    equal(f"{folder}: different layers", layers[0], layers[1])
print(f"{len(folders) * len(EXTENSIONS)} files hold what was expected")
