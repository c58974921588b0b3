// The frame in C++17 and OpenMP: `single` loops over the vertices, `batch` has 32 frames innermost, so that each loop over
// them is a few vectors. What is said to and asked of this program is described in peer.py.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <omp.h>
#include <string>
#include <type_traits>
#include <vector>

constexpr int FRAMES = 32;

// Memory is first touched by the threads that use it, so nothing is initialised here.
template <class T> struct Array {
    explicit Array(size_t size) : size(size), data(static_cast<T *>(std::aligned_alloc(64, (size * sizeof(T) + 63) / 64 * 64))) {}
    ~Array() { std::free(data); }
    Array(const Array &) = delete;
    T &operator[](size_t i) { return data[i]; }
    const T &operator[](size_t i) const { return data[i]; }
    const size_t size;
    T *const data;
};

[[noreturn]] void fail(const std::string &what) {
    std::cerr << what << std::endl;
    std::exit(1);
}

template <class T> std::vector<T> read_npy(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    char start[10];
    uint16_t header = 0;
    if (!file.read(start, 10)) fail(path + ": no .npy file");
    std::memcpy(&header, start + 8, 2);
    std::string text(header, ' ');
    file.read(text.data(), header);
    const char *type = std::is_same_v<T, float> ? "'<f4'" : "'<u4'";
    if (text.find(type) == std::string::npos) fail(path + ": expected " + type + ", found " + text);
    const auto begin = file.tellg();
    file.seekg(0, std::ios::end);
    std::vector<T> values((file.tellg() - begin) / sizeof(T));
    file.seekg(begin);
    if (!file.read(reinterpret_cast<char *>(values.data()), values.size() * sizeof(T))) fail(path + ": cannot be read");
    return values;
}

void write_npy(const std::string &path, const float *values, int frames, int vertices) {
    std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(frames) + ", " +
                       std::to_string(vertices) + ", 3), }";
    text.resize((text.size() + 11 + 63) / 64 * 64 - 11, ' ');
    text += '\n';
    const uint16_t header = text.size();
    std::ofstream file(path, std::ios::binary);
    file.write("\x93NUMPY\x01\x00", 8).write(reinterpret_cast<const char *>(&header), 2) << text;
    file.write(reinterpret_cast<const char *>(values), sizeof(float) * 3 * frames * vertices);
    if (!file.flush()) fail(path + ": cannot be written");
}

// A rig's arrays, and what is made of them before any frame.
struct Rig {
    explicit Rig(const std::string &folder)
        : rest(read_npy<float>(folder + "/rest.npy")), basis(read_npy<float>(folder + "/basis.npy")),
          alphas(read_npy<float>(folder + "/influence_weights.npy")),
          pose_features(read_npy<float>(folder + "/pose_features.npy")),
          rbf_weights(read_npy<float>(folder + "/rbf_weights.npy")),
          handles_over_time(read_npy<float>(folder + "/handles_over_time.npy")),
          handle_rest(read_npy<float>(folder + "/handle_rest.npy")),
          strain_edges(read_npy<uint32_t>(folder + "/strain_edges.npy")),
          neighbors(read_npy<uint32_t>(folder + "/tangent_neighbors.npy")) {
        edges = read_npy<uint32_t>(folder + "/influence_edges.npy");
        V = rest.size() / 3, H = handle_rest.size() / 3, F = strain_edges.size() / 2;
        K = edges.size() / V, N = pose_features.size() / F;
        if (handles_over_time.size() != size_t(FRAMES) * 3 * H) fail("expected 32 frames");

        const auto triangles = read_npy<uint32_t>(folder + "/triangles.npy");
        offsets.assign(V + 1, 0);
        for (uint32_t v : triangles) offsets[v + 1]++;
        for (int v = 0; v < V; v++) offsets[v + 1] += offsets[v];
        std::vector<uint32_t> next(offsets.begin(), offsets.end() - 1);
        others.resize(2 * triangles.size());
        for (size_t corner = 0; corner < triangles.size(); corner++) {
            const size_t first = corner / 3 * 3, i = next[triangles[corner]]++;
            others[2 * i] = triangles[first + (corner + 1) % 3];
            others[2 * i + 1] = triangles[first + (corner + 2) % 3];
        }
    }

    // (f_e - f_je)^2 for one frame; in double, since strain is a small difference of lengths.
    template <class Out> void squared_differences(const float *handles, Out out) const {
        const auto length = [&](const float *p, int e) {
            double sum = 0;
            for (int c = 0; c < 3; c++) {
                const double d = double(p[3 * strain_edges[2 * e] + c]) - p[3 * strain_edges[2 * e + 1] + c];
                sum += d * d;
            }
            return std::sqrt(sum);
        };
        for (int e = 0; e < F; e++) {
            const double at_rest = length(handle_rest.data(), e);
            const double f = (length(handles, e) - at_rest) / at_rest;
            for (int j = 0; j < N; j++) out(e, j) = float((f - pose_features[j * F + e]) * (f - pose_features[j * F + e]));
        }
    }

