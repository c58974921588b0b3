"""Renders the picture of docs/blender.md: the add-on's handles, a frame of a take, and a handle that was dragged.

    cargo run --release -- demo picture --vertices 60000
    target/venv-blender/bin/pip install --target modules target/wheels/rhytid-*.whl pillow
    PYTHONPATH=modules:integrations/blender target/venv-blender/bin/python docs/images/blender_addon.py picture docs/images/addon.png

The face is placed, solved and moved by the add-on's own operators.
"""

import math
import os
import sys
import tempfile
from pathlib import Path

import bpy  # isort: skip  # Before bmesh and mathutils, which it brings.
import addon
import bmesh
from addon import handles, project, scene_space
from mathutils import Matrix
from PIL import Image

PANEL = (420, 500)
FRAME = 60


def prepare(folder):
    """The demo's face with its rig, which follows its take, in front of a camera."""
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    for path in sorted((folder / "poses").glob("*.obj")):
        bpy.ops.wm.obj_import(filepath=str(path))
    poses = list(bpy.data.objects)
    bpy.ops.wm.obj_import(filepath=str(folder / "neutral.obj"))
    face = bpy.context.object
    for pose in poses:
        pose.select_set(True)
    face.rhytid.unit = "cm"
    bpy.context.scene.render.fps = 30
    bpy.ops.rhytid.add_examples()
    handles.put_all(face, project.read_handles(folder / "markers.csv"))
    bpy.ops.rhytid.solve()
    for pose in poses:
        bpy.data.objects.remove(pose)
    bpy.ops.rhytid.open_take(filepath=str(folder / "performance.csv"))
    face.data.shade_smooth()
    light(bpy.context.scene)
    return face


def light(scene):
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler, camera.data.lens = (0, -75, -3), (math.pi / 2, 0, 0), 118
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 3, 0.2, (0.8, 0.4, 0.2)
    for thing in (camera, sun):
        scene.collection.objects.link(thing)
    scene.camera, scene.world = camera, bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.35, 0.38, 0.42, 1)
    scene.render.engine, scene.cycles.samples = "CYCLES", 48
    scene.render.resolution_x, scene.render.resolution_y = PANEL


def dots(places, scene):
    """A mesh with a ball at each place."""
    balls, mesh = bmesh.new(), bpy.data.meshes.new("dots")
    for place in places:
        bmesh.ops.create_icosphere(balls, subdivisions=2, radius=0.16, matrix=Matrix.Translation(place))
    balls.to_mesh(mesh)
    blue = bpy.data.materials.new("blue")
    blue.use_nodes = True
    blue.node_tree.nodes["Principled BSDF"].inputs[0].default_value = (0.03, 0.2, 0.9, 1)
    mesh.materials.append(blue)
    found = bpy.data.objects.new("dots", mesh)
    scene.collection.objects.link(found)
    return found


def shoot(path):
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return Image.open(path).convert("RGB")


def main():
    folder, output = Path(sys.argv[1]), Path(sys.argv[2])
    addon.register()
    face, scene = prepare(folder), bpy.context.scene
    with tempfile.TemporaryDirectory() as kept:
        bpy.ops.rhytid.play()
        shown = dots(scene_space.in_world(face, handles.positions_of(face)), scene)
        pictures = [shoot(Path(kept) / "handles.png")]
        bpy.data.objects.remove(shown)
        bpy.ops.rhytid.play()
        scene.frame_set(FRAME)
        pictures.append(shoot(Path(kept) / "take.png"))
        bpy.ops.rhytid.bake_handles()
        controls = {control.rhytid_handle: control for control in face.rhytid.controls.objects}
        for label in ("mouth_corner_L", "lip_up_L1", "lip_low_L1"):
            controls[label].animation_data_clear()
            controls[label].location.y += 0.8
        bpy.context.view_layer.update()
        pictures.append(shoot(Path(kept) / "dragged.png"))
    sheet = Image.new("RGB", (len(pictures) * PANEL[0], PANEL[1]))
    for column, picture in enumerate(pictures):
        sheet.paste(picture, (column * PANEL[0], 0))
    sheet.save(output, optimize=True)
    # What libraries run at a process's exit might wait for drivers' threads.
    os._exit(0)


main()
