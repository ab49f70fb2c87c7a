// The scene's data and what a hit is: common to all stages.
#ifndef RAYGEN_SCENE_GLSL
#define RAYGEN_SCENE_GLSL

#include "shared.h"

#define RAYGEN_X(type, name) type name;
struct box {
    RAYGEN_BOX(RAYGEN_X)
};
layout(std140, set = 0, binding = RAYGEN_BIND_FRAME) uniform frame_block { RAYGEN_FRAME(RAYGEN_X) } frame;
#undef RAYGEN_X
layout(std430, set = 0, binding = RAYGEN_BIND_BOXES) readonly buffer box_block { box boxes[]; };

// What a ray met; also the ray payload.
struct hit_info {
    float t; // distance along the ray, metres; negative: nothing
    uint box_index;
    vec3 normal; // world space, on the side of the ray
};

vec3 transform(vec4 x, vec4 y, vec4 z, vec4 v)
{
    return vec3(dot(x, v), dot(y, v), dot(z, v));
}

// Normal of a cube's surface at a point of it: along the axis on which the point lies farthest out.
vec3 cube_normal(vec3 p)
{
    vec3 a = abs(p);
    if (a.x >= a.y && a.x >= a.z)
        return vec3(sign(p.x), 0.0, 0.0);
    return a.y >= a.z ? vec3(0.0, sign(p.y), 0.0) : vec3(0.0, 0.0, sign(p.z));
}

// A box's map has orthogonal columns, so that it takes the cube's normals to normals, but for their length.
vec3 box_normal(box b, vec3 point_in_box, vec3 direction)
{
    vec4 n = vec4(cube_normal(point_in_box), 0.0);
    vec3 normal = normalize(transform(b.to_world_x, b.to_world_y, b.to_world_z, n));
    return dot(normal, direction) > 0.0 ? -normal : normal;
}

#endif
