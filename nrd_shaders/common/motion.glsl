/* Where a pixel was in the previous frame. */
#ifndef MOTION_GLSL
#define MOTION_GLSL

struct Reprojection {
    vec2 uv;
    vec3 position;   /* previous view space */
    float tolerance; /* plane distance, units */
};

/* motion: scaled, in the frame's mode. threshold: of the view's extent. */
Reprojection reproject(vec3 motion, vec2 uv, float z, float signed_z, float threshold)
{
    Reprojection r;
    vec3 position = view_position(uv, z, g.frustum, g.orthographic);
    if (is_absent(NRD_ABSENT_MOTION)) return Reprojection(uv, position, plane_tolerance(threshold, z));
    if ((g.motion_mode | opaque_zero()) == NRD_MOTION_WORLD) {
        vec3 world = mat3(g.view_to_world) * position + motion;
        r.position = (g.world_to_view_prev * vec4(world, 1.0)).xyz;
        r.uv = project_prev(r.position);
    } else {
        r.uv = uv + motion.xy;
        float still_z = (g.view_to_view_prev * vec4(position, 1.0)).z;   /* a static point's */
        float z_prev = (g.motion_mode | opaque_zero()) == NRD_MOTION_2_5D ? abs(signed_z + motion.z) : still_z;
        r.position = view_position(r.uv, z_prev, g.frustum_prev, g.orthographic_prev);
    }
    r.tolerance = plane_tolerance(threshold, z);
    return r;
}

#endif
