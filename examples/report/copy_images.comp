// Reads: an image. Writes: the first texels, in order of rows, into another: a copy as passes make it.
#version 450

const int EACH = 4; // fetches under way in every thread at once

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D in_image;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D out_image;
layout(push_constant) uniform push_block { uint count; } push;

void main()
{
    ivec2 size = textureSize(in_image, 0);
    ivec2 p = ivec2(gl_WorkGroupID.xy) * ivec2(8, 8 * EACH) + ivec2(gl_LocalInvocationID.xy);
    vec4 texels[EACH];
    for (int i = 0; i < EACH; i++) texels[i] = texelFetch(in_image, ivec2(p.x, min(p.y + 8 * i, size.y - 1)), 0);
    for (int i = 0; i < EACH; i++) {
        ivec2 q = ivec2(p.x, p.y + 8 * i);
        if (q.y < size.y && uint(q.y * size.x + q.x) < push.count) imageStore(out_image, q, texels[i]);
    }
}
