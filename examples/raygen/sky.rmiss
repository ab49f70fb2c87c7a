// Miss: the ray left the scene.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"

layout(location = 0) rayPayloadInEXT hit_info payload;

void main()
{
    payload.t = -1.0;
}
