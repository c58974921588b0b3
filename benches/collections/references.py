"""Other programs' readings of OBJ, PLY and USD, and trimesh's of all but USD."""

import warnings

import numpy as np
import plyfile
import tinyobjloader
import trimesh
from pxr import Usd, UsdGeom, UsdSkel
from reading import Reading, Refused


def obj(path):
    """By tinyobjloader, which keeps the order of vertices and whole polygons."""
    reader, config = tinyobjloader.ObjReader(), tinyobjloader.ObjReaderConfig()
    config.triangulate = False
    if not reader.ParseFromFile(str(path), config):
        raise Refused(reader.Error().strip() or "tinyobjloader does not say why")
    attributes, counts, indices = reader.GetAttrib(), [], []
    for shape in reader.GetShapes():
        # Its functions for NumPy repeat the first index, so these are its lists.
        counts.append(np.array(shape.mesh.num_face_vertices, int))
        corners = [(i.vertex_index, i.texcoord_index) for i in shape.mesh.indices]
        indices.append(np.array(corners, int).reshape(-1, 2))
    if not counts or not sum(map(len, counts)):
        raise Refused("no faces")
    # The vertex and the texture coordinate of each corner.
    indices = np.concatenate(indices)
    positions = np.array(attributes.vertices, float).reshape(-1, 3)
    coordinates = np.array(attributes.texcoords, float).reshape(-1, 2)
    coordinates = np.vstack([coordinates, np.full(2, np.nan)])
    if indices[:, 0].max() >= len(positions) or indices[:, 0].min() < 0:
        raise Refused("an index past the last vertex")
    past = (indices[:, 1] < 0) | (indices[:, 1] >= len(coordinates) - 1)
    uvs = coordinates[np.where(past, -1, indices[:, 1])]
    return Reading(positions, np.concatenate(counts), indices[:, 0], uvs)


def ply(path):
    """By plyfile, which knows the elements of the file but not what they mean."""
    try:
        data = plyfile.PlyData.read(str(path))
    except (plyfile.PlyParseError, ValueError, UnicodeDecodeError) as error:
        raise Refused(str(error)) from error
    if "vertex" not in data or "face" not in data or not len(data["face"].data):
        raise Refused("no faces")
    vertices, faces = data["vertex"].data, data["face"].data
    positions = np.stack([np.asarray(vertices[axis], float) for axis in "xyz"], axis=1)
    name = next((name for name in ("vertex_indices", "vertex_index") if name in faces.dtype.names), None)
    if name is None:
        raise Refused("no list of vertices")
    lists = [np.asarray(row, int) for row in faces[name]]
    kept = [number for number, row in enumerate(lists) if len(row) >= 3]
    counts = np.array([len(lists[number]) for number in kept])
    corners = np.concatenate([lists[number] for number in kept])
    uvs = None
    if "texcoord" in faces.dtype.names:
        found = [np.asarray(faces["texcoord"][number], float).reshape(-1, 2) for number in kept]
        missing = [np.full((count, 2), np.nan) for count in counts]
        uvs = np.concatenate([f if len(f) == len(m) else m for f, m in zip(found, missing)])
    for pair in (("u", "v"), ("s", "t"), ("texture_u", "texture_v")):
        if uvs is None and set(pair) <= set(vertices.dtype.names):
            uvs = np.stack([np.asarray(vertices[axis], float) for axis in pair], axis=1)[corners]
    return Reading(positions, counts, corners, uvs)


def loosely(path):
    """By trimesh, which cuts polygons into triangles and sorts them by material."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mesh = trimesh.load(path, process=False, maintain_order=True, force="mesh")
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces):
        raise Refused("no faces")
    return Reading(np.array(mesh.vertices), np.full(len(mesh.faces), 3), np.array(mesh.faces).ravel())


def usd(path):
    """By USD's own library."""
    try:
        stage = Usd.Stage.Open(str(path))
    except Exception as error:
        raise Refused(str(error).splitlines()[0]) from error
    parts = [of_prim(prim) for prim in meshes(stage)]
    if not sum(len(part.counts) for part in parts):
        raise Refused("no faces")
    return joined(parts)


def meshes(stage):
    """The meshes that are shown, copies of instances too."""
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdGeom.Mesh):
            imageable = UsdGeom.Imageable(prim)
            is_hidden = imageable.ComputeVisibility(first_time(prim)) == UsdGeom.Tokens.invisible
            if not is_hidden and imageable.ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render):
                yield prim


def at_first(attribute):
    """The value without a time, else the first one."""
    value = attribute.Get()
    return value if value is not None else attribute.Get(Usd.TimeCode.EarliestTime())


