"""Writes layers with USD's own library into FOLDER, and beside each what the library reads from it as JSON.

Numbers are compared as bits: arrays and doubles stand as hexadecimal bytes.
"""

import itertools
import json
import os
import struct
import sys
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdUtils, Vt

FLOATS = [0.0, -0.0, 1e-45, 3.4028235e38, -1.1754944e-38, 0.1, 1 / 3, 7.038531e-26, 16777217.0, 123456.79]


def numbers():
    """Floats with a large spread, the same ones every time."""
    state = 1
    for i in itertools.count():
        state = state * 6364136223846793005 + 1442695040888963407 & (1 << 64) - 1
        yield FLOATS[i // 3 % len(FLOATS)] if i % 3 == 0 else ((state >> 40) / (1 << 20) - 8) ** 5


def vectors(count, source):
    return [(next(source), next(source), next(source)) for _ in range(count)]


def small(layer):
    """A face as it is exported, and every type of value."""
    vertices, frames, source = 40, 5, numbers()
    stage = Usd.Stage.Open(layer)
    stage.SetStartTimeCode(-2)
    stage.SetEndTimeCode(2)
    stage.SetTimeCodesPerSecond(30000 / 1001)
    stage.SetFramesPerSecond(30)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, "Z")
    root = UsdGeom.Xform.Define(stage, "/face")
    stage.SetDefaultPrim(root.GetPrim())
    Usd.ModelAPI(root).SetKind("component")
    origin = {"version": "0.1", "rig": "ab" * 32, "stage": "full", "first_frame": 3, "end_frame": 8, "fps": 29.97}
    for key, value in {**origin, "missing": "hold"}.items():
        root.GetPrim().SetCustomDataByKey("rhytid:" + key, value)
    motion = root.AddTransformOp()
    mesh = UsdGeom.Mesh.Define(stage, "/face/face_mesh")
    mesh.CreateDoubleSidedAttr(True)
    mesh.CreatePointsAttr(vectors(vertices, source))
    mesh.CreateNormalsAttr(vectors(vertices, source))
    mesh.SetNormalsInterpolation("vertex")
    mesh.CreateFaceVertexCountsAttr([3] * 50)
    mesh.CreateFaceVertexIndicesAttr([i * 7 % vertices for i in range(150)])
    for i in range(frames):
        time = i - 2
        mesh.GetPointsAttr().Set(vectors(vertices, source), time)
        mesh.GetNormalsAttr().Set(vectors(vertices, source), time)
        mesh.CreateVelocitiesAttr().Set(vectors(vertices, source), time)
        mesh.CreateExtentAttr().Set(vectors(2, source), time)
        turn = Gf.Rotation((1, 2, 3), i * 10)
        motion.Set(Gf.Matrix4d(1) if i == 3 else Gf.Matrix4d().SetTransform(turn, (i, 0.1, -2)), time)
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    st.Set([(0, 0), (1, -0.0), (0.5, 1 / 3)])
    st.SetIndices([i % 3 for i in range(150)])
    every_type(stage)
    stage.GetRootLayer().Save()


