"""The zip: the same bytes for the same input, and right by Blender's own check."""

from __future__ import annotations

import subprocess
import sys
import tomllib
import unittest
import zipfile
from pathlib import Path

import bpy

import build
import support
from support import VERSION


class Zip(unittest.TestCase):
    def test_it_is_right_by_blenders_own_check(self) -> None:
        tool = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core/bl_pkg/cli/blender_ext.py"
        done = subprocess.run(
            [sys.executable, tool, "validate", support.folder / "rhytid.zip"], capture_output=True, text=True
        )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        # The check finds faults.
        broken = support.folder / "broken.zip"
        with zipfile.ZipFile(support.folder / "rhytid.zip") as source, zipfile.ZipFile(broken, "w") as target:
            for name in source.namelist():
                if name.endswith(".toml"):
                    target.writestr(name, source.read(name).replace(b'type = "add-on"', b'type = "addon"'))
        done = subprocess.run([sys.executable, tool, "validate", broken], capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)

    def test_the_manifest_names_what_is_inside(self) -> None:
        with zipfile.ZipFile(support.folder / "rhytid.zip") as archive:
            names = archive.namelist()
            manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        self.assertEqual((manifest["version"], manifest["platforms"]), (VERSION, ["linux-x64"]))
        [wheel] = manifest["wheels"]
        self.assertIn(wheel.removeprefix("./"), names)
        self.assertEqual(set(manifest["permissions"]), {"files", "network"})
        self.assertTrue({"__init__.py", "LICENSE-MIT", "LICENSE-APACHE"} <= set(names))

    def test_the_same_input_gives_the_same_bytes(self) -> None:
        [wheel] = support.folder.glob("*.whl")
        again = support.folder / "again.zip"
        build.build(VERSION, [wheel], again)
        self.assertEqual(again.read_bytes(), (support.folder / "rhytid.zip").read_bytes())
        with self.assertRaisesRegex(SystemExit, "expected one that Blender runs on"):
            build.platform(Path("rhytid-0.1.0-cp310-abi3-musllinux_1_2_x86_64.whl"))