def first_time(prim):
    """The time of the first transforms, if one of them has no value without a time."""
    while prim and not prim.IsPseudoRoot():
        for operation in UsdGeom.Xformable(prim).GetOrderedXformOps() if prim.IsA(UsdGeom.Xformable) else []:
            if operation.GetAttr().Get() is None:
                return Usd.TimeCode.EarliestTime()
        prim = prim.GetParent()
    return Usd.TimeCode.Default()


def of_prim(prim):
    mesh = UsdGeom.Mesh(prim)
    points, counts = at_first(mesh.GetPointsAttr()), at_first(mesh.GetFaceVertexCountsAttr())
    indices = at_first(mesh.GetFaceVertexIndicesAttr())
    if points is None or counts is None or indices is None:
        raise Refused(f"{prim.GetPath()} is no whole mesh")
    points, counts, indices = np.array(points, float).reshape(-1, 3), np.array(counts, int), np.array(indices, int)
    if counts.sum() != len(indices) or len(indices) and (indices.max() >= len(points) or indices.min() < 0):
        raise Refused(f"{prim.GetPath()} has wrong indices")
    matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(first_time(prim)))
    binding = UsdSkel.BindingAPI(prim)
    skeleton = binding.GetInheritedSkeleton()
    if skeleton and binding.GetJointIndicesPrimvar().HasValue():
        bind = binding.GetGeomBindTransformAttr().Get()
        place = UsdGeom.Xformable(skeleton.GetPrim()).ComputeLocalToWorldTransform(first_time(skeleton.GetPrim()))
        matrix = (np.eye(4) if bind is None else np.array(bind)) @ np.array(place)
    is_turned = (mesh.GetOrientationAttr().Get() == "leftHanded") != (np.linalg.det(matrix[:3, :3]) < 0)
    holes, kept, first = set(mesh.GetHoleIndicesAttr().Get() or []), [], 0
    for face, count in enumerate(counts):
        of_face = list(range(first, first + count))
        first += count
        if count >= 3 and face not in holes:
            kept.append(of_face[:1] + of_face[:0:-1] if is_turned else of_face)
    order = np.array([corner for of_face in kept for corner in of_face], int)
    uvs = uvs_of(prim, indices, len(points))
    return Reading(
        points @ matrix[:3, :3] + matrix[3, :3],
        np.array([len(of_face) for of_face in kept], int),
        indices[order],
        None if uvs is None else uvs[order],
        shapes_of(binding, matrix, len(points)),
    )


def uvs_of(prim, indices, points):
    found = [p for p in UsdGeom.PrimvarsAPI(prim).GetPrimvars() if p.GetTypeName().role == "TextureCoordinate"]
    named = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
    chosen = named if named and named.HasValue() else found[0] if found else None
    if chosen is None:
        return None
    values = chosen.ComputeFlattened()
    if values is None:
        values = chosen.ComputeFlattened(Usd.TimeCode.EarliestTime())
    values = np.array(values, float)
    if values.ndim != 2:
        return None
    if chosen.GetInterpolation() == "faceVarying" and len(values) == len(indices):
        return values[:, :2]
    if chosen.GetInterpolation() in ("vertex", "varying") and len(values) == points:
        return values[indices, :2]
    return None


def shapes_of(binding, matrix, points):
    names = binding.GetBlendShapesAttr().Get() or []
    targets = binding.GetBlendShapeTargetsRel().GetTargets()
    shapes = {}
    for name, target in zip(names, targets):
        shape = UsdSkel.BlendShape(binding.GetPrim().GetStage().GetPrimAtPath(target))
        offsets = np.array(shape.GetOffsetsAttr().Get() or [], float).reshape(-1, 3)
        indices = shape.GetPointIndicesAttr().Get()
        moved = np.zeros((points, 3))
        moved[np.array(indices, int) if indices else np.arange(len(offsets))] = offsets
        shapes[name] = moved @ matrix[:3, :3]
    return shapes


def joined(parts):
    """Several readings as one."""
    first = np.cumsum([0] + [len(part.positions) for part in parts])
    uvs = None
    if any(part.uvs is not None for part in parts):
        uvs = np.concatenate([np.full((len(p.corners), 2), np.nan) if p.uvs is None else p.uvs for p in parts])
    shapes = {}
    for part, begin in zip(parts, first):
        for name, moved in (part.shapes or {}).items():
            shapes.setdefault(name, np.zeros((first[-1], 3)))[begin : begin + len(moved)] += moved
    return Reading(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.counts for part in parts]),
        np.concatenate([part.corners + begin for part, begin in zip(parts, first)]),
        uvs,
        shapes,
    )
