"""The tab Face: the neutral, its examples, what the doctor finds, and the solve."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import rhytid
from bpy.props import IntProperty, StringProperty

from . import mesh, play, project, scene_space, store
from .problem import Problem, reported
from .work import Job, Long, Progress


def collect(object: bpy.types.Object, scene: bpy.types.Scene) -> project.Face:
    """The face of a neutral and its settings.

    Raises `Problem` for what no solve can use.
    """
    settings = object.rhytid
    vertices = mesh.positions(object.data)
    face = project.Face(
        name=object.name,
        vertices=vertices,
        faces=mesh.faces(object.data),
        metres_per_unit=scene_space.metres_per_unit(object, scene),
        up=scene_space.up_axis(object),
        handles=[item.place for item in settings.handles],
    )
    if settings.examples_from == "FOLDER":
        folder = Path(bpy.path.abspath(settings.folder))
        if not settings.folder or not folder.is_dir():
            raise Problem(f"{folder}: there is no such folder; choose the folder of the examples")
        face.files = project.meshes_of(folder, object.name)
        if not face.files:
            raise Problem(f"{folder}: there is no mesh, expected files such as smile.obj")
    elif settings.examples_from == "SHAPE_KEYS":
        keys = object.data.shape_keys
        named = [] if keys is None else [key for key in keys.key_blocks[1:] if key.name != mesh.KEY]
        face.examples = [project.Example(key.name, mesh.key_positions(key)) for key in named]
    else:
        face.examples = [example_of(item.object, object) for item in settings.examples if item.object is not None]
    if settings.pins:
        face.pins = np.flatnonzero(mesh.weights(object, settings.pins) >= 0.5).tolist()
    return face


def example_of(example: bpy.types.Object, neutral: bpy.types.Object) -> project.Example:
    """An object as an example of a neutral."""
    matrix = scene_space.example_in_neutral(example, neutral)
    positions = mesh.positions(example.data)
    # Where both objects stand alike, no number changes.
    moved = positions if np.allclose(matrix, np.eye(3), atol=1e-6) else positions @ matrix.T
    if len(moved) != len(neutral.data.vertices):
        raise Problem(
            f"the example {example.name} has {len(moved)} vertices where the neutral {neutral.name} has "
            f"{len(neutral.data.vertices)}; every mesh needs the same vertices in the same order"
        )
    return project.Example(example.name, moved)


def opened(face: project.Face, folder: str) -> rhytid.Face:
    """The face as the library has it. `folder` is empty."""
    if not face.handles:
        raise Problem("the face has no handles yet; place some in the tab Handles")
    return rhytid.Face.open(project.write(face, Path(folder)), allow_elsewhere=bool(face.files))


class AddExamples(bpy.types.Operator):
    """Make the other selected objects examples of the active one"""

    bl_idname = "rhytid.add_examples"
    bl_label = "Add Selected Objects"
    bl_options = {"REGISTER", "UNDO"}

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        examples = object.rhytid.examples
        known = {item.object for item in examples}
        added = [other for other in context.selected_objects if other.type == "MESH" and other != object]
        if not added:
            raise Problem("only the neutral is selected; select the examples too, the neutral last")
        for other in sorted(added, key=lambda other: other.name):
            if other not in known:
                example_of(other, object)
                examples.add().object = other
        object.rhytid.examples_from = "OBJECTS"
        return {"FINISHED"}


class RemoveExample(bpy.types.Operator):
    """Take an object out of the examples"""

    bl_idname = "rhytid.remove_example"
    bl_label = "Remove Example"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty()

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        mesh.face_of(context).rhytid.examples.remove(self.index)
        return {"FINISHED"}


class Doctor(Long, bpy.types.Operator):
    """Find what would harm the solve"""

    bl_idname = "rhytid.doctor"
    bl_label = "Examine"
    bl_options = {"REGISTER", "UNDO"}

    def job(self, context: bpy.types.Context) -> Job:
        object = mesh.face_of(context)
        self.object = object.name
        face = collect(object, context.scene)

        def examine(_progress: Progress) -> list[dict[str, Any]]:
            with tempfile.TemporaryDirectory() as folder:
                return opened(face, folder).doctor()

        return examine

    def finish(self, context: bpy.types.Context, result: list[dict[str, Any]]) -> set[str]:
        findings = still_there(self.object).rhytid.findings
        findings.clear()
        for found in result:
            item = findings.add()
            item.name, item.severity, item.code = found["message"], found["severity"], found["code"]
            item.vertices = " ".join(map(str, found["vertices"]))
        worst = {"error": "ERROR", "warning": "WARNING", "note": "INFO"}[result[0]["severity"]] if result else "INFO"
        if worst != "INFO":
            # An error report would cancel the operator, and the list is its result.
            self.report({"WARNING"}, result[0]["message"])
        else:
            self.report({"INFO"}, "Nothing would harm the solve")
        return {"FINISHED"}


def still_there(name: str) -> bpy.types.Object:
    """The object of this name.

    Raises `Problem` if it went while work was done for it.
    """
    object = bpy.data.objects.get(name)
    if object is None:
        raise Problem(f"the object {name} is gone, or has another name; try again")
    return object


class SelectFinding(bpy.types.Operator):
    """Select the vertices that the finding is about"""

    bl_idname = "rhytid.select_finding"
    bl_label = "Select Vertices"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty()

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        findings = object.rhytid.findings
        if not 0 <= self.index < len(findings):
            raise Problem(f"there is no finding {self.index}; examine the face again")
        finding = findings[self.index]
        object.rhytid.finding = self.index
        wanted = [int(vertex) for vertex in finding.vertices.split()]
        if not wanted:
            self.report({"INFO"}, "This finding is about no vertex in particular")
            return {"FINISHED"}
        if object.mode == "EDIT":
            bpy.ops.object.mode_set(mode="OBJECT")
        data = object.data
        chosen = np.zeros(len(data.vertices), bool)
        chosen[[vertex for vertex in wanted if vertex < len(chosen)]] = True
        # In object mode, selected faces and edges would select their vertices again.
        for elements in (data.polygons, data.edges):
            elements.foreach_set("select", np.zeros(len(elements), bool))
        data.vertices.foreach_set("select", chosen)
        context.scene.tool_settings.mesh_select_mode = (True, False, False)
        bpy.ops.object.mode_set(mode="EDIT")
        return {"FINISHED"}


class Solve(Long, bpy.types.Operator):
    """Make the rig that animates the face"""

    bl_idname = "rhytid.solve"
    bl_label = "Solve"
    bl_options = {"REGISTER", "UNDO"}

    def job(self, context: bpy.types.Context) -> Job:
        object = mesh.face_of(context)
        self.object = object.name
        face = collect(object, context.scene)

        def solve(progress: Progress) -> bytes:
            with tempfile.TemporaryDirectory() as folder:
                rig = opened(face, folder).solve(progress=progress)
                path = Path(folder) / "rig.safetensors"
                rig.save(path)
                return path.read_bytes()

        return solve

    def finish(self, context: bpy.types.Context, result: bytes) -> set[str]:
        object = still_there(self.object)
        store.put_rig(object, result)
        rig = store.rig(object)
        self.report({"INFO"}, f"The rig has {len(rig.labels)} handles and {len(rig.examples)} examples")
        play.refresh(context.scene)
        return {"FINISHED"}


class SaveProject(bpy.types.Operator):
    """Write the face as a project folder for the program rhytid"""

    bl_idname = "rhytid.save_project"
    bl_label = "Save Project"
    bl_options = {"REGISTER"}

    directory: StringProperty(subtype="DIR_PATH")

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        path = project.write(collect(object, context.scene), Path(bpy.path.abspath(self.directory)))
        self.report({"INFO"}, f"{path}")
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}


CLASSES = (AddExamples, RemoveExample, Doctor, SelectFinding, Solve, SaveProject)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
