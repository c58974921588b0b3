"""assimp, from Debian's library: the mesh without its animation."""

import ctypes

import client
import numpy as np
import pyassimp
import pyassimp.core


def read(path, job):
    with pyassimp.load(str(path), processing=0) as scene:
        positions, normals = [], []
        walk(scene.rootnode, np.eye(4), positions, normals)
        materials = [material(one) for one in scene.materials]
    return client.Read([np.concatenate(positions)], [np.concatenate(normals)] if all(map(len, normals)) else None, materials)


def walk(node, above, positions, normals):
    matrix = above @ np.array(node.transformation)
    for mesh in node.meshes:
        positions.append(np.array(mesh.vertices, float) @ matrix[:3, :3].T + matrix[:3, 3])
        normals.append(np.array(mesh.normals, float).reshape(-1, 3) @ np.linalg.inv(matrix[:3, :3]))
    for child in node.children:
        walk(child, matrix, positions, normals)


def material(one):
    # The keys are names with the kind of texture that they are about.
    properties = {name: dict.__getitem__(one.properties, (name, kind)) for name, kind in dict.keys(one.properties)}
    colour = properties.get("diffuse")
    return {
        "name": properties.get("name", ""),
        "colour": None if colour is None else list(map(float, colour[:3])),
        # It names images and decodes none.
        "texture": [0, 0] if "file" in properties else None,
    }


def version():
    library = pyassimp.core._assimp_lib.dll
    library.aiGetVersionMajor.restype = library.aiGetVersionMinor.restype = ctypes.c_uint
    return f"{library.aiGetVersionMajor()}.{library.aiGetVersionMinor()}.{library.aiGetVersionPatch()}"


client.run(version(), read)
