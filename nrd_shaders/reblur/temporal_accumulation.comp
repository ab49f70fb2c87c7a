/* Reads   guides, noisy signals, last frame's history, lengths, guides, stabilised luma and lighting change.
   Writes  accumulated colour and deviation, length, hit distance, reprojected stabilised luma, this frame's guide, tile statistics.
   Finds every pixel in the previous frame, keeps what is on the same surface (and, for the specular signal, what reflected the same
   point), and averages the new sample into it.
   First in the chain: everything after it works on an average with a known number of frames and a known deviation.
   Recurrent accumulation: D. Zhdan, "Fast Denoising with Self-Stabilizing Recurrent Blurs", GTC 2020;
   per-pixel moments: C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/texel.glsl"
#include "../common/checkerboard.glsl"
#include "reblur.glsl"
#include "tile_change.glsl"

layout(binding = 1) uniform sampler2D in_motion;
layout(binding = 2) uniform sampler2D in_normal_roughness;
layout(binding = 3) uniform sampler2D in_view_z;
layout(binding = 4) uniform sampler2D in_threshold_mix;
layout(binding = 5) uniform usampler2D prev_guide;
layout(binding = 6, rg32ui) uniform writeonly uimage2D out_guide;
#ifdef SPECULAR
layout(binding = 7) uniform usampler2D prev_track;
#ifdef DIFFUSE
layout(binding = 8, rg32ui) uniform writeonly uimage2D out_track;
#else
layout(binding = 8, r32ui) uniform writeonly uimage2D out_track;
#endif
#endif

#define FIRST (7 + 2 * HAS_SPECULAR)
#ifdef DIFFUSE
layout(binding = FIRST) uniform sampler2D in_diff;
layout(binding = FIRST + 1) uniform sampler2D in_diff_confidence;
layout(binding = FIRST + 2) uniform sampler2D diff_history;
layout(binding = FIRST + 3) uniform sampler2D prev_diff_stabilized;
layout(binding = FIRST + 4) uniform sampler2D prev_diff_tile;
layout(binding = FIRST + 5, rgba16f) uniform writeonly image2D out_diff;
layout(binding = FIRST + 6, r32ui) uniform writeonly uimage2D out_diff_tile_raw;
#endif
#ifdef SPECULAR
#define SECOND (FIRST + 7 * HAS_DIFFUSE)
layout(binding = SECOND) uniform sampler2D in_spec;
layout(binding = SECOND + 1) uniform sampler2D in_spec_confidence;
layout(binding = SECOND + 2) uniform sampler2D spec_history;
layout(binding = SECOND + 3) uniform sampler2D prev_spec_stabilized;
layout(binding = SECOND + 4) uniform sampler2D prev_spec_tile;
layout(binding = SECOND + 5, rgba16f) uniform writeonly image2D out_spec;
layout(binding = SECOND + 6, r32ui) uniform writeonly uimage2D out_spec_tile_raw;
layout(binding = SECOND + 7) uniform sampler2D in_spec_unblurred;   /* hit distances of neighbours: in_spec may be out_spec */
layout(binding = SECOND + 8) uniform sampler2D in_spec_hit_dist;
layout(binding = SECOND + 9) uniform sampler2D in_spec_motion;
#endif
#ifdef DIFFUSE
layout(binding = FIRST + 7 + 10 * HAS_SPECULAR) uniform sampler2D in_diff_hit_dist;
#endif

#ifdef SH
#define SH_FIRST (FIRST + 8 * HAS_DIFFUSE + 10 * HAS_SPECULAR)
#ifdef DIFFUSE
layout(binding = SH_FIRST) uniform sampler2D in_diff_sh1;
layout(binding = SH_FIRST + 1) uniform sampler2D diff_light_history;
layout(binding = SH_FIRST + 2, rgba16f) uniform writeonly image2D out_diff_light;
#endif
#ifdef SPECULAR
layout(binding = SH_FIRST + 3 * HAS_DIFFUSE) uniform sampler2D in_spec_sh1;
layout(binding = SH_FIRST + 3 * HAS_DIFFUSE + 1) uniform sampler2D spec_light_history;
layout(binding = SH_FIRST + 3 * HAS_DIFFUSE + 2, rgba16f) uniform writeonly image2D out_spec_light;
#endif

vec4 load_noisy_light(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(in_diff_sh1, p, 0), return texelFetch(in_spec_sh1, p, 0)) }
vec4 load_light_history(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(diff_light_history, p, 0), return texelFetch(spec_light_history, p, 0)) }
void store_light(int s, ivec2 p, vec4 v) { OF_SIGNAL(s, imageStore(out_diff_light, p, v), imageStore(out_spec_light, p, v)) }
#endif

