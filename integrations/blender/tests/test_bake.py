"""The tab Bake: shape keys, caches and handles show what the program makes, without the add-on."""

from __future__ import annotations

import bpy
import numpy as np

from support import Case, choose, evaluated, module


class Bake(Case):
    def counts(self) -> dict[str, int]:
        names = ("objects", "meshes", "armatures", "materials", "collections", "cache_files")
        return {name: len(getattr(bpy.data, name)) for name in names}

    def test_shape_keys(self) -> None:
        face, expected = self.playing(), self.reference()
        face.rhytid.start, face.rhytid.shapes = 7, 30
        before = self.counts()
        scene = bpy.context.scene
        scene.frame_set(9)
        choose(face)
        bpy.ops.rhytid.bake_shapes()
        self.assertEqual((before, scene.frame_current, bpy.context.object), (self.counts(), 9, face))
        module("play").unregister()
        try:
            for frame in (0, 50, 100, 216):
                scene.frame_set(7 + frame)
                self.assert_near(evaluated(face), expected[frame], 2e-4)
        finally:
            module("play").register()
        keys = face.data.shape_keys.key_blocks
        self.assertEqual(len(keys), 32)
        # Again, in place of the first ones, with fewer.
        face.rhytid.playing, face.rhytid.shapes = True, 5
        bpy.ops.rhytid.bake_shapes()
        self.assertEqual(len(face.data.shape_keys.key_blocks), 7)
        scene.frame_set(107)
        self.assert_near(evaluated(face), expected[100], 5e-3)

    def test_caches(self) -> None:
        face, expected = self.playing(), self.reference()
        face.rhytid.start = 12
        face.modifiers.new("Subdivision", "SUBSURF").show_viewport = False
        face.rhytid.strain = True
        for name in ("face.usdc", "face.pc2"):
            with self.subTest(name):
                face.rhytid.playing = True
                bpy.ops.rhytid.bake_cache(filepath=str(self.folder / name))
                self.assertEqual([modifier.name for modifier in face.modifiers], ["Rhytid", "Subdivision"])
                self.assertIsNone(module("mesh").play_key(face))
                for frame in (0, 50, 216):
                    bpy.context.scene.frame_set(12 + frame)
                    self.assert_near(evaluated(face), expected[frame])
        face.rhytid.playing = True
        self.fails("is not saved yet", bpy.ops.rhytid.bake_cache)
        self.fails("face.txt", bpy.ops.rhytid.bake_cache, filepath=str(self.folder / "face.txt"))
        face.rhytid.start = 0.5
        self.fails("expected a whole frame", bpy.ops.rhytid.bake_cache, filepath=str(self.folder / "a.usdc"))

    def test_handles_as_empties_and_bones(self) -> None:
        for kind in ("EMPTIES", "BONES"):
            with self.subTest(kind):
                self.setUp()
                face, expected = self.playing(), self.reference()
                face.location, face.scale = (1, 2, 3), (0.1, 0.1, 0.1)
                face.rhytid.start = 5
                bpy.ops.rhytid.bake_handles(kind=kind)
                self.assertEqual(face.rhytid.source, "HANDLES")
                for frame in (0, 50, 216):
                    self.shows(face, 5 + frame, expected[frame])
                # Again: nothing is doubled.
                objects = len(bpy.data.objects)
                bpy.ops.rhytid.bake_handles(kind=kind)
                self.assertEqual(len(bpy.data.objects), objects)
                self.shows(face, 55, expected[50])

    def test_dragged_handles_move_the_face(self) -> None:
        face = self.playing()
        bpy.ops.rhytid.bake_handles(keys="NONE")
        rig = module("store").rig(face)
        self.shows(face, 30, rig.vertices)
        number = 7
        empty = next(each for each in face.rhytid.controls.objects if each.rhytid_handle == rig.labels[number])
        empty.location.z += 0.5
        bpy.context.view_layer.update()
        handles = rig.handles.copy()
        handles[number, 2] += 0.5
        expected = rig.animator("cpu:0")(handles)
        self.assertGreater(np.abs(expected - rig.vertices).max(), 0.3)
        self.assert_near(evaluated(face), expected)
        # A handle that is deleted is at rest.
        bpy.data.objects.remove(empty)
        self.shows(face, 31, rig.vertices)

    def test_handles_have_the_scenes_rate(self) -> None:
        bpy.context.scene.render.fps = 60
        face, expected = self.playing(), self.reference()
        bpy.ops.rhytid.bake_handles()
        self.shows(face, 100, expected[50])
