"""Faces follow the frame: times, objects, modes and modifiers as animators have them."""

from __future__ import annotations

import bpy
import numpy as np

from support import Case, choose, demo, evaluated, module


class Times(Case):
    def test_each_frame_is_that_of_the_program(self) -> None:
        face, expected = self.playing(), self.reference()
        for frame in (0, 1, 50, 216):
            self.shows(face, frame, expected[frame])

    def test_before_and_after_the_take_it_holds(self) -> None:
        face, expected = self.playing(), self.reference()
        face.rhytid.start = 10
        self.shows(face, -5, expected[0])
        self.shows(face, 10, expected[0])
        self.shows(face, 11, expected[1])
        self.shows(face, 1000, expected[-1])

    def test_between_two_frames_it_is_on_the_line(self) -> None:
        face, expected = self.playing(), self.reference()
        self.shows(face, 60.25, 0.75 * expected[60] + 0.25 * expected[61])

    def test_seconds_count_in_a_scene_of_another_rate(self) -> None:
        face = self.playing()
        for fps, base, words in ((24, 1, 24), (60, 1, 60), (30, 1.001, 30 / 1.001)):
            bpy.context.scene.render.fps, bpy.context.scene.render.fps_base = fps, base
            expected = self.reference("--fps", repr(words))
            for frame in (0, 33, len(expected) - 1):
                self.shows(face, frame, expected[frame])

    def test_the_detail_is_that_of_the_program(self) -> None:
        face = self.playing()
        face.rhytid.detail = 0.25
        expected = self.reference("--detail", "0.25")
        self.shows(face, 100, expected[100])
        whole = self.reference()
        self.assertGreater(np.abs(whole[100] - expected[100]).max(), 1e-3)
        # With keys, the detail changes from frame to frame.
        face.rhytid.detail = 0
        face.rhytid.keyframe_insert("detail", frame=0)
        face.rhytid.detail = 1
        face.rhytid.keyframe_insert("detail", frame=200)
        for curve in module("curves").of_action(face):
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
        without = self.reference("--detail", "0")
        self.shows(face, 100, 0.5 * (without[100] + whole[100]))
        self.fails("the detail has keys", bpy.ops.rhytid.bake_shapes)

    def test_painted_regions_have_a_detail_of_their_own(self) -> None:
        face, whole = self.playing(), self.reference()
        upper = np.flatnonzero(whole[0][:, 1] > 0).tolist()
        face.vertex_groups.new(name="upper").add(upper, 1.0, "REPLACE")
        bpy.ops.rhytid.add_region()
        face.rhytid.regions[0].detail = 0
        bpy.context.scene.frame_set(100)
        shown = evaluated(face)
        without = self.reference("--detail", "0")
        lower = np.setdiff1d(np.arange(len(shown)), upper)
        self.assertLess(np.abs(shown[upper] - without[100][upper]).max(), 1e-5)
        self.assertLess(np.abs(shown[lower] - whole[100][lower]).max(), 1e-5)
        self.fails("is a region already", bpy.ops.rhytid.add_region)

    def test_attributes_are_the_channels_of_the_program(self) -> None:
        face = self.playing()
        import rhytid

        rig = rhytid.Rig.open(demo / "face.safetensors")
        take = rhytid.Take.open(demo / "performance.csv", rig)
        frame = rig.play(take, device="cpu:0", strain=True, wrinkles=True, sigma=True)[80]
        face.rhytid.strain = face.rhytid.wrinkles = face.rhytid.sigma = True
        bpy.context.scene.frame_set(80)
        self.assertEqual(module("play").problems, {})

        def attribute(name: str, field: str = "value") -> np.ndarray:
            data = face.data.attributes[name].data
            values = np.empty(len(data) * (3 if field == "vector" else 1), np.float32)
            data.foreach_get(field, values)
            return values

        # The two rigs differ in their last digits.
        near = dict(rtol=1e-3, atol=1e-4)
        self.assertTrue(np.allclose(attribute("sigma"), frame["sigma"], **near))
        self.assertTrue(np.allclose(attribute("strain1"), frame["strain"][:, 0], **near))
        self.assertTrue(np.allclose(attribute("wrinkle_smile"), frame["wrinkle_smile"], **near))
        self.assertGreater(attribute("strain1").max(), 0.05)
        directions = attribute("strainDirection1", "vector").reshape(-1, 3)
        # Where the skin is stretched alike in all directions, none is the first.
        clear = frame["strain"][:, 0] - frame["strain"][:, 1] > 0.05
        along = np.abs((directions * frame["strainDirection1"]).sum(1))
        self.assertTrue(clear.sum() > 100 and along[clear].min() > 0.999)
        # They reach the evaluated mesh, where geometry nodes are.
        shown = face.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        self.assertIn("strain1", shown.attributes)