#ifdef SH
#define TILES (SH_FIRST + 3 * HAS_DIFFUSE + 3 * HAS_SPECULAR)
#else
#define TILES (FIRST + 8 * HAS_DIFFUSE + 10 * HAS_SPECULAR)
#endif
#include "../common/tiles.glsl"

vec4 gather_stabilized(int s, vec2 uv) { OF_SIGNAL(s, return textureGather(prev_diff_stabilized, uv, 0).wzxy, return textureGather(prev_spec_stabilized, uv, 0).wzxy) }
vec4 load_history(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(diff_history, p, 0), return texelFetch(spec_history, p, 0)) }
#ifdef SPECULAR
vec3 load_specular_motion(ivec2 p) { return texelFetch(in_spec_motion, p, 0).xyz; }
#endif
float load_reconstructed(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(in_diff_hit_dist, p, 0).x, return texelFetch(in_spec_hit_dist, p, 0).x) }
vec4 load_noisy(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(in_diff, p, 0), return texelFetch(in_spec, p, 0)) }
float load_confidence(int s, vec2 uv) { OF_SIGNAL(s, return textureLod(in_diff_confidence, uv, 0.0).x, return textureLod(in_spec_confidence, uv, 0.0).x) }
vec2 load_change(int s, vec2 px) { OF_SIGNAL(s, return sample_tiles(prev_diff_tile, px, g.tile_last.zw, g.tile_uv.zw).xw, return sample_tiles(prev_spec_tile, px, g.tile_last.zw, g.tile_uv.zw).xw) }
void store_color(int s, ivec2 p, vec4 v) { OF_SIGNAL(s, imageStore(out_diff, p, v), imageStore(out_spec, p, v)) }
void store_tile(int s, ivec2 p, uint v) { OF_SIGNAL(s, imageStore(out_diff_tile_raw, p, uvec4(v)), imageStore(out_spec_tile_raw, p, uvec4(v))) }

#ifdef SPECULAR
uvec4 gather_tracks_at(int s, uvec4 seconds, vec2 uv) { return s == 0 ? textureGather(prev_track, uv, 0).wzxy : textureGather(prev_track, uv, 1).wzxy; }
#else
uvec4 gather_tracks_at(int s, uvec4 seconds, vec2 uv) { return seconds; }
#endif

/* What is too bright keeps its hue; chroma is held to what RGB of at least 0 can have. */
vec4 sanitize(vec4 noisy)
{
    float luma = clamp(noisy.x, 0.0, 65504.0), scale = noisy.x > 65504.0 ? 65504.0 / noisy.x : 1.0;
    float green = clamp(noisy.z * scale, -luma, luma), orange = clamp(noisy.y * scale, green - luma, luma - green);
    return nrd_is_finite(noisy.xyz) ? vec4(luma, orange, green, nrd_sanitize_norm_hit_dist(noisy.w)) : vec4(0.0);
}

/* Of a checkerboard, a pixel that is not traced takes the mean of those beside it, and that counts as a sample like any other: giving it
   less weight beside a history (0 to 0.5 tried) makes error 10 to 60 % larger. After the pre-pass every pixel is there. */
vec4 load_sample(int s, ivec2 pixel, float z)
{
    int lobe = s == SPECULAR_SIGNAL ? SPECULAR_LOBE : DIFFUSE_LOBE;
    if (!is_checkerboarded(lobe) || has_flag(s == SPECULAR_SIGNAL ? NRD_FLAG_SPECULAR_PREPASS : NRD_FLAG_PREPASS)) return sanitize(load_noisy(s, pixel));
    if (is_traced(pixel, lobe)) return sanitize(load_noisy(s, noisy_texel(pixel, lobe)));
    vec2 w = side_weights(pixel, z, in_view_z);
    ivec2 left = noisy_texel(max(pixel - ivec2(1, 0), ivec2(0)), lobe), right = noisy_texel(min(pixel + ivec2(1, 0), rect_size() - 1), lobe);
    return w.x * sanitize(load_noisy(s, left)) + w.y * sanitize(load_noisy(s, right));
}

/* What the last frame found out about lighting there. Fetched before history is: what waits for one load waits for both. */
vec2 fetch_change(int signal, vec2 uv_prev)
{
    return has_flag(NRD_FLAG_TILE_HISTORY) ? load_change(signal, uv_prev * g.rect_px.zw) : vec2(0.0);
}

bool is_reconstructed() { return (SPEC_FEATURES & NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION) != 0 && has_flag(NRD_FLAG_RECONSTRUCTION); }

