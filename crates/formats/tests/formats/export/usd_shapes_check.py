"""Opens FOLDER/shapes.{usd,usdc,usda,usdz} and lets UsdSkel apply the shapes: the points must go where the offsets
in FOLDER/expected.json take them. Every validator must report nothing."""

import json
import sys
from pathlib import Path

from pxr import Gf, Usd, UsdGeom, UsdShade, UsdSkel, Vt
from usd_validate import check_that_validators_complain, validate


def equal(what, found, expected):
    assert found == expected, f"{what}: found {found!r:.300}, expected {expected!r:.300}"


def far(found, expected):
    """The largest difference of two lists of triples."""
    equal("length", len(found), len(expected))
    return max(abs(a - b) for p, q in zip(found, expected) for a, b in zip(p, q))


def mixed(rest, shapes, weights):
    """rest + Σ weight · offsets"""
    return [
        [x + sum(w * shape[1][v][i] for w, shape in zip(weights, shapes)) for i, x in enumerate(point)]
        for v, point in enumerate(rest)
    ]


def check(path, expected):
    equal("validation", validate(path), [])
    stage = Usd.Stage.Open(str(path))
    root = UsdSkel.Root(stage.GetDefaultPrim())
    assert root, "the default prim is no SkelRoot"
    equal("recipe", root.GetPrim().GetCustomDataByKey("rhytid"), expected["recipe"])
    mesh = UsdGeom.Mesh(root.GetPrim().GetChildren()[0])
    equal("subsets", len(UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()), 4)

    cache = UsdSkel.Cache()
    assert cache.Populate(root, Usd.PrimDefaultPredicate)
    (binding,) = cache.ComputeSkelBindings(root, Usd.PrimDefaultPredicate)
    skeleton = cache.GetSkelQuery(binding.GetSkeleton())
    animation = skeleton.GetAnimQuery()
    (skinning,) = binding.GetSkinningTargets()
    equal("skinned", skinning.GetPrim(), mesh.GetPrim())
    assert not skinning.HasJointInfluences(), "the joint moves the mesh"
    equal("weights", list(animation.ComputeBlendShapeWeights()), [0.0] * len(expected["shapes"]))

    shapes = expected["shapes"]
    query = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(mesh.GetPrim()))
    names = [query.GetBlendShape(i).GetPrim().GetCustomDataByKey("name") for i in range(query.GetNumBlendShapes())]
    equal("names", names, [name for name, _, _ in shapes])
    indices, offsets = query.ComputeBlendShapePointIndices(), query.ComputeSubShapePointOffsets()
    equal("which shapes are sparse", [len(i) > 0 for i in indices[:2]], [False, True])
    for i, (_, _, normals) in enumerate(shapes):
        shape = query.GetBlendShape(i)
        found = shape.GetNormalOffsetsAttr().Get()
        dense = found and spread(found, shape.GetPointIndicesAttr().Get(), len(expected["rest"]))
        equal("normal offsets", dense, normals)
    box = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"]).ComputeUntransformedBound(root.GetPrim()).GetRange()
    for weights in [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.25, 0.5, 1]]:
        sub = query.ComputeSubShapeWeights(Vt.FloatArray(skinning_order(skinning, animation, weights)))
        points = Vt.Vec3fArray([Gf.Vec3f(*p) for p in expected["rest"]])
        assert query.ComputeDeformedPoints(*sub, indices, offsets, points)
        alone = sum(weights) <= 1
        assert not alone or all(box.Contains(Gf.Vec3d(p)) for p in points), f"points at {weights} are outside of {box}"
        off = far(points, mixed(expected["rest"], shapes, weights))
        assert off < 1e-5, f"points are off by {off} at {weights}"


def spread(offsets, indices, count):
    """An offset for each point, given those of some."""
    if not indices:
        return [list(offset) for offset in offsets]
    dense = [[0.0] * 3 for _ in range(count)]
    for index, offset in zip(indices, offsets):
        dense[index] = list(offset)
    return dense


def skinning_order(skinning, animation, weights):
    """The animation's weights in the mesh's order."""
    mapper = skinning.GetBlendShapeMapper()
    order = skinning.GetBlendShapeOrder()
    equal("order", list(order), list(animation.GetBlendShapeOrder()))
    assert mapper.IsIdentity()
    return weights


check_that_validators_complain()
folder = Path(sys.argv[1])
expected = json.loads((folder / "expected.json").read_text())
for extension in ["usd", "usdc", "usda", "usdz"]:
    try:
        check(folder / f"shapes.{extension}", expected)
    except Exception as error:
        sys.exit(f"{extension}: {type(error).__name__}: {error}")
print(f"4 files hold {len(expected['shapes'])} shapes")
