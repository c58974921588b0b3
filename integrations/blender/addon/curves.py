"""Animation curves: actions have slots and layers from Blender 4.4 on, and nothing else from 5.0 on."""

from __future__ import annotations

import bpy
import numpy as np

#: The number of linear interpolation in Blender's list.
LINEAR = 1


def curve(owner: bpy.types.ID, path: str, index: int = -1) -> bpy.types.FCurve:
    """The curve of a property, without keys. It is made if there is none."""
    animation = owner.animation_data_create()
    if animation.action is None:
        animation.action = bpy.data.actions.new(f"{owner.name} Rhytid")
    action = animation.action
    if hasattr(action, "fcurve_ensure_for_datablock"):
        found = action.fcurve_ensure_for_datablock(owner, path, index=max(index, 0))
    else:
        found = action.fcurves.find(path, index=max(index, 0))
        if found is None:
            found = action.fcurves.new(path, index=max(index, 0))
    found.keyframe_points.clear()
    return found


def set_keys(curve: bpy.types.FCurve, frames: np.ndarray, values: np.ndarray) -> None:
    """Gives a curve a key for each frame, on straight lines."""
    points = curve.keyframe_points
    points.clear()
    points.add(len(frames))
    points.foreach_set("co", np.stack([frames, values], axis=1).astype(np.float32).ravel())
    points.foreach_set("interpolation", np.full(len(frames), LINEAR, np.int32))
    curve.update()


def of_action(owner: bpy.types.ID) -> list[bpy.types.FCurve]:
    """The curves of what animates a datablock."""
    animation = owner.animation_data
    if animation is None or animation.action is None:
        return []
    action = animation.action
    if not hasattr(action, "layers"):
        return list(action.fcurves)
    slot = animation.action_slot
    found: list[bpy.types.FCurve] = []
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(slot) if slot is not None else None
            if bag is not None:
                found.extend(bag.fcurves)
    return found
