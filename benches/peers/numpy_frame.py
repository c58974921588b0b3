"""The frame in NumPy and SciPy: BLAS for the large scale, sparse products for sums over neighbours and influences."""

import platform

import numpy as np
import scipy
import scipy.sparse

import peer


def normalised(vectors):
    """3 x V; a vector of length zero stays zero."""
    squares = np.einsum("cv,cv->v", vectors, vectors)
    return vectors * np.divide(1, np.sqrt(squares), out=np.zeros_like(squares), where=squares > 0)


def cross(a, b):
    """3 x V; np.cross is several times slower."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def make_evaluate(rig):
    v, k = rig.vertices, rig.influences
    triangles = np.ascontiguousarray(rig.triangles.T.astype(np.int32))
    t = triangles.shape[1]
    # Adds up the triangles' cross products at their corners.
    corners = scipy.sparse.csr_matrix(
        (np.ones(3 * t, np.float32), (triangles.ravel(), np.tile(np.arange(t, dtype=np.int32), 3))), (v, t)
    )
    # Adds up the squared differences of a vertex's edges.
    influences = scipy.sparse.csr_matrix(
        (rig.influence_weights.ravel(), rig.influence_edges.ravel().astype(np.int32), np.arange(v + 1) * k),
        (v, len(rig.strain_edges)),
    )
    # Components first, so that each is one contiguous array.
    rest = np.ascontiguousarray(rig.rest.T)
    basis = np.ascontiguousarray(rig.basis.T)
    rbf_weights = np.ascontiguousarray(rig.rbf_weights.transpose(2, 1, 0))
    neighbors = rig.tangent_neighbors.astype(np.int32)

    def vertex_normals(x):
        a, b, c = (np.take(x, corner, axis=1) for corner in triangles)
        return normalised(np.stack([corners @ component for component in cross(b - a, c - a)]))

    def evaluate(handles, watch):
        frames = len(handles)
        displacements = (handles - rig.handle_rest).transpose(0, 2, 1).reshape(3 * frames, -1)
        moved = (displacements @ basis).reshape(frames, 3, v)
        watch.lap("large_scale")
        squares = rig.squared_differences(handles)
        positions = np.empty((frames, v, 3), np.float32)
        normals = np.empty((frames, v, 3), np.float32)
        watch.lap("detail")
        for frame in range(frames):
            smooth = rest + moved[frame]
            watch.lap("large_scale")
            n = vertex_normals(smooth)
            watch.lap("large_scale_normals")
            distances = np.sqrt(np.ascontiguousarray((influences @ squares[frame]).T))
            d = np.einsum("cnv,nv->cv", rbf_weights, distances)
            edge = np.take(smooth, neighbors, axis=1) - smooth
            tangent = normalised(edge - np.einsum("cv,cv->v", edge, n) * n)
            x = smooth + tangent * d[0] + cross(n, tangent) * d[1] + n * d[2]
            positions[frame] = x.T
            watch.lap("detail")
            normals[frame] = vertex_normals(x).T
            watch.lap("normals")
        return positions, normals

    return evaluate


if __name__ == "__main__":
    peer.serve(
        make_evaluate,
        "NumPy/SciPy",
        f"Python {platform.python_version()}, NumPy {np.__version__}, SciPy {scipy.__version__}",
    )
