// Closest hit: where, on which box, and its normal.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"

layout(location = 0) rayPayloadInEXT hit_info payload;

void main()
{
    vec3 in_box = gl_ObjectRayOriginEXT + gl_HitTEXT * gl_ObjectRayDirectionEXT;
    payload.t = gl_HitTEXT;
    payload.box_index = gl_InstanceCustomIndexEXT;
    payload.normal = box_normal(boxes[gl_InstanceCustomIndexEXT], in_box, gl_WorldRayDirectionEXT);
}
