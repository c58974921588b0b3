"""An own reading of glTF: pygltflib splits the file, NumPy reads the numbers. It follows the specification."""

import base64
import warnings
from pathlib import Path
from urllib.parse import unquote

import DracoPy
import meshoptimizer
import numpy as np
import pygltflib
from reading import Reading, Refused
from references import joined

TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
TRIANGLES, STRIP, FAN = 4, 5, 6


def gltf(path):
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            document = pygltflib.GLTF2().load(str(path))
    except Exception as error:
        raise Refused(f"pygltflib: {type(error).__name__} {error}") from error
    if document is None or not document.scenes or not str(document.asset.version).startswith("2"):
        raise Refused("not a scene of glTF 2.0")
    return Scene(document, Path(path)).read()


class Scene:
    def __init__(self, document, path):
        self.document, self.path = document, path
        self.bytes = [self.buffer(number, buffer) for number, buffer in enumerate(document.buffers)]
        self.worlds, self.order = {}, []
        scene = document.scenes[document.scene or 0]
        for top in scene.nodes or []:
            self.walk(top, np.eye(4), self.order)
        children = {child for node in document.nodes for child in node.children or []}
        for top in set(range(len(document.nodes))) - children - set(self.worlds):
            self.walk(top, np.eye(4), [])

    def buffer(self, number, buffer):
        if buffer.uri is None:
            return self.document.binary_blob() or b""
        if buffer.uri.startswith("data:"):
            return base64.b64decode(buffer.uri.split(",", 1)[1])
        beside = self.path.parent / unquote(buffer.uri)
        if not beside.is_file():
            raise Refused(f"no file {buffer.uri}")
        return beside.read_bytes()

    def walk(self, index, above, order):
        self.worlds[index] = above @ local(self.document.nodes[index])
        order.append(index)
        for child in self.document.nodes[index].children or []:
            self.walk(child, self.worlds[index], order)

    def accessor(self, index, as_stored=False):
        accessor = self.document.accessors[index]
        kind, width = np.dtype(TYPES[accessor.componentType]), WIDTHS[accessor.type]
        values = np.zeros((accessor.count, width), kind)
        if accessor.bufferView is not None:
            values = self.view(accessor.bufferView, accessor.byteOffset or 0, kind, width, accessor.count)
        if accessor.sparse:
            sparse, values = accessor.sparse, values.copy()
            where = np.dtype(TYPES[sparse.indices.componentType])
            at = self.view(sparse.indices.bufferView, sparse.indices.byteOffset or 0, where, 1, sparse.count)
            put = self.view(sparse.values.bufferView, sparse.values.byteOffset or 0, kind, width, sparse.count)
            values[at.ravel().astype(int)] = put
        if as_stored:
            return values
        values = values.astype(float)
        if accessor.normalized:
            values = np.maximum(values / np.iinfo(kind).max, -1)
        return values

    def view(self, index, offset, kind, width, count):
        view = self.document.bufferViews[index]
        row = kind.itemsize * width
        stride, start, data = view.byteStride or row, (view.byteOffset or 0) + offset, self.bytes[view.buffer]
        for name, compressed in (view.extensions or {}).items():
            if name.endswith("_meshopt_compression"):
                start, data = offset, self.unfolded(compressed)
        if count and start + stride * (count - 1) + row > len(data):
            raise Refused("a buffer is cut short")
        return np.ndarray((count, width), kind.newbyteorder("<"), data, start, (stride, kind.itemsize)).copy()

    def unfolded(self, view):
        """The bytes of a view that meshopt compressed."""
        start, stride, count = view.get("byteOffset", 0), view["byteStride"], view["count"]
        data = bytes(self.bytes[view["buffer"]][start : start + view["byteLength"]])
        if view["mode"] != "ATTRIBUTES":
            sequence = view["mode"] == "INDICES"
            decode = meshoptimizer.decode_index_sequence if sequence else meshoptimizer.decode_index_buffer
            # It makes room for 32 bits, and fills in the indices as wide as they are.
            return decode(count, stride, data).tobytes()[: count * stride]
        decoded = meshoptimizer.decode_vertex_buffer(count, stride, data, dtype=np.dtype((np.void, stride)))
        decoded = np.frombuffer(decoded.tobytes(), np.uint8)
        filters = {
            "EXPONENTIAL": meshoptimizer.decode_filter_exp,
            "OCTAHEDRAL": meshoptimizer.decode_filter_oct,
            "QUATERNION": meshoptimizer.decode_filter_quat,
        }
        unfilter = filters.get(view.get("filter"))
        return (unfilter(decoded, count, stride) if unfilter else decoded).tobytes()

    def read(self):
        parts = []
        for index in self.order:
            node = self.document.nodes[index]
            if node.mesh is not None:
                parts += self.node(index, node)
        if not sum(len(part.counts) for part in parts):
            raise Refused("no triangles")
        return joined(parts)

    def node(self, index, node):
        """A reading for each array of vertices; primitives that share one add their triangles to it."""
        mesh, whole, begin = self.document.meshes[node.mesh], Reading(*empty()), {}
        uvs = []
        for primitive in mesh.primitives:
            if (TRIANGLES if primitive.mode is None else primitive.mode) < TRIANGLES:
                continue
            arrays = self.arrays(primitive)
            targets = [target.get("POSITION") for target in map(as_dict, primitive.targets or [])]
            key = (arrays.key, str(targets), str(arrays.sets) if node.skin is not None else "")
            matrices = self.matrices(index, node, arrays)
            if key not in begin:
                begin[key] = len(whole.positions)
                whole.positions = np.vstack([whole.positions, moved(matrices, arrays.positions, 1)])
                self.add_shapes(whole, mesh, targets, begin[key], matrices)
            corners = triangles(primitive.mode, arrays.indices)
            is_mirrored = np.linalg.det(matrices[corners[:, 0]][:, :3, :3]) < 0
            corners[is_mirrored] = corners[is_mirrored][:, [0, 2, 1]]
            whole.corners = np.concatenate([whole.corners, begin[key] + corners.ravel()])
            whole.counts = np.concatenate([whole.counts, np.full(len(corners), 3)])
            found = self.uvs(primitive, arrays)
            uvs.append(np.full((corners.size, 2), np.nan) if found is None else found[corners.ravel()])
        if uvs:
            whole.uvs = np.concatenate(uvs)
        for name, by in (whole.shapes or {}).items():
            whole.shapes[name] = np.vstack([by, np.zeros((len(whole.positions) - len(by), 3))])
        return [whole]

    def arrays(self, primitive):
        """The vertices, indices and joints of a primitive, unfolded from Draco where it has them."""
        attributes, draco = (
            as_dict(primitive.attributes),
            (primitive.extensions or {}).get("KHR_draco_mesh_compression"),
        )
        if not draco:
            if attributes.get("POSITION") is None:
                raise Refused("no POSITION")
            read = {name: self.accessor(index) for name, index in attributes.items() if index is not None}
            key, indices = attributes["POSITION"], np.arange(len(read["POSITION"]))
            if primitive.indices is not None:
                indices = self.accessor(primitive.indices, as_stored=True).ravel().astype(int)
        else:
            view = self.document.bufferViews[draco["bufferView"]]
            start = view.byteOffset or 0
            found = DracoPy.decode(bytes(self.bytes[view.buffer][start : start + view.byteLength]))
            by_id = {attribute["unique_id"]: attribute["data"] for attribute in found.attributes}
            read = {name: np.asarray(by_id[number], float) for name, number in draco["attributes"].items()}
            key, indices = ("draco", primitive.indices, str(attributes)), np.asarray(found.faces).ravel().astype(int)
        if len(indices) and indices.max() >= len(read["POSITION"]):
            raise Refused("an index past the last vertex")
        sets = [(attributes.get(f"JOINTS_{n}"), attributes.get(f"WEIGHTS_{n}")) for n in range(4)]
        return Arrays(key, read["POSITION"], indices, read, [both for both in sets if None not in both])

    def matrices(self, index, node, arrays):
        """What places each vertex."""
        if node.skin is None:
            return np.broadcast_to(self.worlds[index], (len(arrays.positions), 4, 4))
        skin, inverse = self.document.skins[node.skin], None
        if skin.inverseBindMatrices is not None:
            inverse = self.accessor(skin.inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1)
        joints = [
            self.worlds[joint] @ (np.eye(4) if inverse is None else inverse[j]) for j, joint in enumerate(skin.joints)
        ]
        blended, total = np.zeros((len(arrays.positions), 4, 4)), 0
        if not arrays.sets:
            raise Refused("a skin without joints")
        for number in range(len(arrays.sets)):
            weights = arrays.read[f"WEIGHTS_{number}"]
            blended += np.einsum("vk,vkij->vij", weights, np.array(joints)[arrays.read[f"JOINTS_{number}"].astype(int)])
            total = total + weights.sum(axis=1)
        return blended / np.maximum(total, 1e-30)[:, None, None]

    def add_shapes(self, whole, mesh, targets, first, matrices):
        names = (mesh.extras or {}).get("targetNames") if isinstance(mesh.extras, dict) else None
        whole.shapes = whole.shapes or {}
        for number, target in enumerate(targets):
            name = names[number] if names and number < len(names) else f"shape {number + 1}"
            by = np.zeros((len(matrices), 3)) if target is None else moved(matrices, self.accessor(target), 0)
            before = whole.shapes.get(name, np.zeros((0, 3)))
            whole.shapes[name] = np.vstack([before, np.zeros((first - len(before), 3)), by])

    def uvs(self, primitive, arrays):
        """By vertex, as the material's base colour uses them, from below."""
        used, transform = 0, None
        if primitive.material is not None:
            texture = first_texture(self.document.materials[primitive.material])
            if texture is not None:
                used = texture.texCoord or 0
                transform = (texture.extensions or {}).get("KHR_texture_transform")
        if transform:
            used = transform.get("texCoord", used)
        if f"TEXCOORD_{used}" not in arrays.read:
            return None
        u, v = arrays.read[f"TEXCOORD_{used}"].T
        if transform:
            (su, sv), (ou, ov) = transform.get("scale", [1, 1]), transform.get("offset", [0, 0])
            c, s = np.cos(transform.get("rotation", 0)), np.sin(transform.get("rotation", 0))
            u, v = c * u * su + s * v * sv + ou, -s * u * su + c * v * sv + ov
        return np.stack([u, 1 - v], axis=1)


