"""The frame in Numba: one parallel loop over the vertices for each part, in float32."""

import platform

import numba
import numpy as np
from numba import njit, prange

import peer

compiled = njit(parallel=True, fastmath=True, error_model="numpy", boundscheck=False)

@compiled
def large_scale(basis, rest, displacements, out):
    """`displacements` is 3 x H, so that the sum over the handles is one of vectors."""
    for v in prange(len(basis)):
        x = y = z = np.float32(0)
        row = basis[v]
        for h in range(len(row)):
            x += row[h] * displacements[0, h]
            y += row[h] * displacements[1, h]
            z += row[h] * displacements[2, h]
        out[v, 0] = rest[v, 0] + x
        out[v, 1] = rest[v, 1] + y
        out[v, 2] = rest[v, 2] + z

@compiled
def vertex_normals(positions, offsets, others, out):
    """`others[offsets[v]:offsets[v + 1]]` are the other two corners of each triangle at v, in its order."""
    for v in prange(len(positions)):
        x, y, z = positions[v, 0], positions[v, 1], positions[v, 2]
        nx = ny = nz = np.float32(0)
        for i in range(offsets[v], offsets[v + 1]):
            a, b = others[i, 0], others[i, 1]
            ax, ay, az = positions[a, 0] - x, positions[a, 1] - y, positions[a, 2] - z
            bx, by, bz = positions[b, 0] - x, positions[b, 1] - y, positions[b, 2] - z
            nx += ay * bz - az * by
            ny += az * bx - ax * bz
            nz += ax * by - ay * bx
        square = nx * nx + ny * ny + nz * nz
        scale = np.float32(1) / np.sqrt(square) if square > 0 else np.float32(0)
        out[v, 0] = nx * scale
        out[v, 1] = ny * scale
        out[v, 2] = nz * scale

def make_fine_scale(centers, influences):
    """Detail and tangent frames, compiled for these numbers, so that the loops over them are unrolled. `squares` is N x F."""

    @compiled
    def fine_scale(smooth, normals, neighbors, edges, alphas, squares, rbf_weights, out):
        for v in prange(len(smooth)):
            d0 = d1 = d2 = np.float32(0)
            for j in range(centers):
                square = np.float32(0)
                for k in range(influences):
                    square += alphas[v, k] * squares[j, edges[v, k]]
                r = np.sqrt(square)
                d0 += rbf_weights[v, j, 0] * r
                d1 += rbf_weights[v, j, 1] * r
                d2 += rbf_weights[v, j, 2] * r
            nx, ny, nz = normals[v, 0], normals[v, 1], normals[v, 2]
            w = neighbors[v]
            tx, ty, tz = smooth[w, 0] - smooth[v, 0], smooth[w, 1] - smooth[v, 1], smooth[w, 2] - smooth[v, 2]
            along = tx * nx + ty * ny + tz * nz
            tx -= along * nx
            ty -= along * ny
            tz -= along * nz
            square = tx * tx + ty * ty + tz * tz
            scale = np.float32(1) / np.sqrt(square) if square > 0 else np.float32(0)
            tx *= scale
            ty *= scale
            tz *= scale
            out[v, 0] = smooth[v, 0] + tx * d0 + (ny * tz - nz * ty) * d1 + nx * d2
            out[v, 1] = smooth[v, 1] + ty * d0 + (nz * tx - nx * tz) * d1 + ny * d2
            out[v, 2] = smooth[v, 2] + tz * d0 + (nx * ty - ny * tx) * d1 + nz * d2

    return fine_scale


def triangles_at_vertices(triangles, vertices):
    """The offsets and corners that `vertex_normals` takes."""
    corners = triangles.astype(np.int64)
    at = np.concatenate([corners[:, 0], corners[:, 1], corners[:, 2]])
    others = np.concatenate([corners[:, [1, 2]], corners[:, [2, 0]], corners[:, [0, 1]]])
    offsets = np.concatenate([[0], np.cumsum(np.bincount(at, minlength=vertices))])
    return offsets.astype(np.uint32), others[np.argsort(at, kind="stable")].astype(np.uint32)


def make_evaluate(rig):
    offsets, others = triangles_at_vertices(rig.triangles, rig.vertices)
    few = len(rig.strain_edges) <= 256
    edges = rig.influence_edges.astype(np.uint8 if few else np.uint32)
    fine_scale = make_fine_scale(len(rig.pose_features), rig.influences)
    smooth = np.empty_like(rig.rest)
    smooth_normals = np.empty_like(rig.rest)
    room = np.empty((2, len(rig.handles_over_time), *rig.rest.shape), np.float32)

    def evaluate(handles, watch):
        positions, normals = room[:, : len(handles)]
        displacements = np.ascontiguousarray((handles - rig.handle_rest).transpose(0, 2, 1))
        squares = np.ascontiguousarray(rig.squared_differences(handles).transpose(0, 2, 1))
        watch.lap("detail")
        for frame in range(len(handles)):
            large_scale(rig.basis, rig.rest, displacements[frame], smooth)
            watch.lap("large_scale")
            vertex_normals(smooth, offsets, others, smooth_normals)
            watch.lap("large_scale_normals")
            fine_scale(
                smooth,
                smooth_normals,
                rig.tangent_neighbors,
                edges,
                rig.influence_weights,
                squares[frame],
                rig.rbf_weights,
                positions[frame],
            )
            watch.lap("detail")
            vertex_normals(positions[frame], offsets, others, normals[frame])
            watch.lap("normals")
        return positions, normals

    return evaluate


if __name__ == "__main__":
    peer.serve(
        make_evaluate,
        "Numba, parallel",
        f"Python {platform.python_version()}, Numba {numba.__version__}",
    )
