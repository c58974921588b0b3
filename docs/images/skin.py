"""Renders the right half of skin.png: a scan in Blender's Cycles, in the light and from where `rhytid render --show skin` has it.

    rhytid render head.safetensors TAKE.csv -o ours{frame}.png --frames 2020..2021 --show skin --size 480x640 --turn 25 --hide 24591,…
    python3.11 -m venv venv && venv/bin/pip install bpy==5.0.1
    venv/bin/python docs/images/skin.py neutral.obj pose.obj markers.csv cycles.png

The mesh is ICT-FaceKit's head, whose unit is the centimetre; the scan is the take's frame 2020. Its faces from vertex 24591 on, lashes and the
film of tears, are left out; teeth and eyes, from 17039 on, are white.
"""

import argparse
import math

import bpy
from mathutils import Matrix, Vector

WHITE, HIDDEN = 17039, 24591
TURN, LENS, ASPECT, MARGIN = math.radians(25), 85, 0.75, 0.9
LIGHT = (math.radians(-41), math.radians(33))
# Of crates/render/src/skin: radiance from everywhere, and what is added above, on the right and behind, in cd/m².
SKY = [(24, 34, 26, 20), (22, 38, 28, 22), (21, 46, 32, 26)]
EXPOSURE = 7.6


def read(path):
    points, faces = [], []
    with open(path) as lines:
        for line in lines:
            kind, _, rest = line.partition(" ")
            if kind == "v":
                points.append(Vector([float(x) for x in rest.split()[:3]]))
            elif kind == "f":
                faces.append([int(corner.split("/")[0]) - 1 for corner in rest.split()])
    return points, faces


def bounds(points):
    return [Vector([pick(p[c] for p in points) for c in range(3)]) for pick in (min, max)]


def camera(rest, handles):
    """As `Camera::framing` about the handles: a turn of the axes, and where it stands."""
    points = [rest[handle] for handle in handles]
    low, high = bounds(points)
    center = (low + high) / 2
    low, high = bounds(rest)
    points = [center + 1.4 * (p - center) for p in points]
    points = [Vector([min(max(p[c], low[c]), high[c]) for c in range(3)]) for p in points]
    toward, up = Vector((math.sin(TURN), 0, math.cos(TURN))), Vector((0, 1, 0))
    axes = Matrix((up.cross(toward), up, toward))
    seen = [axes @ p for p in points]
    low, high = bounds(seen)
    middle = (low + high) / 2
    half = 0.5 * 24 / LENS * MARGIN
    away = [p - middle for p in seen]
    distance = max(p.z + max(abs(p.y) / half, abs(p.x) / (half * ASPECT)) for p in away)
    turn = axes.transposed()
    return turn, turn @ (middle + Vector((0, 0, distance)))


def material(name, colour, scatters):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.subsurface_method = "BURLEY"
    values = {
        "Base Color": (*colour, 1),
        "Roughness": 0.5,
        "IOR": 1.4,
        "Subsurface Weight": scatters,
        # The root mean squares of the distances of the six Gaussians, in millimetres.
        "Subsurface Radius": (1.66, 0.37, 0.22),
        "Subsurface Scale": 0.1,
    }
    for name, value in values.items():
        shader.inputs[name].default_value = value
    return made


def sky(turn):
    world = bpy.context.scene.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    nodes, link = world.node_tree.nodes, world.node_tree.links.new
    direction, colour = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeCombineColor")
    for channel, (everywhere, above, right, behind) in enumerate(SKY):
        slope, add = nodes.new("ShaderNodeVectorMath"), nodes.new("ShaderNodeMath")
        slope.operation = "DOT_PRODUCT"
        slope.inputs[1].default_value = turn @ Vector((0.5 * right, 0.5 * above, -0.5 * behind))
        add.inputs[1].default_value = everywhere + 0.5 * (above + right + behind)
        link(direction.outputs["Generated"], slope.inputs[0])
        link(slope.outputs["Value"], add.inputs[0])
        link(add.outputs[0], colour.inputs[channel])
    link(colour.outputs[0], nodes["Background"].inputs["Color"])


def place(name, data):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def main():
    parser = argparse.ArgumentParser()
    for name in ("neutral", "scan", "handles", "picture"):
        parser.add_argument(name)
    parser.add_argument("--samples", type=int, default=96)
    args = parser.parse_args()

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    rest, faces = read(args.neutral)
    points, _ = read(args.scan)
    faces = [face for face in faces if min(face) < HIDDEN]
    mesh = bpy.data.meshes.new("head")
    mesh.from_pydata(points, [], faces)
    mesh.polygons.foreach_set("use_smooth", [True] * len(faces))
    mesh.materials.append(material("skin", (0.539, 0.305, 0.223), 1))
    mesh.materials.append(material("white", (0.62, 0.60, 0.55), 0))
    mesh.polygons.foreach_set("material_index", [int(min(face) >= WHITE) for face in faces])
    place("head", mesh)

    with open(args.handles) as lines:
        handles = [int(line.split(",")[1]) for line in list(lines)[1:]]
    turn, eye = camera(rest, handles)
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.sensor_height, lens.lens, lens.clip_end = "VERTICAL", 24, LENS, 1000
    scene.camera = place("camera", lens)
    scene.camera.matrix_world = Matrix.Translation(eye) @ turn.to_4x4()

    lamp = bpy.data.lights.new("key", "SUN")
    lamp.energy, lamp.color, lamp.angle = 1000, (1.09, 1, 0.9), math.radians(4)
    right, up = LIGHT
    toward = turn @ Vector((math.sin(right) * math.cos(up), math.sin(up), math.cos(right) * math.cos(up)))
    place("key", lamp).rotation_euler = toward.to_track_quat("Z", "Y").to_euler()
    sky(turn)

    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    scene.cycles.samples, scene.cycles.use_denoising = args.samples, True
    scene.render.resolution_x, scene.render.resolution_y = 480, 640
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Khronos PBR Neutral"
    scene.view_settings.exposure = -math.log2(1.2 * 2**EXPOSURE)
    scene.render.filepath = args.picture
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main()
