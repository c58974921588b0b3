"""Imports files into Blender and writes where it shows every vertex.

    python blender.py JOB

JOB is a JSON file: `files` to import, `out` (a folder), `rate` (frames per second), `first` (time code of the first
frame) and `frames` to look at, counted from the first. For file number i, `out`/i.f64 gets frames × vertices × 3
float64: positions in the world, metres, Z up, and `out`/i.normals.f64 the same of the normals that it shades with, in the
mean of each vertex's corners. Printed last, as JSON: for each file the number of `vertices` and their
`ids`, the original's vertex numbers, if the file has them.
"""

import json
import math
import sys
from pathlib import Path

import bpy
import numpy as np


def import_file(path):
    """Imports `path` into an empty scene; returns its only mesh object."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # As docs/export.md tells artists to: the rate is set before the import.
    render = bpy.context.scene.render
    render.fps = math.ceil(job["rate"])
    render.fps_base = render.fps / job["rate"]
    if path.suffix in (".glb", ".gltf"):
        bpy.ops.import_scene.gltf(filepath=str(path))
    elif path.suffix == ".abc":
        bpy.ops.wm.alembic_import(filepath=str(path))
    else:
        bpy.ops.wm.usd_import(filepath=str(path))
    objects = [object for object in bpy.data.objects if object.type == "MESH"]
    assert len(objects) == 1, f"{path.name}: {len(objects)} meshes, expected 1"
    return objects[0]


def world_positions(object):
    """What is drawn: with the morphs, caches and parents of the scene's frame."""
    object = object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    positions = np.empty((len(object.data.vertices), 3), np.float32)
    object.data.vertices.foreach_get("co", positions.ravel())
    matrix = np.array(object.matrix_world, np.float64)
    return positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]


def world_normals(object):
    """What is shaded with: one for each corner of a face, here their mean at each vertex."""
    object = object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = object.data
    corners = np.empty((len(mesh.loops), 3), np.float32)
    mesh.corner_normals.foreach_get("vector", corners.ravel())
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    normals = np.zeros((len(mesh.vertices), 3))
    np.add.at(normals, vertices, corners.astype(np.float64))
    return normals @ np.array(object.matrix_world, np.float64)[:3, :3].T


def vertex_ids(mesh):
    """The original's vertex numbers, or None."""
    attribute = mesh.attributes.get("_VERTEX_ID")
    if attribute is None:
        return None
    assert attribute.domain == "POINT", attribute.domain
    assert attribute.data_type == "FLOAT_VECTOR", attribute.data_type
    values = np.empty((len(mesh.vertices), 3), np.float32)
    attribute.data.foreach_get("vector", values.ravel())
    assert np.all(values == np.round(values)) and not values[:, 1:].any()
    return values[:, 0].astype(int).tolist()


job = json.loads(Path(sys.argv[1]).read_text())
report = []
for number, path in enumerate(map(Path, job["files"])):
    mesh_object = import_file(path)
    # USD's time codes are frame numbers; glTF's animation begins at 0 s.
    first = 0 if path.suffix in (".glb", ".gltf") else job["first"]
    vertices = len(mesh_object.data.vertices)
    folder = Path(job["out"])
    with open(folder / f"{number}.f64", "wb") as out, open(folder / f"{number}.normals.f64", "wb") as shading:
        for frame in job["frames"]:
            bpy.context.scene.frame_set(first + frame)
            positions = world_positions(mesh_object)
            assert positions.shape == (vertices, 3)
            out.write(positions.tobytes())
            shading.write(world_normals(mesh_object).tobytes())
    report.append({"vertices": vertices, "ids": vertex_ids(mesh_object.data)})
print(json.dumps(report))
