"""Makes files with other programs: Blender, glTF Transform, gltfpack, trimesh and USD's library."""

import shutil
import subprocess
import sys
from pathlib import Path

import trimesh
import usd_files

NODE_PACKAGES = ["@gltf-transform/cli@4.5.1", "gltfpack@1.0.0"]

# The commands of glTF Transform, each with its options.
TRANSFORMS = {
    "quantize": [],
    "dequantize": [],
    "meshopt": ["--level", "high"],
    "meshopt-medium": ["--level", "medium"],
    "draco": ["--method", "edgebreaker"],
    "draco-sequential": ["--method", "sequential"],
    "weld": [],
    "unweld": [],
    "reorder": [],
    "flatten": [],
    "join": [],
    "instance": ["--min", "2"],
    "optimize": ["--compress", "meshopt"],
}
# The options of gltfpack.
PACKS = {"plain": [], "c": ["-c"], "cc": ["-cc", "-kn"], "float": ["-vpf", "-noq"], "kept": ["-kn", "-km", "-ke", "-c"]}


def blender(folder, python):
    script = Path(__file__).with_name("blender_exports.py")
    quietly(python, script, folder)


def gltf_tools(folder, exports):
    """Blender's files, each compressed or changed in every way."""
    tools = folder.with_name("npm")
    tools.mkdir(exist_ok=True)
    quietly("npm", "install", "--no-audit", "--no-fund", "--prefix", tools, *NODE_PACKAGES)
    programs = tools / "node_modules/.bin"
    for source in sorted(exports.glob("*-plain.glb")):
        for name, options in TRANSFORMS.items():
            made = folder / f"{source.stem}-transform-{name}.glb"
            quietly(programs / "gltf-transform", name.split("-")[0], source, made, *options)
        for name, options in PACKS.items():
            quietly(programs / "gltfpack", "-i", source, "-o", folder / f"{source.stem}-pack-{name}.glb", *options)


def of_trimesh(folder, exports):
    """Blender's files as trimesh writes them."""
    for source in sorted(exports.glob("*-plain.glb")):
        scene = trimesh.load_scene(source, process=False)
        mesh = scene.to_mesh()
        scene.export(folder / f"{source.stem}-scene.glb")
        scene.export(folder / f"{source.stem}-scene.obj")
        mesh.export(folder / f"{source.stem}.glb")
        mesh.export(folder / f"{source.stem}.obj", digits=6)
        mesh.export(folder / f"{source.stem}.ply")
        mesh.export(folder / f"{source.stem}-ascii.ply", encoding="ascii", vertex_normal=True)
        # The file of numbers beside it always has the same name.
        (folder / source.stem).mkdir()
        mesh.export(folder / source.stem / "written.gltf", merge_buffers=True)


def once(folder, make, *arguments):
    """The folder that `make` fills, once."""
    if not folder.is_dir():
        part = folder.with_name(folder.name + ".part")
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True)
        make(part, *arguments)
        part.rename(folder)
    return folder


def all_exports(folder, python_with_bpy):
    """The made collections: each label with its folder."""
    exports = once(folder / "blender", blender, python_with_bpy)
    return {
        "exports of Blender 5.0.1": exports,
        "glTF Transform 4.5.1 and gltfpack 1.0.0": once(folder / "gltf-tools", gltf_tools, exports),
        f"exports of trimesh {trimesh.__version__}": once(folder / "trimesh", of_trimesh, exports),
        "files of usd-core 26.11": once(folder / "usd-core", usd_files.write),
    }


def quietly(*command):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode:
        print(done.stdout, done.stderr, file=sys.stderr)
        raise SystemExit(f"{command} failed")
