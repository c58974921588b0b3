"""The examples of the documentation run, one after the other, beside the files that they name."""

import os
import pathlib
import re
import shutil

import pytest

ROOT = pathlib.Path(os.environ["RHYTID_ROOT"])


@pytest.mark.parametrize("page", ["docs/python.md", "python/README.md"])
def test_examples_run(page, demo, take, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(demo / "poses", "poses")
    for name in ("face.toml", "neutral.obj", "markers.csv"):
        shutil.copy(demo / name, name)
    shutil.copy(demo / "performance.csv", "take.csv")
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), re.MULTILINE | re.DOTALL)
    assert blocks
    names = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
