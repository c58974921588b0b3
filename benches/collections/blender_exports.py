"""Writes what Blender exports of a few scenes, with many combinations of its options. Blender's Python runs it."""

import math
import sys
from pathlib import Path

import bpy

folder = Path(sys.argv[1])


def only_default():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def head(name="head"):
    """A monkey's head with texture coordinates, quads and triangles."""
    bpy.ops.mesh.primitive_monkey_add(size=2)
    added = bpy.context.object
    added.name = name
    return added


def placed():
    """Turned and stretched objects, one below the other, one mirrored."""
    parent = head()
    parent.rotation_euler, parent.scale, parent.location = (0.3, 0.7, -0.2), (1, 2, 0.5), (3, -1, 2)
    bpy.ops.mesh.primitive_torus_add(location=(1, 0, 0), major_segments=9, minor_segments=5)
    child = bpy.context.object
    child.parent, child.scale = parent, (-1, 1, 1)


def materials():
    """Three materials on one mesh, in mixed order."""
    of = head()
    for number in range(3):
        of.data.materials.append(bpy.data.materials.new(f"skin {number}"))
    for face in of.data.polygons:
        face.material_index = face.index % 3
        face.use_smooth = face.index % 2 == 0


def shapes():
    """Shape keys, one of them shown in part."""
    of = head()
    of.shape_key_add(name="Basis")
    for number, name in enumerate(["smile", "jaw open", "Blink_L"]):
        key = of.shape_key_add(name=name)
        for v, point in enumerate(key.data):
            if v % (number + 2) == 0:
                point.co.z += 0.1 * (number + 1)
    of.data.shape_keys.key_blocks["jaw open"].value = 0.25


def armature():
    """A head that two bones hold, one of them turned."""
    of = head()
    bpy.ops.object.armature_add(location=(0, 0, -1))
    bones = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    upper = bones.data.edit_bones.new("upper")
    upper.head, upper.tail = (0, 0, 1), (0, 0, 2)
    upper.parent = bones.data.edit_bones[0]
    bpy.ops.object.mode_set(mode="POSE")
    bones.pose.bones["upper"].rotation_mode = "XYZ"
    bones.pose.bones["upper"].rotation_euler = (0.4, 0.1, 0)
    bpy.ops.object.mode_set(mode="OBJECT")
    for bone in bones.data.bones:
        group = of.vertex_groups.new(name=bone.name)
        for v in of.data.vertices:
            share = min(max((v.co.z + 1) / 2, 0), 1)
            group.add([v.index], share if bone.name == "upper" else 1 - share, "REPLACE")
    of.modifiers.new("bones", "ARMATURE").object = bones
    of.parent = bones


def loose():
    """Polygons of many corners, wires, lonely points, and colours of corners."""
    bpy.ops.mesh.primitive_circle_add(vertices=17, fill_type="NGON")
    bpy.ops.mesh.primitive_circle_add(vertices=5, fill_type="NOTHING", location=(0, 0, 1))
    points = bpy.data.meshes.new("points")
    points.from_pydata([(0, 0, 2), (1, 0, 2)], [], [])
    bpy.context.collection.objects.link(bpy.data.objects.new("points", points))
    ball = head()
    colours = ball.data.color_attributes.new("Col", "BYTE_COLOR", "CORNER")
    for number, colour in enumerate(colours.data):
        colour.color = (math.fmod(number * 0.37, 1), 0.5, 0.2, 1)


def copies():
    """Two objects of one mesh, and a mirror that a modifier makes."""
    first = head()
    second = bpy.data.objects.new("second", first.data)
    second.location.x = 4
    bpy.context.collection.objects.link(second)
    bpy.ops.mesh.primitive_cube_add(location=(0, 3, 1))
    bpy.context.object.modifiers.new("fine", "SUBSURF").levels = 2


def empty_scene():
    """A head, and a second scene without anything."""
    head()
    bpy.data.scenes.new("empty")


SCENES = [placed, materials, shapes, armature, loose, copies, empty_scene]

OBJ = {
    "plain": {},
    "triangles": dict(export_triangulated_mesh=True),
    "no-uv": dict(export_uv=False, export_normals=False),
    "groups": dict(export_object_groups=True, export_material_groups=True, export_vertex_groups=True),
    "z-up": dict(forward_axis="Y", up_axis="Z", export_smooth_groups=True),
    "colours": dict(export_colors=True, export_materials=False, global_scale=100),
}
PLY = {
    "binary": {},
    "ascii": dict(ascii_format=True),
    "ascii-uv": dict(ascii_format=True, export_uv=True, export_normals=True),
    "uv": dict(export_uv=True, export_colors="LINEAR"),
    "triangles": dict(export_uv=True, export_triangulated_mesh=True),
}
GLTF = {
    "plain": dict(export_format="GLB"),
    "separate": dict(export_format="GLTF_SEPARATE"),
    "bare": dict(export_format="GLB", export_texcoords=False, export_normals=False),
    "applied": dict(export_format="GLB", export_apply=True),
    "draco": dict(export_format="GLB", export_draco_mesh_compression_enable=True),
    "z-up": dict(export_format="GLB", export_yup=False),
    "shared": dict(export_format="GLB", export_shared_accessors=True, use_mesh_edges=True, use_mesh_vertices=True),
    "sparse": dict(export_format="GLB", export_try_sparse_sk=True, export_morph_normal=False),
    "instances": dict(export_format="GLB", export_gpu_instances=True),
    "all-scenes": dict(export_format="GLB", use_active_scene=False),
}
USD = {
    "plain.usdc": {},
    "plain.usda": {},
    "package.usdz": {},
    "y-up.usda": dict(convert_orientation=True, convert_scene_units="CENTIMETERS"),
    "triangles.usdc": dict(triangulate_meshes=True, export_uvmaps=False),
    "instances.usda": dict(use_instancing=True, export_materials=False),
    "best.usdc": dict(export_subdivision="BEST_MATCH", xform_op_mode="MAT"),
}

for scene in SCENES:
    only_default()
    scene()
    for name, options in OBJ.items():
        bpy.ops.wm.obj_export(filepath=str(folder / f"{scene.__name__}-{name}.obj"), **options)
    for name, options in PLY.items():
        bpy.ops.wm.ply_export(filepath=str(folder / f"{scene.__name__}-{name}.ply"), **options)
    for name, options in GLTF.items():
        ending = ".gltf" if options["export_format"] == "GLTF_SEPARATE" else ".glb"
        bpy.ops.export_scene.gltf(filepath=str(folder / f"{scene.__name__}-{name}{ending}"), **options)
    for name, options in USD.items():
        bpy.ops.wm.usd_export(filepath=str(folder / f"{scene.__name__}-{name}"), **options)
