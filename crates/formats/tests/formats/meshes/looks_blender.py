"""Writes images of many formats and a textured glTF into a folder, and prints how Blender reads looks.mtl there.

The folder has looks.obj and looks.mtl, written by the test.
"""

import json
import os
import sys

import bpy

folder = sys.argv[1]
at = lambda name: os.path.join(folder, name)

# An image of 4 x 2 pixels: red on the left and blue on the right; the lower row lets half through.
image = bpy.data.images.new("image", 4, 2, alpha=True)
image.pixels = [c for opacity in (0.5, 1.0) for c in ([1, 0, 0, opacity] * 2 + [0, 0, 1, opacity] * 2)]
scene = bpy.context.scene
scene.view_settings.view_transform = "Standard"
settings = scene.render.image_settings
for name, kind, mode in [
    ("image.png", "PNG", "RGBA"),
    ("image.jpg", "JPEG", "RGB"),
    ("image.tga", "TARGA", "RGBA"),
    ("image.bmp", "BMP", "RGB"),
    ("image.tif", "TIFF", "RGBA"),
    ("image.webp", "WEBP", "RGBA"),
    ("image.exr", "OPEN_EXR", "RGBA"),
]:
    settings.file_format, settings.color_mode = kind, mode
    settings.quality = 100
    image.save_render(at(name), scene=scene)

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.obj_import(filepath=at("looks.obj"))
read = {}
for material in bpy.data.materials:
    surface = material.node_tree.nodes["Principled BSDF"]
    links = {link.to_socket.name: link for link in material.node_tree.links if link.to_node == surface}
    texture = lambda socket: links[socket].from_node.image.name if socket in links else None
    read[material.name] = {
        "color": list(surface.inputs["Base Color"].default_value)[:3],
        "image": texture("Base Color"),
        "opacity": surface.inputs["Alpha"].default_value,
        "opacity_image": texture("Alpha"),
        "roughness": surface.inputs["Roughness"].default_value,
        "metallic": surface.inputs["Metallic"].default_value,
    }

# The meshes as glTF: with its image packed, and beside.
bpy.ops.export_scene.gltf(filepath=at("packed.glb"), export_format="GLB")
bpy.ops.export_scene.gltf(filepath=at("beside.gltf"), export_format="GLTF_SEPARATE", export_texture_dir="maps")
# Standard output has Blender's own lines, too.
with open(at("read.json"), "w") as out:
    json.dump(read, out)
