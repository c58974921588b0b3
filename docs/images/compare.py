"""Renders learned.png: the same frames of a take by the chapter's method, by the learned one, and as they were.

    venv/bin/python docs/images/compare.py frames.npz docs/images/learned.png

frames.npz has `counts` and `indices`, the faces of a mesh, and `positions`, frames × 3 × V × 3 in centimetres with Y up: what
`animate` made of two rigs of the same face, and the truth. Each panel says how far it is from the truth. The environment is shot.py's.
"""

import argparse
from pathlib import Path

import bpy
import numpy as np
import render
import shot
from mathutils import Vector
from PIL import Image, ImageDraw, ImageFont

PANEL = (320, 380)
NAMES = ["the chapter", "learned", "the truth"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("frames", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--samples", type=int, default=24)
    args = parser.parse_args()
    frames = np.load(args.frames)
    corners = np.split(frames["indices"], np.cumsum(frames["counts"])[:-1])
    positions = frames["positions"].astype(float)

    bpy.ops.wm.read_factory_settings(use_empty=True)
    # Blender has Z up.
    in_blender = np.stack([positions[..., 0], -positions[..., 2], positions[..., 1]], axis=-1)
    low, high = in_blender.min(axis=(0, 1, 2)), in_blender.max(axis=(0, 1, 2))
    shot.PANEL = PANEL
    shot.set_up(Vector((low + high) / 2), float((high - low).max()) * 0.62, args.samples)
    clay, shader = render.material("clay", (0.62, 0.45, 0.37), roughness=0.5)
    shader.inputs["Subsurface Weight"].default_value = 0.1

    picture = Image.new("RGB", (PANEL[0] * len(NAMES), PANEL[1] * len(positions)))
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(15)
    for row, of_frame in enumerate(positions):
        for column, name in enumerate(NAMES):
            mesh = bpy.data.meshes.new(name)
            mesh.from_pydata(in_blender[row, column].tolist(), [], [face.tolist() for face in corners])
            mesh.shade_smooth()
            mesh.materials.append(clay)
            thing = bpy.data.objects.new(name, mesh)
            bpy.context.scene.collection.objects.link(thing)
            left, top = column * PANEL[0], row * PANEL[1]
            picture.paste(render.panel(PANEL), (left, top))
            bpy.data.objects.remove(thing)
            off = 10 * np.sqrt(((of_frame[column] - of_frame[2]) ** 2).sum(axis=1).mean())
            said = name if column == 2 else f"{name}: {off:.2f} mm"
            at = (left + PANEL[0] // 2, top + PANEL[1] - 12)
            draw.text(at, said, fill=(225, 225, 228), font=font, anchor="ms")
    palette = picture.quantize(256, kmeans=4)
    picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(args.picture, optimize=True)


if __name__ == "__main__":
    main()
