struct View {
    clip_from_camera: mat4x4f,
    camera_from_mesh: mat4x4f,
    // Width and height in pixels, and by how much marks are nearer than they are.
    size: vec4f,
}

@group(0) @binding(0) var<uniform> view: View;

struct Corner {
    @builtin(position) at: vec4f,
    // In pixels: along the line from its beginning, and across it.
    @location(0) place: vec2f,
    @location(1) length: f32,
    @location(2) radius: f32,
    @location(3) colour: vec3f,
}

fn seen(position: vec3f) -> vec4f {
    var place = view.camera_from_mesh * vec4f(position, 1);
    place.z += view.size.z;
    return view.clip_from_camera * place;
}

@vertex fn corner(
    @builtin(vertex_index) index: u32,
    @location(0) a: vec3f,
    @location(1) b: vec3f,
    @location(2) colour: vec3f,
    @location(3) width: f32,
) -> Corner {
    // Two triangles: the beginning's corners and the end's.
    let is_end = index == 1 || index == 2 || index == 4;
    let is_left = index == 2 || index == 4 || index == 5;
    let ends = array(seen(a), seen(b));
    let half = 0.5 * view.size.xy;
    let first = ends[0].xy / ends[0].w * half;
    let last = ends[1].xy / ends[1].w * half;
    let length = distance(first, last);
    var along = vec2f(1, 0);
    if length > 1e-3 {
        along = (last - first) / length;
    }
    let across = vec2f(-along.y, along.x);
    // A pixel more, over which it fades.
    let radius = 0.5 * width;
    let out = radius + 1;
    let place = vec2f(select(-out, length + out, is_end), select(-out, out, is_left));
    let at = (first + along * place.x + across * place.y) / half;
    let end = select(ends[0], ends[1], is_end);
    return Corner(vec4f(at * end.w, end.zw), place, length, radius, colour);
}

@fragment fn mark(c: Corner) -> @location(0) vec4f {
    let nearest = vec2f(clamp(c.place.x, 0, c.length), 0);
    let covered = clamp(c.radius + 0.5 - distance(c.place, nearest), 0, 1);
    return vec4f(c.colour * covered, covered);
}
