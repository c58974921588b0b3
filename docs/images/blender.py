"""Renders the README's blender.png: a file that `animate` wrote, imported into Blender, at four of its frames.

    cargo run --release -- demo picture --vertices 250000
    cargo run --release -- animate picture/face.safetensors picture/performance.csv --fps 5 -o picture/face.usd
    python3.11 -m venv venv && venv/bin/pip install bpy==5.0.1 pillow
    venv/bin/python docs/images/blender.py picture/face.usd docs/images/blender.png

The shapes are what Blender makes of the file. By scene.py beside this file, the skin is painted
for the picture, and eyeballs and a dark inside of the head are added.
"""

import argparse
from pathlib import Path

import bpy
import numpy as np
import scene
from mathutils import Matrix, Vector
from PIL import Image, ImageDraw, ImageFont

RATE = 5
# Seconds of the demo's performance, and from how far to its left the head is seen then, in degrees.
SHOTS = [(1.0, -12), (2.6, 12), (3.8, 8), (4.6, -8)]
PANEL = (400, 560)


def import_face(path):
    """The file's mesh, which its caches or shape keys animate; the scene has the file's frame rate."""
    bpy.context.scene.render.fps = RATE
    if path.suffix in (".glb", ".gltf"):
        bpy.ops.import_scene.gltf(filepath=str(path))
    else:
        bpy.ops.wm.usd_import(filepath=str(path))
    [face] = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    # The painting and the lights of render.py have Y up and centimetres, as the mesh itself.
    face.parent = None
    face.matrix_world = Matrix()
    return face


def vertex_uvs(mesh):
    """One texture coordinate for each vertex; the demo's has no seams."""
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    values = np.empty((len(mesh.loops), 2), np.float32)
    mesh.uv_layers[0].data.foreach_get("uv", values.ravel())
    uvs = np.empty((len(mesh.vertices), 2))
    uvs[corners] = values
    return uvs


def positions(face):
    """The vertices as Blender shows them in the scene's frame."""
    mesh = face.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    values = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", values.ravel())
    return values.astype(float)


def shoot(face, degrees):
    """The scene's frame, from a camera that is turned about the head and has it in the middle."""
    turn = Matrix.Rotation(np.radians(degrees), 3, "Y")
    across = positions(face) @ np.array(turn.col[0])
    target = turn.col[0] * float(across.min() + across.max()) / 2 + Vector((0, -2.6, -2))
    scene.aim(bpy.context.scene.camera, target + turn @ Vector((0, 1.0, 56)), target)
    return scene.panel(PANEL)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--samples", type=int, default=16)
    args = parser.parse_args()

    bpy.ops.wm.read_factory_settings(use_empty=True)
    face = import_face(args.file)
    bpy.context.scene.frame_set(0)
    skin, shader = scene.material("skin", roughness=0.45)
    shader.inputs["Subsurface Weight"].default_value = 0.2
    shader.inputs["Subsurface Radius"].default_value = (1, 0.35, 0.2)
    shader.inputs["Subsurface Scale"].default_value = 0.2
    scene.colour_vertices(face.data, scene.paint(positions(face), vertex_uvs(face.data)))
    face.data.materials.clear()
    face.data.materials.append(skin)
    scene.add_inside()
    scene.PANEL = PANEL
    scene.set_up(args.samples)

    picture = Image.new("RGB", (PANEL[0] * len(SHOTS), PANEL[1]))
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(17)
    for i, (seconds, degrees) in enumerate(SHOTS):
        bpy.context.scene.frame_set(round(seconds * RATE))
        picture.paste(shoot(face, degrees), (i * PANEL[0], 0))
        centre = i * PANEL[0] + PANEL[0] // 2
        draw.text((centre, PANEL[1] - 16), f"{seconds} s", fill=(225, 225, 228), font=font, anchor="ms")
    # 256 colours, dithered, keep the file small.
    palette = picture.quantize(256, kmeans=4)
    picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(args.picture, optimize=True)


if __name__ == "__main__":
    main()
