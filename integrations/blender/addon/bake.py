"""The tab Bake: shape keys with curves, a mesh cache, or keys of handles. The face then needs no add-on."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import rhytid
from bpy.props import EnumProperty, StringProperty

from . import controls, curves, face, mesh, player, store, timing, tracks
from .problem import Problem, reported
from .work import Job, Long, Progress

#: How baked shape keys and modifiers are called.
NAME = "Rhytid"
#: Where the mesh is in a USD file.
PRIM, MESH = "/face", "mesh"


def animation_of(object: bpy.types.Object, scene: bpy.types.Scene) -> rhytid.Animation:
    """The face's take in the scene's rate, with the detail and the regions of the tab Play.

    Raises `Problem` if the detail has keys.
    """
    wish = replace(player.wish_of(object, scene), channels=())
    if wish.detail is None:
        raise Problem("the detail has keys, and a bake has one detail; remove the keys, or bake the handles")
    return player.Player.of(object, wish).animations[0]


def first_frame(object: bpy.types.Object) -> int:
    """The frame of the scene at which the take begins.

    Raises `Problem` if it begins between two frames.
    """
    start = object.rhytid.start
    if start != round(start):
        raise Problem(f"the take starts at frame {start:g}, expected a whole frame; change the start in the tab Play")
    return round(start)


class BakeShapes(Long, bpy.types.Operator):
    """Bake the take to shape keys with curves"""

    bl_idname = "rhytid.bake_shapes"
    bl_label = "Bake to Shape Keys"
    bl_options = {"REGISTER", "UNDO"}

    def job(self, context: bpy.types.Context) -> Job:
        object = mesh.face_of(context)
        self.object, self.first = object.name, first_frame(object)
        animation, shapes = animation_of(object, context.scene), object.rhytid.shapes
        self.folder = tempfile.TemporaryDirectory()
        path = Path(self.folder.name) / "shapes.usdc"

        def write(progress: Progress) -> Path:
            animation.write(path, shapes=shapes, progress=progress)
            return path

        return write

    def finish(self, context: bpy.types.Context, result: Path) -> set[str]:
        object = face.still_there(self.object)
        object.rhytid.playing = False
        mesh.remove_play_key(object)
        imported = Imported(context, result)
        try:
            made = copy_shapes(object, imported.mesh, self.first)
        finally:
            imported.remove()
            self.folder.cleanup()
        self.report({"INFO"}, f"{made} shape keys with curves")
        return {"FINISHED"}


#: The collections of datablocks that an import of a mesh adds to.
IMPORTED = ("objects", "meshes", "armatures", "materials", "images", "actions", "collections")


class Imported:
    """A mesh of a USD file in the scene, for as long as its shapes are copied."""

    def __init__(self, context: bpy.types.Context, path: Path) -> None:
        before = {name: set(getattr(bpy.data, name)) for name in IMPORTED}
        active = context.view_layer.objects.active
        selected = list(context.selected_objects)
        scene = context.scene
        frames = (scene.frame_start, scene.frame_end, scene.frame_current)
        bpy.ops.wm.usd_import(filepath=str(path), import_materials=False, set_frame_range=False)
        scene.frame_start, scene.frame_end = frames[:2]
        scene.frame_set(frames[2])
        for other in context.selected_objects:
            other.select_set(False)
        for other in selected:
            other.select_set(True)
        context.view_layer.objects.active = active
        self.new = {name: set(getattr(bpy.data, name)) - before[name] for name in IMPORTED}
        self.mesh = next(other for other in self.new["objects"] if other.type == "MESH")

    def remove(self) -> None:
        """Removes all that the import added."""
        for name, data in self.new.items():
            for each in data:
                getattr(bpy.data, name).remove(each)


def copy_shapes(object: bpy.types.Object, source: bpy.types.Object, first: int) -> int:
    """Copies the shape keys of an imported mesh and their curves to the face. Returns how many there are."""
    remove_baked(object)
    keys = source.data.shape_keys
    by_path = {curve.data_path: curve for curve in curves.of_action(keys)}
    if object.data.shape_keys is None:
        object.shape_key_add(name="Basis", from_mix=False)
    neutral, base = mesh.positions(object.data), mesh.key_positions(keys.key_blocks[0])
    # The shapes are displacements from a base of their own, which all frames have in common.
    common = object.shape_key_add(name=f"{NAME} base", from_mix=False)
    common.points.foreach_set("co", base.ravel())
    common.value = 1
    for number, key in enumerate(keys.key_blocks[1:]):
        made = object.shape_key_add(name=f"{NAME} {number + 1:02}", from_mix=False)
        # Those of Blender 5 begin at 1.
        made.value, made.slider_min, made.slider_max = 0, -10, 10
        made.points.foreach_set("co", (neutral + (mesh.key_positions(key) - base)).ravel())
        curve = by_path[f'key_blocks["{key.name}"].value']
        points = np.empty(2 * len(curve.keyframe_points), np.float32)
        curve.keyframe_points.foreach_get("co", points)
        frames, values = points.reshape(-1, 2).T
        path = f'key_blocks["{made.name}"].value'
        curves.set_keys(curves.curve(object.data.shape_keys, path), frames + first, values)
    object.data.update_tag()
    return len(keys.key_blocks) - 1


def remove_baked(object: bpy.types.Object) -> None:
    """Removes the shape keys of an earlier bake."""
    keys = object.data.shape_keys
    if keys is not None:
        for key in [key for key in keys.key_blocks if key.name.startswith(f"{NAME} ")]:
            object.shape_key_remove(key)


class BakeCache(Long, bpy.types.Operator):
    """Bake the take to a file that a modifier plays: USD or PC2"""

    bl_idname = "rhytid.bake_cache"
    bl_label = "Bake to a Cache"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(subtype="FILE_PATH", description="The file; without it, the path of the panel")

    def job(self, context: bpy.types.Context) -> Job:
        object = mesh.face_of(context)
        self.object, self.first = object.name, first_frame(object)
        given = self.filepath or object.rhytid.cache_path
        if given.startswith("//") and not bpy.data.filepath:
            raise Problem("the .blend file is not saved yet, so that nothing can be beside it; save it first")
        path, animation = Path(bpy.path.abspath(given)), animation_of(object, context.scene)
        # USD has time codes. In PC2, the modifier says which frame is the first.
        options: dict[str, Any] = {}
        if path.suffix.lower() != ".pc2":
            options = {"start_frame": self.first, "prim_path": PRIM, "mesh_name": MESH}

        def write(progress: Progress) -> Path:
            animation.write(path, progress=progress, **options)
            return path

        self.given = given
        return write

    def finish(self, context: bpy.types.Context, result: Path) -> set[str]:
        object = face.still_there(self.object)
        object.rhytid.playing = False
        mesh.remove_play_key(object)
        for modifier in [modifier for modifier in object.modifiers if modifier.name == NAME]:
            object.modifiers.remove(modifier)
        add_pc2(object, self.given, self.first) if result.suffix.lower() == ".pc2" else add_usd(object, self.given)
        self.report({"INFO"}, f"{result}")
        return {"FINISHED"}


def first_of_all(object: bpy.types.Object, kind: str) -> Any:
    """A new modifier above all others, so that those, such as a subdivision, are on top of the cache."""
    modifier = object.modifiers.new(NAME, kind)
    object.modifiers.move(len(object.modifiers) - 1, 0)
    return modifier


def add_pc2(object: bpy.types.Object, path: str, first: int) -> None:
    modifier = first_of_all(object, "MESH_CACHE")
    modifier.cache_format = "PC2"
    modifier.filepath = path
    modifier.frame_start = first


def add_usd(object: bpy.types.Object, path: str) -> None:
    before = set(bpy.data.cache_files)
    bpy.ops.cachefile.open(filepath=bpy.path.abspath(path))
    file = next(iter(set(bpy.data.cache_files) - before))
    file.filepath = path
    modifier = first_of_all(object, "MESH_SEQUENCE_CACHE")
    modifier.cache_file = file
    modifier.read_data = {"VERT"}
    modifier.object_path = f"{PRIM}/{MESH}"


class BakeHandles(bpy.types.Operator):
    """Make objects or bones for the handles, keyed as the take moves them, to drag and to animate further"""

    bl_idname = "rhytid.bake_handles"
    bl_label = "Bake to Handles"
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(
        name="As",
        items=(("EMPTIES", "Empties", "An empty for each handle"), ("BONES", "Bones", "A bone for each handle")),
    )
    keys: EnumProperty(
        name="Keys",
        items=(("TAKE", "Of the Take", "A key for each frame of the take"), ("NONE", "None", "Handles at rest")),
        default="TAKE",
    )

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        rig = store.rig(object)
        frames, places = None, None
        if self.keys == "TAKE":
            frames, places = in_frames(object, context.scene)
        if self.kind == "BONES":
            armature = controls.make_bones(object, rig, context)
            owners = [(armature, f'pose.bones["{label}"].location') for label in rig.labels]
        else:
            owners = [(empty, "location") for empty in controls.make_empties(object, rig, context.scene)]
        if frames is not None and places is not None:
            for number, (owner, path) in enumerate(owners):
                moved = places[:, number]
                if self.kind == "BONES":
                    # A bone along y at rest has the axes of its armature.
                    moved = moved - rig.handles[number]
                for axis in range(3):
                    curves.set_keys(curves.curve(owner, path, axis), frames, moved[:, axis])
        # The objects are where they are only after the scene was evaluated.
        context.view_layer.update()
        object.rhytid.source = "HANDLES"
        object.rhytid.playing = True
        context.scene.frame_set(context.scene.frame_current, subframe=context.scene.frame_subframe)
        self.report({"INFO"}, f"{len(owners)} handles")
        return {"FINISHED"}


def in_frames(object: bpy.types.Object, scene: bpy.types.Scene) -> tuple[np.ndarray, np.ndarray]:
    """The frames of the scene that a take has, and the frames × H × 3 places of its handles in them."""
    take, rig = store.take(object), store.rig(object)
    rate = scene.render.fps / scene.render.fps_base
    times = take.times - take.times[0]
    count = len(take) if timing.resampled(rate, take.rate) is None else int(np.floor(times[-1] * rate + 1e-6)) + 1
    wanted = np.arange(count) / rate
    column = {label: i for i, label in enumerate(take.labels)}
    positions = take.positions[:, [column[label] for label in rig.labels]]
    return object.rhytid.start + np.arange(count), tracks.at_times(positions, times, wanted)


CLASSES = (BakeShapes, BakeCache, BakeHandles)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
