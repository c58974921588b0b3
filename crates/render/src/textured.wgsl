// Behind shader.wgsl. A vertex has a place in the image for each of its corners, and there is only one of it in a session's buffers: so corners
// fetch their vertices.
@group(2) @binding(0) var<storage, read> positions: array<f32>;
@group(2) @binding(1) var<storage, read> normals: array<f32>;

struct TexturedCorner {
    @builtin(position) at: vec4f,
    @location(0) normal: vec3f,
    @location(1) uv: vec2f,
}

@vertex fn textured_corner(@location(0) vertex: u32, @location(1) uv: vec2f) -> TexturedCorner {
    let i = 3 * vertex;
    let position = vec3f(positions[i], positions[i + 1], positions[i + 2]);
    let normal = vec3f(normals[i], normals[i + 1], normals[i + 2]);
    let turned = (view.camera_from_mesh * vec4f(normal, 0)).xyz;
    // Images begin at the upper left.
    return TexturedCorner(view.clip_from_mesh * vec4f(position, 1), turned, vec2f(uv.x, 1 - uv.y));
}

// Colours are multiplied by their opacity.
@fragment fn clear(c: TexturedCorner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let seen = textureSample(image, filtering, c.uv);
    return vec4f(lit(seen.rgb, normalize(c.normal), is_front).rgb * seen.a, seen.a);
}

@fragment fn textured(c: TexturedCorner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return lit(textureSample(image, filtering, c.uv).rgb, normalize(c.normal), is_front);
}
