// Reads: one signal, view depth, normals. Writes: the filtered signal.
// Plain joint bilateral filter over a full square window, without history: the baseline that a denoiser's time could buy
// instead (Eisemann and Durand 2004; depth along its own slope as in Schied et al. 2017, equation 3).
#version 450
#extension GL_GOOGLE_include_directive : require

#include "nrd.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D in_view_z;
layout(set = 0, binding = 1) uniform sampler2D in_normal;
layout(set = 0, binding = 2) uniform sampler2D in_signal;
layout(set = 0, binding = 3, rgba16f) writeonly uniform image2D out_signal;
layout(push_constant) uniform push_block { int radius; float sky; } push;

const float NORMAL_SENSITIVITY = 8.0;
const float DEPTH_TOLERANCE = 0.01; // of the depth, off the slope

vec3 normal_at(ivec2 p)
{
    return nrd_decode_normal_roughness(texelFetch(in_normal, p, 0), NRD_NORMAL_FORMAT_RGBA16_SNORM, NRD_ROUGHNESS_FORMAT_LINEAR).normal;
}

float view_z_at(ivec2 p) { return texelFetch(in_view_z, p, 0).x; }

// The smaller of the differences to both sides: the slope of the surface at p, not the step beside it.
float slope(ivec2 p, ivec2 along, float z, ivec2 last)
{
    float before = z - view_z_at(max(p - along, ivec2(0)));
    float after = view_z_at(min(p + along, last)) - z;
    return abs(before) < abs(after) ? before : after;
}

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 last = textureSize(in_view_z, 0) - 1;
    if (any(greaterThan(p, last))) return;
    vec4 centre = texelFetch(in_signal, p, 0);
    float z = view_z_at(p);
    if (!(abs(z) < push.sky)) {
        imageStore(out_signal, p, centre);
        return;
    }
    vec3 normal = normal_at(p);
    vec2 gradient = vec2(slope(p, ivec2(1, 0), z, last), slope(p, ivec2(0, 1), z, last));
    float sigma = max(0.5 * float(push.radius), 0.5);
    vec4 sum = vec4(0.0);
    float total = 0.0;
    for (int y = -push.radius; y <= push.radius; y++)
        for (int x = -push.radius; x <= push.radius; x++) {
            ivec2 q = p + ivec2(x, y);
            if (any(lessThan(q, ivec2(0))) || any(greaterThan(q, last))) continue;
            float off = abs(view_z_at(q) - z - dot(gradient, vec2(x, y))) / (DEPTH_TOLERANCE * abs(z));
            float bend = NORMAL_SENSITIVITY * (1.0 - dot(normal_at(q), normal));
            float w = exp(-float(x * x + y * y) / (2.0 * sigma * sigma) - off - bend);
            sum += w * texelFetch(in_signal, q, 0);
            total += w;
        }
    imageStore(out_signal, p, sum / total);
}
