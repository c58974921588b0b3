"""Writes USD files with USD's own library: what a scan may have that exporters seldom write."""

from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel

ENDINGS = ["usda", "usdc", "usdz"]
# A house: four corners, a roof, quads and a triangle.
POINTS = [(0, 0, 0), (2, 0, 0), (2, 1, 0.5), (0, 1, 0), (1, 2, 0.25)]
COUNTS, INDICES = [4, 3], [0, 1, 2, 3, 3, 2, 4]


def house(stage, path="/root/house"):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(POINTS)
    mesh.CreateFaceVertexCountsAttr(COUNTS)
    mesh.CreateFaceVertexIndicesAttr(INDICES)
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


def plain(stage):
    house(stage)


def left_handed(stage):
    house(stage).CreateOrientationAttr("leftHanded")


def holes(stage):
    house(stage).CreateHoleIndicesAttr([0])


def operations(stage):
    mesh = house(stage)
    mesh.AddTranslateOp().Set((1, 2, 3))
    mesh.AddTranslateOp(opSuffix="pivot").Set((0.5, 0, 0))
    mesh.AddRotateXYZOp().Set((30, -40, 50))
    mesh.AddOrientOp().Set(Gf.Quatf(0.5, 0.5, 0.5, 0.5))
    mesh.AddScaleOp().Set((1, -2, 0.5))
    mesh.AddTranslateOp(opSuffix="pivot", isInverseOp=True)


def half_precision(stage):
    mesh = house(stage)
    mesh.AddTranslateOp(UsdGeom.XformOp.PrecisionHalf).Set(Gf.Vec3h(1, 2, 3))
    mesh.AddRotateYOp(UsdGeom.XformOp.PrecisionHalf).Set(45)
    mesh.AddOrientOp(UsdGeom.XformOp.PrecisionHalf).Set(Gf.Quath(0.5, 0.5, 0.5, 0.5))


def reset(stage):
    UsdGeom.Xform.Define(stage, "/root").AddTranslateOp().Set((9, 9, 9))
    mesh = house(stage)
    mesh.AddRotateZOp().Set(90)
    mesh.SetResetXformStack(True)


def uvs(stage, name, kind, interpolation, values, indices=None):
    primvar = UsdGeom.PrimvarsAPI(house(stage)).CreatePrimvar(name, kind, interpolation)
    primvar.Set(values)
    if indices:
        primvar.SetIndices(indices)


def uv_of_corners(stage):
    uvs(stage, "st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying", [(i / 7, 0.5) for i in range(7)])


def uv_of_vertices(stage):
    uvs(stage, "map1", Sdf.ValueTypeNames.TexCoord2dArray, "vertex", [(0.1, i / 5) for i in range(5)])


def uv_indexed(stage):
    kind = Sdf.ValueTypeNames.TexCoord2hArray
    uvs(stage, "st", kind, "faceVarying", [(0, 0), (1, 0.5), (0.25, 1)], [0, 1, 2, 0, 1, 2, 0])


def uv_as_floats(stage):
    uvs(stage, "st", Sdf.ValueTypeNames.Float2Array, "varying", [(0.1, i / 5) for i in range(5)])


def uv_in_three(stage):
    uvs(stage, "st", Sdf.ValueTypeNames.TexCoord3fArray, "vertex", [(0.1, i / 5, 0) for i in range(5)])


def animated(stage):
    mesh = house(stage)
    mesh.GetPointsAttr().Clear()
    for time in (1, 5):
        mesh.GetPointsAttr().Set([Gf.Vec3f(x, y, z + time) for x, y, z in POINTS], time)
    mesh.AddTranslateOp().Set((0, 0, 1), 1)
    mesh.GetOrderedXformOps()[0].Set((0, 5, 1), 5)


def two(stage):
    house(stage)
    house(stage, "/root/b/second").AddTranslateOp().Set((5, 0, 0))
    UsdGeom.Imageable(house(stage, "/root/hidden")).MakeInvisible()
    UsdGeom.Imageable(house(stage, "/root/proxy")).CreatePurposeAttr("proxy")


