// Light on skin, and what a camera sees of it. Radiance in cd/m², irradiance in lx; directions in the camera's space.

struct Scene {
    clip_from_mesh: mat4x4f,
    // Turns and moves; does not scale.
    camera_from_mesh: mat4x4f,
    // Towards the key light.
    toward: vec4f,
    // The key light's irradiance where it falls straight.
    key: vec4f,
    // The sky's spherical harmonics.
    sky: array<vec4f, 9>,
    // Reflectance straight on, the roughness of two lobes, and the part of the first.
    specular: vec4f,
    // What a display shows of 1 cd/m², and how: 0 as it is, 1 Khronos PBR Neutral, 2 AgX.
    display: vec4f,
}

struct Frame {
    vertices: u32,
    first_position: u32,
    first_normal: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<storage, read> normals: array<f32>;
@group(0) @binding(3) var<storage, read> seen: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> light: array<vec4f>;

const PI = 3.14159265;

fn sum(d: vec3f, factors: vec3f) -> vec3f {
    let c1 = factors.y * 0.48860251;
    let c2 = factors.z * 1.09254843;
    return max(vec3f(0), factors.x * 0.28209479 * scene.sky[0].rgb
        + c1 * (d.y * scene.sky[1].rgb + d.z * scene.sky[2].rgb + d.x * scene.sky[3].rgb)
        + c2 * (d.x * d.y * scene.sky[4].rgb + d.y * d.z * scene.sky[5].rgb + d.x * d.z * scene.sky[7].rgb)
        + factors.z * 0.31539157 * (3 * d.z * d.z - 1) * scene.sky[6].rgb
        + 0.5 * c2 * (d.x * d.x - d.y * d.y) * scene.sky[8].rgb);
}

// The part of even light that skin's surface throws back: B. Karis, Physically Based Shading on Mobile (2014), a fit of the split sum.
fn thrown_back(roughness: f32, cosine: f32) -> f32 {
    let r = roughness * vec4f(-1, -0.0275, -0.572, 0.022) + vec4f(1, 0.0425, 1.04, -0.04);
    let a = min(r.x * r.x, exp2(-9.28 * cosine)) * r.x + r.y;
    let scale = vec2f(-1.04, 1.04) * a + r.zw;
    return clamp(scene.specular.x * scale.x + scale.y, 0, 1);
}

fn thrown_back_by_both(cosine: f32) -> f32 {
    let parts = vec2f(thrown_back(scene.specular.y, cosine), thrown_back(scene.specular.z, cosine));
    return mix(parts.y, parts.x, scene.specular.w);
}

@compute @workgroup_size(64) fn receive(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let v = id.x + id.y * groups.x * 64;
    if v >= frame.vertices {
        return;
    }
    let i = frame.first_normal + 3 * v;
    let n = (scene.camera_from_mesh * vec4f(normals[i], normals[i + 1], normals[i + 2], 0)).xyz;
    let cosine = max(dot(n, scene.toward.xyz), 0);
    let key = scene.key.rgb * cosine * seen[v].z * (1 - thrown_back_by_both(cosine));
    let open = select(1.0, seen[v].x / seen[v].y, seen[v].y > 0);
    // On the average over all directions that light comes from, as at 60°.
    let sky = open * sum(n, vec3f(PI, 2 * PI / 3, PI / 4)) * (1 - thrown_back_by_both(0.5));
    light[v] = vec4f(key + sky, 0);
}

struct Corner {
    @builtin(position) at: vec4f,
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) spread: vec3f,
    @location(3) seen: vec2f,
    @location(4) albedo: vec3f,
}

@vertex fn corner(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) spread: vec4f,
    @location(3) reached: vec4f,
    @location(4) albedo: vec4f,
) -> Corner {
    let place = (scene.camera_from_mesh * vec4f(position, 1)).xyz;
    let turned = (scene.camera_from_mesh * vec4f(normal, 0)).xyz;
    let open = select(1.0, reached.x / reached.y, reached.y > 0);
    return Corner(scene.clip_from_mesh * vec4f(position, 1), place, turned, spread.rgb, vec2f(open, reached.z), albedo.rgb);
}

