"""The tab Handles: where each marker is on the mesh. From a take, by count, clicked or moved by hand, mirrored."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np
import rhytid
from bpy.props import BoolProperty, FloatVectorProperty, IntProperty, StringProperty
from bpy_extras import view3d_utils
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from . import face, mesh, naming, project
from .problem import Problem, reported
from .work import Job, Long, Progress

#: A vertex is the mirror image of another one within this part of the mesh's size.
MIRRORED = 0.01


def positions_of(object: bpy.types.Object) -> np.ndarray:
    """H × 3 places of the handles at rest, in the mesh's coordinates."""
    vertices = mesh.positions(object.data)
    places = [item.place for item in object.rhytid.handles]
    found = [np.asarray(place.weights) @ vertices[list(place.vertices)] for place in places]
    return np.array(found).reshape(-1, 3)


def put_all(object: bpy.types.Object, handles: list[project.Handle]) -> None:
    """Replaces all handles."""
    items = object.rhytid.handles
    items.clear()
    for handle in handles:
        items.add().put(handle)
    object.rhytid.handle = 0


class Placed(Long):
    """Work whose result is a table of handles."""

    def finish(self, context: bpy.types.Context, result: list[project.Handle]) -> set[str]:
        put_all(face.still_there(self.object), result)
        self.report({"INFO"}, f"{len(result)} handles")
        return {"FINISHED"}


class HandlesByCount(Placed, bpy.types.Operator):
    """Spread handles evenly over the front of the face"""

    bl_idname = "rhytid.handles_by_count"
    bl_label = "Place by Count"
    bl_options = {"REGISTER", "UNDO"}

    def job(self, context: bpy.types.Context) -> Job:
        object = mesh.face_of(context)
        self.object = object.name
        count, of_face = object.rhytid.count, face.collect(object, context.scene)
        of_face.handles = []
        return lambda progress: placed(of_face, None, progress, count=count)


class HandlesFromTake(Placed, bpy.types.Operator):
    """Find where each marker of a take is on the mesh"""

    bl_idname = "rhytid.handles_from_take"
    bl_label = "Place from a Take"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(subtype="FILE_PATH")

    def job(self, context: bpy.types.Context) -> Job:
        object = mesh.face_of(context)
        self.object = object.name
        given = self.filepath or object.rhytid.take_path
        if not given:
            raise Problem("no file is chosen; choose the take's file in the tab Take first")
        take, of_face = Path(bpy.path.abspath(given)), face.collect(object, context.scene)
        of_face.handles = []
        return lambda progress: placed(of_face, take, progress)


def placed(
    of_face: project.Face, take: Path | None, progress: Progress, count: int | None = None
) -> list[project.Handle]:
    """The handles that the library places."""
    with tempfile.TemporaryDirectory() as folder:
        path = project.write(of_face, Path(folder))
        table = Path(folder) / "markers.csv"
        elsewhere = {"allow_elsewhere": True} if of_face.files else {}
        by = {"count": count} if take is None else {"picture": Path(folder) / "handles.png"}
        rhytid.handles(path, take, output=table, progress=progress, **by, **elsewhere)
        return project.read_handles(table)


def chosen_vertex(object: bpy.types.Object) -> int:
    """The one vertex that is selected.

    Raises `Problem` for none or several.
    """
    if object.mode == "EDIT":
        object.update_from_editmode()
    selected = np.zeros(len(object.data.vertices), bool)
    object.data.vertices.foreach_get("select", selected)
    found = np.flatnonzero(selected)
    if len(found) != 1:
        raise Problem(f"{len(found)} vertices are selected, expected one; select the vertex in the edit mode")
    return int(found[0])


def put_at(object: bpy.types.Object, name: str, vertex: int, index: int | None) -> None:
    """Puts a handle at a vertex: a new one, or the one of this index.

    Raises `Problem` if another handle is there.
    """
    items = object.rhytid.handles
    for number, item in enumerate(items):
        if number != index and item.place.vertices == (vertex,):
            raise Problem(f"the handle {item.name} is at vertex {vertex} already; choose another vertex")
    if index is None:
        taken = {item.name for item in items}
        index = len(items)
        items.add().put(project.Handle(naming.free(name, taken), (vertex,)))
    else:
        items[index].put(project.Handle(items[index].name, (vertex,)))
    object.rhytid.handle = index


def active_handle(object: bpy.types.Object) -> int:
    """The index of the handle that is chosen in the list.

    Raises `Problem` if there is none.
    """
    index = object.rhytid.handle
    if not 0 <= index < len(object.rhytid.handles):
        raise Problem("no handle is chosen; choose one in the list")
    return index


class AddHandle(bpy.types.Operator):
    """Put a handle at the selected vertex"""

    bl_idname = "rhytid.add_handle"
    bl_label = "Add at Vertex"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", default="handle")
    vertex: IntProperty(name="Vertex", default=-1, description="The vertex, from 0; -1 for the selected one")

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        vertex = self.vertex if self.vertex >= 0 else chosen_vertex(object)
        if vertex >= len(object.data.vertices):
            raise Problem(f"there is no vertex {vertex}, expected 0 to {len(object.data.vertices) - 1}")
        put_at(object, self.name, vertex, None)
        return {"FINISHED"}