class Objects(Case):
    def test_the_world_transform_does_not_matter(self) -> None:
        face, expected = self.playing(), self.reference()
        parent = bpy.data.objects.new("parent", None)
        bpy.context.scene.collection.objects.link(parent)
        parent.location, parent.scale, parent.rotation_euler = (1, 2, 3), (2, 2, 2), (0.3, 0.2, 1)
        face.parent = parent
        self.shows(face, 60, expected[60])

    def test_a_subdivision_stays_on_top(self) -> None:
        face, expected = self.playing(), self.reference()
        modifier = face.modifiers.new("Subdivision", "SUBSURF")
        modifier.levels = 1
        bpy.context.scene.frame_set(60)
        fine = evaluated(face)
        self.assertGreater(len(fine), 3 * len(expected[0]))
        modifier.show_viewport = False
        self.shows(face, 60, expected[60])

    def test_the_neutral_stays(self) -> None:
        face = self.playing()
        neutral = module("mesh").positions(face.data)
        bpy.context.scene.frame_set(60)
        self.assertTrue(np.array_equal(module("mesh").positions(face.data), neutral))
        self.assertGreater(np.abs(evaluated(face) - neutral).max(), 0.1)
        # A solve while it plays is that of the neutral.
        former = face.rhytid.rig_hash
        bpy.ops.rhytid.solve()
        self.assertEqual(face.rhytid.rig_hash, former)
        bpy.ops.rhytid.play()
        self.assert_near(evaluated(face), neutral, 1e-7)

    def test_in_edit_mode_the_mesh_is_left_alone(self) -> None:
        face, expected = self.playing(), self.reference()
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.context.scene.frame_set(60)
        self.assertEqual(module("play").problems, {})
        bpy.ops.object.mode_set(mode="OBJECT")
        self.shows(face, 61, expected[61])

    def test_two_faces_in_a_scene(self) -> None:
        first, expected = self.playing(), self.reference()
        second = self.playing()
        self.assertNotEqual(first.name, second.name)
        second.rhytid.start = 20
        bpy.context.scene.frame_set(80)
        self.assert_near(evaluated(first), expected[80])
        self.assert_near(evaluated(second), expected[60])

    def test_linked_duplicates_show_the_same(self) -> None:
        face, expected = self.playing(), self.reference()
        copied = face.copy()
        bpy.context.scene.collection.objects.link(copied)
        self.shows(face, 60, expected[60])
        self.assert_near(evaluated(copied), expected[60])
        # A copy with a rig of its own leaves the first one's alone.
        choose(copied)
        copied.data = face.data.copy()
        former = face.rhytid.rig_hash
        copied.rhytid.examples.remove(0)
        bpy.ops.rhytid.solve()
        self.assertNotEqual(copied.rhytid.rig_hash, former)
        module("store").forget()
        module("play").forget()
        self.shows(face, 61, expected[61])

    def test_a_face_of_another_file_is_left_alone_and_says_so(self) -> None:
        name = self.playing().name
        file = str(self.folder / "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=file)
        bpy.ops.wm.read_homefile(use_empty=True)
        with bpy.data.libraries.load(file, link=True) as (_there, wanted):
            wanted.objects = [name]
        bpy.context.scene.collection.objects.link(wanted.objects[0])
        before = evaluated(wanted.objects[0])
        bpy.context.scene.frame_set(60)
        self.assertIn("make it local to play it", module("play").problems[name])
        self.assert_near(evaluated(wanted.objects[0]), before)

    def test_a_face_may_be_renamed_and_deleted(self) -> None:
        face, expected = self.playing(), self.reference()
        bpy.context.scene.frame_set(10)
        face.name = "anna"
        self.shows(face, 60, expected[60])
        bpy.data.objects.remove(face)
        bpy.context.scene.frame_set(61)
        self.assertEqual((module("play").problems, module("play")._players), ({}, {}))

    def test_another_mesh_is_named(self) -> None:
        face = self.playing()
        face.data = bpy.data.meshes.new("other")
        bpy.context.scene.frame_set(3)
        self.assertIn("has 0 vertices and its rig has 2001", module("play").problems[face.name])

    def test_shape_keys_of_the_neutral_are_examples_and_stay(self) -> None:
        neutral = self.face()
        positions = {item.object.name: module("mesh").positions(item.object.data) for item in neutral.rhytid.examples}
        neutral.shape_key_add(name="Basis")
        for name, moved in positions.items():
            key = neutral.shape_key_add(name=name)
            key.points.foreach_set("co", moved.ravel())
            key.value = 0
        bpy.ops.rhytid.solve()
        of_objects = neutral.rhytid.rig_hash
        neutral.rhytid.examples_from = "SHAPE_KEYS"
        bpy.ops.rhytid.solve()
        self.assertEqual(neutral.rhytid.rig_hash, of_objects)
        bpy.ops.rhytid.open_take(filepath=str(demo / "performance.csv"))
        self.shows(neutral, 60, self.reference()[60])
        self.assertEqual(len(neutral.data.shape_keys.key_blocks), 1 + len(positions) + 1)
        # A shape key that is on adds to the face, which is said.
        neutral.data.shape_keys.key_blocks["smile"].value = 0.5
        self.assertEqual(module("mesh").other_keys(neutral), ["smile"])
        module("mesh").remove_play_key(neutral)
        self.assertEqual(len(neutral.data.shape_keys.key_blocks), 1 + len(positions))


class Undo(Case):
    def test_undo_and_redo_find_all_again(self) -> None:
        face, expected = self.playing(), self.reference()
        bpy.ops.ed.undo_push(message="play")
        bpy.context.object.rhytid.detail = 0
        bpy.ops.ed.undo_push(message="detail")
        without = self.reference("--detail", "0")
        self.shows(face, 60, without[60])
        bpy.ops.ed.undo()
        face = bpy.data.objects["neutral"]
        self.shows(face, 60, expected[60])
        bpy.ops.ed.redo()
        self.shows(bpy.data.objects["neutral"], 60, without[60])

    def test_what_kept_a_face_from_playing_is_forgotten_with_an_undo(self) -> None:
        face = self.playing()
        bpy.ops.ed.undo_push(message="play")
        face.rhytid.rig_hash = ""
        bpy.ops.ed.undo_push(message="no rig")
        bpy.context.scene.frame_set(60)
        self.assertIn("has no rig yet", module("play").problems["neutral"])
        bpy.ops.ed.undo()
        self.assertEqual(module("play").problems, {})

    def test_a_solve_can_be_undone(self) -> None:
        face = self.face()
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.rhytid.solve()
        bpy.ops.ed.undo_push(message="solve")
        self.assertTrue(face.rhytid.rig_hash)
        bpy.ops.ed.undo()
        self.assertEqual(bpy.data.objects["neutral"].rhytid.rig_hash, "")
        self.assertNotIn("neutral.rhytid", bpy.data.texts)
        bpy.ops.ed.redo()
        bpy.ops.rhytid.open_take(filepath=str(demo / "performance.csv"))
        self.shows(bpy.data.objects["neutral"], 60, self.reference()[60])


class Memory(Case):
    def test_frames_are_kept_within_a_bound(self) -> None:
        face, expected = self.playing(), self.reference()
        player = module("player")
        former = player.MOST_BYTES
        player.MOST_BYTES = 20 * expected[0].nbytes
        try:
            for frame in range(217):
                bpy.context.scene.frame_set(frame)
            plays = module("play")._players[face.name]
            self.assertLessEqual(len(plays.kept), 20)
            self.assertEqual(plays.bytes, sum(player.size(frames) for frames in plays.kept.values()))
            self.shows(face, 3, expected[3])
        finally:
            player.MOST_BYTES = former

    def test_only_the_next_frames_are_computed_ahead(self) -> None:
        face, expected = self.playing(), self.reference()
        for frame in (0, 1):
            self.shows(face, frame, expected[frame])
        plays, ahead = module("play")._players[face.name], module("player").AHEAD
        self.assertEqual(plays.coming.frames, range(2, 2 + ahead))
        for frame in range(2, 60):
            self.shows(face, frame, expected[frame])
            last = max([*plays.kept, *(plays.coming.frames if plays.coming else ())])
            self.assertLessEqual(last, frame + 2 * ahead)
        # Where the scene jumps, a frame is computed alone.
        self.shows(face, 200, expected[200])
        self.assertNotIn(201, plays.kept)
        # Where the next frames were shown before, none is computed.
        plays.coming = None
        for frame in (0, 1, 2):
            self.shows(face, frame, expected[frame])
        self.assertIsNone(plays.coming)

    def test_memory_does_not_grow(self) -> None:
        self.playing()
        scene = bpy.context.scene

        def resident() -> int:
            with open("/proc/self/statm") as file:
                return int(file.read().split()[1]) * 4096

        for frame in range(600):
            scene.frame_set(frame % 217)
        before = resident()
        for frame in range(3000):
            scene.frame_set(frame % 217)
        # At 25 frames a second, an hour has 90,000 frames: less than 60 MB.
        self.assertLess(resident() - before, 2_000_000)
