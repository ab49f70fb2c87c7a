/* Where a pixel was in the previous frame. */
#ifndef MOTION_GLSL
#define MOTION_GLSL

struct Reprojection {
    vec2 uv;         /* of what stands for the middle of the pixel */
    vec3 position;   /* of what the ray met, previous view space */
    float tolerance; /* plane distance, units */
};

const float STILL_PX = 1e-3;   /* less is rounding; put back, so that a picture at rest is not resampled every frame */

/* Where uv_prev lies among the centres of the previous frame's pixels. */
vec2 place_prev(vec2 uv_prev)
{
    vec2 place = uv_prev * g.rect_px.zw - 0.5, whole = round(place);
    return mix(place, whole, lessThan(abs(place - whole), vec2(STILL_PX)));
}

/* How far the camera's move, not its turn, shifts a point on the screen, px. */
float camera_parallax(vec3 position, vec2 uv_prev)
{
    vec2 turned = project_prev(mat3(g.view_to_view_prev) * position);
    return length((turned - uv_prev) * g.rect_px.zw);
}

/* Hair and grass change their depths by chance from frame to frame: the thinner they are, the less their depths say. */
float strand_threshold(float threshold, vec3 position, vec2 uv_prev)
{
    float thin = clamp(0.5 * pixel_size(position.z) / g.strand_thickness, 0.0, 1.0), near = smoothstep(0.0, 1.0, camera_parallax(position, uv_prev));
    return mix(0.25, mix(threshold, g.disocclusion_threshold_alternate, thin), near);
}

/* motion: scaled, in the frame's mode. uv: the middle of the pixel. threshold: of the view's extent. */
Reprojection reproject(vec3 motion, vec2 uv, float z, float signed_z, float threshold, uint material)
{
    Reprojection r;
    vec3 position = view_position(uv + jitter_uv(), z, g.frustum, g.orthographic);
    if (is_absent(NRD_ABSENT_MOTION)) return Reprojection(uv, position, plane_tolerance(threshold, z));
    if ((g.motion_mode | opaque_zero()) == NRD_MOTION_WORLD) {
        vec3 world = mat3(g.view_to_world) * position + motion;
        r.position = (g.world_to_view_prev * vec4(world, 1.0)).xyz;
        r.uv = project_prev(r.position) - jitter_uv();
    } else {
        r.uv = uv + motion.xy;
        float still_z = (g.view_to_view_prev * vec4(position, 1.0)).z;   /* a static point's */
        float z_prev = (g.motion_mode | opaque_zero()) == NRD_MOTION_2_5D ? abs(signed_z + motion.z) : still_z;
        r.position = view_position(r.uv + jitter_uv(), z_prev, g.frustum_prev, g.orthographic_prev);
    }
    if (HAS_MATERIALS && material == special_material(NRD_MATERIAL_STRAND)) threshold = strand_threshold(threshold, position, r.uv + jitter_uv());
    r.tolerance = plane_tolerance(threshold, z);
    return r;
}

#endif
