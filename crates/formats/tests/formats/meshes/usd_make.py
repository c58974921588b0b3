"""Writes USD files with meshes, and beside each a JSON file with what USD's own library reads from it."""

import json
import sys
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, Vt

FOLDER = Path(sys.argv[1])
SQUARE = [(0, 0, 0), (1, 0, 0.25), (1, 1, 0), (0, 1, 0)]


def mesh(stage, path, points=SQUARE, counts=(4,), indices=(0, 1, 2, 3)):
    made = UsdGeom.Mesh.Define(stage, path)
    made.CreatePointsAttr(points)
    made.CreateFaceVertexCountsAttr(list(counts))
    made.CreateFaceVertexIndicesAttr(list(indices))
    return made


def stage_of(name, up="Y", metres=0.01):
    stage = Usd.Stage.CreateNew(str(FOLDER / name))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, metres)
    return stage


def world(stage, path, points, time):
    matrix = UsdGeom.XformCache(time).GetLocalToWorldTransform(stage.GetPrimAtPath(path))
    return [list(matrix.Transform(Gf.Vec3d(*point))) for point in points]


def expect(stage, name, paths, time=Usd.TimeCode.Default()):
    """The points, faces and blend shapes of the meshes at `paths`, one after the other."""
    stage.GetRootLayer().Save()
    positions, faces, shapes = [], [], {}
    for path in paths:
        made = UsdGeom.Mesh(stage.GetPrimAtPath(path))
        points = [Gf.Vec3d(*point) for point in made.GetPointsAttr().Get(time)]
        first = len(positions)
        binding = UsdSkel.BindingAPI(made)
        names = binding.GetBlendShapesAttr().Get() or []
        for shape, target in zip(names, binding.GetBlendShapeTargetsRel().GetTargets()):
            prim = UsdSkel.BlendShape(stage.GetPrimAtPath(target))
            where = prim.GetPointIndicesAttr().Get()
            moved = [Gf.Vec3d(point) for point in points]
            for i, offset in enumerate(prim.GetOffsetsAttr().Get()):
                moved[where[i] if where is not None else i] += Gf.Vec3d(*offset)
            shapes.setdefault(shape, []).append([first, world(stage, path, moved, time)])
        positions += world(stage, path, points, time)
        corner = 0
        flips = made.GetOrientationAttr().Get() == "leftHanded"
        for count in made.GetFaceVertexCountsAttr().Get():
            face = [first + made.GetFaceVertexIndicesAttr().Get()[corner + i] for i in range(count)]
            corner += count
            faces.append([face[0]] + face[:0:-1] if flips else face)
    whole = {shape: [list(p) for p in positions] for shape in shapes}
    for shape, parts in shapes.items():
        for first, moved in parts:
            whole[shape][first:first + len(moved)] = moved
    (FOLDER / f"{name}.json").write_text(json.dumps({"positions": positions, "faces": faces, "shapes": whole}))


def placed(name):
    """Every kind of transform, on prims above one another."""
    stage = stage_of(name, "Z", 1.0)
    root = UsdGeom.Xform.Define(stage, "/root")
    root.AddTranslateOp().Set((1, 2, 3))
    root.AddRotateXYZOp().Set((10, 20, 30))
    root.AddScaleOp().Set((1, 2, 0.5))
    pivot = root.AddTranslateOp(opSuffix="pivot")
    pivot.Set((0.5, 0, 0))
    root.AddRotateZXYOp(opSuffix="more", precision=UsdGeom.XformOp.PrecisionDouble).Set((5, -6, 7))
    root.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
    inner = UsdGeom.Xform.Define(stage, "/root/inner")
    inner.AddOrientOp().Set(Gf.Quatf(0.5, 0.1, 0.2, 0.3).GetNormalized())
    inner.AddRotateYOp().Set(12.5)
    inner.AddTransformOp().Set(Gf.Matrix4d(1).SetTransform(Gf.Rotation((1, 2, 3), 40), (3, 2, 1)))
    mesh(stage, "/root/inner/a")
    alone = UsdGeom.Xform.Define(stage, "/root/inner/alone")
    alone.SetResetXformStack(True)
    alone.AddScaleOp().Set((2, 2, 2))
    mesh(stage, "/root/inner/alone/b", counts=(3, 3), indices=(0, 1, 2, 0, 2, 3))
    expect(stage, name, ["/root/inner/a", "/root/inner/alone/b"])


