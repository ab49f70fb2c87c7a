/* Reads   the guides, one or two noisy signals, the history that the denoiser has just written.
   Writes  4 x 4 small pictures of them, for eyes.
   Shows an application what its inputs look like from inside. After the other passes: it changes nothing that they read.

   normals        roughness         view z             motion: error against the camera's
   world grid     virtual motion    history, first     history, second
   hits, first    hits, second      signal, first      signal, second
   motion         material          rules              jitter
   With shadows "hits" are the penumbra's half width and the classes of tiles. README says which colour means what. */
#version 450
#extension GL_GOOGLE_include_directive : require
#define DIFFUSE
#define SPECULAR
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/texel.glsl"
#include "../reblur/signals.glsl"
#include "../reblur/occlusion.glsl"
#include "../sigma/sigma.glsl"

layout(binding = 1) uniform sampler2D in_mv;
layout(binding = 2) uniform sampler2D in_normal_roughness;
layout(binding = 3) uniform sampler2D in_view_z;
layout(binding = 4) uniform sampler2D in_first;    /* as in check.comp */
layout(binding = 5) uniform sampler2D in_second;
layout(binding = 6) uniform usampler2D in_state;   /* guide, tap, or history of shadows */
layout(binding = 7) uniform usampler2D in_more;    /* tracks, or state of taps */
layout(binding = 8) uniform sampler2D in_tiles;    /* of shadows */
layout(binding = 9, rgba8) uniform writeonly image2D out_validation;

const int CELLS = 4;
const float HALF_DEPTH = 10.0;        /* units, shown as grey 0.5 */
const float ERROR_WHITE_PX = 4.0;
const float MOTION_FULL_PX = 32.0;    /* from the middle of a colour's range to its end */
const float VIRTUAL_WHITE_PX = 16.0;
const float PENUMBRA_WHITE_PX = 32.0;
const vec3 SKY = vec3(0.1, 0.2, 0.5);
const vec3 WRONG = vec3(1.0, 0.0, 0.0);

struct Surface {
    ivec2 pixel;
    vec2 uv;
    float z, signed_z;
    vec3 position;    /* view space */
    vec3 motion;
    nrd_surface guide;
};

uint signals() { return push.iteration | opaque_zero(); }
bool has_radiance() { return signals() < NRD_SIGNALS_HIT_DIST; }
bool has_direction() { return signals() == NRD_SIGNALS_DIRECTION; }
bool has_shadow() { return signals() >= NRD_SIGNALS_SHADOW; }
bool has_both() { return !has_shadow() && !has_direction() && signals() % 3u == 2u; }
bool is_specular_alone() { return !has_shadow() && !has_direction() && signals() % 3u == 1u; }
bool has_specular() { return has_both() || is_specular_alone(); }

/* Longer than the range: red. */
vec3 grey(float v) { return v > 1.0 ? WRONG : vec3(clamp(v, 0.0, 1.0)); }
vec3 saturated(float v) { return vec3(clamp(v, 0.0, 1.0)); }

/* ---- motion ---- */
vec2 camera_uv(Surface s) { return project_prev((g.view_to_view_prev * vec4(s.position, 1.0)).xyz); }

vec2 given_uv(Surface s)
{
    if ((g.motion_mode | opaque_zero()) != NRD_MOTION_WORLD) return s.uv + s.motion.xy;
    return project_prev((g.world_to_view_prev * vec4(mat3(g.view_to_world) * s.position + s.motion, 1.0)).xyz);
}

vec3 show_motion_error(Surface s)
{
    return grey(length((given_uv(s) - camera_uv(s)) * g.rect_px.xy) / ERROR_WHITE_PX);
}

vec3 show_motion(Surface s) { return vec3(clamp((given_uv(s) - s.uv) * g.rect_px.xy / MOTION_FULL_PX * 0.5 + 0.5, 0.0, 1.0), 0.5); }

/* Hit distance that the specular signal follows, units. */
float reflected_distance(Surface s)
{
    if (!has_radiance()) return nrd_denormalize_hit_dist(texelFetch(in_second, s.pixel, 0).x, s.z, s.guide.roughness, g.hit_distance);
    float tracked = unpack_track(texelFetch(in_more, s.pixel, 0)[has_both() ? 1 : 0]).hit_dist;
    return tracked / max(1.0 - tracked, 1e-3) * distance_to_camera(s.uv, s.z);
}

