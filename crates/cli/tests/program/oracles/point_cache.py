"""Plays point caches on a mesh in Blender, by its modifier Mesh Cache, and writes where it shows every vertex.

    python point_cache.py JOB

JOB is a JSON file: `mesh`, an OBJ file to import as it is; `cache`, the .pc2; `first`, the number of the first frame, and `frames` to look at,
counted from the first; and `out`, a folder that gets `positions`, frames × vertices × 3 float32 in the mesh's own space.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

job = json.loads(Path(sys.argv[1]).read_text())
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.obj_import(filepath=job["mesh"])
[object] = [object for object in bpy.data.objects if object.type == "MESH"]
modifier = object.modifiers.new("cache", "MESH_CACHE")
modifier.cache_format = "PC2"
modifier.filepath = job["cache"]
modifier.frame_start = job["first"]
with open(Path(job["out"]) / "positions", "wb") as out:
    for frame in job["frames"]:
        bpy.context.scene.frame_set(job["first"] + frame)
        mesh = object.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        positions = np.empty((len(mesh.vertices), 3), np.float32)
        mesh.vertices.foreach_get("co", positions.ravel())
        out.write(positions.tobytes())
print(json.dumps({"vertices": len(object.data.vertices)}))
