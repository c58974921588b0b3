"""VTK's reader of glTF with its deformations."""

import client
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def read(path, job):
    complaints = []
    vtk.vtkObject.GlobalWarningDisplayOn()
    reader = vtk.vtkGLTFReader()
    reader.AddObserver("ErrorEvent", lambda *_: complaints.append("an error of the reader"))
    reader.SetFileName(str(path))
    reader.ApplyDeformationsToGeometryOn()
    reader.SetFrameRate(0)
    reader.UpdateInformation()
    for clip in range(reader.GetNumberOfAnimations()):
        reader.EnableAnimation(clip)
    positions, normals = [], []
    for frame in range(job["frames"] if reader.GetNumberOfAnimations() else 1):
        reader.UpdateTimeStep(frame / job["rate"])
        parts = polygons(reader.GetOutput())
        if complaints or not parts:
            raise ValueError(complaints[0] if complaints else "no mesh")
        positions.append(np.concatenate([vtk_to_numpy(part.GetPoints().GetData()) for part in parts]))
        directions = [part.GetPointData().GetNormals() for part in parts]
        if all(directions):
            normals.append(np.concatenate([vtk_to_numpy(one) for one in directions]))
    materials = [material(part, reader) for part in polygons(reader.GetOutput())]
    return client.Read(positions, normals if len(normals) == len(positions) else None, materials)


def polygons(output):
    found, walk = [], output.NewIterator()
    walk.InitTraversal()
    while not walk.IsDoneWithTraversal():
        found.append(walk.GetCurrentDataObject())
        walk.GoToNextItem()
    return [one for one in found if one.IsA("vtkPolyData") and one.GetNumberOfPoints()]


def material(part, reader):
    field = part.GetFieldData()
    value = lambda name: field.GetAbstractArray(name)
    colour, texture = value("BaseColorMultiplier"), value("BaseColorTextureIndex")
    size = None
    if texture is not None and 0 <= int(texture.GetTuple1(0)) < reader.GetNumberOfTextures():
        image = reader.GetTexture(int(texture.GetTuple1(0))).GetVTKTexture().GetInput()
        size = list(image.GetDimensions()[:2]) if image else None
    return {"name": "", "colour": None if colour is None else list(colour.GetTuple(0)[:3]), "texture": size}


client.run(vtk.VTK_VERSION, read)
