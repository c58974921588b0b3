"""trimesh: the mesh without its animation."""

import client
import numpy as np
import trimesh
from trimesh.visual.material import PBRMaterial


def read(path, job):
    scene = trimesh.load_scene(path, process=False)
    positions, normals, materials = [], [], []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        mesh = scene.geometry[name]
        positions.append(mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3])
        normals.append(mesh.vertex_normals @ np.linalg.inv(matrix[:3, :3]))
        look = mesh.visual.material
        if isinstance(look, PBRMaterial):
            colour, image = look.baseColorFactor, look.baseColorTexture
            materials.append(
                {
                    "name": look.name,
                    # It keeps them in eight bits.
                    "colour": None if colour is None else [float(x) / 255 for x in colour[:3]],
                    "texture": None if image is None else list(image.size),
                }
            )
    return client.Read([np.concatenate(positions)], [np.concatenate(normals)], materials)


client.run(trimesh.__version__, read)
