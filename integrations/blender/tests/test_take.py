"""The tab Take: files, empties, the tracks of a clip, and a live stream."""

from __future__ import annotations

import socket
import struct
import threading
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix


from support import Case, choose, demo, evaluated, module


def csv_positions(path: Path) -> tuple[list[str], np.ndarray]:
    """The labels and the frames × markers × 3 positions of a take, read here by its columns."""
    names = path.read_text().split("\n", 1)[0].split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    labels = [name[:-2] for name in names if name.endswith("_x")]
    columns = [[names.index(f"{label}_{axis}") for axis in "xyz"] for label in labels]
    return labels, table[:, columns]


class Files(Case):
    def test_errors_are_the_librarys(self) -> None:
        face = self.face()
        self.fails("has no rig yet", bpy.ops.rhytid.open_take, filepath=str(demo / "performance.csv"))
        bpy.ops.rhytid.solve()
        self.fails("no file is chosen", bpy.ops.rhytid.open_take)
        self.fails("none.csv: not found|none.csv.*No such file|none.csv", bpy.ops.rhytid.open_take, filepath="/none.csv")
        empty = self.folder / "empty.csv"
        empty.write_text((demo / "performance.csv").read_text().split("\n", 1)[0] + "\n")
        self.fails("has no frames", bpy.ops.rhytid.open_take, filepath=str(empty))
        other = self.folder / "other.csv"
        other.write_text("time,a_x,a_y,a_z\n0,1,2,3\n")
        self.fails("handles are missing|missing from the header", bpy.ops.rhytid.open_take, filepath=str(other))
        self.assertEqual((face.rhytid.take_hash, face.rhytid.playing), ("", False))
        self.fails("has no take yet", bpy.ops.rhytid.play)
        self.assertFalse(face.rhytid.playing)

    def test_the_scene_is_long_enough(self) -> None:
        bpy.context.scene.render.fps = 60
        self.playing()
        # 217 frames at 30 a second.
        self.assertGreaterEqual(bpy.context.scene.frame_end, 432)

    def test_markers_of_another_take_go(self) -> None:
        self.playing()
        scene = bpy.context.scene
        scene.timeline_markers.new("mine", frame=3)
        take = module("take")
        take.mark(scene, bpy.context.object, [take.Mark(2.0, "chin: gap")])
        take.mark(scene, bpy.context.object, [take.Mark(1.0, "nose: swap")])
        found = {marker.name: marker.frame for marker in scene.timeline_markers}
        self.assertEqual(found, {"mine": 3, "Rhytid: nose: swap": 30})


class Empties(Case):
    def test_keyed_empties_are_a_take(self) -> None:
        face, expected = self.playing(), self.reference()
        labels, positions = csv_positions(demo / "performance.csv")
        face.location, face.rotation_euler = (2, 0, 1), (1.2, 0.3, 0)
        bpy.context.view_layer.update()
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = 4, 34
        scale, empties = module("scene_space"), []
        for marker, label in enumerate(labels):
            empty = bpy.data.objects.new(f"{label}.001", None)
            scene.collection.objects.link(empty)
            for frame in range(31):
                empty.location = scale.in_world(face, positions[frame : frame + 1, marker])[0]
                empty.keyframe_insert("location", frame=4 + frame)
            empties.append(empty)
        scene.frame_set(7)
        choose(face)
        self.fails("no selected object is called as a handle", bpy.ops.rhytid.take_objects)
        choose(face, *empties)
        bpy.ops.rhytid.take_objects()
        self.assertEqual((scene.frame_current, face.rhytid.start), (7, 4))
        bpy.context.scene.frame_set(24)
        self.assert_near(evaluated(face), expected[20], 1e-5)


