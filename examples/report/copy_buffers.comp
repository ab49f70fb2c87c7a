// Reads: a buffer. Writes: the same into another: what a device needs to move bytes and do nothing else.
#version 450

const uint THREADS = 256u;
const uint EACH = 4u; // loads under way in every thread at once

layout(local_size_x = 256) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer from_buffer { uvec4 from_words[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer to_buffer { uvec4 to_words[]; };
layout(push_constant) uniform push_block { uint count; } push;

void main()
{
    uint first = gl_WorkGroupID.x * THREADS * EACH + gl_LocalInvocationID.x;
    uvec4 words[EACH];
    for (uint i = 0u; i < EACH; i++) words[i] = from_words[min(first + i * THREADS, push.count - 1u)];
    for (uint i = 0u; i < EACH; i++)
        if (first + i * THREADS < push.count) to_words[first + i * THREADS] = words[i];
}
