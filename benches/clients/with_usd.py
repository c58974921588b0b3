"""USD's own library: points and normals at every time code, weights of blend shapes, and bound materials."""

import io
import zipfile
from pathlib import Path

import client
import numpy as np
from PIL import Image
from pxr import Usd, UsdGeom, UsdShade, UsdSkel


def read(path, job):
    stage = Usd.Stage.Open(str(path))
    [prim] = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    metres = UsdGeom.GetStageMetersPerUnit(stage)
    codes = [stage.GetStartTimeCode() + frame for frame in range(job["frames"])]
    assert stage.GetEndTimeCode() == codes[-1], f"the last time code is {stage.GetEndTimeCode()}"
    assert stage.GetTimeCodesPerSecond() == job["rate"], f"the rate is {stage.GetTimeCodesPerSecond()}"
    local, shading = shapes(prim, codes) if prim.HasAPI(UsdSkel.BindingAPI) else samples(prim, codes)
    positions, normals = [], []
    for code, points, directions in zip(codes, local, shading):
        matrix = np.array(UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(code))
        positions.append(metres * (np.array(points, float) @ matrix[:3, :3] + matrix[3, :3]))
        if directions is not None:
            normals.append(np.array(directions, float) @ np.linalg.inv(matrix[:3, :3]).T)
    return client.Read(positions, normals or None, materials(stage, prim, path), str(UsdGeom.GetStageUpAxis(stage)))


def samples(prim, codes):
    mesh = UsdGeom.Mesh(prim)
    return [[attribute.Get(code) for code in codes] for attribute in (mesh.GetPointsAttr(), mesh.GetNormalsAttr())]


def shapes(prim, codes):
    """The rest with blend shapes, as UsdSkel documents it."""
    mesh, binding = UsdGeom.Mesh(prim), UsdSkel.BindingAPI(prim)
    stage = prim.GetStage()
    names = binding.GetBlendShapesAttr().Get()
    targets = [UsdSkel.BlendShape(stage.GetPrimAtPath(path)) for path in binding.GetBlendShapeTargetsRel().GetTargets()]
    source = UsdSkel.BindingAPI(binding.GetInheritedSkeleton().GetPrim()).GetInheritedAnimationSource()
    animation = UsdSkel.Animation(source)
    order = [list(animation.GetBlendShapesAttr().Get()).index(name) for name in names]
    results = []
    for base, offsets in (
        (mesh.GetPointsAttr().Get(), lambda target: target.GetOffsetsAttr().Get()),
        (mesh.GetNormalsAttr().Get(), lambda target: target.GetNormalOffsetsAttr().Get()),
    ):
        if base is None:
            results.append([None for _ in codes])
            continue
        base = np.array(base, float)
        moved = []
        for target in targets:
            whole, indices = np.zeros_like(base), target.GetPointIndicesAttr().Get()
            whole[np.array(indices) if indices else slice(None)] = offsets(target)
            moved.append(whole)
        weights = [np.array(animation.GetBlendShapeWeightsAttr().Get(code), float)[order] for code in codes]
        results.append([base + np.tensordot(weight, moved, 1) for weight in weights])
    return results


def materials(stage, prim, path):
    parts = [subset.GetPrim() for subset in UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Imageable(prim))] or [prim]
    bound = [UsdShade.MaterialBindingAPI(part).ComputeBoundMaterial()[0] for part in parts]
    return [material(stage, one, path) for one in bound if one]


def material(stage, bound, path):
    surface = bound.ComputeSurfaceSource()[0]
    colour, texture = None, None
    if surface and (base := surface.GetInput("diffuseColor")):
        source = UsdShade.Shader(base.GetConnectedSource()[0].GetPrim()) if base.HasConnectedSource() else None
        if source is None:
            colour = list(map(float, base.Get()))
        else:
            asset = source.GetInput("file").Get()
            texture = list(Image.open(image(asset, path)).size)
    return {"name": bound.GetPrim().GetName(), "colour": colour, "texture": texture}


def image(asset, path):
    """The image's bytes: a file, or a part of a package."""
    resolved = asset.resolvedPath
    if resolved.endswith("]"):
        package, inner = resolved[:-1].split("[")
        return io.BytesIO(zipfile.ZipFile(package).read(inner))
    if not resolved:
        raise FileNotFoundError(f"{asset.path} beside {path.name}")
    return io.BytesIO(Path(resolved).read_bytes())


client.run(".".join(map(str, Usd.GetVersion()[1:])), read)