    int V, H, F, K, N;
    std::vector<float> rest, basis, alphas, pose_features, rbf_weights, handles_over_time, handle_rest;
    std::vector<uint32_t> strain_edges, neighbors, edges;
    // others[2 offsets[v] .. 2 offsets[v + 1]]: the other two corners of each triangle at v, in its order.
    std::vector<uint32_t> offsets, others;
};

struct Stopwatch {
    using Clock = std::chrono::steady_clock;
    Clock::time_point start = Clock::now(), last = start;
    std::map<std::string, double> parts;

    static double ms(Clock::duration d) { return std::chrono::duration<double, std::milli>(d).count(); }
    void lap(const char *part) {
        const auto now = Clock::now();
        parts[part] += ms(now - last);
        last = now;
    }
    void print() {
        parts["whole"] = ms(Clock::now() - start);
        std::string line;
        for (const auto &[part, ms] : parts) line += (line.empty() ? "{\"" : ", \"") + part + "\": " + std::to_string(ms);
        std::cout << line << "}" << std::endl;
    }
};

namespace single {
void large_scale(const Rig &rig, const float *u, float *out) {
#pragma omp parallel for
    for (int v = 0; v < rig.V; v++) {
        const float *row = &rig.basis[size_t(v) * rig.H];
        const float *ux = u, *uy = u + rig.H, *uz = u + 2 * rig.H;
        float x = 0, y = 0, z = 0;
#pragma omp simd reduction(+ : x, y, z)
        for (int h = 0; h < rig.H; h++) {
            x += row[h] * ux[h];
            y += row[h] * uy[h];
            z += row[h] * uz[h];
        }
        out[3 * v] = rig.rest[3 * v] + x;
        out[3 * v + 1] = rig.rest[3 * v + 1] + y;
        out[3 * v + 2] = rig.rest[3 * v + 2] + z;
    }
}

void vertex_normals(const Rig &rig, const float *p, float *out) {
#pragma omp parallel for
    for (int v = 0; v < rig.V; v++) {
        const float x = p[3 * v], y = p[3 * v + 1], z = p[3 * v + 2];
        float nx = 0, ny = 0, nz = 0;
        for (uint32_t i = rig.offsets[v]; i < rig.offsets[v + 1]; i++) {
            const float *a = p + 3 * rig.others[2 * i], *b = p + 3 * rig.others[2 * i + 1];
            const float ax = a[0] - x, ay = a[1] - y, az = a[2] - z;
            const float bx = b[0] - x, by = b[1] - y, bz = b[2] - z;
            nx += ay * bz - az * by;
            ny += az * bx - ax * bz;
            nz += ax * by - ay * bx;
        }
        const float square = nx * nx + ny * ny + nz * nz;
        const float scale = square > 0 ? 1 / std::sqrt(square) : 0;
        out[3 * v] = nx * scale, out[3 * v + 1] = ny * scale, out[3 * v + 2] = nz * scale;
    }
}

// `squares` is N/8 x F x 8: eight centres of an edge are one vector.
void fine_scale(const Rig &rig, const float *squares, const float *smooth, const float *normals, float *out) {
#pragma omp parallel for
    for (int v = 0; v < rig.V; v++) {
        const uint32_t *edges = &rig.edges[size_t(v) * rig.K];
        const float *alphas = &rig.alphas[size_t(v) * rig.K], *w = &rig.rbf_weights[size_t(v) * rig.N * 3];
        float d0 = 0, d1 = 0, d2 = 0;
        for (int first = 0; first < rig.N; first += 8) {
            float r[8] = {};
            for (int k = 0; k < rig.K; k++) {
                const float *row = squares + first * rig.F + 8 * edges[k];
#pragma omp simd
                for (int j = 0; j < 8; j++) r[j] += alphas[k] * row[j];
            }
            for (int j = 0; j < 8; j++) r[j] = std::sqrt(r[j]);
            for (int j = 0; j < std::min(8, rig.N - first); j++) {
                const float *wj = w + 3 * (first + j);
                d0 += wj[0] * r[j], d1 += wj[1] * r[j], d2 += wj[2] * r[j];
            }
        }
        const float *x = smooth + 3 * v, *to = smooth + 3 * rig.neighbors[v];
        const float nx = normals[3 * v], ny = normals[3 * v + 1], nz = normals[3 * v + 2];
        float tx = to[0] - x[0], ty = to[1] - x[1], tz = to[2] - x[2];
        const float along = tx * nx + ty * ny + tz * nz;
        tx -= along * nx, ty -= along * ny, tz -= along * nz;
        const float square = tx * tx + ty * ty + tz * tz;
        const float scale = square > 0 ? 1 / std::sqrt(square) : 0;
        tx *= scale, ty *= scale, tz *= scale;
        out[3 * v] = x[0] + tx * d0 + (ny * tz - nz * ty) * d1 + nx * d2;
        out[3 * v + 1] = x[1] + ty * d0 + (nz * tx - nx * tz) * d1 + ny * d2;
        out[3 * v + 2] = x[2] + tz * d0 + (nx * ty - ny * tx) * d1 + nz * d2;
    }
}

struct Session {
    const Rig &rig;
    Array<float> smooth{size_t(rig.V) * 3}, smooth_normals{size_t(rig.V) * 3};
    Array<float> positions{size_t(rig.V) * 3}, normals{size_t(rig.V) * 3};

