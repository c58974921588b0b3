"""The whole path of a user: from an OBJ, six poses and a C3D to a keyed, baked face. Positions by the command line."""

from __future__ import annotations

import os
import subprocess
import sys
import unittest
from pathlib import Path

import bpy

import support
from support import DATA, Case, choose, evaluated, load, module, pc2, program


@unittest.skipUnless(DATA.is_dir(), "no scans in ../shared")
class WholePath(Case):
    def test_from_scans_and_a_capture_to_a_baked_face(self) -> None:
        poses = [load(path) for path in sorted((DATA / "face/poses").glob("*.obj"))[:6]]
        face = load(DATA / "face/neutral.obj")
        bpy.context.scene.render.fps = 24
        clicks = 0

        def click(operator, **options: object) -> None:
            nonlocal clicks
            self.assertEqual(operator(**options), {"FINISHED"})
            clicks += 1

        choose(face, *poses)
        face.rhytid.unit = "cm"
        click(bpy.ops.rhytid.add_examples)
        capture = DATA / "takes/rom_3_raw.c3d"
        click(bpy.ops.rhytid.handles_from_take, filepath=str(capture))
        self.assertGreaterEqual(len(face.rhytid.handles), 85)
        click(bpy.ops.rhytid.doctor)
        self.assertNotIn("error", [finding.severity for finding in face.rhytid.findings])
        click(bpy.ops.rhytid.solve)
        click(bpy.ops.rhytid.open_take, filepath=str(capture))
        marks = bpy.context.scene.timeline_markers
        self.assertTrue(0 < len(marks) <= 100)

        # The same project, rig and frames by the program.
        bpy.ops.rhytid.save_project(directory=str(self.folder))
        rig, file = self.folder / "face.safetensors", self.folder / "face.pc2"
        program("solve", self.folder / "face.toml", "-o", rig)
        program("animate", rig, capture, "-o", file, "--fps", 24, "--device", "cpu:0", "--no-normals")
        expected = pc2(file)
        self.assertEqual(len(expected), 480)
        for frame in (0, 1, 100, 333, 479):
            self.shows(face, frame, expected[frame])

        # A swap that the capture was given is marked where it is.
        swaps = [marker.frame for marker in marks if "swap" in marker.name]
        self.assertIn(round(900 / 120 * 24), swaps)

        # Keys of handles, and the face baked for good.
        click(bpy.ops.rhytid.bake_handles)
        bpy.context.scene.frame_set(200)
        self.assert_near(evaluated(face), expected[200], 2e-3)
        click(bpy.ops.rhytid.bake_shapes)
        bpy.context.scene.frame_set(200)
        self.assertFalse(face.rhytid.playing)
        self.assert_near(evaluated(face), expected[200], 1e-3)
        self.assertLessEqual(clicks, 7)


class SavedAndOpened(Case):
    def test_a_saved_file_plays_in_another_process(self) -> None:
        face = self.playing()
        expected = self.reference()
        face.rhytid.start = 5
        path = self.folder / "face.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        script = self.folder / "again.py"
        script.write_text(
            "import os, sys, bpy, numpy as np\n"
            "import support\n"
            "bpy.ops.preferences.addon_enable(module=support.ID)\n"
            "bpy.context.preferences.addons[support.ID].preferences.device = 'cpu:0'\n"
            "bpy.ops.wm.open_mainfile(filepath=sys.argv[1])\n"
            "face = bpy.data.objects['neutral']\n"
            "bpy.context.scene.frame_set(105)\n"
            "np.save(sys.argv[2], support.evaluated(face))\n"
            # The module of Blender 4.2 crashes where a process ends after a panel was registered.
            "os._exit(len(support.module('play').problems))\n"
        )
        here = Path(__file__).parent
        done = subprocess.run(
            [sys.executable, script, path, self.folder / "again.npy"],
            env={**os.environ, "PYTHONPATH": f"{here}{os.pathsep}{here.parent}"},
            capture_output=True,
            text=True,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        import numpy as np

        self.assert_near(np.load(self.folder / "again.npy"), expected[100])

    def test_files_open_again_in_the_same_process(self) -> None:
        self.playing()
        expected = self.reference()
        path = self.folder / "face.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        bpy.ops.wm.read_homefile(use_empty=True)
        bpy.ops.wm.open_mainfile(filepath=str(path))
        self.shows(bpy.data.objects["neutral"], 60, expected[60])

    def test_a_rig_beside_the_file(self) -> None:
        face = self.face()
        face.rhytid.store = "BESIDE"
        self.fails("is not saved yet", bpy.ops.rhytid.solve)
        path = self.folder / "face.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        bpy.ops.rhytid.solve()
        bpy.ops.rhytid.open_take(filepath=str(support.demo / "performance.csv"))
        bpy.ops.wm.save_mainfile()
        self.assertTrue((self.folder / "neutral.safetensors").is_file())
        self.assertEqual(face.rhytid.rig_path, "//neutral.safetensors")
        module("store").forget()
        bpy.ops.wm.open_mainfile(filepath=str(path))
        face = bpy.data.objects["neutral"]
        self.shows(face, 60, self.reference()[60])
        # Another rig in its place is found out.
        (self.folder / "neutral.safetensors").write_bytes((support.demo / "face.safetensors").read_bytes()[:-1])
        module("store").forget()
        bpy.ops.wm.open_mainfile(filepath=str(path))
        self.assertIn("is not the one that was solved", module("play").problems["neutral"])
        (self.folder / "neutral.safetensors").unlink()
        module("store").forget()
        self.fails("put the file back", bpy.ops.rhytid.update)

    def test_a_damaged_rig_is_named(self) -> None:
        face = self.playing()
        store = module("store")
        data = bytearray(face.rhytid.data[store.RIG])
        data[len(data) // 2] ^= 1
        store.put(face.rhytid.data, store.RIG, bytes(data))
        self.assertEqual(len(face.rhytid.data[store.RIG]), len(data))
        module("store").forget()
        self.fails("is not the one that was solved", bpy.ops.rhytid.update)
        del face.rhytid.data[store.RIG]
        self.fails("is gone from the .blend file", bpy.ops.rhytid.update)
        bpy.ops.rhytid.solve()
        store.put(face.rhytid.data, store.TAKE, b"no take")
        module("store").forget()
        self.fails("damaged; open the take again", bpy.ops.rhytid.update)
