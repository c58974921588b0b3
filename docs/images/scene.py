"""What blender.py renders the demo's face with: paint for the skin, eyeballs and a dark inside of the head, which the mesh does not have,
lamps and a camera."""

import tempfile

import bpy
import numpy as np
from mathutils import Matrix, Vector
from PIL import Image

PANEL = (400, 600)
# The demo's domain, see crates/demo/src/shape: texture coordinates times SIZE less these are centimetres.
SIZE, LEFT, BOTTOM = 23.8, 11.9, 15.2
EYE = (3.04, 0.02, -2.07)


def smooth(x, low, high):
    q = np.clip((x - low) / (high - low), 0, 1)
    return q * q * (3 - 2 * q)


def paint(rest, uvs):
    """A colour for every vertex: lips, cheeks, brows and lashes on plain skin."""
    x, y = np.abs(rest[:, 0]), rest[:, 1]
    colour = np.tile([0.60, 0.385, 0.30], (len(rest), 1))

    def blend(towards, amount):
        colour[:] += amount[:, None] * (np.array(towards) - colour)

    line = np.interp(x, [0, 0.5, 1.2, 2.0, 2.6, 4.0], [-6.52, -6.46, -6.43, -6.47, -6.47, -6.4])
    upper = np.interp(x, [0, 0.42, 1.0, 1.8, 2.65, 2.8], [0.66, 0.78, 0.62, 0.36, 0.1, 0.0])
    lower = np.interp(x, [0, 0.6, 1.2, 1.9, 2.65, 2.8], [0.98, 0.95, 0.78, 0.46, 0.1, 0.0])
    height = np.where(y > line, (y - line) / np.maximum(upper, 0.01), (line - y) / np.maximum(lower, 0.01))
    blend([0.47, 0.185, 0.16], 0.85 * (1 - smooth(height, 0.9, 1.15)) * (x < 2.8))
    cheeks = np.exp(-(((x - 3.9) / 1.6) ** 2) - ((y + 2.7) / 1.5) ** 2)
    nose = np.exp(-((x / 1.3) ** 2) - ((y + 3.7) / 0.8) ** 2)
    blend([0.60, 0.28, 0.22], 0.35 * cheeks + 0.3 * nose)
    arch = 2.05 + 0.42 * smooth(x, 0.9, 3.4) - 0.55 * smooth(x, 3.6, 5.4)
    thick = 0.36 * smooth(x, 0.7, 1.5) * (1 - 0.65 * smooth(x, 2.6, 5.2))
    brow = np.exp(-(((y - arch) / np.maximum(thick, 0.02)) ** 4)) * smooth(x, 0.75, 1.25) * (1 - smooth(x, 4.6, 5.3))
    blend([0.10, 0.06, 0.04], 0.72 * brow)
    across, up = np.abs(uvs[:, 0] * SIZE - LEFT), uvs[:, 1] * SIZE - BOTTOM
    lid = smooth(across, 1.75, 2.2) * (1 - smooth(across, 4.6, 4.9)) * (np.abs(up) < 0.6)
    blend([0.05, 0.025, 0.018], 0.85 * lid * np.where(up > -1e-5, 1.0, 0.45) * np.exp(-((up / 0.15) ** 2)))
    return colour


def material(name, colour=None, roughness=0.5):
    """A principled material; without a colour it takes the mesh's own."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, shader = made.node_tree.nodes, made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Roughness"].default_value = roughness
    if colour:
        shader.inputs["Base Color"].default_value = (*colour, 1)
    else:
        own = nodes.new("ShaderNodeVertexColor")
        own.layer_name = "colour"
        made.node_tree.links.new(own.outputs["Color"], shader.inputs["Base Color"])
    return made, shader


def add(name, data, made):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    if made:
        data.materials.append(made)
    return thing


def colour_vertices(mesh, colours):
    layer = mesh.color_attributes.new("colour", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", np.c_[colours, np.ones(len(colours))].astype(np.float32).ravel())


def add_inside():
    """Eyeballs, and something dark behind the openings."""
    eye, _ = material("eye", roughness=0.12)
    for side in (-1, 1):
        bpy.ops.mesh.primitive_uv_sphere_add(
            radius=1.3, location=(side * (EYE[0] - 0.06), *EYE[1:]), segments=256, ring_count=128
        )
        ball = bpy.context.object
        p = np.array([v.co[:] for v in ball.data.vertices])
        r = np.where(p[:, 2] > 0, np.hypot(p[:, 0] - side * 0.04, p[:, 1] - 0.02), 9)[:, None]
        iris = np.array([0.15, 0.085, 0.045]) * (0.6 + 0.8 * smooth(r, 0.2, 0.5)) * (1 - 0.75 * smooth(r, 0.5, 0.6))
        inner = (-side * p[:, 0] > 1.0)[:, None]
        white = np.where(inner, [0.34, 0.13, 0.10], [0.60, 0.55, 0.52])
        colour_vertices(ball.data, np.where(r < 0.23, 0.004, np.where(r < 0.62, iris, white)))
        ball.scale = (1.12, 1, 1)
        ball.data.materials.append(eye)
        bpy.ops.object.shade_smooth()
    dark, _ = material("inside", (0.02, 0.006, 0.005), 1.0)
    bpy.ops.mesh.primitive_uv_sphere_add(location=(0, -1.5, -6.4), segments=48, ring_count=24)
    bpy.context.object.scale = (5.2, 6.5, 3.4)
    bpy.context.object.data.materials.append(dark)
    bpy.ops.mesh.primitive_uv_sphere_add(location=(0, -8.0, -5.0), segments=48, ring_count=24)
    bpy.context.object.scale = (3.3, 2.6, 3.6)
    bpy.context.object.data.materials.append(dark)


def light(location, power, size, colour):
    lamp = bpy.data.lights.new("light", "AREA")
    lamp.energy, lamp.size, lamp.color = power, size, colour
    aim(add("light", lamp, None), Vector(location), Vector((0, -2, -1)))


def aim(thing, location, target):
    back = (location - target).normalized()
    right = Vector((0, 1, 0)).cross(back).normalized()
    thing.location = location
    thing.rotation_euler = Matrix((right, back.cross(right), back)).transposed().to_euler()


def set_up(samples):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = True
    # Twice the size, halved at the end.
    scene.render.resolution_x, scene.render.resolution_y = 2 * PANEL[0], 2 * PANEL[1]
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs[0].default_value = (0.10, 0.115, 0.135, 1)
    background.inputs[1].default_value = 0.62
    # The key light grazes, so that wrinkles cast shade; fill from the other side, rim from behind.
    light((-27, 27, 25), 15000, 7, (1, 0.95, 0.88))
    light((38, 2, 28), 4200, 30, (0.82, 0.9, 1))
    light((22, 14, -26), 5200, 12, (1, 1, 1))
    camera = bpy.data.cameras.new("camera")
    camera.lens = 85
    scene.camera = add("camera", camera, None)


def panel(size):
    """What the scene's camera sees, as a picture of that size."""
    with tempfile.TemporaryDirectory() as folder:
        bpy.context.scene.render.filepath = f"{folder}/panel.png"
        bpy.ops.render.render(write_still=True)
        return Image.open(f"{folder}/panel.png").convert("RGB").resize(size, Image.LANCZOS)
