// What a tracer is given for one frame: the same bytes as C structs and as std430 storage buffers. Every vec4 sits on a
// multiple of 16 and every struct is a multiple of 16 bytes, so both layouts are equal.

#ifndef TRACER_DATA_GLSL
#define TRACER_DATA_GLSL

#include "lang.glsl"

#define PT_TEXTURE_PLAIN 0u
#define PT_TEXTURE_CHECKER 1u
#define PT_TEXTURE_BRICK 2u
#define PT_TEXTURE_NOISE 3u
#define PT_TEXTURE_WOOD 4u
#define PT_TEXTURE_TILES 5u
#define PT_TEXTURE_STRIPES 6u

#define PT_NO_TRIANGLE 0xffffffffu
#define PT_MISS 65504.0f    // hit distance of a ray that met nothing
#define PT_MAX_HIT 65000.0f // farthest hit distance of a ray that met something
#define PT_SURFACE_EPS 1e-4f // metres: ray origins are lifted by this much, and nearer hits are the surface itself

PT_STRUCT(pt_material)
{
    vec4 color;     // rgb base colour where the texture is 0; w metalness
    vec4 color2;    // rgb base colour where the texture is 1; w texture repeats per unit of uv
    vec4 emission;  // rgb radiance of the front side
    vec4 roughness; // x where the texture is 0, y where it is 1; z bump height in metres; w unused
    vec4 transmission; // rgb that rays to the sun keep on their way through, 0: opaque. Camera and paths see the surface, never through it
    uint texture_kind;
    uint id;        // small integer written to the capture
    uint pad0;
    uint pad1;
};

PT_STRUCT(pt_triangle)
{
    vec4 p[3];    // xyz position, w texture u
    vec4 prev[3]; // xyz position in the previous frame, w texture v
    vec4 n[3];    // xyz shading normal
    uint material;
    uint pad0;
    uint pad1;
    uint pad2;
};

// An emitting triangle. Lights are chosen in proportion to luminance x area, so the density per area of a point on any
// of them is luminance / (total luminance x area), whichever triangle it lies on.
PT_STRUCT(pt_light)
{
    vec4 corner;   // xyz; w: normalised luminance x area of the lights up to and including this one, 1 for the last
    vec4 edge1;    // xyz from the corner
    vec4 edge2;    // xyz from the corner
    vec4 normal;   // xyz unit, of the side that emits
    vec4 radiance; // rgb
};

// Node of the bounding volume hierarchy. The children of an inner node follow one another.
PT_STRUCT(pt_node)
{
    float low[3];
    uint first; // inner node: its first child; leaf: its first triangle in the order of the hierarchy
    float high[3];
    uint count; // of triangles; 0: inner node
};

PT_STRUCT(pt_camera)
{
    vec4 position;
    vec4 right;   // xyz unit vector, w tangent of half the horizontal field of view
    vec4 up;      // xyz unit vector, w tangent of half the vertical field of view
    vec4 forward; // xyz unit vector, w 0
};

PT_STRUCT(pt_frame)
{
    pt_camera camera;
    pt_camera camera_prev;
    vec4 sun_direction;  // xyz unit, towards the sun; w tangent of the angular radius
    vec4 sun_irradiance; // rgb on a surface that faces the sun, 0 without a sun; of a lamp at 1 metre
    vec4 lamp;           // a round lamp instead of the sun: xyz position, w radius; w 0: the sun. It faces every point
    vec4 sky_zenith;     // rgb radiance
    vec4 sky_horizon;    // rgb radiance; w strength of the glow around the sun
    vec4 sky_ground;     // rgb radiance of directions below the horizon
    vec4 occlusion;      // A, B, C, D with which a reference normalises hit distances; (3, 0, 1, 0) is the capture format
    vec4 jitter;         // xy in pixels, y down
    vec4 hit_dist_params; // A, B, C, D with which hit distances are normalised for the denoisers' textures
    float denoising_range;
    float inv_light_power; // 1 / sum of luminance x area, 0 without lights
    uint light_count;
    uint width;
    uint height;
    uint frame_index;
    uint seed;
    uint bounces;        // longest path, in rays after the primary one
    uint paths;          // per pixel and lobe
    uint direct_mis;     // 1: lights are also sampled at the primary hit
    uint sample_first;   // reference: index of the first sample of this call
    uint sample_count;   // reference: samples of this call
    uint sample_add;     // reference, in the shader: 1 if the planes already hold a sum to add to
    uint has_glass;      // 1: some material lets light through
    uint pad0;
    uint pad1;
};

// Planes of a rendered frame, in order; each is width x height floats.
#define PT_PLANE_VIEW_Z 0u
#define PT_PLANE_NORMAL 1u
#define PT_PLANE_ROUGHNESS 4u
#define PT_PLANE_MOTION 5u
#define PT_PLANE_MATERIAL 8u
#define PT_PLANE_BASE_COLOR 9u
#define PT_PLANE_METALNESS 12u
#define PT_PLANE_DIFFUSE 13u
#define PT_PLANE_DIFFUSE_HIT 16u
#define PT_PLANE_DIFFUSE_DIR 17u
#define PT_PLANE_SPECULAR 20u
#define PT_PLANE_SPECULAR_HIT 23u
#define PT_PLANE_SPECULAR_DIR 24u
#define PT_PLANE_DIFFUSE_FACTOR 27u
#define PT_PLANE_SPECULAR_FACTOR 30u
#define PT_PLANE_EMISSION 33u
#define PT_PLANE_SHADOW_HIT 36u
#define PT_PLANE_SUN 37u
#define PT_PLANE_TRANSLUCENCY 40u
#define PT_PLANE_COUNT 43u

// Planes of a reference.
#define PT_REF_DIFFUSE 0u
#define PT_REF_SPECULAR 3u
#define PT_REF_SHADOW 6u
#define PT_REF_AO 7u
#define PT_REF_TRANSLUCENCY 8u
#define PT_REF_SPECULAR_AO 11u
#define PT_REF_COUNT 12u

#endif
