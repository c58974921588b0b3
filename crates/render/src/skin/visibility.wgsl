// Which light reaches each vertex: maps of what is nearest to a light, one direction after another.

struct Direction {
    // From the mesh's space: x and y in texels from the map's upper left corner, z along the light in mesh units.
    map_from_mesh: mat4x4f,
    // Towards the light, in the mesh's space; w is what it brings, for the sky.
    toward: vec4f,
    // Texels of a side, the filter's radius in texels, by how much a surface is nearer than it is, in mesh units; the map's depth.
    numbers: vec4f,
    // 1 for the key light.
    is_key: u32,
}

struct Frame {
    vertices: u32,
    // Of the arrays of positions and of normals, in floats.
    first_position: u32,
    first_normal: u32,
}

@group(0) @binding(0) var<uniform> d: Direction;
@group(0) @binding(1) var<uniform> frame: Frame;
// Distances as the bits of floats: integers can be drawn to by every device.
@group(0) @binding(2) var map: texture_2d<u32>;
@group(0) @binding(3) var<storage, read> positions: array<f32>;
@group(0) @binding(4) var<storage, read> normals: array<f32>;
// The sky's light that arrives, what would arrive if nothing were in its way, the part of the key light that arrives, and how far
// vertices are apart here, in mesh units.
@group(0) @binding(5) var<storage, read_write> seen: array<vec4f>;

struct Corner {
    @builtin(position) at: vec4f,
    @location(0) depth: f32,
}

@vertex fn caster(@location(0) position: vec3f) -> Corner {
    let p = (d.map_from_mesh * vec4f(position, 1)).xyz;
    let side = d.numbers.x;
    return Corner(vec4f(2 * p.x / side - 1, 1 - 2 * p.y / side, p.z / d.numbers.w, 1), p.z);
}

@fragment fn nearest(c: Corner) -> @location(0) u32 {
    return bitcast<u32>(c.depth);
}

@compute @workgroup_size(64) fn begin(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let v = id.x + id.y * groups.x * 64;
    if v < frame.vertices {
        seen[v] = vec4f(0, 0, 1, seen[v].w);
    }
}

@compute @workgroup_size(64) fn look(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let v = id.x + id.y * groups.x * 64;
    if v >= frame.vertices {
        return;
    }
    let i = frame.first_position + 3 * v;
    let j = frame.first_normal + 3 * v;
    let normal = vec3f(normals[j], normals[j + 1], normals[j + 2]);
    let cosine = dot(normal, d.toward.xyz);
    if cosine <= 0 {
        return;
    }
    // A little above the surface: the triangles around a vertex are flat and its normal is not theirs.
    let above = vec3f(positions[i], positions[i + 1], positions[i + 2]) + 0.1 * seen[v].w * normal;
    let p = (d.map_from_mesh * vec4f(above, 1)).xyz;
    // How much farther from the light the surface is a texel to the right and a texel down, as its normal says; not beyond 80°,
    // where there is no light to speak of.
    let right = vec3f(d.map_from_mesh[0].x, d.map_from_mesh[1].x, d.map_from_mesh[2].x);
    let down = vec3f(d.map_from_mesh[0].y, d.map_from_mesh[1].y, d.map_from_mesh[2].y);
    let texel = 1 / length(right);
    let slope = texel * vec2f(dot(normal, right), dot(normal, down)) * texel / max(cosine, 0.17);
    // A disc of texels, those at its rim counting less, so that nothing jumps where a vertex moves on. It reaches to the
    // next vertices, so that no shadow has a finer edge than the mesh can show; of a large one not every texel is taken.
    let radius = max(d.numbers.y, seen[v].w / texel);
    let stride = max(i32(radius / 6), 1);
    let first = vec2i(max(ceil(p.xy - 0.5 - radius), vec2f(0)));
    let end = vec2i(min(floor(p.xy - 0.5 + radius), vec2f(d.numbers.x - 1)));
    var lit = 0.0;
    var all = 0.0;
    for (var y = first.y; y <= end.y; y += stride) {
        for (var x = first.x; x <= end.x; x += stride) {
            let away = vec2f(f32(x) + 0.5, f32(y) + 0.5) - p.xy;
            let weight = max(1 - dot(away, away) / (radius * radius), 0);
            let surface = p.z + dot(slope, away);
            let depth = bitcast<f32>(textureLoad(map, vec2i(x, y), 0).x);
            all += weight;
            lit += weight * select(0.0, 1.0, surface - d.numbers.z <= depth);
        }
    }
    let part = select(1.0, lit / all, all > 0);
    if d.is_key == 1 {
        seen[v].z = part;
    } else {
        seen[v] += vec4f(part * cosine * d.toward.w, cosine * d.toward.w, 0, 0);
    }
}
