"""Faces, rigs, takes, animations and animators."""

import gc
import socket
import struct
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from pxr import Usd, UsdGeom

import rhytid
from rhytid import _rhytid


def program(*words):
    """The program as a user starts it."""
    return subprocess.run([sys.executable, "-m", "rhytid", *map(str, words)], check=True, capture_output=True)


def test_a_file_has_the_bytes_of_the_program(demo, take, tmp_path):
    rig = rhytid.Rig.open(demo / "face.safetensors")
    for name, words, play, write in [
        ("a.usd", ["--strain"], {"strain": True}, {}),
        ("a.usda", ["--fps", "24", "--frames", "10..20"], {"fps": 24, "frames": range(10, 20)}, {}),
        ("a.glb", ["--shapes", "12", "--quantize"], {}, {"shapes": 12, "quantize": True}),
        ("a.pc2", ["--stage", "large-scale"], {"stage": "large-scale"}, {}),
    ]:
        ours, theirs = tmp_path / "ours" / name, tmp_path / "theirs" / name
        ours.parent.mkdir(exist_ok=True), theirs.parent.mkdir(exist_ok=True)
        written = rig.play(take, device="cpu:0", **play).write(ours, **write)
        program(
            "animate", demo / "face.safetensors", demo / "performance.csv", "-o", theirs, "--device", "cpu:0", *words
        )
        assert ours.read_bytes() == theirs.read_bytes(), name
        assert written["bytes"] == ours.stat().st_size


