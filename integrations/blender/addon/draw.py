"""Dots and names of the handles in the viewport."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector

from . import handles, mesh, scene_space
from .problem import Problem

#: Colours: a handle, and the chosen one.
DOT, CHOSEN = (0.25, 0.55, 1.0, 1.0), (1.0, 0.55, 0.1, 1.0)
#: The size of a dot, and of a name, in pixels of a display without scaling.
SIZE, TEXT = 7.0, 11

_handlers: list[Any] = []


def points_of(context: bpy.types.Context) -> tuple[list[str], np.ndarray, int] | None:
    """The labels, the H × 3 places in the world and the chosen one of the handles to draw. `None` for none."""
    try:
        object = mesh.face_of(context)
        if not object.rhytid.handles or object.data.is_editmode:
            return None
        places = scene_space.in_world(object, handles.positions_of(object))
    except (Problem, IndexError):
        # The mesh has changed under its handles; the doctor says so.
        return None
    return [item.name for item in object.rhytid.handles], places, object.rhytid.handle


def draw_dots() -> None:
    found = points_of(bpy.context)
    if found is None:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    labels, places, chosen = found
    colors = [CHOSEN if number == chosen else DOT for number in range(len(labels))]
    shader = gpu.shader.from_builtin("FLAT_COLOR")
    batch = batch_for_shader(shader, "POINTS", {"pos": places.astype(np.float32).tolist(), "color": colors})
    gpu.state.depth_test_set("NONE")
    gpu.state.point_size_set(SIZE * bpy.context.preferences.system.ui_scale)
    batch.draw(shader)
    gpu.state.point_size_set(1)


def draw_names() -> None:
    found = points_of(bpy.context)
    if found is None or bpy.context.region_data is None:
        return
    import blf

    labels, places, chosen = found
    scale = bpy.context.preferences.system.ui_scale
    blf.size(0, TEXT * scale)
    for number, (label, place) in enumerate(zip(labels, places)):
        at = view3d_utils.location_3d_to_region_2d(bpy.context.region, bpy.context.region_data, Vector(place))
        if at is not None:
            blf.color(0, *(CHOSEN if number == chosen else DOT))
            blf.position(0, at.x + SIZE * scale, at.y - 0.4 * TEXT * scale, 0)
            blf.draw(0, label)


def register() -> None:
    # Without a window there is nothing to draw into.
    if not bpy.app.background:
        for function, kind in ((draw_dots, "POST_VIEW"), (draw_names, "POST_PIXEL")):
            _handlers.append(bpy.types.SpaceView3D.draw_handler_add(function, (), "WINDOW", kind))


def unregister() -> None:
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
