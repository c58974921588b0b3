"""Objects and bones that move the handles, so that they can be dragged and keyed."""

from __future__ import annotations

import bpy
import numpy as np
import rhytid
from mathutils import Matrix, Vector

#: The size of an empty and the length of a bone, as a part of the face's size.
SIZE = 0.012


def size_of(rig: rhytid.Rig) -> float:
    """The size of a control, in the rig's unit."""
    return SIZE * float(np.linalg.norm(np.ptp(rig.vertices, axis=0)))


def collection_of(object: bpy.types.Object, scene: bpy.types.Scene) -> bpy.types.Collection:
    """The collection of a face's controls. It is made if there is none."""
    settings = object.rhytid
    if settings.controls is None:
        settings.controls = bpy.data.collections.new(f"{object.name} handles")
    if settings.controls.name not in scene.collection.children:
        scene.collection.children.link(settings.controls)
    return settings.controls


def make_empties(object: bpy.types.Object, rig: rhytid.Rig, scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """An empty for each handle, a child of the face, in the order of the rig. Those that are there stay."""
    collection = collection_of(object, scene)
    there = {control.rhytid_handle: control for control in collection.objects}
    empties = []
    for label, place in zip(rig.labels, rig.handles.tolist()):
        empty = there.get(label)
        if empty is None:
            empty = bpy.data.objects.new(label, None)
            empty.empty_display_type = "SPHERE"
            empty.empty_display_size = size_of(rig)
            empty.rhytid_handle = label
            collection.objects.link(empty)
            empty.parent = object
            empty.matrix_parent_inverse = Matrix.Identity(4)
            empty.location = place
        empties.append(empty)
    return empties


def make_bones(object: bpy.types.Object, rig: rhytid.Rig, context: bpy.types.Context) -> bpy.types.Object:
    """An armature with a bone for each handle, called as the handle. It is a child of the face.

    The armature that is there stays if it has all these bones.
    """
    there = object.rhytid.armature
    if there is not None and all(label in there.data.bones for label in rig.labels):
        return there
    armature = bpy.data.objects.new(f"{object.name} bones", bpy.data.armatures.new(f"{object.name} bones"))
    collection_of(object, context.scene).objects.link(armature)
    armature.parent = object
    armature.matrix_parent_inverse = Matrix.Identity(4)
    armature.show_in_front = True
    active, length = context.view_layer.objects.active, size_of(rig)
    if active is not None and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for label, place in zip(rig.labels, rig.handles.tolist()):
        bone = armature.data.edit_bones.new(label)
        bone.head = place
        bone.tail = Vector(place) + Vector((0, length, 0))
        bone.use_deform = False
    bpy.ops.object.mode_set(mode="OBJECT")
    context.view_layer.objects.active = active
    object.rhytid.armature = armature
    return armature