class MoveHandle(bpy.types.Operator):
    """Move the chosen handle to the selected vertex"""

    bl_idname = "rhytid.move_handle"
    bl_label = "Move to Vertex"
    bl_options = {"REGISTER", "UNDO"}

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        put_at(object, "", chosen_vertex(object), active_handle(object))
        return {"FINISHED"}


class ClickHandle(bpy.types.Operator):
    """Click on the face to put a handle there, or to move the chosen one; Esc ends"""

    bl_idname = "rhytid.click_handle"
    bl_label = "Click"
    bl_options = {"REGISTER", "UNDO"}

    move: BoolProperty(name="Move the Chosen One")
    origin: FloatVectorProperty(size=3, name="Origin", description="Where the ray begins, in the world")
    direction: FloatVectorProperty(size=3, name="Direction", description="Where the ray goes, in the world")

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        vertex = hit_vertex(object, Vector(self.origin), Vector(self.direction))
        put_at(object, "handle", vertex, active_handle(object) if self.move else None)
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if context.region_data is None:
            return self.execute(context)
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set("Rhytid: click on the face    (Esc ends)")
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"}:
            context.workspace.status_text_set(None)
            return {"FINISHED"}
        if event.type == "LEFTMOUSE" and event.value == "PRESS" and context.region_data is not None:
            at = (event.mouse_region_x, event.mouse_region_y)
            self.origin = view3d_utils.region_2d_to_origin_3d(context.region, context.region_data, at)
            self.direction = view3d_utils.region_2d_to_vector_3d(context.region, context.region_data, at)
            if self.execute(context) == {"FINISHED"}:
                bpy.ops.ed.undo_push(message="Handle")
            return {"RUNNING_MODAL"}
        return {"PASS_THROUGH"}


def hit_vertex(object: bpy.types.Object, origin: Vector, direction: Vector) -> int:
    """The vertex of the first face on a ray of the world that is nearest to where the ray hits it.

    Raises `Problem` for a ray beside the face.
    """
    to_object = object.matrix_world.inverted()
    # The neutral is asked, and not what modifiers make of it.
    vertices = mesh.positions(object.data)
    tree = BVHTree.FromPolygons(vertices.tolist(), mesh.faces(object.data))
    at, _normal, polygon, _distance = tree.ray_cast(to_object @ origin, to_object.to_3x3() @ direction)
    if at is None:
        raise Problem("there is no face below the mouse; click on the face")
    corners = list(object.data.polygons[polygon].vertices)
    return corners[int(np.argmin(np.linalg.norm(vertices[corners] - np.array(at), axis=1)))]


class MirrorHandles(bpy.types.Operator):
    """Put a handle on the other side of x for each whose name says a side, such as brow_l"""

    bl_idname = "rhytid.mirror_handles"
    bl_label = "Mirror"
    bl_options = {"REGISTER", "UNDO"}

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        vertices, items = mesh.positions(object.data), object.rhytid.handles
        size = np.linalg.norm(np.ptp(vertices, axis=0))
        taken = {item.name for item in items}
        made = []
        for item in list(items):
            name = naming.mirrored(item.name)
            if name is None or name in taken:
                continue
            images = [image_of(vertices, vertex, size) for vertex in item.place.vertices]
            if None in images:
                raise Problem(
                    f"the handle {item.name} has no vertex on the other side of x; "
                    "mirror works on faces that are alike on both sides of x"
                )
            made.append(project.Handle(name, tuple(images), item.place.weights))
        for handle in made:
            items.add().put(handle)
        self.report({"INFO"}, f"{len(made)} handles on the other side")
        return {"FINISHED"}


def image_of(vertices: np.ndarray, vertex: int, size: float) -> int | None:
    """The vertex on the other side of x, if there is one."""
    distances = np.linalg.norm(vertices - vertices[vertex] * (-1, 1, 1), axis=1)
    nearest = int(distances.argmin())
    return nearest if distances[nearest] <= MIRRORED * size else None


class RemoveHandle(bpy.types.Operator):
    """Remove the chosen handle"""

    bl_idname = "rhytid.remove_handle"
    bl_label = "Remove"
    bl_options = {"REGISTER", "UNDO"}

    every: BoolProperty(name="All")

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        if self.every:
            object.rhytid.handles.clear()
        else:
            object.rhytid.handles.remove(active_handle(object))
        object.rhytid.handle = max(0, min(object.rhytid.handle, len(object.rhytid.handles) - 1))
        return {"FINISHED"}


class AddRegion(bpy.types.Operator):
    """Make the active vertex group a region with a detail of its own"""

    bl_idname = "rhytid.add_region"
    bl_label = "Add Painted Region"
    bl_options = {"REGISTER", "UNDO"}

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        group = object.vertex_groups.active
        if group is None:
            raise Problem(f"the object {object.name} has no vertex group; paint the region's weights first")
        if group.name in object.rhytid.regions:
            raise Problem(f"the vertex group {group.name} is a region already")
        object.rhytid.regions.add().name = group.name
        return {"FINISHED"}


class RemoveRegion(bpy.types.Operator):
    """Take a region away; its vertex group stays"""

    bl_idname = "rhytid.remove_region"
    bl_label = "Remove Region"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty()

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        mesh.face_of(context).rhytid.regions.remove(self.index)
        return {"FINISHED"}


CLASSES = (
    HandlesByCount,
    HandlesFromTake,
    AddHandle,
    MoveHandle,
    ClickHandle,
    MirrorHandles,
    RemoveHandle,
    AddRegion,
    RemoveRegion,
)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
