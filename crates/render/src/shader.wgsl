struct View {
    clip_from_mesh: mat4x4f,
    // Turns and moves; does not scale.
    camera_from_mesh: mat4x4f,
    // Linear.
    colour: vec4f,
    // The numbers of the first and the last colour.
    range: vec4f,
    colours: array<vec4f, 65>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var filtering: sampler;

struct Corner {
    @builtin(position) at: vec4f,
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) number: f32,
    @location(3) light: f32,
}

// Irradiance over that of a white wall before the brighter lamp: a lamp at the upper left, a weak one at the right, and a sky.
// All of it is in the camera's space, so that a face that turns is lit from where the viewer is.
fn light(n: vec3f) -> f32 {
    let key = max(dot(n, normalize(vec3f(-0.45, 0.55, 0.7))), 0);
    let fill = max(dot(n, normalize(vec3f(0.8, 0, 0.6))), 0);
    return 0.75 * key + 0.12 * fill + 0.09 + 0.05 * n.y;
}

fn seen(position: vec3f, normal: vec3f, number: f32) -> Corner {
    let place = view.camera_from_mesh * vec4f(position, 1);
    let turned = (view.camera_from_mesh * vec4f(normal, 0)).xyz;
    return Corner(view.clip_from_mesh * vec4f(position, 1), place.xyz, turned, number, light(turned));
}

@vertex fn corner(@location(0) position: vec3f, @location(1) normal: vec3f) -> Corner {
    return seen(position, normal, 0);
}

@vertex fn numbered_corner(@location(0) position: vec3f, @location(1) normal: vec3f, @location(2) number: f32) -> Corner {
    return seen(position, normal, number);
}

// What is seen from its inside is darker.
fn lit(colour: vec3f, n: vec3f, is_front: bool) -> vec4f {
    let light = select(0.3 * light(-n), light(n), is_front);
    return vec4f(min(colour * light, vec3f(1)), 1);
}

fn skin(n: vec3f, is_front: bool) -> vec4f {
    return lit(view.colour.rgb, n, is_front);
}

@fragment fn smooth_skin(c: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return skin(normalize(c.normal), is_front);
}

@fragment fn gouraud_skin(c: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return vec4f(min(view.colour.rgb * select(0.3, 1.0, is_front) * c.light, vec3f(1)), 1);
}

@fragment fn flat_skin(c: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    // Towards the viewer, whichever side is seen.
    let n = normalize(cross(dpdx(c.place), dpdy(c.place)));
    let toward = select(n, -n, dot(n, c.place) > 0);
    return skin(select(-toward, toward, is_front), is_front);
}

@fragment fn wire(c: Corner) -> @location(0) vec4f {
    return view.colour;
}

// What is between wires, a little lit so that the shape is seen.
@fragment fn behind(c: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return vec4f(vec3f(0.12) * select(0.3, 1.0, is_front) * light(normalize(c.normal)), 1);
}

fn heat_of(number: f32) -> vec4f {
    // No number: see heat.rs.
    if number < -1e30 {
        return vec4f(vec3f(0.3), 1);
    }
    let t = clamp((number - view.range.x) / (view.range.y - view.range.x), 0, 1) * 64;
    let first = min(u32(t), 63u);
    return mix(view.colours[first], view.colours[first + 1], t - f32(first));
}

@fragment fn heat(c: Corner) -> @location(0) vec4f {
    return heat_of(c.number);
}

@fragment fn lit_heat(c: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return lit(heat_of(c.number).rgb, normalize(c.normal), is_front);
}

// A ball's picture where its surface has the same direction, seen along the ray to this place rather than along the camera's axis,
// so that a ball looks the same wherever it is in the picture.
@fragment fn matcap(c: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let n = select(-1.0, 1.0, is_front) * normalize(c.normal);
    let toward = normalize(-c.place);
    let right = normalize(vec3f(toward.z, 0, -toward.x));
    let seen = vec2f(dot(right, n), dot(cross(toward, right), n));
    // The ball fills the picture but for half a pixel of 256.
    let colour = textureSample(image, filtering, 0.5 + vec2f(0.498, -0.498) * seen).rgb;
    return vec4f(select(0.3, 1.0, is_front) * colour, 1);
}
