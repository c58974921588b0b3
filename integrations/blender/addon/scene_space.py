"""The space of the neutral's own coordinates: its unit and its upward axis in the scene."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector

from .problem import Problem

#: Metres in the units that a face can name.
METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}


def metres_per_unit(object: bpy.types.Object, scene: bpy.types.Scene) -> float:
    """Metres in one unit of the mesh's coordinates.

    Raises `Problem` for an object that is scaled unevenly.
    """
    if object.rhytid.unit != "SCENE":
        return METRES[object.rhytid.unit]
    scales = [abs(scale) for scale in object.matrix_world.to_scale()]
    if max(scales) > 1.001 * min(scales):
        shown = ", ".join(f"{scale:.4g}" for scale in scales)
        raise Problem(
            f"the object {object.name} is scaled by {shown}, expected the same along each axis; "
            "apply its scale (Ctrl-A), or choose a unit"
        )
    return sum(scales) / 3 * scene.unit_settings.scale_length


def up_axis(object: bpy.types.Object) -> str:
    """The axis of the mesh's coordinates that points up in the scene, `y` or `z`.

    Raises `Problem` if it is another one.
    """
    up = object.matrix_world.to_quaternion().inverted() @ Vector((0, 0, 1))
    axis = max(range(3), key=lambda i: abs(up[i]))
    if axis == 0 or up[axis] < 0:
        found = ("-" if up[axis] < 0 else "") + "xyz"[axis]
        raise Problem(
            f"the {found} of the object {object.name} points up, expected its y or its z; "
            "turn the object upright, or apply its rotation (Ctrl-A)"
        )
    return "xyz"[axis]


def example_in_neutral(example: bpy.types.Object, neutral: bpy.types.Object) -> np.ndarray:
    """The 3 × 3 matrix from an example's coordinates to the neutral's.

    Where an example stands in the scene does not count, so that examples may stand side by side.
    """
    return np.array(neutral.matrix_world.to_3x3().inverted() @ example.matrix_world.to_3x3())


def in_object(object: bpy.types.Object, points: np.ndarray) -> np.ndarray:
    """N × 3 points of the world in the object's coordinates."""
    matrix = np.array(object.matrix_world.inverted())
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def in_world(object: bpy.types.Object, points: np.ndarray) -> np.ndarray:
    """N × 3 points of the object's coordinates in the world."""
    matrix = np.array(object.matrix_world)
    return points @ matrix[:3, :3].T + matrix[:3, 3]
