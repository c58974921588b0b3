"""Opens what `rhytid animate` writes with other programs, and tables what they read of it.

`cargo xtask clients` runs it. A small face is made and solved, and its take is written in every kind of file. Each
client opens each file that it is for. Where it shows each vertex is compared with Rhytid's own frames.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import face
import measure
import page
from kinds import KINDS

HERE = Path(__file__).parent
# How long a client may take for all its files.
SECONDS = 600


class Client:
    """A program that opens files."""

    def __init__(self, name, command, kinds, is_quick=True, **job):
        self.name, self.command, self.is_quick, self.job = name, list(map(str, command)), is_quick, job
        self.kinds = [kind for kind in KINDS if kinds(kind)]

    def rows(self, folder, expected):
        """A row for each kind of file. A client that ends in the midst of a file is started again behind it."""
        rows, left, version = [], self.kinds, ""
        while left:
            with tempfile.TemporaryDirectory() as out:
                lines, why = self.ask(folder, left, Path(out))
                for line in lines:
                    version = line.get("version", version)
                    rows.append(measure.row(self.name, left[line["file"]], line, Path(out), expected))
            left = left[len(lines) :]
            if left:
                rows.append(measure.Row(self.name, left[0].name, error=why))
                left = left[1:]
        for row in rows:
            row.client = f"{self.name} {version}".strip()
        return rows

    def ask(self, folder, kinds, out):
        """The lines about the files, as far as they come, and why no more come."""
        job = {"files": [str(folder / kind.file) for kind in kinds], "rate": face.RATE, "frames": face.FRAMES}
        job |= {"out": str(out), **self.job}
        (out / "job.json").write_text(json.dumps(job))
        try:
            done = subprocess.run(
                [*self.command, out / "job.json"], capture_output=True, text=True, errors="replace", timeout=SECONDS
            )
        except FileNotFoundError as missing:
            return [], f"not installed: {missing.filename}"
        except subprocess.TimeoutExpired:
            return [], f"takes more than {SECONDS} s"
        lines = [line for line in done.stdout.splitlines() if line.startswith('{"')]
        said = (done.stderr.strip().splitlines() or [""])[-1]
        return list(map(json.loads, lines)), f"ends with code {done.returncode}: {said}"[:200]


def clients(given):
    """All clients, the quick ones first."""
    modules = str(given.node)
    oracles = (HERE / "../../crates/cli/tests/program/oracles").resolve()
    viewer = {"page": os.path.relpath(HERE / "model_viewer.html", oracles), "modules": f"{modules}/node_modules"}
    usd = lambda kind: kind.format == "usd"
    gltf = lambda kind: kind.format == "gltf"
    every = lambda kind: True
    scene = lambda kind: kind.format != "pc2"
    python = lambda name: [given.python, HERE / f"with_{name}.py"]
    node = lambda name: ["node", HERE / f"{name}.mjs"]
    found = [
        Client("usd-core", python("usd"), usd),
        Client("glTF validator", node("validator"), gltf, modules=modules),
        Client("three.js", node("three"), scene, modules=modules),
        Client("Babylon.js", node("babylon"), gltf, modules=modules),
        Client("crate gltf", [given.gltf_crate], gltf),
        Client("trimesh", python("trimesh"), gltf),
        Client("assimp", python("assimp"), gltf),
        Client("VTK", python("vtk"), gltf),
    ]
    for blender in given.blender or []:
        found.append(Client("Blender", [blender, HERE / "with_bpy.py"], every, False))
    found.append(Client("model-viewer", ["node", oracles / "browser.mjs"], gltf, False, **viewer))
    return [client for client in found if client.is_quick or not given.quick]


def make_files(program, folder):
    """Solves the face and writes every kind of file. Returns the errors of those that were not written."""
    face.write(folder)
    rhytid(program, folder, "solve", "face.toml", "-o", "face.safetensors")
    errors = {}
    for kind in KINDS:
        try:
            animate = ["animate", "face.safetensors", "take.csv", "--device", "cpu:0", "-o", kind.file, *kind.options]
            rhytid(program, folder, *animate)
        except RuntimeError as error:
            errors[kind.name] = str(error)
    return errors


def rhytid(program, folder, *arguments):
    done = subprocess.run([program, *arguments, "--quiet"], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        said = (done.stderr.strip().splitlines() or [""])[0]
        raise RuntimeError(f"rhytid {' '.join(arguments)}: {said}")


def measured(given, folder):
    errors = make_files(given.program, folder)
    expected = measure.truth(folder / "cache.pc2")
    with ThreadPoolExecutor(given.at_once) as pool:
        rows = list(pool.map(lambda client: client.rows(folder, expected), clients(given)))
    rows = [row for of_client in rows for row in of_client]
    for row in rows:
        if row.kind in errors:
            row.error = f"not written: {errors[row.kind]}"
    return rows


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--program", type=Path, required=True, help="rhytid")
    options.add_argument("--python", type=Path, required=True, help="a Python with the packages of the clients")
    options.add_argument("--blender", type=Path, action="append", help="a Python that has bpy; can be given many times")
    options.add_argument("--node", type=Path, required=True, help="the folder with the packages of npm")
    options.add_argument("--gltf-crate", type=Path, required=True, help="the example gltf_crate")
    options.add_argument("--quick", action="store_true", help="only clients that take seconds")
    options.add_argument("--at-once", type=int, default=2, help="how many clients run at the same time")
    options.add_argument("--keep", type=Path, help="keep the files in this folder")
    options.add_argument("--page", type=Path, required=True, help="docs/clients.md")
    what = options.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="fail where a row is worse than in the page; write nothing")
    what.add_argument("--print", action="store_true", help="print the table and all errors; write nothing")
    given = options.parse_args()
    for name in ("program", "node", "gltf_crate"):
        setattr(given, name, getattr(given, name).resolve())
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        rows = measured(given, folder.resolve())
    if given.check:
        sys.exit(page.check(given.page, rows))
    if given.print:
        print(page.table(rows))
        for row in rows:
            if row.error:
                print(f"{row.client}, {row.kind}: {row.error}")
    else:
        sys.exit(page.write(given.page, rows))


if __name__ == "__main__":
    main()
