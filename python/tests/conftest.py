"""A small face with a performance, which the program makes in code."""

from pathlib import Path

import pytest

import rhytid


@pytest.fixture(scope="session")
def demo(tmp_path_factory):
    """The folder of the demo: `face.toml`, `face.safetensors`, `performance.csv`."""
    folder = tmp_path_factory.mktemp("demo") / "face"
    rhytid.demo(folder, vertices=2000)
    return Path(folder)


@pytest.fixture(scope="session")
def face(demo):
    return rhytid.Face.open(demo / "face.toml")


@pytest.fixture(scope="session")
def rig(face):
    return face.solve()


@pytest.fixture(scope="session")
def take(demo, rig):
    return rhytid.Take.open(demo / "performance.csv", rig)