def hidden(name):
    """What is not shown, and what is not there."""
    stage = stage_of(name)
    mesh(stage, "/a/shown")
    UsdGeom.Imageable(mesh(stage, "/a/invisible")).MakeInvisible()
    UsdGeom.Imageable(mesh(stage, "/a/proxy")).CreatePurposeAttr("proxy")
    mesh(stage, "/a/inactive").GetPrim().SetActive(False)
    stage.OverridePrim("/over/mesh").SetTypeName("Mesh")
    stage.CreateClassPrim("/class")
    expect(stage, name, ["/a/shown"])


def shaped(name):
    """Blend shapes of two meshes, one of them sparse, below a scaled prim."""
    stage = stage_of(name)
    root = UsdSkel.Root.Define(stage, "/root")
    root.AddScaleOp().Set((1, 2, 3))
    skeleton = UsdSkel.Skeleton.Define(stage, "/root/skeleton")
    animation = UsdSkel.Animation.Define(stage, "/root/skeleton/animation")
    animation.CreateBlendShapesAttr(["smile", "blink"])
    animation.CreateBlendShapeWeightsAttr([0, 0.5])
    for path, shapes in [("/root/head", ("smile", "blink")), ("/root/teeth", ("smile",))]:
        made = mesh(stage, path)
        binding = UsdSkel.BindingAPI.Apply(made.GetPrim())
        binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
        targets = []
        for i, shape in enumerate(shapes):
            prim = UsdSkel.BlendShape.Define(stage, f"{path}/shape{i}")
            if i == 0:
                prim.CreateOffsetsAttr([(0, 0.5, 0), (0, 0, 0), (0.25, 0, 0), (0, 0, 0.125)])
            else:
                prim.CreateOffsetsAttr([(0, 0, 1), (1, 0, 0)])
                prim.CreatePointIndicesAttr([3, 1])
            targets.append(prim.GetPath())
        binding.CreateBlendShapesAttr(list(shapes))
        binding.CreateBlendShapeTargetsRel().SetTargets(targets)
    expect(stage, name, ["/root/head", "/root/teeth"])


def moving(name):
    """Points with time samples, below a prim that moves."""
    stage = stage_of(name)
    root = UsdGeom.Xform.Define(stage, "/root")
    move = root.AddTranslateOp()
    made = mesh(stage, "/root/face")
    for time in (1, 2, 10):
        made.GetPointsAttr().Set([(x + time, y * time, z) for x, y, z in SQUARE], time)
        move.Set((0, 0, time * time), time)
    expect(stage, name, ["/root/face"], Usd.TimeCode(4))


def looks(name):
    """Texture coordinates, materials, left-handed faces."""
    stage = stage_of(name)
    made = mesh(stage, "/root/face", counts=(3, 3), indices=(0, 1, 2, 0, 2, 3))
    made.CreateOrientationAttr("leftHanded")
    made.CreateSubdivisionSchemeAttr("catmullClark")
    uvs = UsdGeom.PrimvarsAPI(made).CreatePrimvar("map1", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    uvs.Set([(0, 0), (1, 0), (1, 1), (0, 1)])
    uvs.SetIndices([0, 1, 2, 0, 2, 3])
    for i, part in enumerate(["skin", "lip"]):
        material = UsdShade.Material.Define(stage, f"/root/looks/{part}")
        subset = UsdGeom.Subset.CreateGeomSubset(made, part, "face", Vt.IntArray([i]), "materialBind")
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
    mesh(stage, "/root/wide")
    expect(stage, name, ["/root/face"])


def eyes(name):
    """A mesh and a ball."""
    stage = stage_of(name)
    mesh(stage, "/root/face")
    UsdGeom.Sphere.Define(stage, "/root/eye")
    expect(stage, name, ["/root/face"])


def variants(name):
    """A mesh of its own, and another in the chosen variant."""
    stage = stage_of(name)
    mesh(stage, "/root/face")
    kinds = stage.GetPrimAtPath("/root").GetVariantSets().AddVariantSet("kind")
    kinds.AddVariant("old")
    kinds.SetVariantSelection("old")
    with kinds.GetVariantEditContext():
        mesh(stage, "/root/wrinkles")
    expect(stage, name, ["/root/face"])


def inherited(name):
    """A mesh of its own, and another that is inherited."""
    stage = stage_of(name)
    mesh(stage, "/root/face")
    stage.CreateClassPrim("/shared")
    mesh(stage, "/shared/teeth")
    stage.DefinePrim("/root/copy").GetInherits().AddInherit("/shared")
    expect(stage, name, ["/root/face"])


for extension in ("usda", "usdc"):
    for make in (placed, hidden, shaped, moving, looks, eyes, variants, inherited):
        make(f"{make.__name__}.{extension}")
