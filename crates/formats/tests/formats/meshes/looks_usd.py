"""Writes USD files with looks into a folder, which has image.png and mask.png."""

import os
import sys

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdUtils

os.chdir(sys.argv[1])


def shader(stage, path, kind):
    made = UsdShade.Shader.Define(stage, path)
    made.CreateIdAttr(kind)
    return made


def material(stage, path):
    made = UsdShade.Material.Define(stage, path)
    surface = shader(stage, f"{path}/surface", "UsdPreviewSurface")
    made.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    return made, surface


def image(stage, path, file):
    made = shader(stage, path, "UsdUVTexture")
    made.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(file)
    return made


def make(name):
    stage = Usd.Stage.CreateNew(name)
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/root").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/root/face")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3] * 6)
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 0, 2, 3] * 3)
    mesh.CreateSubdivisionSchemeAttr("none")
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    st.Set([(0, 0), (1, 0), (1, 1), (0, 1)])
    looks = "/root/looks"
    made = []

    plain, surface = material(stage, f"{looks}/plain")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.5, 0.25, 0.125))
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.25)
    surface.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.75)
    surface.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(0.5)
    made.append(plain)

    # The image through an input of the material, as many programs do.
    textured, surface = material(stage, f"{looks}/textured")
    file = textured.CreateInput("file", Sdf.ValueTypeNames.Asset)
    file.Set("./image.png")
    texture = shader(stage, f"{looks}/textured/image", "UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).ConnectToSource(file)
    color = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    color.ConnectToSource(texture.ConnectableAPI(), "rgb")
    made.append(textured)

    cut, surface = material(stage, f"{looks}/cut")
    texture = image(stage, f"{looks}/cut/image", "./image.png")
    color = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    color.ConnectToSource(texture.ConnectableAPI(), "rgb")
    opacity = surface.CreateInput("opacity", Sdf.ValueTypeNames.Float)
    opacity.ConnectToSource(texture.ConnectableAPI(), "a")
    surface.CreateInput("opacityThreshold", Sdf.ValueTypeNames.Float).Set(0.75)
    made.append(cut)

    masked, surface = material(stage, f"{looks}/masked")
    texture = image(stage, f"{looks}/masked/image", "./image.png")
    mask = image(stage, f"{looks}/masked/mask", "./mask.png")
    color = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    color.ConnectToSource(texture.ConnectableAPI(), "rgb")
    opacity = surface.CreateInput("opacity", Sdf.ValueTypeNames.Float)
    opacity.ConnectToSource(mask.ConnectableAPI(), "r")
    made.append(masked)

    made.append(UsdShade.Material.Define(stage, f"{looks}/empty"))

    for i, one in enumerate(made):
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, f"part{i}", "face", [i], "materialBind")
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(one)
    stage.Save()


for extension in ("usda", "usdc"):
    make(f"looks.{extension}")
assert UsdUtils.CreateNewUsdzPackage("looks.usdc", "looks.usdz")
