"""Opens each file of the list LOOKS.json with USD and compares how each face looks with what is beside its path."""

import json
import sys
import zipfile
from pathlib import Path

from pxr import Ar, Usd, UsdGeom, UsdShade
from usd_validate import validate


def value(shader, name):
    """What an input has in the end: a value, or the texture that it is connected to."""
    found = shader.GetInput(name)
    if not found:
        return None, None
    if not found.HasConnectedSource():
        return found.Get(), None
    source, output, _ = found.GetConnectedSource()
    return UsdShade.Shader(source.GetPrim()), output


def bytes_of(asset):
    assert asset.resolvedPath, f"{asset} is not there"
    if Ar.IsPackageRelativePath(asset.resolvedPath):
        package, member = Ar.SplitPackageRelativePathOuter(asset.resolvedPath)
        return list(zipfile.ZipFile(package).read(member))
    return list(Path(asset.resolvedPath).read_bytes())


def look(material):
    shader, _, _ = material.ComputeSurfaceSource()
    assert shader.GetIdAttr().Get() == "UsdPreviewSurface"
    found = {
        "name": material.GetPrim().GetCustomDataByKey("name"),
        "default": bool(material.GetPrim().GetCustomDataByKey("defaultLook")),
        "roughness": value(shader, "roughness")[0],
        "metallic": value(shader, "metallic")[0],
        "cutoff": value(shader, "opacityThreshold")[0] or 0.0,
        "image": None,
    }
    # A name with other letters stands beside the prim's.
    shown = material.GetPrim().GetDisplayName() or material.GetPrim().GetName()
    assert shown == found["name"], (shown, found["name"])
    color, output = value(shader, "diffuseColor")
    opacity, of_opacity = value(shader, "opacity")
    if output is None:
        assert of_opacity is None
        return {**found, "color": list(color), "opacity": opacity, "mixes": opacity < 1}
    assert (output, color.GetIdAttr().Get()) == ("rgb", "UsdUVTexture")
    reader, result = value(color, "st")
    assert (reader.GetIdAttr().Get(), result) == ("UsdPrimvarReader_float2", "result")
    assert value(reader, "varname")[0] == "st"
    assert value(color, "sourceColorSpace")[0] == "sRGB"
    assert value(color, "wrapS")[0] == value(color, "wrapT")[0] == "repeat"
    scale = value(color, "scale")[0] or (1, 1, 1, 1)
    if of_opacity is None:
        assert opacity == 1
    else:
        assert (opacity.GetPath(), of_opacity) == (color.GetPath(), "a")
    return {
        **found,
        "image": bytes_of(value(color, "file")[0]),
        "color": list(scale)[:3],
        "opacity": scale[3] if of_opacity else 1.0,
        "mixes": of_opacity is not None,
    }


cases = json.load(open(sys.argv[1]))
for path, expected in cases:
    complaints = validate(path)
    assert not complaints, f"{path}: {complaints}"
    stage = Usd.Stage.Open(path)
    mesh = UsdGeom.Mesh(next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)))
    bound, _ = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()
    faces = [bound] * len(expected)
    for subset in UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets():
        material, _ = UsdShade.MaterialBindingAPI(subset).ComputeBoundMaterial()
        for face in subset.GetIndicesAttr().Get():
            faces[face] = material
    for face, (material, wanted) in enumerate(zip(faces, expected)):
        found = look(material)
        for key, right in wanted.items():
            numbers = lambda x: x if isinstance(x, list) else [x]
            pairs = list(zip(numbers(found[key]), numbers(right)))
            close = lambda a, b: a == b or isinstance(a, float) and abs(a - b) < 1e-7
            same = len(numbers(found[key])) == len(numbers(right)) and all(close(a, b) for a, b in pairs)
            assert same, f"{path}: face {face}: {key} is {str(found[key]):.99}, expected {str(right):.99}"
print(f"{len(cases)} files look as they should")
