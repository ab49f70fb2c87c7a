// Reads: an image. Writes: the same texels into another: what a device needs to move bytes and do nothing else.
#version 450

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D in_image;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D out_image;

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, textureSize(in_image, 0)))) return;
    imageStore(out_image, p, texelFetch(in_image, p, 0));
}