/* How far apart surface and reflection move, as a flat mirror would show it: the reflected point lies behind the surface. */
vec3 show_virtual_motion(Surface s)
{
    if (!has_specular()) return vec3(0.0);
    vec3 ray = g.orthographic > 0.5 ? vec3(0.0, 0.0, 1.0) : normalize(s.position), behind = s.position + ray * reflected_distance(s);
    vec2 virtual_uv = project_prev((g.view_to_view_prev * vec4(behind, 1.0)).xyz);
    return saturated(length((virtual_uv - camera_uv(s)) * g.rect_px.xy) / VIRTUAL_WHITE_PX);
}

/* ---- history ---- */
float history_frames_of(Surface s, int signal)
{
    uvec2 state = texelFetch(in_state, s.pixel, 0).xy;
    uint more = texelFetch(in_more, s.pixel, 0).x;
    if (has_shadow()) return min(unpack_age(history_age_code(state)), g.max_accumulated_frames);
    if (has_radiance()) return unpack_frames(has_specular() ? state.x >> (16 + 8 * signal) : state.y);
    if (is_specular_alone() || signal == 1) return field(state.y, 8, 6);
    return has_both() ? field(state.y, 26, 6) : field(more, 4, 6);
}

/* Red: none, green: as long as allowed. */
vec3 show_history(Surface s, int signal)
{
    if (signal == 1 && !has_both()) return vec3(0.0);
    float share = clamp(history_frames_of(s, signal) / max(g.max_accumulated_frames, 1.0), 0.0, 1.0);
    return vec3(1.0 - share, share, 0.0);
}

/* ---- signals ---- */
vec3 show_penumbra(Surface s)
{
    float p = texelFetch(in_first, s.pixel, 0).x;
    if (!(p >= 0.0)) return WRONG;
    if (p == 0.0) return vec3(0.0, 0.0, 0.3);
    return p >= NRD_PENUMBRA_LIT ? vec3(1.0, 1.0, 0.6) : saturated(p / pixel_size(s.z) / PENUMBRA_WHITE_PX);
}

vec3 show_tiles(Surface s)
{
    uint tile = unpack_tile(texelFetch(in_tiles, s.pixel / 8, 0).x);
    return vec3(equal(uvec3(tile) & uvec3(TILE_ACTIVE, TILE_STALE, TILE_LIT), uvec3(TILE_ACTIVE, TILE_STALE, TILE_LIT)));
}

vec4 load_signal(Surface s, int signal) { return signal == 0 ? texelFetch(in_first, s.pixel, 0) : texelFetch(in_second, s.pixel, 0); }

vec3 show_hits(Surface s, int signal)
{
    if (has_shadow()) return signal == 0 ? show_penumbra(s) : show_tiles(s);
    if (signal == 1 && !has_both()) return vec3(0.0);
    vec4 texel = load_signal(s, signal);
    float w = has_radiance() || has_direction() ? texel.w : texel.x;
    return !(w >= 0.0) ? WRONG : w == 0.0 ? vec3(0.3, 0.0, 0.3) : grey(w);
}

vec3 show_signal(Surface s, int signal)
{
    if (signal == 1 && !has_both() && signals() != NRD_SIGNALS_TRANSLUCENT_SHADOW) return vec3(0.0);
    vec4 texel = load_signal(s, signal);
    if (!nrd_is_finite(texel.xyz) || !nrd_is_finite(texel.w)) return WRONG;
    if (has_shadow()) return signal == 0 ? vec3(texel.x >= NRD_PENUMBRA_LIT) : texel.xyz;
    if (has_direction()) return texel.xyz / max(texel.w, 1e-3) * 0.5 + 0.5;
    if (!has_radiance()) return saturated(texel.x);
    vec3 rgb = nrd_ycocg_to_rgb(texel.xyz);
    return pow(rgb / (1.0 + max(texel.x, 0.0)), vec3(1.0 / 2.2));
}

