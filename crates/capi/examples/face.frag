#version 450
// One light from the upper left.
layout(location = 0) in vec3 turned;
layout(location = 0) out vec4 color;

void main() {
    float lit = 0.15 + 0.85 * max(dot(normalize(turned), normalize(vec3(-0.5, 0.6, 0.8))), 0.0);
    color = vec4(vec3(0.86, 0.66, 0.55) * lit, 1.0);
}