class Clip(Case):
    def test_tracks_seen_by_a_camera_are_a_take(self) -> None:
        face = self.face()
        bpy.ops.rhytid.solve()
        bpy.ops.rhytid.open_take(filepath=str(demo / "performance.csv"))
        labels, positions = csv_positions(demo / "performance.csv")
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = 1, 20
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(camera)
        # In front of the face, which looks along -y of the scene.
        camera.matrix_world = Matrix.Translation((0, -90, 0)) @ Matrix.Rotation(np.pi / 2, 4, "X")
        self.fails("no movie clip is chosen", bpy.ops.rhytid.take_clip)
        image = bpy.data.images.new("frame", 160, 90)
        image.filepath_raw = str(self.folder / "frame.png")
        image.file_format = "PNG"
        image.save()
        clip = bpy.data.movieclips.load(str(self.folder / "frame.png"))
        face.rhytid.clip = clip
        self.fails("the scene has no camera", bpy.ops.rhytid.take_clip)
        scene.camera = camera
        self.fails("no track of", bpy.ops.rhytid.take_clip)
        bpy.context.view_layer.update()
        # The camera's own projection, by hand: a film of 36 mm and a lens of 50 mm.
        aspect = scene.render.resolution_x / scene.render.resolution_y
        rest = module("store").rig(face).handles
        for marker, label in enumerate(labels):
            track = clip.tracking.tracks.new(name=label, frame=1)
            for frame in range(20):
                x, y, z = module("scene_space").in_world(face, positions[60 + frame : 61 + frame, marker])[0]
                depth = y + 90
                u, v = 50 / 36 * x / depth + 0.5, 50 / 36 * z / depth * aspect + 0.5
                track.markers.insert_frame(frame + 1, co=(u, v))
        bpy.ops.rhytid.take_clip()
        found = module("store").take(face).positions
        # Sideways and upwards, the markers are where they were seen. In depth they stay at rest.
        expected = positions[60:80]
        nearness = (90 - expected[..., 2]) / (90 - rest[None, :, 2])
        self.assertLess(np.abs(found[..., :2] - expected[..., :2] / nearness[..., None]).max(), 2e-3)
        self.assertLess(np.abs(found[..., 2] - rest[:, 2]).max(), 2e-3)
        self.assertGreater(np.abs(found - rest).max(), 0.1)


def datagram(number: int, seconds: float, labels: list[str], positions: np.ndarray) -> bytes:
    """A frame as OSC has it, made here without the library: docs/live.md."""

    def text(value: str) -> bytes:
        data = value.encode() + b"\0"
        return data + b"\0" * (-len(data) % 4)

    messages = [text("/rhytid/frame") + text(",id") + struct.pack(">id", number, seconds)]
    for label, position in zip(labels, positions):
        messages.append(text("/rhytid/handle") + text(",sfff") + text(label) + struct.pack(">fff", *position))
    return text("#bundle") + struct.pack(">II", 0, 1) + b"".join(struct.pack(">i", len(m)) + m for m in messages)


class Live(Case):
    def test_a_stream_is_followed_and_kept(self) -> None:
        face = self.face()
        bpy.ops.rhytid.solve()
        labels, positions = csv_positions(demo / "performance.csv")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        face.rhytid.address = f"127.0.0.1:{port}"
        self.fails("0 frames came", bpy.ops.rhytid.live, seconds=0.2)
        # No two frames are the same.
        frames = positions[60:120] + 0.001 * np.arange(60)[:, None, None]
        shown, moments = [], []
        former = module("play").show
        module("play").show = lambda *of: (shown.append(1), former(*of))

        def send() -> None:
            sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            for frame in range(60):
                moments.append(time.monotonic())
                sender.sendto(datagram(frame, moments[-1], labels, frames[frame]), ("127.0.0.1", port))
                time.sleep(1 / 30)

        thread = threading.Thread(target=send)
        try:
            thread.start()
            bpy.ops.rhytid.live(seconds=3)
        finally:
            thread.join()
            module("play").show = former
        self.assertGreater(len(shown), 20)
        take = module("store").take(face)
        self.assertEqual(take.labels, module("store").rig(face).labels)
        # Each frame that was kept is one that was sent, at its time.
        order = [labels.index(label) for label in take.labels]
        apart = np.abs(take.positions[:, None] - frames[None][:, :, order]).max((2, 3))
        self.assertLess(apart.min(1).max(), 1e-5)
        sent = apart.argmin(1)
        at = np.array(moments)[sent]
        self.assertTrue(np.allclose(take.times, at - at[0], atol=1e-3))
        self.assertGreater(len(take), 20)
        face.rhytid.address = "nowhere"
        self.fails("expected an address and a port", bpy.ops.rhytid.live, seconds=0.1)
        self.assertEqual(module("play").paused, set())


class Pure(Case):
    def test_what_is_not_seen_is_between_what_is(self) -> None:
        tracks = module("tracks")
        positions = np.arange(5.0).reshape(5, 1, 1) * np.ones((1, 2, 3))
        positions[2, 0] = 99
        positions[:2, 1] = 77
        seen = np.ones((5, 2), bool)
        seen[2, 0] = seen[0, 1] = seen[1, 1] = False
        found = tracks.filled(positions, seen)
        self.assertEqual(found[:, 0, 0].tolist(), [0, 1, 2, 3, 4])
        self.assertEqual(found[:, 1, 2].tolist(), [2, 2, 2, 3, 4])

    def test_names_of_both_sides(self) -> None:
        mirrored = module("naming").mirrored
        for left, right in (("brow_l", "brow_r"), ("eye.L", "eye.R"), ("Left cheek", "Right cheek"), ("lipLeft", "lipRight")):
            self.assertEqual((mirrored(left), mirrored(right)), (right, left))
        for name in ("chin", "curl", "l", "bowler"):
            self.assertIsNone(mirrored(name), name)