    void evaluate(Stopwatch &watch) {
        std::vector<float> u(3 * rig.H), squares((rig.N + 7) / 8 * 8 * rig.F);
        for (int i = 0; i < 3 * rig.H; i++) u[i % 3 * rig.H + i / 3] = rig.handles_over_time[i] - rig.handle_rest[i];
        large_scale(rig, u.data(), smooth.data);
        watch.lap("large_scale");
        vertex_normals(rig, smooth.data, smooth_normals.data);
        watch.lap("large_scale_normals");
        rig.squared_differences(rig.handles_over_time.data(),
                                [&](int e, int j) -> float & { return squares[j / 8 * 8 * rig.F + 8 * e + j % 8]; });
        fine_scale(rig, squares.data(), smooth.data, smooth_normals.data, positions.data);
        watch.lap("detail");
        vertex_normals(rig, positions.data, normals.data);
        watch.lap("normals");
    }
};
} // namespace single

// Arrays of vectors are V x 3 x FRAMES.
namespace batch {
using Frames = float[FRAMES];

// `u` is H x 3 x FRAMES.
void large_scale(const Rig &rig, const Frames *u, Frames *out) {
#pragma omp parallel for
    for (int v = 0; v < rig.V; v++) {
        const float *row = &rig.basis[size_t(v) * rig.H];
        alignas(64) Frames sum[3] = {};
        for (int h = 0; h < rig.H; h++)
            for (int c = 0; c < 3; c++)
                for (int f = 0; f < FRAMES; f++) sum[c][f] += row[h] * u[3 * h + c][f];
        for (int c = 0; c < 3; c++)
            for (int f = 0; f < FRAMES; f++) out[3 * v + c][f] = rig.rest[3 * v + c] + sum[c][f];
    }
}

void vertex_normals(const Rig &rig, const Frames *p, Frames *out) {
#pragma omp parallel for
    for (int v = 0; v < rig.V; v++) {
        const Frames *o = p + 3 * size_t(v);
        alignas(64) Frames n[3] = {};
        for (uint32_t i = rig.offsets[v]; i < rig.offsets[v + 1]; i++) {
            const Frames *a = p + 3 * size_t(rig.others[2 * i]), *b = p + 3 * size_t(rig.others[2 * i + 1]);
            for (int f = 0; f < FRAMES; f++) {
                const float ax = a[0][f] - o[0][f], ay = a[1][f] - o[1][f], az = a[2][f] - o[2][f];
                const float bx = b[0][f] - o[0][f], by = b[1][f] - o[1][f], bz = b[2][f] - o[2][f];
                n[0][f] += ay * bz - az * by;
                n[1][f] += az * bx - ax * bz;
                n[2][f] += ax * by - ay * bx;
            }
        }
        for (int f = 0; f < FRAMES; f++) {
            const float square = n[0][f] * n[0][f] + n[1][f] * n[1][f] + n[2][f] * n[2][f];
            const float scale = square > 0 ? 1 / std::sqrt(square) : 0;
            for (int c = 0; c < 3; c++) out[3 * size_t(v) + c][f] = n[c][f] * scale;
        }
    }
}

// `squares` is F x N x FRAMES.
void fine_scale(const Rig &rig, const Frames *squares, const Frames *smooth, const Frames *normals, Frames *out) {
#pragma omp parallel for
    for (int v = 0; v < rig.V; v++) {
        const uint32_t *edges = &rig.edges[size_t(v) * rig.K];
        const float *alphas = &rig.alphas[size_t(v) * rig.K], *w = &rig.rbf_weights[size_t(v) * rig.N * 3];
        alignas(64) Frames d[3] = {};
        for (int j = 0; j < rig.N; j++) {
            alignas(64) Frames sum = {};
            for (int k = 0; k < rig.K; k++) {
                const float *row = squares[edges[k] * rig.N + j];
                for (int f = 0; f < FRAMES; f++) sum[f] += alphas[k] * row[f];
            }
            for (int f = 0; f < FRAMES; f++) {
                const float r = std::sqrt(sum[f]);
                for (int c = 0; c < 3; c++) d[c][f] += w[3 * j + c] * r;
            }
        }
        const Frames *x = smooth + 3 * size_t(v), *to = smooth + 3 * size_t(rig.neighbors[v]), *n = normals + 3 * size_t(v);
        for (int f = 0; f < FRAMES; f++) {
            const float nx = n[0][f], ny = n[1][f], nz = n[2][f];
            float tx = to[0][f] - x[0][f], ty = to[1][f] - x[1][f], tz = to[2][f] - x[2][f];
            const float along = tx * nx + ty * ny + tz * nz;
            tx -= along * nx, ty -= along * ny, tz -= along * nz;
            const float square = tx * tx + ty * ty + tz * tz;
            const float scale = square > 0 ? 1 / std::sqrt(square) : 0;
            tx *= scale, ty *= scale, tz *= scale;
            out[3 * size_t(v)][f] = x[0][f] + tx * d[0][f] + (ny * tz - nz * ty) * d[1][f] + nx * d[2][f];
            out[3 * size_t(v) + 1][f] = x[1][f] + ty * d[0][f] + (nz * tx - nx * tz) * d[1][f] + ny * d[2][f];
            out[3 * size_t(v) + 2][f] = x[2][f] + tz * d[0][f] + (nx * ty - ny * tx) * d[1][f] + nz * d[2][f];
        }
    }
}

// To FRAMES x V x 3, a tile of vertices at a time.
void rearrange(const Rig &rig, const Frames *in, float *out) {
    const int values = 3 * rig.V, tile = 64;
#pragma omp parallel for
    for (int first = 0; first < values; first += tile)
        for (int f = 0; f < FRAMES; f++)
            for (int i = first; i < std::min(first + tile, values); i++) out[size_t(f) * values + i] = in[i][f];
}

struct Session {
    const Rig &rig;
    Array<Frames> smooth{size_t(rig.V) * 3}, smooth_normals{size_t(rig.V) * 3}, x{size_t(rig.V) * 3}, n{size_t(rig.V) * 3};
    Array<float> positions{size_t(rig.V) * 3 * FRAMES}, normals{size_t(rig.V) * 3 * FRAMES};

