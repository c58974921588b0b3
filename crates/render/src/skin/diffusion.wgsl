struct Step {
    // Of the polynomial that comes of this step; w is 0 for the first step, else 1.
    coefficients: vec4f,
    // Of the one before, for the first step alone.
    before: vec4f,
    vertices: u32,
}

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> offsets: array<u32>;
// A neighbour, and 2 w / Λ M as the bits of a float.
@group(0) @binding(2) var<storage, read> links: array<vec2u>;
@group(0) @binding(3) var<storage, read> now: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> last: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> spread: array<vec4f>;

// The next Chebyshev polynomial of the Laplacian times light: T₁ = y, T₍k₊₁₎ = 2 y T₍k₎ − T₍k₋₁₎ with y = 2 L/Λ − 1.
@compute @workgroup_size(64) fn diffuse(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let v = id.x + id.y * groups.x * 64;
    if v >= step.vertices {
        return;
    }
    let here = now[v];
    // Differences, so that constant light stays constant to the last bit.
    var sum = vec4f(0);
    for (var i = offsets[v]; i < offsets[v + 1]; i++) {
        sum += bitcast<f32>(links[i].y) * (here - now[links[i].x]);
    }
    let y = sum - here;
    if step.coefficients.w == 0 {
        last[v] = y;
        spread[v] = step.before * here + step.coefficients * y;
    } else {
        let next = 2 * y - last[v];
        last[v] = next;
        spread[v] += step.coefficients * next;
    }
}
