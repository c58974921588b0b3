"""Renders prepare.png: a file that `animate` wrote from a raw take, imported into Blender as it is, at eight of its frames.

    cargo run --release -- animate head.safetensors session.c3d -o shot.usd --fps 30
    python3.11 -m venv venv && venv/bin/pip install bpy==5.0.1 pillow
    venv/bin/python docs/images/shot.py shot.usd docs/images/prepare.png

Shapes and the head's motion are what Blender makes of the file; camera and lights stand still.
"""

import argparse
from pathlib import Path

import bpy
import numpy as np
import render
from mathutils import Vector
from PIL import Image, ImageDraw, ImageFont

PANEL = (300, 380)
COLUMNS = 4
RATE = 30


def in_the_world(thing):
    """The vertices as Blender shows them in the scene's frame."""
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    values = np.empty((len(shown.data.vertices), 3), np.float32)
    shown.data.vertices.foreach_get("co", values.ravel())
    turn = np.array(shown.matrix_world)
    return values @ turn[:3, :3].T + turn[:3, 3]


def aim(thing, location, target):
    thing.location = location
    thing.rotation_euler = (target - location).to_track_quat("-Z", "Y").to_euler()


def light(name, energy, size, at, target):
    lamp = bpy.data.lights.new(name, "AREA")
    lamp.energy, lamp.size = energy, size
    thing = bpy.data.objects.new(name, lamp)
    bpy.context.scene.collection.objects.link(thing)
    aim(thing, at, target)


def set_up(middle, size, samples):
    """A camera that has all frames in view, two lights and a grey world. Blender has Z up; the head looks along -Y."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.data.lens = 85
    aim(camera, middle + size * Vector((0.15, -2.8, 0.1)), middle)
    light("key", 60 * size**2, size, middle + size * Vector((-1.2, -1.5, 1.2)), middle)
    light("fill", 16 * size**2, size, middle + size * Vector((1.6, -1.2, 0.2)), middle)
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.02, 0.022, 0.026, 1)
    scene.render.engine = "CYCLES"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = True
    # Twice the size, halved at the end.
    scene.render.resolution_x, scene.render.resolution_y = 2 * PANEL[0], 2 * PANEL[1]
    scene.view_settings.view_transform = "Standard"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--frames", type=int, nargs=8, default=[0, 45, 100, 200, 260, 350, 420, 480])
    parser.add_argument("--samples", type=int, default=24)
    args = parser.parse_args()

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = RATE
    bpy.ops.wm.usd_import(filepath=str(args.file))
    scene = bpy.context.scene
    [head] = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    points = []
    for frame in args.frames:
        scene.frame_set(frame)
        points.append(in_the_world(head))
        print(f"frame {frame}: head at", np.round(np.array(head.matrix_world), 3).tolist())
    everything = np.concatenate(points)
    low, high = everything.min(axis=0), everything.max(axis=0)
    middle = (low + high) / 2 - [0, 0, 0.03 * (high - low).max()]
    set_up(Vector(middle), float((high - low).max()), args.samples)
    clay, shader = render.material("clay", (0.62, 0.45, 0.37), roughness=0.5)
    shader.inputs["Subsurface Weight"].default_value = 0.1
    head.data.materials.clear()
    head.data.materials.append(clay)

    rows = -(-len(args.frames) // COLUMNS)
    picture = Image.new("RGB", (PANEL[0] * COLUMNS, PANEL[1] * rows))
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(15)
    for i, frame in enumerate(args.frames):
        scene.frame_set(frame)
        left, top = i % COLUMNS * PANEL[0], i // COLUMNS * PANEL[1]
        picture.paste(render.panel(PANEL), (left, top))
        at = (left + PANEL[0] // 2, top + PANEL[1] - 12)
        draw.text(at, f"{frame / RATE:.1f} s", fill=(225, 225, 228), font=font, anchor="ms")
    palette = picture.quantize(256, kmeans=4)
    picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(args.picture, optimize=True)


if __name__ == "__main__":
    main()
