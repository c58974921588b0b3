"""The tab Face: units, axes, examples, the doctor, and errors with the library's sentences."""

from __future__ import annotations

import math

import bpy
import numpy as np

import support
from support import Case, choose, demo, load, module


class Spaces(Case):
    def metres(self, object: bpy.types.Object) -> float:
        bpy.context.view_layer.update()
        return module("scene_space").metres_per_unit(object, bpy.context.scene)

    def up(self, object: bpy.types.Object) -> str:
        bpy.context.view_layer.update()
        return module("scene_space").up_axis(object)

    def test_the_unit_is_that_of_scene_and_object(self) -> None:
        face = load(demo / "neutral.obj")
        self.assertAlmostEqual(self.metres(face), 1)
        face.scale = (0.01, 0.01, 0.01)
        self.assertAlmostEqual(self.metres(face), 0.01)
        bpy.context.scene.unit_settings.scale_length = 0.1
        self.assertAlmostEqual(self.metres(face), 0.001)
        parent = bpy.data.objects.new("parent", None)
        bpy.context.scene.collection.objects.link(parent)
        parent.scale, face.parent = (10, 10, 10), parent
        self.assertAlmostEqual(self.metres(face), 0.01)
        face.rhytid.unit = "mm"
        self.assertEqual(self.metres(face), 0.001)
        face.rhytid.unit = "SCENE"
        face.scale = (0.01, 0.02, 0.01)
        choose(face)
        self.fails("apply its scale", bpy.ops.rhytid.handles_by_count)

    def test_up_is_that_of_the_scene(self) -> None:
        face = load(demo / "neutral.obj")
        # An OBJ has y up. Blender turns the object, and leaves the coordinates.
        self.assertEqual(self.up(face), "y")
        face.rotation_euler = (0, 0, 0)
        self.assertEqual(self.up(face), "z")
        face.rotation_euler = (0, math.pi / 2, 0)
        choose(face)
        self.fails("-x of the object neutral points up|x of the object neutral points up", bpy.ops.rhytid.solve)

    def test_a_turned_and_scaled_face_has_the_same_rig(self) -> None:
        face = self.face()
        bpy.ops.rhytid.solve()
        expected = module("store").rig(face).vertices
        former = face.rhytid.rig_hash
        parent = bpy.data.objects.new("parent", None)
        bpy.context.scene.collection.objects.link(parent)
        parent.location, parent.rotation_euler, parent.scale = (5, 1, 2), (0.2, -0.1, 2), (0.3, 0.3, 0.3)
        for object in [face, *[item.object for item in face.rhytid.examples]]:
            object.parent = parent
        bpy.context.view_layer.update()
        bpy.ops.rhytid.solve()
        self.assertEqual(face.rhytid.rig_hash, former)
        self.assertTrue(np.array_equal(module("store").rig(face).vertices, expected))

    def test_an_example_of_another_scale_is_brought_to_the_neutral(self) -> None:
        face = self.face()
        example = face.rhytid.examples[0].object
        expected = module("face").example_of(example, face).positions
        for vertex in example.data.vertices:
            vertex.co = 0.01 * vertex.co
        example.scale = (100, 100, 100)
        example.location = (70, 0, 0)
        bpy.context.view_layer.update()
        self.assert_near(module("face").example_of(example, face).positions, expected, 1e-6)


