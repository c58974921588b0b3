"""Puts each layer of CASES.json over its asset and compares the stage with the whole export, value by value."""

import json
import sys

from pxr import Sdf, Usd, UsdGeom, UsdShade
from usd_validate import validate

EXACT = ["points", "normals", "extent", "velocities", "xformOp:transform"]


def layers(prim):
    yield prim
    for child in prim.nameChildren:
        yield from layers(child)


cases = json.load(open(sys.argv[1]))
for asset, whole, over, path in cases:
    # By itself, it defines nothing, and it has samples alone.
    layer = Sdf.Layer.FindOrOpen(over)
    names = set()
    for root in layer.rootPrims:
        for prim in layers(root):
            assert prim.specifier == Sdf.SpecifierOver and not prim.typeName, f"{over}: {prim.path}"
            for attribute in prim.properties:
                names.add(attribute.name)
                if attribute.name != "xformOpOrder":
                    assert attribute.default is None, f"{over}: {attribute.path} has a value for all times"
                    assert layer.ListTimeSamplesForPath(attribute.path), f"{over}: {attribute.path}"
    assert {"points", "normals", "extent", "velocities", "xformOp:transform", "primvars:strain"} <= names, names

    complaints = validate(whole)
    assert not complaints, f"{whole}: {complaints}"
    expected = Usd.Stage.Open(whole)
    assert expected.GetDefaultPrim().GetPath() == "/" + path.split("/")[1]
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().subLayerPaths = [over, asset]
    stage.SetTimeCodesPerSecond(expected.GetTimeCodesPerSecond())
    face = expected.GetPrimAtPath(path)
    assert face.IsModel() and Usd.ModelAPI(face).GetKind() == "component"
    assert face.GetCustomDataByKey("rhytid")
    codes = UsdGeom.Mesh(face.GetChildren()[0]).GetPointsAttr().GetTimeSamples()
    assert len(codes) == 5
    compared = 0
    for wanted in Usd.PrimRange(expected.GetPseudoRoot()):
        if wanted.IsPseudoRoot():
            continue
        found = stage.GetPrimAtPath(wanted.GetPath())
        assert found and found.GetTypeName() == wanted.GetTypeName(), wanted.GetPath()
        for attribute in wanted.GetAuthoredAttributes():
            other = found.GetAttribute(attribute.GetName())
            assert other.GetTypeName() == attribute.GetTypeName(), attribute.GetPath()
            for code in codes:
                a, b = attribute.Get(code), other.Get(code)
                # Images have other places.
                if isinstance(a, Sdf.AssetPath):
                    continue
                assert a == b, f"{attribute.GetPath()} at {code}: {b!r:.99}, expected {a!r:.99}"
                compared += 1
    assert compared > 100
    mesh = stage.GetPrimAtPath(path + "/" + path.split("/")[-1] + "_mesh")
    assert UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
print(f"{len(cases)} layers over assets play as the whole")