class Arrays:
    def __init__(self, key, positions, indices, read, sets):
        self.key, self.positions, self.indices, self.read, self.sets = key, positions, indices, read, sets


def empty():
    return np.zeros((0, 3)), np.zeros(0, int), np.zeros(0, int)


def as_dict(attributes):
    found = attributes if isinstance(attributes, dict) else vars(attributes)
    return {name: index for name, index in found.items() if index is not None}


def first_texture(material):
    surface = material.pbrMetallicRoughness
    found = [
        surface and surface.baseColorTexture,
        material.normalTexture,
        material.emissiveTexture,
        material.occlusionTexture,
        surface and surface.metallicRoughnessTexture,
    ]
    return next((texture for texture in found if texture), None)


def local(node):
    if node.matrix:
        return np.array(node.matrix, float).reshape(4, 4).T
    x, y, z, w = np.array(node.rotation or [0, 0, 0, 1], float)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.scale or [1, 1, 1], float)
    matrix[:3, 3] = node.translation or [0, 0, 0]
    return matrix


def moved(matrices, points, w):
    """Points (w = 1) or vectors (w = 0), each by its matrix."""
    return np.einsum("vij,vj->vi", matrices[:, :3, :3], points) + w * matrices[:, :3, 3]


def triangles(mode, indices):
    if mode == STRIP:
        found = [
            [i, j, k] if n % 2 == 0 else [i, k, j] for n, (i, j, k) in enumerate(zip(indices, indices[1:], indices[2:]))
        ]
        found = [t for t in found if len(set(t)) == 3]
    elif mode == FAN:
        found = [[indices[0], j, k] for j, k in zip(indices[1:], indices[2:])]
    else:
        if len(indices) % 3:
            raise Refused("corners that are no triangles")
        return indices.reshape(-1, 3).copy()
    return np.array(found, int).reshape(-1, 3)
