// Reads: cases (SM_INPUTS floats each), a guide image. Writes: results (SM_OUTPUTS floats each), a 16-bit float image.
// Purpose: evaluates one function of nrd.glsl, chosen by a push constant, on every case, for test_shader_*.c.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../nrd_shaders/nrd.glsl"
#include "shader_math.glsl"

layout(local_size_x = SM_GROUP) in;

layout(push_constant) uniform push_block {
    uint operation; // SM_...
    uint count;     // cases
} push;

layout(std430, set = 0, binding = 0) readonly buffer case_block { vec4 cases[]; };
layout(std430, set = 0, binding = 1) writeonly buffer result_block { vec4 results[]; };
layout(set = 0, binding = 2) uniform sampler2D in_guide;
layout(set = 0, binding = 3, rgba16f) writeonly uniform image2D out_half;

// The forms that only GLSL has.
void evaluate_overloads(inout test_case t)
{
    if (push.operation == SM_IS_FINITE) {
        t.x.y = float(nrd_is_finite(t.a.xyz));
    } else if (push.operation == SM_ROUND_TO_HALF || push.operation == SM_STORE_HALF) {
        t.x = nrd_round_to_half(t.a);
        t.y = vec4(nrd_round_to_half(t.a.x), nrd_round_to_half(t.a.xy).y, nrd_round_to_half(t.a.xyz).z, t.x.w);
    } else if (push.operation == SM_MOTION) {
        t.x.xyz = nrd_motion_2_5d(t.a, t.c.x, t.b, t.c.y);
    }
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count)
        return;
    ivec2 texel_px = ivec2(i % SM_WIDTH, i / SM_WIDTH);
    uint first = SM_INPUTS / 4 * i;
    test_case t = test_case(cases[first], cases[first + 1], cases[first + 2], cases[first + 3], cases[first + 4],
                            cases[first + 5], cases[first + 6], cases[first + 7], cases[first + 8], cases[first + 9],
                            cases[first + 10], cases[first + 11], vec4(0.0), vec4(0.0));
    if (push.operation == SM_DECODE_IMAGE)
        t.c = texelFetch(in_guide, texel_px, 0);
    t = evaluate(push.operation == SM_DECODE_IMAGE ? SM_DECODE_NORMAL_ROUGHNESS : push.operation, t);
    evaluate_overloads(t);
    if (push.operation == SM_STORE_HALF)
        imageStore(out_half, texel_px, t.x);
    results[2 * i] = t.x;
    results[2 * i + 1] = t.y;
}
