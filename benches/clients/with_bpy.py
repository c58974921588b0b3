"""Blender as a Python module: imports each file into an empty scene, and reads what the viewport would show."""

import math
import os
import shutil
import tempfile
from pathlib import Path

import bpy
import client
import numpy as np

GLTF = (".glb", ".gltf")


def read(path, job):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # As docs/export.md tells artists to: the rate is set before the import.
    render = bpy.context.scene.render
    render.fps = math.ceil(job["rate"])
    render.fps_base = render.fps / job["rate"]
    before = set(bpy.data.objects)
    if path.suffix == ".pc2":
        cached(path)
    elif path.suffix in GLTF:
        bpy.ops.import_scene.gltf(filepath=str(path))
    else:
        bpy.ops.wm.usd_import(filepath=str(path))
    meshes = [one for one in bpy.data.objects if one not in before and one.type == "MESH"]
    if not meshes:
        raise ValueError("no mesh")
    positions, normals = [], []
    for frame in range(job["frames"]):
        bpy.context.scene.frame_set(frame)
        shown = [evaluated(one) for one in meshes]
        positions.append(np.concatenate([points for points, _ in shown]))
        normals.append(np.concatenate([directions for _, directions in shown]))
    used = {slot.material for one in meshes for slot in one.material_slots if slot.material}
    looks = [material(one) for one in sorted(used, key=lambda one: one.name)]
    return client.Read(positions, normals, looks, up="Z")


def cached(path):
    """The neutral's own file with a mesh cache, as docs/export.md says. Its unit and axes are the neutral's."""
    bpy.ops.wm.obj_import(filepath=str(path.with_name("neutral.obj")), global_scale=0.01)
    [mesh] = [one for one in bpy.data.objects if one.type == "MESH"]
    modifier = mesh.modifiers.new("cache", "MESH_CACHE")
    modifier.cache_format = "PC2"
    modifier.filepath = str(path)
    modifier.frame_start = 0


def evaluated(object):
    object = object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = object.data
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", points.ravel())
    corners = np.empty((len(mesh.loops), 3), np.float32)
    mesh.corner_normals.foreach_get("vector", corners.ravel())
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    normals = np.zeros((len(mesh.vertices), 3))
    np.add.at(normals, vertices, corners.astype(np.float64))
    matrix = np.array(object.matrix_world, np.float64)
    inverse = np.linalg.inv(matrix[:3, :3])
    return points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3], normals @ inverse


def material(one):
    colour, texture = None, None
    if one.use_nodes:
        for node in one.node_tree.nodes:
            if node.type == "BSDF_PRINCIPLED":
                socket = node.inputs["Base Color"]
                if not socket.is_linked:
                    colour = list(socket.default_value)[:3]
            if node.type == "TEX_IMAGE" and node.image and node.image.size[0]:
                texture = list(node.image.size)
    return {"name": one.name, "colour": colour, "texture": texture}


# Blender writes textures of a package beside the file of the scene, or else into the working folder.
work = tempfile.mkdtemp()
os.chdir(work)
client.run(bpy.app.version_string.split()[0], read)
shutil.rmtree(work)