class Doctor(Case):
    def test_findings_select_their_vertices(self) -> None:
        face = self.face(poses=0)
        data = face.data
        count = len(data.vertices)
        data.vertices.add(3)
        bpy.ops.rhytid.doctor()
        found = {finding.code: index for index, finding in enumerate(face.rhytid.findings)}
        self.assertIn("no-examples", found)
        bpy.ops.rhytid.select_finding(index=found["isolated-vertices"])
        self.assertEqual(face.mode, "EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        chosen = np.zeros(count + 3, bool)
        data.vertices.foreach_get("select", chosen)
        self.assertEqual(np.flatnonzero(chosen).tolist(), [count, count + 1, count + 2])
        bpy.ops.rhytid.select_finding(index=found["no-examples"])
        self.fails("there is no finding 99", bpy.ops.rhytid.select_finding, index=99)

    def test_the_sentences_are_those_of_the_program(self) -> None:
        import json

        face = self.face()
        example = face.rhytid.examples[0].object
        example.data.vertices[8].co = (90, 90, 90)
        bpy.ops.rhytid.doctor()
        bpy.ops.rhytid.save_project(directory=str(self.folder))
        said = json.loads(support.program("doctor", self.folder / "face.toml", "--json"))["findings"]
        self.assertEqual([finding.name for finding in face.rhytid.findings], [finding["message"] for finding in said])
        self.assertIn("vertices-in-another-order", [finding.code for finding in face.rhytid.findings])


class Examples(Case):
    def test_a_folder_gives_the_rig_of_its_objects(self) -> None:
        face = self.face()
        bpy.ops.rhytid.solve()
        expected = module("store").rig(face)
        face.rhytid.examples_from, face.rhytid.folder = "FOLDER", str(demo / "poses")
        bpy.ops.rhytid.solve()
        found = module("store").rig(face)
        self.assertEqual(found.examples, expected.examples)
        handles = found.handles + np.linspace(0, 0.3, found.handles.size, dtype=np.float32).reshape(-1, 3)
        # The files have more digits than Blender's float32.
        moved = [rig.animator("cpu:0")(handles) for rig in (found, expected)]
        self.assert_near(moved[0], moved[1], 1e-5)

    def test_what_is_wrong_is_said(self) -> None:
        face = self.face()
        self.fails("only the neutral is selected", lambda: (choose(face), bpy.ops.rhytid.add_examples()))
        bpy.ops.mesh.primitive_cube_add()
        cube = bpy.context.object
        choose(face, cube)
        self.fails("the example Cube has 8 vertices where the neutral neutral has 2001", bpy.ops.rhytid.add_examples)
        self.assertEqual(len(face.rhytid.examples), 6)
        face.rhytid.examples.add().object = cube
        self.fails("every mesh needs the same vertices", bpy.ops.rhytid.solve)
        bpy.ops.rhytid.remove_example(index=6)
        self.assertEqual(len(face.rhytid.examples), 6)
        face.rhytid.examples_from, face.rhytid.folder = "FOLDER", str(self.folder / "none")
        self.fails("there is no such folder", bpy.ops.rhytid.solve)
        face.rhytid.folder = str(self.folder)
        self.fails("there is no mesh", bpy.ops.rhytid.solve)
        face.rhytid.examples_from = "OBJECTS"
        face.rhytid.pins = "skull"
        self.fails("has no vertex group “skull”", bpy.ops.rhytid.solve)
        face.rhytid.pins = ""
        face.rhytid.handles.clear()
        self.fails("has no handles yet", bpy.ops.rhytid.solve)
        self.assertEqual(face.rhytid.rig_hash, "")
        bpy.ops.object.camera_add()
        self.fails("no mesh is active", bpy.ops.rhytid.solve)

    def test_two_handles_at_a_vertex_are_the_librarys_error(self) -> None:
        face = self.face()
        face.rhytid.handles[1].vertices = face.rhytid.handles[0].vertices
        face.rhytid.handles[1].weights = (1, 0, 0)
        face.rhytid.handles[0].weights = (1, 0, 0)
        self.fails("each needs a vertex of its own", bpy.ops.rhytid.solve)

    def test_pins_stay_still(self) -> None:
        face = self.face()
        handles = {vertex for item in face.rhytid.handles for vertex in item.place.vertices}
        lowest = np.argsort(module("mesh").positions(face.data)[:, 2])[:300]
        pins = [int(vertex) for vertex in lowest if int(vertex) not in handles]
        face.vertex_groups.new(name="back").add(pins, 1.0, "REPLACE")
        face.vertex_groups.new(name="weak").add([3], 0.4, "REPLACE")
        face.rhytid.pins = "back"
        bpy.ops.rhytid.solve()
        rig = module("store").rig(face)
        moved = rig.animator("cpu:0")(rig.handles + np.float32(0.5))
        self.assertLess(np.abs(moved - rig.vertices)[pins].max(), 1e-5)
        self.assertGreater(np.abs(moved - rig.vertices).max(), 0.4)
        face.rhytid.pins = "weak"
        self.assertEqual(module("face").collect(face, bpy.context.scene).pins, [])
