"""Imports the USD file FILE into Blender and writes the look of each material to OUT as JSON."""

import json
import sys

import bpy

file, out = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=file, import_textures_mode="IMPORT_COPY" if file.endswith("z") else "IMPORT_NONE",
                      import_textures_dir=out + ".textures")
read = {}
for material in bpy.data.materials:
    nodes = material.node_tree
    surface = next(node for node in nodes.nodes if node.type == "BSDF_PRINCIPLED")
    sources = {link.to_socket: link.from_node for link in nodes.links}
    image = scale = None
    node = sources.get(surface.inputs["Base Color"])
    while node is not None and node.type != "TEX_IMAGE":
        vector = node.inputs[1] if node.type == "VECT_MATH" else None
        if vector is not None and node.operation == "MULTIPLY":
            scale = list(vector.default_value)
        if node.type == "VECT_MATH" and node.operation == "MULTIPLY_ADD":
            scale = list(node.inputs[1].default_value)
        node = next((sources[socket] for socket in node.inputs if socket in sources), None)
    if node is not None:
        image = {
            "file": bpy.path.abspath(node.image.filepath),
            "size": list(node.image.size),
            "space": node.image.colorspace_settings.name,
        }
    read[material.name] = {
        "color": list(surface.inputs["Base Color"].default_value)[:3],
        "image": image,
        "scale": scale,
        "opacity": surface.inputs["Alpha"].default_value,
        "opacity_from_image": surface.inputs["Alpha"] in sources,
        "roughness": surface.inputs["Roughness"].default_value,
        "metallic": surface.inputs["Metallic"].default_value,
    }
with open(out, "w") as stream:
    json.dump(read, stream)