def variants(stage):
    house(stage)
    kinds = stage.GetPrimAtPath("/root").GetVariantSets().AddVariantSet("kind")
    for name in ("a", "b"):
        kinds.AddVariant(name)
        kinds.SetVariantSelection(name)
        with kinds.GetVariantEditContext():
            house(stage, f"/root/{name}")


def instances(stage):
    house(stage, "/root/model/house")
    for number in range(2):
        copy = UsdGeom.Xform.Define(stage, f"/root/copy{number}")
        copy.AddTranslateOp().Set((3 * number + 3, 0, 0))
        copy.GetPrim().GetReferences().AddInternalReference("/root/model")
        copy.GetPrim().SetInstanceable(True)


def inherited(stage):
    stage.CreateClassPrim("/shared")
    house(stage, "/shared/house")
    stage.DefinePrim("/root/copy").GetInherits().AddInherit("/shared")


def over(stage):
    house(stage)
    stage.OverridePrim("/root/else/house")


def ball(stage):
    UsdGeom.Sphere.Define(stage, "/root/ball")


def point_instancer(stage):
    instancer = UsdGeom.PointInstancer.Define(stage, "/root/crowd")
    house(stage, "/root/crowd/prototype")
    instancer.CreatePrototypesRel().SetTargets(["/root/crowd/prototype"])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([(5, 0, 0), (9, 0, 0)])


def blend_shapes(stage):
    mesh = house(stage)
    mesh.AddScaleOp().Set((2, 1, 1))
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    for name, offsets, points in (("smile", [(0, 0, 1)] * 5, None), ("Blink", [(1, 0, 0), (0, 1, 0)], [4, 2])):
        shape = UsdSkel.BlendShape.Define(stage, f"/root/house/{name}")
        shape.CreateOffsetsAttr(offsets)
        shape.CreateInbetween("half").SetOffsets([(0, 0, 0.2)] * len(offsets))
        if points:
            shape.CreatePointIndicesAttr(points)
    binding.CreateBlendShapesAttr(["smile", "Blink"])
    binding.CreateBlendShapeTargetsRel().SetTargets(["/root/house/smile", "/root/house/Blink"])


def sublayers(stage):
    house(stage)
    stage.GetRootLayer().subLayerPaths.append("./plain.usda")


def payload(stage):
    house(stage)
    stage.DefinePrim("/root/other").GetPayloads().AddPayload("./plain.usda", "/root")


def specialised(stage):
    house(stage, "/root/base/house")
    stage.DefinePrim("/root/copy").GetSpecializes().AddSpecialize("/root/base")


def inherited_beside(stage):
    house(stage)
    inherited(stage)


def inactive(stage):
    house(stage)
    house(stage, "/root/off").GetPrim().SetActive(False)


def double_points(stage):
    mesh = house(stage)
    mesh.GetPrim().RemoveProperty("points")
    points = mesh.GetPrim().CreateAttribute("points", Sdf.ValueTypeNames.Point3dArray)
    points.Set([Gf.Vec3d(*point) for point in POINTS])


FILES = [
    plain, left_handed, holes, operations, half_precision, reset, uv_of_corners, uv_of_vertices, uv_indexed,
    uv_as_floats, uv_in_three, animated, two, variants, instances, inherited, over, ball, double_points,
    point_instancer, blend_shapes, sublayers, payload, specialised, inherited_beside, inactive,
]  # fmt: skip


def write(folder):
    from pxr import UsdUtils

    for fill in FILES:
        for ending in ENDINGS[:2]:
            path = Path(folder) / f"{fill.__name__}.{ending}"
            stage = Usd.Stage.CreateNew(str(path))
            stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/root").GetPrim())
            fill(stage)
            stage.Save()
        UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(path)), str(path.with_suffix(".usdz")))