// B. Walter et al. (2007), with the height-correlated masking of E. Heitz (2014): D G / 4 (n·l) (n·v).
fn lobe(alpha: f32, half: f32, to_light: f32, to_eye: f32) -> f32 {
    let a2 = alpha * alpha;
    let d = half * half * (a2 - 1) + 1;
    let masked = to_eye * sqrt(a2 + (1 - a2) * to_light * to_light)
        + to_light * sqrt(a2 + (1 - a2) * to_eye * to_eye);
    return a2 / (PI * d * d) * 0.5 / max(masked, 1e-6);
}

@fragment fn skin(c: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let eye = normalize(-c.place);
    let outward = normalize(c.normal);
    let n = select(-outward, outward, is_front);
    let to_eye = max(dot(n, eye), 1e-3);
    let diffuse = c.albedo / PI * c.spread * (1 - thrown_back_by_both(to_eye));
    if !is_front {
        // What is seen from its inside is darker and does not shine.
        return vec4f(shown(0.3 * diffuse), 1);
    }

    let to_light = max(dot(n, scene.toward.xyz), 0);
    let between = normalize(eye + scene.toward.xyz);
    let half = max(dot(n, between), 0);
    // R. Schlick (1994).
    let fresnel = scene.specular.x + (1 - scene.specular.x) * pow(1 - max(dot(eye, between), 0), 5);
    let alpha = scene.specular.y * scene.specular.y;
    let beta = scene.specular.z * scene.specular.z;
    let lobes = mix(lobe(beta, half, to_light, to_eye), lobe(alpha, half, to_light, to_eye), scene.specular.w);
    let key = scene.key.rgb * c.seen.y * to_light * fresnel * lobes;

    // The sky in a mirror that is as rough: as R. Ramamoorthi and P. Hanrahan (2001) have it for a lobe of Phong's, whose exponent is
    // 2/α² − 2.
    let mirrored = reflect(-eye, n);
    let fade = exp(-0.25 * alpha * alpha * vec3f(0, 1, 4));
    let sky = sum(mirrored, fade) * thrown_back_by_both(to_eye) * c.seen.x;
    return vec4f(shown(diffuse + key + sky), 1);
}

fn shown(radiance: vec3f) -> vec3f {
    let x = scene.display.x * radiance;
    if scene.display.y == 1 {
        return neutral(x);
    }
    if scene.display.y == 2 {
        return agx(x);
    }
    return clamp(x, vec3f(0), vec3f(1));
}

// Khronos PBR Neutral Tone Mapper (2024): what is below 0.76 stays as it is but for the mirror's 4 %; what is above is pressed together
// and loses its colour.
fn neutral(colour: vec3f) -> vec3f {
    let least = min(colour.r, min(colour.g, colour.b));
    let mirror = select(0.04, least - 6.25 * least * least, least < 0.08);
    let x = colour - mirror;
    let peak = max(x.r, max(x.g, x.b));
    const START = 0.76;
    if peak < START {
        return max(x, vec3f(0));
    }
    const ROOM = 1 - START;
    let pressed = 1 - ROOM * ROOM / (peak + ROOM - START);
    let white = 1 - 1 / (0.15 * (peak - pressed) + 1);
    return mix(x * pressed / peak, vec3f(pressed), white);
}

// T. Sobotka's AgX in sRGB's primaries, its curve as B. Wrensch fitted it (2023).
fn agx(colour: vec3f) -> vec3f {
    let inset = mat3x3f(
        vec3f(0.842479062, 0.042328242, 0.042375655),
        vec3f(0.0784336, 0.878468636, 0.0784336),
        vec3f(0.079223745, 0.079166127, 0.879142974),
    );
    let outset = mat3x3f(
        vec3f(1.196879048, -0.052896852, -0.052971630),
        vec3f(-0.098020882, 1.151903130, -0.098043452),
        vec3f(-0.099029747, -0.098961170, 1.151073672),
    );
    let x = clamp((log2(max(inset * colour, vec3f(1e-10))) + 12.47393) / 16.5, vec3f(0), vec3f(1));
    let curve = ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232);
    return clamp(pow(max(outset * curve, vec3f(0)), vec3f(2.2)), vec3f(0), vec3f(1));
}