def every_type(stage):
    prim = stage.DefinePrim("/face/face_mesh/types", "GeomSubset")
    names = Sdf.ValueTypeNames
    big = [(i * 2654435761 & 0xFFFFFFFF) - (1 << 31) for i in range(300)]
    matrix = Gf.Matrix4d(*[i / 7 for i in range(16)])
    for name, kind, value in [
        ("asset", names.Asset, Sdf.AssetPath("./a b.usd")),
        ("assets", names.AssetArray, [Sdf.AssetPath("a.usd"), Sdf.AssetPath("../b/c.usd")]),
        ("no_assets", names.AssetArray, []),
        ("bool", names.Bool, False),
        ("double", names.Double, 0.1),
        ("short_double", names.Double, -0.0),
        ("double2s", names.Double2Array, [(0, 0.1), (-0.0, 1e300)]),
        ("float", names.Float, 1 / 3),
        ("few_floats", names.FloatArray, [1, 2, 3]),
        ("whole_floats", names.FloatArray, [float(i % 50 - 9) for i in range(200)]),
        ("table_floats", names.FloatArray, [FLOATS[i % 4] * 3 for i in range(2000)]),
        ("many_floats", names.FloatArray, [i / 7 for i in range(300)]),
        ("float2s", names.Float2Array, [(0.1, -0.0)]),
        ("color", names.Color3fArray, [(0.1, 0.2, 0.3)]),
        ("color_and_opacity", names.Color4fArray, [(0.1, 0.2, 0.3, 1), (0, -0.0, 1, 0.5)]),
        ("left_out", names.Int3, Gf.Vec3i(1, 2, 3)),
        ("float3", names.Float3, (1, 2, 0.1)),
        ("small_float3", names.Color3f, (1, -128, 127)),
        ("half3", names.Half3, (1, 0.5, 300)),
        ("small_half3", names.Half3, (1, -2, 3)),
        ("double3", names.Double3, (0.1, -0.0, 1e300)),
        ("small_double3", names.Vector3d, (-1, 0, 3)),
        ("double3s", names.Point3dArray, [(0.1, -0.0, 1e300), (1, 2, 3)]),
        ("half", names.Half, 0.333),
        ("halves", names.HalfArray, [0.333, 1, -65504]),
        ("half2s", names.TexCoord2hArray, [(0.333, 1)]),
        ("half3s", names.Point3hArray, [(0.333, 1, 2), (0, -0.0, 7)]),
        ("quatf", names.Quatf, Gf.Quatf(0.1, 0.2, 0.3, 0.4)),
        ("quatd", names.Quatd, Gf.Quatd(0.1, 0.2, 0.3, 0.4)),
        ("quath", names.Quath, Gf.Quath(0.1, 0.2, 0.3, 0.4)),
        ("left_out_too", names.Int64Array, list(range(50))),
        ("left_out_strings", names.StringArray, ["a ] \"b", "c"]),
        ("int", names.Int, -(1 << 31)),
        ("few_ints", names.IntArray, [-1, 2, 3]),
        ("many_ints", names.IntArray, big),
        ("no_ints", names.IntArray, []),
        ("matrix", names.Matrix4d, matrix),
        ("whole_matrix", names.Matrix4d, Gf.Matrix4d(2, 0, 0, 0, 0, -3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)),
        ("matrices", names.Matrix4dArray, [matrix, Gf.Matrix4d(1)]),
        ("string", names.String, "two \"lines\"\n with 'quotes', \\ and Zoë\t"),
        ("no_string", names.String, ""),
        ("token", names.Token, "a token"),
        ("tokens", names.TokenArray, ["a", "", "last @ <one>"]),
    ]:
        prim.CreateAttribute(name, kind).Set(value)
    prim.CreateAttribute("blocked", names.Float).Block()
    surface = prim.CreateAttribute("inputs:a", names.Float)
    surface.AddConnection("/face/face_mesh/types.float")
    uniform = prim.CreateAttribute("uniform", names.Token, False, Sdf.VariabilityUniform)
    uniform.Set("x")
    prim.CreateRelationship("targets").SetTargets(["/face", "/face/face_mesh.points"])
    prim.CreateRelationship("one", False).SetTargets(["/face"])
    prim.SetDocumentation("what\nit is")
    prim.AddAppliedSchema("SomeAPI")
    prim.AddAppliedSchema("OtherAPI")
    other = stage.OverridePrim("/other")
    other.GetReferences().AddReference("part.usd", "/face")
    other.GetReferences().AddReference("sub dir/part2.usd")
    other.SetInstanceable(True)
    Usd.ClipsAPI(other).SetClips({"default": {
        "assetPaths": Sdf.AssetPathArray([Sdf.AssetPath("a"), Sdf.AssetPath("b")]),
        "primPath": "/face", "active": Vt.Vec2dArray([(0, 0), (3, 1)]), "manifestAssetPath": Sdf.AssetPath("c"),
    }})
    stage.CreateClassPrim("/left_out_class")
    variants = other.GetVariantSets().AddVariantSet("v")
    variants.AddVariant("one")
    variants.SetVariantSelection("one")
    with variants.GetVariantEditContext():
        stage.DefinePrim("/other/within", "Xform").CreateAttribute("x", names.Int).Set(1)


ARRAYS = (Vt.IntArray, Vt.FloatArray, Vt.Vec2fArray, Vt.Vec3fArray, Vt.Vec4fArray, Vt.Vec2dArray, Vt.Vec3dArray,
          Vt.Matrix4dArray)
# They are read as the floats that they are.
HALVES = {Vt.HalfArray: Vt.FloatArray, Vt.Vec2hArray: Vt.Vec2fArray, Vt.Vec3hArray: Vt.Vec3fArray}
QUATERNIONS = (Gf.Quatf, Gf.Quatd, Gf.Quath)