/* What the camera sees in a pixel. */
struct Seen {
    float signed_z;
    nrd_surface surface;
};

Seen look(ivec2 pixel)
{
    float signed_z = texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale;
    return Seen(signed_z, nrd_decode_normal_roughness(texelFetch(in_normal_roughness, pixel + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT));
}

#include "reprojection.glsl"
#ifdef SPECULAR
#include "specular_motion.glsl"

/* The length that specular history may have on a surface: reflections in smooth ones change by more, and need less averaging. */
float responsive_limit(float roughness)
{
    if (g.responsive_roughness <= float(opaque_zero())) return g.max_accumulated_frames;
    float share = mix(nrd_roughness_curve(roughness, 0.25), 1.0, smoothstep(0.0, 1.0, roughness / g.responsive_roughness));
    return min(max(share * g.max_accumulated_frames, g.responsive_frames), g.max_accumulated_frames);
}
#endif

/* Stabilised luma of a surface that faced another way by more than 32 degrees is not followed. 0.1 to 0.5 tried: less flickers more, more
   blurs the joints of bricks. Weighting the texels by their normals instead was worse, for the colour history too. */
const float STABLE_BEND = 0.15;

/* Frames of history from which on a pixel has a say in whether lighting changed. 2 to 6 tried; below CHANGED_FRAMES, or a change silences its tile. */
const float SETTLED_FRAMES = 4.0;

/* Frames that history counts for where things move near a surface (1 to 5 tried: more lags, and has no less noise). */
const float MOVED_FRAMES = 1.0;

/* Deviation of hit distances within a tile below which a change of them says nothing: they are kept in 8 bits. */
const float LEAST_HIT_DIST_NOISE = 0.03;

shared vec4 s_sums[SIGNALS][64];
shared float s_squares[SIGNALS][8];

/* Where lighting changed last frame, history was rescaled then and counts as short now; it cannot be rescaled where things moved near by. */
float shorten(float frames, int signal, vec2 uv_prev, vec2 change)
{
    if ((SPEC_FEATURES & NRD_FEATURE_HISTORY_CONFIDENCE) != 0 && has_flag(NRD_FLAG_HISTORY_CONFIDENCE))
        frames *= clamp(load_confidence(signal, uv_prev), 0.0, 1.0);
    return mix(mix(frames, min(frames, CHANGED_FRAMES), change.x), min(frames, MOVED_FRAMES), change.y);
}

/* Welford's recurrence with the length as an effective one; sigma is the unbiased deviation of single samples. */
float update_sigma(float sigma, float delta, float frames)
{
    if (frames < 0.5) return 0.0;
    float variance = delta * delta * frames / (frames + 1.0);
    return sqrt(mix(sigma * sigma, variance, 1.0 / max(frames, 1.0)));
}

/* What a pixel adds to its tile: (luma change, its expected square, luma, change of the hit distance). The square is mostly the new sample's
   own, which follows a change at once; the history's part keeps skewed noise (rare bright samples) from looking like darkening.
   farther: of the hit distance, much less noisy than light; 0 for the specular signal, which keeps none. */
vec4 tile_sample(History h, float delta, float farther)
{
    vec3 light = h.frames > SETTLED_FRAMES ? vec3(delta, mix(delta * delta, h.color.w * h.color.w, 0.25), h.color.x) : vec3(0.0);
    return vec4(light, h.frames > 0.75 * MOVED_FRAMES ? farther : 0.0);
}

#ifdef SH
/* As load_sample: of a checkerboard, a pixel that is not traced takes the mean of those beside it. */
vec4 load_light_sample(ivec2 pixel, int signal, bool blurred)
{
    int lobe = signal == SPECULAR_SIGNAL ? SPECULAR_LOBE : DIFFUSE_LOBE;
    if (!is_checkerboarded(lobe) || blurred) return load_noisy_light(signal, pixel);
    if (is_traced(pixel, lobe)) return load_noisy_light(signal, noisy_texel(pixel, lobe));
    vec2 w = side_weights(pixel, abs(texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale), in_view_z);
    vec4 sides[2];
    for (int i = 0; i < 2; i++) {
        sides[i] = load_noisy_light(signal, side_texel(pixel, 2 * i - 1, lobe));
        if (!nrd_is_finite(sides[i].xyz)) sides[i] = vec4(0.0);
    }
    return w.x * sides[0] + w.y * sides[1];
}

/* Only the pre-pass writes a gain; without it, one sample is on the pixel's own normal. luma: of the noisy colour. */
vec4 noisy_light(ivec2 pixel, int signal, float luma)
{
    bool blurred = (SPEC_FEATURES & NRD_FEATURE_PREPASS) != 0 && has_flag(signal == SPECULAR_SIGNAL ? NRD_FLAG_SPECULAR_PREPASS : NRD_FLAG_PREPASS);
    vec4 noisy = load_light_sample(pixel, signal, blurred);
    return relative_light(nrd_is_finite(noisy.xyz) ? noisy.xyz : vec3(0.0), blurred ? noisy.w * luma : luma, luma);
}

/* Share of its gain that history loses per frame. 0 to 0.5 tried: with none errors of turns add up (8 % too bright on bricks under a moving
   camera), more forgets detail under motion. */
const float GAIN_LEAK = 0.25, SPECULAR_GAIN_LEAK = 0.5;

/* What the history's light is on the pixel's own normal. */
void turn_history(inout History h, Receiver r, int signal)
{
    float turn = h.bend <= SAME_NORMAL ? 0.0 : own_normal_turn(r, signal, h.light.moment, h.color.x, h.light.normal, FILTERED_SAMPLES * h.frames);
    h.light.resolved = mix(h.light.resolved, h.color.x, signal == SPECULAR_SIGNAL ? SPECULAR_GAIN_LEAK : GAIN_LEAK) + h.color.x * turn;
}

/* The same average as of colours. */
void accumulate_light(ivec2 pixel, int signal, float luma, History h, float alpha, uint random)
{
    vec4 noisy = noisy_light(pixel, signal, luma) * luma;
    vec4 mixed = mix(vec4(h.light.moment, h.light.resolved), noisy, alpha);
    store_light(signal, pixel, dither_to_half(relative_light(mixed.xyz, mixed.w, mix(h.color.x, luma, alpha)), random));
}
#endif

/* Averages one signal into its history and stores the colour. noisy.w: what is tracked. Returns the track; h.frames is the new length. */
uint accumulate(ivec2 pixel, int signal, vec4 noisy, inout History h, uint random)
{
    float alpha = 1.0 / (1.0 + h.frames), delta = noisy.x - h.color.x;
    store_color(signal, pixel, dither_color(vec4(mix(h.color.xyz, noisy.xyz, alpha), update_sigma(h.color.w, delta, h.frames)), random));
    SH_ONLY(accumulate_light(pixel, signal, noisy.x, h, alpha, random);)
    s_sums[signal][gl_LocalInvocationIndex] = tile_sample(h, delta, noisy.w - h.hit_dist);
    float stabilized = h.frames > 0.0 && (h.bend <= STABLE_BEND) ? h.stabilized : -1.0;
    h.frames += 1.0;
    return pack_track(Track(mix(h.hit_dist, noisy.w, alpha), stabilized), (float(random >> 16) + 0.5) / 256.0);
}

/* inside: the pixel, or the nearest one in the rectangle; own: what is seen there. What everything waits for is loaded before the first branch. */
void denoise(ivec2 pixel, ivec2 inside, Seen own)
{
    float signed_z = own.signed_z, z = abs(signed_z);
    nrd_surface surface = own.surface;
    Reprojection r = reproject(inside, pixel_uv(inside), z, signed_z, surface.material_id);
    Footprint f = fetch_footprint(r.uv);
    for (int s = 0; s < SIGNALS; s++) s_sums[s][gl_LocalInvocationIndex] = vec4(0.0);
    if (!in_rect(pixel)) return;
    if (is_sky(signed_z)) {
        imageStore(out_guide, pixel, uvec4(GUIDE_SKY, 0u, 0u, 0u));
        return;
    }
#ifndef DIFFUSE
    if (is_too_rough(surface.roughness)) {
        imageStore(out_guide, pixel, uvec4(GUIDE_SKY, 0u, 0u, 0u));
        return;
    }
#endif
    uint random = hash(uint(pixel.x), uint(pixel.y), g.frame_index) >> 8;
    if (is_reset()) f.weights = vec4(0.0);
    else weigh_surface(f, r.position, surface.normal, surface.material_id, r.tolerance);
    vec3 normal_vs = surface.normal * mat3(g.view_to_world);
    uvec2 guide = guide_pack(z, normal_vs, surface.roughness, surface.material_id);
#ifdef DIFFUSE
    vec2 diffuse_change = fetch_change(0, r.uv);
    History diffuse = fetch_history(f, f.weights * material_agreement(f, surface.material_id, NRD_MATERIAL_LEAST_DIFFUSE), 0, surface.normal);
    SH_ONLY(if (diffuse.frames > 0.0) turn_history(diffuse, make_receiver(guide, pixel_uv(pixel), z, surface.roughness), 0);)
    if (diffuse.frames > 0.0) diffuse.frames = min(min(shorten(diffuse.frames, 0, r.uv, diffuse_change), bend_limit(diffuse, 1.0)), g.max_accumulated_frames);
    vec4 noisy_diffuse = load_sample(0, pixel, z);
    if (is_reconstructed()) noisy_diffuse.w = load_reconstructed(0, pixel);
    if (noisy_diffuse.w == 0.0) noisy_diffuse.w = diffuse.hit_dist;   /* not sampled: as it was .. */
    if (diffuse.hit_dist == 0.0) diffuse.hit_dist = noisy_diffuse.w;  /* .. and never before: as it is */
    uint track = accumulate(pixel, 0, noisy_diffuse, diffuse, random);
#ifdef SPECULAR
    guide.x |= pack_frames(diffuse.frames) << 16;
#else
    guide.y |= pack_frames(diffuse.frames) | track;
#endif
#endif
#ifdef SPECULAR
    uint spec_track = 0u;
    if (!is_too_rough(surface.roughness)) {
        vec2 uv_history, change;
        Tracking tracking = track_hit_distance(pixel, surface);
        f.weights *= sounding(f);
        if (tracking.q < 0.0) tracking = recall_tracking(f);
        History specular = find_specular_history(pixel, z, r, f, surface, tracking, uv_history, change);
        SH_ONLY(if (specular.frames > 0.0 && specular.turns) turn_history(specular, make_receiver(guide, pixel_uv(pixel), z, surface.roughness), SPECULAR_SIGNAL);)
        if (specular.frames > 0.0) specular.frames = min(shorten(specular.frames, SPECULAR_SIGNAL, uv_history, change), responsive_limit(surface.roughness));
        specular.hit_dist = tracking.q;   /* as measured: its average would follow a change of what is reflected too late */
        vec4 noisy = load_sample(SPECULAR_SIGNAL, pixel, z);
        spec_track = accumulate(pixel, SPECULAR_SIGNAL, vec4(noisy.xyz, tracking.q), specular, random);
        guide.x |= pack_frames(specular.frames) << (16 + 8 * SPECULAR_SIGNAL);
    }
#ifdef DIFFUSE
    imageStore(out_track, pixel, uvec4(track, spec_track, 0u, 0u));
#else
    imageStore(out_track, pixel, uvec4(spec_track, 0u, 0u, 0u));
#endif
#endif
    imageStore(out_guide, pixel, uvec4(guide, 0u, 0u));
}

/* Hit distances that several pixels share make their mean less certain than their squares say: by as much as this. */
float shared_doubt()
{
    if ((SPEC_FEATURES & NRD_FEATURE_PREPASS) != 0 && has_flag(NRD_FLAG_PREPASS)) return 3.0;   /* 9 taps */
    return is_checkerboarded(DIFFUSE_LOBE) || is_reconstructed() ? 1.7 : 1.0;
}

/* Sums over the 8 x 8 pixels, divided by 64; the change of hit distances in standard errors. */
void write_tile(int signal)
{
    vec4 sum = vec4(0.0);
    float squares = 0.0;
    for (uint k = 0u; k < 8u; k++) {
        sum += s_sums[signal][k];
        squares += s_squares[signal][k];
    }
    float farther = sum.w * inversesqrt(squares + 64.0 * LEAST_HIT_DIST_NOISE * LEAST_HIT_DIST_NOISE) / shared_doubt();
    sum /= 64.0;
    store_tile(signal, tile, pack_change(TileChange(sum.x, sum.z, sqrt(sum.y), farther), hash(uint(tile.x), uint(tile.y), g.frame_index)));
}

/* Eight threads a signal sum columns, then one of each signal the columns' sums. */
void write_tiles()
{
    uint i = gl_LocalInvocationIndex, s = i >> 3, column = i & 7u;
    barrier();
    if (s < uint(SIGNALS)) {
        vec4 sum = vec4(0.0);
        float squares = 0.0;
        for (uint k = 0u; k < 8u; k++) {
            vec4 one = s_sums[s][column + 8u * k];
            sum += one;
            squares += one.w * one.w;
        }
        s_sums[s][column] = sum;
        s_squares[s][column] = squares;
    }
    barrier();
    if (i < uint(SIGNALS)) write_tile(int(i));
}

void process(ivec2 pixel)
{
    ivec2 inside = min(pixel, rect_size() - 1);
    Seen own = look(inside);
#ifdef SPECULAR
    load_neighbourhood(pixel, own);
#endif
    denoise(pixel, inside, own);
    if (!is_absent(NRD_ABSENT_LIGHTING_CHANGE)) write_tiles();
}
