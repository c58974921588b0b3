"""The functions of the program's commands."""

import json
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

import rhytid
from rhytid import _rhytid


def printed(*words):
    """What the program prints as JSON."""
    words = [sys.executable, "-m", "rhytid", *map(str, words), "--json"]
    return json.loads(subprocess.run(words, check=True, capture_output=True).stdout)


def test_every_command_is_a_function():
    for command in _rhytid.option_list():
        name = command["name"].replace("-", "_")
        assert callable(getattr(rhytid, name)) and name in rhytid.__all__, name
        if name != "render":
            assert getattr(rhytid, name).__doc__.startswith(command["about"])


def test_results_are_those_of_the_program(demo, face, rig, take):
    assert rhytid.doctor(face) == printed("doctor", face.path)
    assert rhytid.devices() == printed("devices")
    info = rhytid.info(rig)
    theirs = printed("info", demo / "face.safetensors")
    # The rig in memory was written to another place.
    assert {**info, "file": ""} == {**theirs, "file": ""}
    found = rhytid.evaluate(face, device="cpu:0")
    assert found == printed("evaluate", face.path, "--device", "cpu:0")


def test_a_farm_wants_paths(demo, rig, take, tmp_path):
    # The machines of the farm read the rig and the takes later.
    for takes, of_rig, place in [([take], demo / "face.safetensors", "takes"), ([demo / "performance.csv"], rig, "rig")]:
        with pytest.raises(ValueError, match=f"^{place}: expected a path, found a .* in memory; save it"):
            rhytid.farm(takes, rig=of_rig, output=tmp_path / "job")
    assert not (tmp_path / "job").exists()
    job = rhytid.farm(
        demo / "performance.csv", rig=demo / "face.safetensors", output=tmp_path / "job", chunk=100, film="none"
    )
    assert job["takes"] == 1 and job["chunks"] == -(-job["frames"] // 100)


def test_findings_become_a_table(face):
    found = rhytid.evaluate(face, device="cpu:0")
    table = found.to_pandas("leave_one_out.regions")
    regions = found["leave_one_out"]["regions"]
    assert list(table["rms_mm"]) == [region["rms_mm"] for region in regions]
    assert found.to_pandas()["leave_one_out.rms_mm"][0] == found["leave_one_out"]["rms_mm"]


def test_what_doctor_finds_is_the_same_for_a_face_in_memory(face):
    assert face.doctor() == rhytid.doctor(face)["findings"]


def test_a_raw_take_is_prepared(demo, rig, take, tmp_path):
    clean = tmp_path / "clean.csv"
    rhytid.prepare(demo / "performance.csv", rig=demo / "face.safetensors", output=clean, fps=15)
    assert rhytid.Take.open(clean, rig).rate == 15


def test_devices_and_scans_are_judged(rig, take, demo):
    report = rhytid.conform(device="cpu:0", quick=True)
    theirs = printed("conform", "--device", "cpu:0", "--quick")
    assert report.keys() == theirs.keys()
    verdicts = {outcome["verdict"] for device in report["devices"] for outcome in device["outcomes"]}
    assert verdicts == {"Pass"}
    plan = rhytid.coverage(rig, take, plan=2)
    assert plan == printed("coverage", demo / "face.safetensors", demo / "performance.csv", "--plan", "2")


def test_wrinkles_go_to_another_face(demo, rig, tmp_path):
    # Another face: the same one, an eighth wider, without scans of its own.
    wider = []
    for line in (demo / "neutral.obj").read_text().splitlines():
        if line.startswith("v "):
            x, y, z = map(float, line.split()[1:4])
            line = f"v {1.125 * x} {y} {z}"
        wider.append(line)
    (tmp_path / "neutral.obj").write_text("\n".join(wider))
    shutil.copy(demo / "markers.csv", tmp_path)
    project = (demo / "face.toml").read_text()
    without = re.sub(r"\[\[example\]\]\nname = .*\nmesh = .*\n", "", project)
    assert without != project
    (tmp_path / "face.toml").write_text(without)
    rhytid.transfer(from_=rig, to=tmp_path / "face.toml", output=tmp_path / "other.safetensors")
    other = rhytid.Rig.open(tmp_path / "other.safetensors")
    assert other.examples == rig.examples and np.ptp(other.vertices[:, 0]) > 1.1 * np.ptp(rig.vertices[:, 0])


def test_a_picture_has_pixels(rig, take, tmp_path):
    picture = rhytid.render(rig, take, count=2, size="120x160", background="none")
    pixels = np.asarray(picture)
    assert pixels.dtype == np.uint8 and pixels.shape[2] == 4
    # The face covers a part of it, and nothing else is there.
    covered = (pixels[:, :, 3] == 255).mean()
    assert 0.1 < covered < 0.9
    assert picture._repr_png_().startswith(b"\x89PNG")
    picture.save(tmp_path / "sheet.png")
    written = rhytid.render(rig, take, count=2, size="120x160", background="none", output=tmp_path / "other.png")
    assert (tmp_path / "other.png").read_bytes() == (tmp_path / "sheet.png").read_bytes()
    assert written.keys() == picture.result.keys()


def test_a_file_is_verified(demo, rig, take, tmp_path):
    path = tmp_path / "face.usd"
    rig.play(take, device="cpu:0", frames=range(5)).write(path)
    assert rhytid.verify(path, rig=demo / "face.safetensors", take=demo / "performance.csv")["passed"]