    void evaluate(Stopwatch &watch) {
        Array<Frames> u(3 * rig.H), squares(rig.F * rig.N);
        for (int f = 0; f < FRAMES; f++) {
            const float *handles = &rig.handles_over_time[size_t(f) * 3 * rig.H];
            for (int i = 0; i < 3 * rig.H; i++) u[i][f] = handles[i] - rig.handle_rest[i];
            rig.squared_differences(handles, [&](int e, int j) -> float & { return squares[e * rig.N + j][f]; });
        }
        watch.lap("detail");
        large_scale(rig, u.data, smooth.data);
        watch.lap("large_scale");
        vertex_normals(rig, smooth.data, smooth_normals.data);
        watch.lap("large_scale_normals");
        fine_scale(rig, squares.data, smooth.data, smooth_normals.data, x.data);
        watch.lap("detail");
        vertex_normals(rig, x.data, n.data);
        watch.lap("normals");
        rearrange(rig, x.data, positions.data);
        rearrange(rig, n.data, normals.data);
        watch.lap("rearranging");
    }
};
} // namespace batch

int main(int, char **arguments) {
    const std::string folder = arguments[1];
    const Rig rig(folder);
    single::Session frame{rig};
    batch::Session frames{rig};
    Stopwatch unused;
    frame.evaluate(unused);
    write_npy(folder + "/frame_positions.npy", frame.positions.data, 1, rig.V);
    write_npy(folder + "/frame_normals.npy", frame.normals.data, 1, rig.V);
    frames.evaluate(unused);
    write_npy(folder + "/batch_positions.npy", frames.positions.data, FRAMES, rig.V);
    write_npy(folder + "/batch_normals.npy", frames.normals.data, FRAMES, rig.V);
    std::cout << "{\"name\": \"C++/OpenMP " << BUILD << "\", \"detail\": \"g++ " << __VERSION__ << "\"}" << std::endl;
    for (std::string line; std::getline(std::cin, line);) {
        Stopwatch watch;
        line == "frame" ? frame.evaluate(watch) : frames.evaluate(watch);
        watch.print();
    }
}
