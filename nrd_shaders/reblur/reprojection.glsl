/* Where a surface was in the previous frame, and what that frame knows of it. Used by temporal accumulation, which binds the textures. */
#ifndef REPROJECTION_GLSL
#define REPROJECTION_GLSL

#include "../common/motion.glsl"

struct History {
    vec4 color;      /* Y, Co, Cg, deviation of one sample's luma */
    float frames;
    float hit_dist;
    float stabilized;
    float bend;      /* 1 - cos of the mean angle to the normals of that history */
#ifdef SH
    LightSums light; /* times luma; weights sum to 1. No normal unless bend is above SAME_NORMAL */
    bool turns;      /* false: found along a curved mirror, where normals differ as they should */
#endif
};

/* 2 x 2 texels of the previous frame. */
struct Footprint {
    ivec2 base;
    vec2 fraction, corner_uv;   /* corner: where the four meet */
    uvec4 guides, seconds;      /* the two words of the guide texels */
    vec4 weights;               /* 0 where a texel is not the same surface */
};

uvec2 footprint_guide(Footprint f, int i) { return uvec2(f.guides[i], f.seconds[i]); }

Reprojection reproject(ivec2 pixel, vec2 uv, float z, float signed_z, uint material)
{
    float threshold = g.disocclusion_threshold;
    if ((SPEC_FEATURES & NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX) != 0 && has_flag(NRD_FLAG_DISOCCLUSION_MIX))
        threshold = mix(threshold, g.disocclusion_threshold_alternate, texelFetch(in_threshold_mix, pixel, 0).x);
    vec3 motion = is_absent(NRD_ABSENT_MOTION) ? vec3(0.0) : texelFetch(in_motion, pixel + rect_origin(), 0).xyz * g.motion_scale.xyz;
    return reproject(motion, uv, z, signed_z, threshold, material);
}

/* Texels of a footprint that count: where nothing moves, the pixel itself. */
const int TEXELS = (SPEC_ABSENT & uint(NRD_ABSENT_MOTION)) != 0u ? 1 : 4;

vec2 size_prev_px() { return g.rect_px.zw; }

Footprint fetch_footprint(vec2 uv_prev)
{
    Footprint f;
    bool still = is_absent(NRD_ABSENT_MOTION);
    vec2 place = still ? vec2(tile_pixel()) : place_prev(uv_prev), corner = still ? place : floor(place);
    f.fraction = still ? vec2(0.0) : place - corner;
    f.corner_uv = (corner + 1.0) * g.texel_uv.zw;
    f.base = ivec2(corner);
    f.guides = textureGather(prev_guide, f.corner_uv, 0).wzxy;
    f.seconds = textureGather(prev_guide, f.corner_uv, 1).wzxy;
    f.weights = vec4(0.0);
    return f;
}

/* Bilinear weights, 0 where a texel is off the plane through a point (previous view space), of another material or outside. */
void weigh_surface(inout Footprint f, vec3 point_vs, vec3 normal_ws, uint material, float tolerance)
{
    vec2 a = f.fraction;
    Plane plane = make_plane(mat3(g.world_to_view_prev) * normal_ws, point_vs, (vec2(f.base) + 0.5) * g.px_uv.zw + jitter_prev_uv(), g.px_uv.zw, g.frustum_prev,
                             g.orthographic_prev, 1.0 / tolerance, g.denoising_range_prev);
    f.weights = vec4((1.0 - a.x) * (1.0 - a.y), a.x * (1.0 - a.y), (1.0 - a.x) * a.y, a.x * a.y);
    for (int i = 0; i < TEXELS; i++) {
        ivec2 offset = ivec2(i & 1, i >> 1);
        bool inside = all(lessThan(uvec2(f.base + offset), uvec2(g.rect_width_prev, g.rect_height_prev)));
        bool on_plane = abs(plane_distance(plane, vec2(offset), guide_relative_depth(f.guides[i]))) < 1.0;
        if (!inside || !on_plane || guide_is_sky(f.guides[i]) || !same_material(guide_material_word(footprint_guide(f, i)) >> 30, material)) f.weights[i] = 0.0;
    }
}

