/* Positions from depth, and the extent of the view that scales every plane-distance test. */
#ifndef GEOMETRY_GLSL
#define GEOMETRY_GLSL

/* View-space position (left-handed, y up) of a uv at view depth z > 0. */
vec3 view_position(vec2 uv, float z, vec4 frustum, float orthographic)
{
    vec2 xy = frustum.xy + uv * frustum.zw;
    return vec3(xy * mix(z, 1.0, orthographic), z);
}

/* What a pixel shows stands for the middle of it, but its depth is where the ray went. */
vec2 jitter_uv() { return g.jitter_uv.xy; }
vec2 jitter_prev_uv() { return g.jitter_uv.zw; }
vec2 ray_uv(ivec2 pixel) { return pixel_uv(pixel) + jitter_uv(); }

/* World size of a pixel at view depth z. */
float pixel_size(float z) { return g.pixel_unproject * mix(z, 1.0, g.orthographic); }

/* World size of the shorter side of the picture at view depth z. */
float frustum_size(float z) { return g.camera.w * mix(z, 1.0, g.orthographic); }

/* uv of a view-space position of the previous frame; far outside when behind the camera. */
vec2 project_prev(vec3 position_vs)
{
    vec2 xy = position_vs.xy / mix(position_vs.z, 1.0, g.orthographic_prev);
    return position_vs.z > 0.0 ? (xy - g.frustum_prev.xy) / g.frustum_prev.zw : vec2(-10.0);
}

/* A plane test that costs a few multiply-adds per texel: the distance of a texel's position from the plane through a point is
   z * (ray . normal) minus a constant, and ray . normal is linear in the texel's coordinates. */
struct Plane {
    vec3 along_z;    /* distance = z * (along_z . (1, x, y)) + (across . (1, x, y)), x and y in texels from the origin texel */
    vec3 across;
};

/* scale: multiplies the distance; z_scale: multiplies the depths that will be given. origin_uv: centre of the origin texel. */
Plane make_plane(vec3 normal_vs, vec3 point_vs, vec2 origin_uv, vec2 texel_uv, vec4 frustum, float orthographic, float scale, float z_scale)
{
    vec3 slope = vec3(dot(normal_vs.xy, frustum.xy + origin_uv * frustum.zw), normal_vs.xy * frustum.zw * texel_uv);
    Plane p;
    p.along_z = (slope * (1.0 - orthographic) + vec3(normal_vs.z, 0.0, 0.0)) * scale * z_scale;
    p.across = (slope * orthographic - vec3(dot(normal_vs, point_vs), 0.0, 0.0)) * scale;
    return p;
}

float plane_distance(Plane p, vec2 texel, float z)
{
    return z * (p.along_z.x + dot(p.along_z.yz, texel)) + (p.across.x + dot(p.across.yz, texel));
}

#endif