/* Red: a number that is none, or outside its range. */
vec3 show_rules(Surface s)
{
    vec4 first = load_signal(s, 0), second = load_signal(s, 1);
    bool finite = nrd_is_finite(s.motion) && nrd_is_finite(s.guide.normal) && nrd_is_finite(first.xyz) && nrd_is_finite(first.w) && nrd_is_finite(second.xyz) && nrd_is_finite(second.w);
    vec2 range = has_shadow() ? vec2(first.x, 0.0) : has_radiance() || has_direction() ? vec2(first.w, second.w) : vec2(first.x, second.x);
    bool in_range = min(range.x, range.y) >= 0.0 && max(range.x, range.y) <= (has_shadow() ? NRD_PENUMBRA_LIT : 1.001);
    return finite && in_range && s.z > 0.0 ? vec3(0.15) : WRONG;
}

/* ---- pictures ---- */
/* A checkerboard of one unit, fixed to the world; faces of the boxes are told apart by brightness. */
vec3 show_grid(Surface s)
{
    vec3 world = mat3(g.view_to_world) * s.position + g.camera.xyz - s.guide.normal * 0.01;
    ivec3 box = ivec3(floor(world));
    return abs(s.guide.normal) * 0.3 + 0.15 + 0.5 * float((box.x + box.y + box.z) & 1);
}

/* A pixel, its middle and where the ray went through. */
vec3 show_jitter(vec2 place)
{
    vec2 from_middle = place - 0.5, to_ray = from_middle - g.jitter_uv.xy * g.rect_px.xy;
    bool middle = max(abs(from_middle.x), abs(from_middle.y)) < 0.01 || min(abs(from_middle.x), abs(from_middle.y)) < 0.003;
    return length(to_ray) < 0.04 ? vec3(1.0, 0.8, 0.0) : vec3(middle ? 0.4 : 0.1);
}

vec3 show(int cell, Surface s, vec2 place)
{
    const vec3 MATERIALS[4] = vec3[4](vec3(0.2), vec3(0.9, 0.5, 0.1), vec3(0.1, 0.6, 0.9), vec3(0.7, 0.9, 0.2));
    if (cell == 15) return show_jitter(place);
    if (is_sky(s.signed_z)) return SKY;
    switch (cell) {
    case 0: return s.guide.normal * 0.5 + 0.5;
    case 1: return vec3(s.guide.roughness);
    case 2: return saturated(s.z / (s.z + HALF_DEPTH));
    case 3: return show_motion_error(s);
    case 4: return show_grid(s);
    case 5: return show_virtual_motion(s);
    case 6: return show_history(s, 0);
    case 7: return show_history(s, 1);
    case 8: return show_hits(s, 0);
    case 9: return show_hits(s, 1);
    case 10: return show_signal(s, 0);
    case 11: return show_signal(s, 1);
    case 12: return show_motion(s);
    case 13: return MATERIALS[s.guide.material_id & 3u];
    default: return show_rules(s);
    }
}

Surface load_surface(ivec2 pixel)
{
    Surface s;
    s.pixel = pixel;
    s.uv = pixel_uv(pixel);
    s.signed_z = texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale;
    s.z = abs(s.signed_z);
    s.position = view_position(s.uv, s.z, g.frustum, g.orthographic);
    s.motion = vec3(0.0);
    if ((SPEC_ABSENT & NRD_ABSENT_MOTION) == 0u) s.motion = texelFetch(in_mv, pixel + rect_origin(), 0).xyz * g.motion_scale.xyz;
    s.guide = nrd_decode_normal_roughness(texelFetch(in_normal_roughness, pixel + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT);
    return s;
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel)) return;
    vec2 place = pixel_uv(pixel) * float(CELLS);
    ivec2 cell = min(ivec2(place), ivec2(CELLS - 1));
    place -= vec2(cell);
    Surface s = load_surface(min(ivec2(place * g.rect_px.xy + 0.25), rect_size() - 1));   /* multiples of 4 give whole numbers: not to be rounded down */
    imageStore(out_validation, pixel, vec4(clamp(show(cell.y * CELLS + cell.x, s, place), 0.0, 1.0), 1.0));
}