/* 1 where a texel's material is that of the pixel for one signal. */
vec4 material_agreement(Footprint f, uint material, int which)
{
    vec4 same = vec4(1.0);
    for (int i = 0; i < 4 && HAS_MATERIALS; i++) same[i] = same_material_for(which, guide_material_word(footprint_guide(f, i)) >> 30, material) ? 1.0 : 0.0;
    return same;
}

History no_history()
{
    History h;
    h.color = vec4(0.0);
    h.frames = h.hit_dist = h.stabilized = h.bend = 0.0;
    SH_ONLY(h.light = no_light(); h.turns = true;)
    return h;
}

#ifdef SH
/* World. Shorter than 1 where the texels' normals differ. */
vec3 mean_footprint_normal(Footprint f, vec4 weights)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < TEXELS; i++) if (weights[i] > 0.0) sum += weights[i] * guide_tap_normal(footprint_guide(f, i));
    return sum * mat3(g.world_to_view_prev);
}
#endif

/* On an H200 directions take 4 % less of their pass's time where nothing is skipped, as no load waits for another; colours alone take 5 % more. */
#ifdef SH
const bool SKIPS_TEXELS = false;
#else
const bool SKIPS_TEXELS = true;
#endif

/* Custom bilinear: the texels of the footprint that are the same surface, renormalised. */
History fetch_history(Footprint f, vec4 weights, int signal, vec3 normal_ws)
{
    vec2 normal_prev = guide_project(mat3(g.world_to_view_prev) * normal_ws);
    float sum = weights.x + weights.y + weights.z + weights.w;
    History h = no_history();
    if (!(sum > 0.01)) return h;
    uvec4 tracks = gather_tracks_at(signal, f.seconds, f.corner_uv);
    vec4 stabilized = is_absent(NRD_ABSENT_STABILIZATION) ? vec4(-1.0) : gather_stabilized(signal, f.corner_uv), w = weights / sum;
    float sampled = 1e-6;   /* hit distance 0: never sampled */
    for (int i = 0; i < TEXELS; i++) {
        if (SKIPS_TEXELS && !(w[i] > 0.0)) continue;   /* histories hold finite numbers everywhere */
        Track track = unpack_track(tracks[i]);
        h.bend += w[i] * guide_bend(guide_point(footprint_guide(f, i)), normal_prev);
        h.frames += w[i] * guide_frames(footprint_guide(f, i), signal);
        h.hit_dist += w[i] * track.hit_dist;
        sampled += track.hit_dist > 0.0 ? w[i] : 0.0;
        h.stabilized += w[i] * stabilized[i];
        ivec2 texel = f.base + ivec2(i & 1, i >> 1);
        if (!SKIPS_TEXELS) texel = clamp(texel, ivec2(0), ivec2(g.rect_width_prev, g.rect_height_prev) - 1);
        vec4 color = load_history(signal, texel);
        h.color += w[i] * color;
        SH_ONLY(add_light(h.light, load_light_history(signal, texel), color.x, vec3(0.0), w[i]);)
    }
    SH_ONLY(if (h.bend > SAME_NORMAL) h.light.normal = mean_footprint_normal(f, w);)
    h.hit_dist /= sampled;
    h.frames *= sqrt(min(sum, 1.0));   /* part of the footprint is gone: the rest is stretched */
    return h;
}

/* Tried 0.1 to 1: more blurs normal-mapped walls under a moving camera, less makes heavy-tailed inputs noisier. */
const float BEND_TOLERANCE = 0.3;
const float LEAST_BEND = 1e-3;   /* 2.6 degrees: twice what the guide's normals resolve */

/* History of a surface that faced another way (normal maps under motion) is biased; accept it only as long as its bias is below what
   noise it removes: with relative variance V of a sample, V / frames of noise are left, against a relative bias that grows as the
   square root of bend. Noisy inputs keep their history, clean ones keep their detail. lobe: its squared width, 1 for diffuse. */
float bend_limit(History h, float lobe)
{
    float relative_variance = (h.color.w * h.color.w + 1e-12) / (h.color.x * h.color.x + 1e-12);
    return h.bend < LEAST_BEND ? 64.0 : max(BEND_TOLERANCE * relative_variance * lobe / h.bend, 1.0);
}

#endif
