// The stand-in for devices without ray tracing (--compute): the same paths, every box intersected in a loop.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "path.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// Distances at which the line enters and leaves the box; enters beyond leaving: it misses.
vec2 intersect(box b, vec3 origin, vec3 direction)
{
    vec3 o = transform(b.to_box_x, b.to_box_y, b.to_box_z, vec4(origin, 1.0));
    vec3 d = transform(b.to_box_x, b.to_box_y, b.to_box_z, vec4(direction, 0.0));
    vec3 inverse = 1.0 / mix(d, vec3(1e-20), lessThan(abs(d), vec3(1e-20)));
    vec3 near = min((-1.0 - o) * inverse, (1.0 - o) * inverse);
    vec3 far = max((-1.0 - o) * inverse, (1.0 - o) * inverse);
    return vec2(max(max(near.x, near.y), near.z), min(min(far.x, far.y), far.z));
}

hit_info trace(vec3 origin, vec3 direction)
{
    hit_info hit = hit_info(1e4, 0u, vec3(0.0));
    for (uint i = 0u; i < frame.box_count; i++) {
        vec2 t = intersect(boxes[i], origin, direction);
        float nearest = t.x > 0.0 ? t.x : t.y;
        if (t.x <= t.y && nearest > 0.0 && nearest < hit.t)
            hit = hit_info(nearest, i, vec3(0.0));
    }
    if (hit.t >= 1e4)
        return hit_info(-1.0, 0u, vec3(0.0));
    box b = boxes[hit.box_index];
    vec3 in_box = transform(b.to_box_x, b.to_box_y, b.to_box_z, vec4(origin + hit.t * direction, 1.0));
    hit.normal = box_normal(b, in_box, direction);
    return hit;
}

bool is_visible(vec3 origin, vec3 direction, float t_max)
{
    for (uint i = 0u; i < frame.box_count; i++) {
        vec2 t = intersect(boxes[i], origin, direction);
        float nearest = t.x > 0.0 ? t.x : t.y;
        if (t.x <= t.y && nearest > 0.0 && nearest < t_max)
            return false;
    }
    return true;
}

void main()
{
    if (gl_GlobalInvocationID.x < frame.width && gl_GlobalInvocationID.y < frame.height)
        trace_pixel(gl_GlobalInvocationID.xy);
}
