"""Positions of meshes as arrays, in and out. Modifiers do not matter."""

from __future__ import annotations

import bpy
import numpy as np

from .problem import Problem

#: The shape key that the face plays into, so that the mesh keeps its neutral.
KEY = "Rhytid"


def face_of(context: bpy.types.Context) -> bpy.types.Object:
    """The neutral: the active object, or the face whose handle is active.

    Raises `Problem` if there is none.
    """
    active = context.object
    if active is not None and active.type != "MESH" and active.parent is not None:
        active = active.parent
    if active is None or active.type != "MESH":
        raise Problem("no mesh is active; choose the object of the neutral face")
    return active


def positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """V × 3 vertices. With shape keys, those of the first one, which is the neutral."""
    if mesh.is_editmode:
        raise Problem(f"the mesh {mesh.name} is being edited; leave the edit mode (Tab) first")
    found = np.empty(3 * len(mesh.vertices), np.float32)
    if mesh.shape_keys is not None:
        mesh.shape_keys.key_blocks[0].points.foreach_get("co", found)
    else:
        mesh.vertices.foreach_get("co", found)
    return found.reshape(-1, 3)


def faces(mesh: bpy.types.Mesh) -> list[tuple[int, ...]]:
    """Each face's vertices."""
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    starts = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    ends = [*starts[1:].tolist(), len(vertices)]
    corners = vertices.tolist()
    return [tuple(corners[start:end]) for start, end in zip(starts.tolist(), ends)]


def key_positions(key: bpy.types.ShapeKey) -> np.ndarray:
    """V × 3 vertices of a shape key."""
    found = np.empty(3 * len(key.points), np.float32)
    key.points.foreach_get("co", found)
    return found.reshape(-1, 3)


def weights(object: bpy.types.Object, group: str) -> np.ndarray:
    """V weights of a vertex group.

    Raises `Problem` for a group that the object does not have.
    """
    found = object.vertex_groups.get(group)
    if found is None:
        raise Problem(f"the object {object.name} has no vertex group “{group}”; paint one, or choose another")
    result = np.zeros(len(object.data.vertices), np.float32)
    for vertex in object.data.vertices:
        for entry in vertex.groups:
            if entry.group == found.index:
                result[vertex.index] = entry.weight
    return result


def check_count(object: bpy.types.Object, vertices: int) -> None:
    """Raises `Problem` if the mesh has another number of vertices than the rig."""
    found = len(object.data.vertices)
    if found != vertices:
        raise Problem(
            f"the mesh of {object.name} has {found} vertices and its rig has {vertices}; "
            "undo what changed the mesh, or solve again"
        )


def show(object: bpy.types.Object, moved: np.ndarray) -> None:
    """Puts V × 3 positions into the shape key of the play, and makes the key if need be."""
    key = play_key(object)
    if key is None:
        if object.data.shape_keys is None:
            object.shape_key_add(name="Basis", from_mix=False)
        key = object.shape_key_add(name=KEY, from_mix=False)
        key.value = 1
    key.points.foreach_set("co", np.ascontiguousarray(moved, np.float32).ravel())
    object.data.update_tag()


def play_key(object: bpy.types.Object) -> bpy.types.ShapeKey | None:
    """The shape key that the face plays into, if there is one."""
    keys = object.data.shape_keys
    return None if keys is None else keys.key_blocks.get(KEY)


def other_keys(object: bpy.types.Object) -> list[str]:
    """The names of shape keys that add to what the face plays."""
    keys = object.data.shape_keys
    blocks = [] if keys is None else keys.key_blocks[1:]
    return [key.name for key in blocks if key.name != KEY and key.value != 0 and not key.mute]


def remove_play_key(object: bpy.types.Object) -> None:
    """Takes the shape key of the play away, and with it the last of the shape keys."""
    key = play_key(object)
    if key is not None:
        object.shape_key_remove(key)
        keys = object.data.shape_keys
        if keys is not None and len(keys.key_blocks) == 1:
            object.shape_key_remove(keys.key_blocks[0])


def write_attribute(mesh: bpy.types.Mesh, name: str, values: np.ndarray) -> None:
    """Writes V numbers or V × 3 numbers as an attribute that geometry nodes read."""
    kind, field = ("FLOAT", "value") if values.ndim == 1 else ("FLOAT_VECTOR", "vector")
    attribute = mesh.attributes.get(name)
    if attribute is not None and (attribute.data_type, attribute.domain) != (kind, "POINT"):
        mesh.attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = mesh.attributes.new(name, kind, "POINT")
    attribute.data.foreach_set(field, np.ascontiguousarray(values, np.float32).ravel())
