"""Errors, warnings, progress and Ctrl-C."""

import logging
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import rhytid


def test_errors_are_of_their_kinds(demo, rig, take, tmp_path):
    sentence = "^nowhere.safetensors: no such file or folder; check the path$"
    with pytest.raises(FileNotFoundError, match=sentence) as raised:
        rhytid.Rig.open("nowhere.safetensors")
    assert isinstance(raised.value, rhytid.Error) and raised.value.filename == "nowhere.safetensors"
    assert raised.value.errno == 2
    with pytest.raises(rhytid.InputError) as raised:
        rhytid.Rig.open(demo / "face.toml")
    assert isinstance(raised.value, ValueError) and raised.value.kind
    with pytest.raises(rhytid.DeviceError, match="vulkan:77"):
        rig.play(take, device="vulkan:77")
    with pytest.raises(rhytid.InputError, match="invalid value '0' for 'fps"):
        rig.play(take, fps=0)
    with pytest.raises(rhytid.InputError, match="unexpected argument 'detial' found; tip: .*'detail'"):
        rig.play(take, detial=0.5)
    with pytest.raises(rhytid.InputError, match="compressed is for glTF"):
        rig.play(take, device="cpu:0").write(tmp_path / "face.usd", compressed=True)
    with pytest.raises(TypeError, match="unexpected keyword argument 'tru'"):
        rhytid.evaluate("face.toml", tru="x")
    with pytest.raises(ValueError, match="from arrays"):
        rhytid.evaluate(rhytid.Face([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], [("a", 0)]))
    with pytest.raises(rhytid.InputError):
        rhytid.Face([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 7]], {"a": 0})
    with pytest.raises(TypeError):
        rhytid.Face([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], {"a": "chin"})
    assert not list(tmp_path.iterdir())


def test_progress_is_told(face):
    told = []
    face.solve(progress=lambda *report: told.append(report))
    steps = [step for step, _, _ in told]
    assert "openings" in steps and all(0 <= done <= total for _, done, total in told)

    def stop(step, done, total):
        raise KeyError("stop")

    with pytest.raises(KeyError):
        face.solve(progress=stop)
    with pytest.raises(TypeError, match="progress is 3"):
        face.solve(progress=3)


@pytest.fixture
def ctrl_c():
    """Ctrl-C as in a terminal. A process in the background starts with it ignored, and Python leaves it so."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_stops_within_a_second(ctrl_c):
    # A sheet of 62,500 vertices, which takes some seconds.
    side = 250
    x, y = np.meshgrid(np.linspace(-8, 8, side), np.linspace(-8, 8, side))
    vertices = np.stack([x, y, 0.1 * np.sin(x)], axis=-1).reshape(-1, 3)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1)
    faces = np.stack([corner, corner + 1, corner + side + 1, corner + side], axis=-1)
    handles = [(f"h{i}", int(v)) for i, v in enumerate(np.linspace(0, side * side - 1, 60).astype(int))]
    examples = [(f"e{i}", vertices + [0, 0, 0.1 * i] * np.cos(x).reshape(-1, 1)) for i in range(1, 4)]
    face = rhytid.Face(vertices, faces.tolist(), handles, examples)
    pressed = []

    def press():
        time.sleep(0.3)
        pressed.append(time.monotonic())
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=press)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            face.solve()
    assert time.monotonic() - pressed[0] < 1.0
    thread.join()


def test_warnings_are_logged(demo, rig, take, tmp_path, caplog):
    # Three frames that jump by centimetres: no skin has such strains.
    positions = take.positions.copy()
    positions[50:53, 10] += 5.0
    path = tmp_path / "jump.csv"
    rhytid.Take(positions, take.labels, rate=30).save(path)
    with caplog.at_level(logging.WARNING, logger="rhytid"):
        rhytid.Take.open(path, rig)
    said = [record.getMessage() for record in caplog.records if record.name == "rhytid"]
    assert any(take.labels[10] in sentence for sentence in said), said
    assert all("--" not in sentence for sentence in said), said


def test_the_program_is_there(demo, tmp_path):
    def run(*words):
        return subprocess.run([sys.executable, "-m", "rhytid", *words], capture_output=True, text=True, cwd=tmp_path)

    assert run("--version").stdout == f"rhytid {rhytid.__version__}\n"
    wrong = run("info", "nowhere.csv")
    assert wrong.returncode == 2 and wrong.stderr.startswith("error: nowhere.csv: ")
