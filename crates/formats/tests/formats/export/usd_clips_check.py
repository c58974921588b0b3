"""Opens FOLDER/clips.{usd,usda,usdz}, which have several animations of weights. The first one is bound. Binds each in
turn, as a stronger layer does, and lets UsdSkel apply the shapes: no point may be farther from its place in
FOLDER/expected.json than stated there and in the file. Every validator must report nothing."""

import json
import sys
from pathlib import Path

from pxr import Usd, UsdGeom, UsdSkel
from usd_validate import check_that_validators_complain, validate

check_that_validators_complain()
folder = Path(sys.argv[1])
expected = json.loads((folder / "expected.json").read_text())
for extension in ["usd", "usda", "usdz"]:
    path = folder / f"clips.{extension}"
    found = validate(path)
    assert not found, found
    stage = Usd.Stage.Open(str(path))
    root = UsdSkel.Root(stage.GetDefaultPrim())
    assert stage.GetTimeCodesPerSecond() == expected["rate"]
    first = expected["clips"][0]
    assert stage.GetStartTimeCode() == first["first"]
    assert stage.GetEndTimeCode() == first["first"] + len(first["frames"]) - 1
    mesh = UsdGeom.Mesh(root.GetPrim().GetChildren()[0])
    (skeleton,) = [prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton)]
    animations = [prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Animation)]
    assert len(animations) == len(expected["clips"])
    source = UsdSkel.BindingAPI(skeleton).GetAnimationSourceRel()
    assert source.GetTargets() == [animations[0].GetPath()]
    query = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(mesh.GetPrim()))
    assert query.GetNumBlendShapes() == expected["shapes"]
    indices, offsets = query.ComputeBlendShapePointIndices(), query.ComputeSubShapePointOffsets()
    for prim, clip in zip(animations, expected["clips"]):
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            source.SetTargets([prim.GetPath()])
        data = prim.GetCustomData()
        assert data["name"] == clip["name"], data
        stated = data["rhytidError"]["worstMillimetres"] / (1000 * UsdGeom.GetStageMetersPerUnit(stage))
        assert abs(stated / clip["worst"] - 1) < 1e-9, f"{stated}, expected {clip['worst']}"
        cache = UsdSkel.Cache()
        assert cache.Populate(root, Usd.PrimDefaultPredicate)
        (binding,) = cache.ComputeSkelBindings(root, Usd.PrimDefaultPredicate)
        animation = cache.GetSkelQuery(binding.GetSkeleton()).GetAnimQuery()
        assert animation.GetPrim() == prim
        codes = animation.GetBlendShapeWeightTimeSamples()
        assert codes == [clip["first"] + frame for frame in range(len(clip["frames"]))], codes
        worst = 0
        for frame, code in enumerate(codes):
            weights = animation.ComputeBlendShapeWeights(code)
            points = mesh.GetPointsAttr().Get()
            assert query.ComputeDeformedPoints(*query.ComputeSubShapeWeights(weights), indices, offsets, points)
            for v, point in enumerate(points):
                place = clip["frames"][frame][3 * v : 3 * v + 3]
                worst = max(worst, sum((a - b) ** 2 for a, b in zip(point, place)) ** 0.5)
        assert 0.5 * stated < worst <= stated, f"{worst}, stated {stated}"
        print(f"{path.name}, {clip['name']}: within {worst}")
