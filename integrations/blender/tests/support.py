"""What the tests share: the installed extension, a small face of the program's demo, and positions as arrays."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

import bpy
import numpy as np

import build
from wheel import wheel

ID = "bl_ext.user_default.rhytid"
#: The repository.
ROOT = Path(__file__).parents[3]
VERSION = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
#: Scans and takes that are not in the repository.
DATA = Path(os.environ.get("RHYTID_SHARED", "")) / "data"

folder: Path
package: Path
demo: Path


def install(of: Path, where: Path) -> None:
    """Installs the extension from its zip, and makes the demo face."""
    global folder, package, demo
    folder, package, demo = where, of, where / "demo"
    made = wheel(package, VERSION, folder)
    build.build(VERSION, [made], folder / "rhytid.zip")
    # Blender itself has it on; the module `bpy` does not.
    bpy.ops.preferences.addon_enable(module="bl_pkg")
    bpy.ops.extensions.package_install_files(
        filepath=str(folder / "rhytid.zip"), repo="user_default", enable_on_install=True
    )
    bpy.context.preferences.addons[ID].preferences.device = "cpu:0"
    program("demo", "--vertices", "2000", demo)


def module(name: str):
    """A module of the extension, such as `play`."""
    return sys.modules[f"{ID}.{name}"]


def program(*words: object) -> str:
    """Runs the program as a user does."""
    done = subprocess.run(
        [sys.executable, "-m", "rhytid", *map(str, words)],
        env={**os.environ, "PYTHONPATH": str(package)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def load(path: Path) -> bpy.types.Object:
    """Imports an OBJ as a user does."""
    bpy.ops.wm.obj_import(filepath=str(path))
    return bpy.context.object


def choose(active: bpy.types.Object, *others: bpy.types.Object) -> None:
    """Selects objects, as clicks do."""
    for object in bpy.context.view_layer.objects:
        object.select_set(object == active or object in others)
    bpy.context.view_layer.objects.active = active


def pc2(path: Path) -> np.ndarray:
    """Frames × V × 3 positions of a PC2 file, read by its layout."""
    data = path.read_bytes()
    magic, _version, vertices, _start, _rate, frames = struct.unpack("<12siiffi", data[:32])
    assert magic == b"POINTCACHE2\0"
    return np.frombuffer(data, "<f4", offset=32).reshape(frames, vertices, 3)


def evaluated(object: bpy.types.Object) -> np.ndarray:
    """V × 3 positions that Blender draws, in the object's coordinates."""
    shown = object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = shown.to_mesh()
    found = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", found)
    shown.to_mesh_clear()
    return found.reshape(-1, 3)


class Case(unittest.TestCase):
    """A test in an empty scene, in a folder of its own."""

    def setUp(self) -> None:
        bpy.ops.wm.read_homefile(use_empty=True)
        module("play").forget()
        self.folder = Path(tempfile.mkdtemp(dir=folder))
        bpy.context.scene.render.fps = 30
        bpy.context.scene.render.fps_base = 1

    def face(self, poses: int = 6) -> bpy.types.Object:
        """The demo's neutral as the active object, with examples and handles."""
        examples = [load(path) for path in sorted((demo / "poses").glob("*.obj"))[:poses]]
        neutral = load(demo / "neutral.obj")
        choose(neutral, *examples)
        neutral.rhytid.unit = "cm"
        if examples:
            bpy.ops.rhytid.add_examples()
        project = module("project")
        module("handles").put_all(neutral, project.read_handles(demo / "markers.csv"))
        return neutral

    def playing(self) -> bpy.types.Object:
        """The demo's face with its rig, following its take."""
        face = self.face()
        bpy.ops.rhytid.solve()
        bpy.ops.rhytid.open_take(filepath=str(demo / "performance.csv"))
        return face

    def reference(self, *words: object, take: Path | None = None) -> np.ndarray:
        """What the program makes of the demo's take."""
        path = self.folder / "reference.pc2"
        take = take or demo / "performance.csv"
        program("animate", demo / "face.safetensors", take, "-o", path, "--device", "cpu:0", "--no-normals", *words)
        return pc2(path)

    def assert_near(self, found: np.ndarray, expected: np.ndarray, tolerance: float = 1e-5) -> None:
        """Asserts that positions agree, by a part of the face's size."""
        size = np.linalg.norm(np.ptp(expected, axis=0))
        self.assertEqual(found.shape, expected.shape)
        self.assertLess(np.abs(found - expected).max(), tolerance * size)

    def fails(self, said: str, operator, **options: object) -> None:
        """Asserts that an operator ends with an error report that has these words."""
        with self.assertRaisesRegex(RuntimeError, f"(?i){said}"):
            operator(**options)

    def shows(self, object: bpy.types.Object, frame: float, expected: np.ndarray) -> None:
        """Asserts what the object shows in a frame of the scene."""
        bpy.context.scene.frame_set(int(np.floor(frame)), subframe=frame % 1)
        self.assertEqual(module("play").problems, {})
        self.assert_near(evaluated(object), expected)