def test_frames_are_those_of_the_file(rig, take, tmp_path):
    animation = rig.play(take, device="cpu:0", velocities=True, strain=True)
    animation.write(tmp_path / "face.usdc")
    stage = Usd.Stage.Open(str(tmp_path / "face.usdc"))
    mesh = next(UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    strain = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("strain")
    seen = 0
    for number, frame in enumerate(animation):
        assert np.array_equal(frame.positions, mesh.GetPointsAttr().Get(number))
        assert np.array_equal(frame.normals, mesh.GetNormalsAttr().Get(number))
        assert np.array_equal(frame["velocities"], mesh.GetVelocitiesAttr().Get(number))
        assert np.array_equal(frame["strain"], strain.Get(number))
        seen += 1
    assert seen == len(animation) == len(take)
    # One by one they are the same: at both ends, and across the pieces in which they are computed.
    for number in (0, 1, 63, 64, 100, len(take) - 1):
        frame = animation[number]
        assert np.array_equal(frame.positions, mesh.GetPointsAttr().Get(number))
        assert np.array_equal(frame["velocities"], mesh.GetVelocitiesAttr().Get(number)), number
    assert np.array_equal(animation[-1].positions, animation[len(take) - 1].positions)
    assert [frame.keys() for frame in animation[3:9:2]] == [animation[3].keys()] * 3
    # A slice is one piece of work, also across those of a walk.
    for number, frame in zip(range(60, 70), animation[60:70], strict=True):
        assert np.array_equal(frame.positions, mesh.GetPointsAttr().Get(number))
        assert np.array_equal(frame["velocities"], mesh.GetVelocitiesAttr().Get(number)), number
    assert animation[5:5] == [] == animation[9:3]


def test_arrays_outlive_what_made_them_and_cannot_be_written(rig, take):
    animation = rig.play(take, device="cpu:0")
    positions = animation[5].positions
    copy = positions.copy()
    del animation
    gc.collect()
    assert np.array_equal(positions, copy)
    assert positions.dtype == np.float32 and positions.flags.c_contiguous
    # Neither the array nor what it is a view of.
    for array in (positions, positions.base, rig.vertices, take.positions):
        with pytest.raises(ValueError):
            array[...] = 0
    # Other libraries see the same memory.
    assert np.from_dlpack(positions).__array_interface__["data"][0] == positions.__array_interface__["data"][0]
    assert memoryview(positions).nbytes == positions.nbytes


def test_a_walk_may_be_left_and_frames_be_asked_for_meanwhile(rig, take):
    animation = rig.play(take, device="cpu:0")
    for frame in animation:
        for number, other in zip(range(3), animation):
            assert np.array_equal(other.positions, animation[number].positions)
        break
    assert len(list(animation)) == len(take)


def test_threads_share_an_animation(rig, take):
    animation = rig.play(take, device="cpu:0")
    alone = [frame.positions for frame in animation]
    seen = []

    def walk():
        for number, frame in enumerate(animation):
            assert np.array_equal(frame.positions, alone[number])
        seen.append(number)

    threads = [threading.Thread(target=walk) for _ in range(3)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert seen == [len(take) - 1] * 3
    # Two threads on one walk: whoever comes second is told.
    one = iter(animation)
    told = []

    def walk_together():
        try:
            for frame in one:
                time.sleep(0.0001)
        except RuntimeError as error:
            told.append(str(error))

    threads = [threading.Thread(target=walk_together) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join(60) for thread in threads]
    assert not any(thread.is_alive() for thread in threads)
    assert all("another thread" in error for error in told)


def test_a_face_of_arrays_is_that_of_the_project(face, rig):
    examples = {}
    folder = face.path.parent / "poses"
    for name in face.examples:
        lines = (folder / f"{name}.obj").read_text().splitlines()
        examples[name] = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)
    handles = dict(zip(face.labels, nearest(face.vertices, rig.handles)))
    made = rhytid.Face(face.vertices, face.faces, handles, list(examples.items()), name=face.name)
    other = made.solve()
    assert made.path is None and other.labels == rig.labels and other.examples == rig.examples
    for frame in (rig.handles, rig.handles + np.linspace(0, 0.3, rig.handles.size).reshape(-1, 3)):
        assert np.array_equal(rig.animator("cpu:0")(frame), other.animator("cpu:0")(frame))


def nearest(vertices, points):
    distances = ((vertices[None] - points[:, None]) ** 2).sum(2)
    return distances.argmin(1).tolist()


def test_a_take_of_arrays_plays_as_its_file(rig, take, tmp_path):
    made = rhytid.Take(take.positions, np.array(take.labels), times=take.times)
    assert np.array_equal(rig.play(made, device="cpu:0")[7].positions, rig.play(take, device="cpu:0")[7].positions)
    made.save(tmp_path / "again.csv")
    again = rhytid.Take.open(tmp_path / "again.csv", rig)
    assert np.array_equal(again.positions, take.positions) and again.rate == take.rate
    for wrong, said in [
        (lambda: rhytid.Take(take.positions[:, :, :2], take.labels, rate=30), "frames × markers × 3"),
        (lambda: rhytid.Take(take.positions, take.labels[:-1], rate=30), "88 labels"),
        (lambda: rhytid.Take(take.positions, take.labels), "either rate or times"),
        (lambda: rhytid.Take(take.positions * np.nan, take.labels, rate=30), "frame 0: marker"),
        (lambda: rhytid.Take(take.positions, take.labels, times=[0.0] * len(take)), "has to rise"),
    ]:
        with pytest.raises(ValueError, match=said):
            wrong()


def test_an_animator_gives_each_stage(rig, take):
    animator = rig.animator("cpu:0", frames=4)
    batch = take.positions[20:24].astype(np.float32)
    positions = animator(batch)
    assert positions.shape == (4, len(rig.vertices), 3)
    for number in range(4):
        assert np.array_equal(animator(batch[number]), positions[number])
        # Markers are met.
        vertices = nearest(rig.vertices, rig.handles)
        assert np.abs(positions[number][vertices] - batch[number]).max() < 1e-5
    animator.evaluate(batch)
    for stage in rhytid.STAGES:
        assert np.isfinite(animator.read(stage)).all()
    with pytest.raises(ValueError, match="there is no stage “smile”"):
        animator.read("smile")
    with pytest.raises(ValueError, match="88"):
        animator(batch[0][:-1])
    with pytest.raises(rhytid.InputError, match="at most 4"):
        animator(np.zeros((5, *batch.shape[1:])))


def test_every_channel_can_be_asked_for(rig, take):
    default = set(rig.play(take, device="cpu:0")[0].keys())
    for kind, is_default in _rhytid.channel_kinds():
        options = {f"no_{kind}": True} if is_default else {kind: True}
        changed = set(rig.play(take, device="cpu:0", **options)[0].keys())
        assert changed < default if is_default else changed > default, kind


def test_markers_of_a_raw_take_are_cleaned(demo, rig, take, tmp_path):
    # In metres, the file is in another space than the rig.
    path = tmp_path / "metres.csv"
    rhytid.Take(take.positions / 100, take.labels, rate=30).save(path)
    with pytest.raises(rhytid.InputError, match="take_unit"):
        rhytid.Take.open(path, rig)
    again = rhytid.Take.open(path, rig, take_unit="m")
    assert np.abs(again.positions - take.positions).max() < 1e-9


def datagram(number, seconds, markers):
    """A frame as OSC has it, made here without the library: docs/live.md."""

    def text(value):
        data = value.encode() + b"\0"
        return data + b"\0" * (-len(data) % 4)

    frame = text("/rhytid/frame") + text(",id") + struct.pack(">id", number, seconds)
    messages = [frame]
    for label, position in markers.items():
        messages.append(text("/rhytid/handle") + text(",sfff") + text(label) + struct.pack(">fff", *position))
    return text("#bundle") + struct.pack(">II", 0, 1) + b"".join(struct.pack(">i", len(m)) + m for m in messages)


def test_markers_are_received_while_they_are_captured(rig):
    receiver = rhytid.Receiver(rig, "127.0.0.1:0")
    assert receiver.newest() is None and receiver.counts["frames"] == 0
    host, port = receiver.address.split(":")
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for number in range(3):
        sender.sendto(datagram(number, number / 30, {rig.labels[4]: (1.0, 2.0, number)}), (host, int(port)))
    deadline = time.monotonic() + 20
    while receiver.counts["frames"] < 3 and time.monotonic() < deadline:
        newest = receiver.newest()
        time.sleep(0.01)
    newest = receiver.newest()
    expected = rig.handles.copy()
    expected[4] = (1, 2, 2)
    assert newest.number == 2 and np.array_equal(newest.positions, expected)
    assert newest.confidence[4] == 1 and newest.confidence[5] == 0
    assert receiver.counts == {"frames": 3, "late": 0, "lost": 0, "bad": 0, "other": 0}
    # The port is taken, and an address has a port.
    with pytest.raises(rhytid.InputError, match=port):
        rhytid.Receiver(rig, receiver.address)
    with pytest.raises(ValueError, match="127.0.0.1:9000"):
        rhytid.Receiver(rig, "localhost")


def test_findings_of_the_doctor_name_vertices(rig):
    vertices = np.vstack([rig.vertices, rig.vertices[:1] + 9]).astype(float)
    face = rhytid.Face(vertices, rig.faces, dict(zip(rig.labels, nearest(rig.vertices, rig.handles))))
    found = {finding["code"]: finding["vertices"] for finding in face.doctor()}
    assert found["isolated-vertices"] == [len(rig.vertices)] and found["no-examples"] == []