def dump(value):
    """A value as JSON; `None` where the reader leaves it out."""
    if isinstance(value, (bool, int)):
        return value
    if isinstance(value, float):
        return struct.pack("<d", value).hex()
    if isinstance(value, str):
        return {"text": value}
    if isinstance(value, Sdf.AssetPath):
        return {"asset": value.path}
    if isinstance(value, Gf.Matrix4d):
        return struct.pack("<16d", *[x for row in value for x in row]).hex()
    if isinstance(value, (Gf.Vec3f, Gf.Vec3h)):
        return struct.pack("<3f", *value).hex()
    if isinstance(value, Gf.Vec3d):
        return struct.pack("<3d", *value).hex()
    if isinstance(value, QUATERNIONS):
        return struct.pack("<4d", value.real, *value.imaginary).hex()
    if type(value) in HALVES:
        value = HALVES[type(value)]([x if isinstance(x, float) else tuple(x) for x in value])
    if isinstance(value, ARRAYS):
        return {"array": memoryview(value).tobytes().hex() if len(value) else ""}
    if isinstance(value, Vt.TokenArray):
        return {"tokens": list(value)}
    if isinstance(value, Sdf.AssetPathArray):
        return {"assets": [asset.path for asset in value]}
    if isinstance(value, dict):
        entries = {key: dump(entry) for key, entry in value.items()}
        return {"dictionary": {key: entry for key, entry in entries.items() if entry is not None}}
    if isinstance(value, Sdf.TokenListOp):
        return {"tokens": list(value.prependedItems)}
    if isinstance(value, Sdf.ReferenceListOp):
        return {"references": [[item.assetPath, str(item.primPath)] for item in value.prependedItems]}
    return None


def metadata(spec, known):
    fields = {key: dump(spec.GetInfo(key)) for key in spec.ListInfoKeys() if key not in known}
    return {key: field for key, field in fields.items() if field is not None and field is not False or key not in ("custom",)
            and field is not None}


def prim(spec):
    return {
        "def": spec.specifier == Sdf.SpecifierDef,
        "type": spec.typeName,
        "metadata": metadata(spec, ["specifier", "typeName", "variantSelection", "variantSetNames"]),
        "properties": {p.name: prop(p) for p in spec.properties},
        "children": {child.name: prim(child) for child in spec.nameChildren if child.specifier != Sdf.SpecifierClass},
    }


def prop(spec):
    if isinstance(spec, Sdf.RelationshipSpec):
        return {"targets": [str(path) for path in items(spec.targetPathList)]}
    layer = spec.layer
    times = layer.ListTimeSamplesForPath(spec.path)
    return {
        "type": str(spec.typeName),
        "uniform": spec.variability == Sdf.VariabilityUniform,
        "metadata": metadata(spec, ["typeName", "variability", "default", "timeSamples", "connectionPaths", "custom"]),
        "custom": spec.custom,
        "default": dump(spec.default),
        "connections": [str(path) for path in items(spec.connectionPathList)],
        "samples": [[dump(time), dump(layer.QueryTimeSample(spec.path, time))] for time in times],
    }


def items(listed):
    return list(listed.explicitItems) + list(listed.prependedItems) + list(listed.appendedItems)


def layer_to_json(path):
    layer = Sdf.Layer.FindOrOpen(str(path))
    return {
        "metadata": metadata(layer.pseudoRoot, []),
        "prims": {p.name: prim(p) for p in layer.rootPrims if p.specifier != Sdf.SpecifierClass},
    }


folder = Path(sys.argv[1])
version = os.environ.get("USD_WRITE_NEW_USDC_FILES_AS_VERSION", "")
crate, text = folder / f"small-{version}.usdc", folder / f"small-{version}.usda"
small(Sdf.Layer.CreateNew(str(crate)))
Sdf.Layer.FindOrOpen(str(crate)).Export(str(text))
for path in [crate, text]:
    path.with_suffix(path.suffix + ".json").write_text(json.dumps(layer_to_json(path)))
if len(sys.argv) > 2:
    # Without what refers to files that are not there.
    plain = folder / "plain.usdc"
    layer = Sdf.Layer.FindOrOpen(str(crate))
    for name in ["other", "left_out_class"]:
        del layer.rootPrims[name]
    types = layer.GetPrimAtPath("/face/face_mesh/types")
    for name in ["asset", "assets"]:
        del types.properties[name]
    layer.Export(str(plain))
    assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(plain)), str(folder / "plain.usdz"))
