"""Opens FOLDER/baked.{usd,usdc,usda,usdz} and lets UsdSkel apply the shapes with their weights of each frame: no point may be farther from its
place in FOLDER/expected.json than stated there and in the file. Every validator must report nothing."""

import json
import sys
from pathlib import Path

from pxr import Gf, Usd, UsdGeom, UsdSkel
from usd_validate import check_that_validators_complain, validate

check_that_validators_complain()
folder = Path(sys.argv[1])
expected = json.loads((folder / "expected.json").read_text())
for extension in ["usd", "usdc", "usda", "usdz"]:
    path = folder / f"baked.{extension}"
    found = validate(path)
    assert not found, found
    stage = Usd.Stage.Open(str(path))
    root = UsdSkel.Root(stage.GetDefaultPrim())
    stated = root.GetPrim().GetCustomDataByKey("rhytidError")["worstMillimetres"]
    stated /= 1000 * UsdGeom.GetStageMetersPerUnit(stage)
    assert abs(stated / expected["worst"] - 1) < 1e-9, f"{stated}, expected {expected['worst']}"
    mesh = UsdGeom.Mesh(root.GetPrim().GetChildren()[0])
    cache = UsdSkel.Cache()
    assert cache.Populate(root, Usd.PrimDefaultPredicate)
    (binding,) = cache.ComputeSkelBindings(root, Usd.PrimDefaultPredicate)
    animation = cache.GetSkelQuery(binding.GetSkeleton()).GetAnimQuery()
    (skinning,) = binding.GetSkinningTargets()
    assert skinning.GetBlendShapeMapper().IsIdentity() and not skinning.HasJointInfluences()
    query = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(mesh.GetPrim()))
    assert query.GetNumBlendShapes() == expected["shapes"]
    indices, offsets = query.ComputeBlendShapePointIndices(), query.ComputeSubShapePointOffsets()
    codes = animation.GetBlendShapeWeightTimeSamples()
    assert codes == [stage.GetStartTimeCode() + frame for frame in range(len(expected["frames"]))], codes
    assert codes[-1] == stage.GetEndTimeCode() and stage.GetTimeCodesPerSecond() == expected["rate"]
    boxes = [UsdGeom.BBoxCache(code, ["default"]) for code in codes]
    worst = 0
    for frame, code in enumerate(codes):
        weights = animation.ComputeBlendShapeWeights(code)
        assert all(0 <= weight <= 1 for weight in weights), list(weights)
        points = mesh.GetPointsAttr().Get()
        assert query.ComputeDeformedPoints(*query.ComputeSubShapeWeights(weights), indices, offsets, points)
        box = boxes[frame].ComputeUntransformedBound(root.GetPrim()).GetRange()
        assert all(box.Contains(Gf.Vec3d(point)) for point in points), f"points are outside of {box}"
        slack = Gf.Range3d(box.GetMin() + Gf.Vec3d(1e-4), box.GetMax() - Gf.Vec3d(1e-4))
        for axis in range(3):
            ends = [pick(point[axis] for point in points) for pick in (min, max)]
            assert ends[0] < slack.GetMin()[axis] and slack.GetMax()[axis] < ends[1], f"{box} is too large"
        for v, point in enumerate(points):
            place = expected["frames"][frame][3 * v : 3 * v + 3]
            worst = max(worst, sum((a - b) ** 2 for a, b in zip(point, place)) ** 0.5)
        matrix = root.ComputeLocalToWorldTransform(code)
        assert [list(row) for row in zip(*(matrix.GetRow(i) for i in range(4)))] == expected["head"][frame]
    assert 0.5 * stated < worst <= stated, f"{worst}, stated {stated}"
    print(f"{path.name}: {expected['shapes']} shapes within {worst}")
