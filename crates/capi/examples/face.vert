#version 450
// A vertex of the face, as Rhytid's buffers have it.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(push_constant) uniform Camera { vec4 center_and_scale; };
layout(location = 0) out vec3 turned;

void main() {
    vec3 p = (position - center_and_scale.xyz) * center_and_scale.w;
    // Vulkan's y goes down.
    gl_Position = vec4(p.x, -p.y, 0.5 - 0.25 * p.z, 1.0);
    turned = normal;
}
