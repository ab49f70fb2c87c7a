/* Reads   guides, noisy hit distances, last frame's history and guides.
   Writes  accumulated occlusion, length and blur radius, with this frame's guide.
   Finds every pixel in the previous frame, keeps what is on the same surface, and averages the new hit distance into it: where occluders are
   far, the mean of those of 20 to 36 pixels around, which costs next to nothing here and halves the flicker. What the blur does never
   returns. The radius is the harmonic mean of the hit distances around: near occluders vary over their own
   distance, and it is small as soon as some rays are short. Specular history follows the surface too, but is cut where the reflection
   has moved by more than the lobe smears: a mirror, which has no noise, keeps none while it moves.
   Harmonic mean of hit distances as the filter's footprint: G. Ward and P. Heckbert, "Irradiance Gradients", EGWR 1992;
   history limited by parallax: D. Zhdan, "Fast Denoising with Self-Stabilizing Recurrent Blurs", GTC 2020. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/motion.glsl"
#include "../common/checkerboard.glsl"
#include "occlusion.glsl"

layout(binding = 1) uniform sampler2D in_motion;
layout(binding = 2) uniform sampler2D in_normal_roughness;
layout(binding = 3) uniform sampler2D in_view_z;
layout(binding = 6) uniform sampler2D in_threshold_mix;
layout(binding = 7) uniform usampler2D prev_tap;
#ifdef DIFFUSE
layout(binding = 4) uniform sampler2D in_diffuse;
layout(binding = 5) uniform sampler2D in_diffuse_confidence;
layout(binding = 8) uniform usampler2D prev_state;
layout(binding = 10, r16ui) uniform writeonly uimage2D out_state;
#endif
#if defined(DIFFUSE) && defined(SPECULAR)
layout(binding = 9, rg32ui) uniform writeonly uimage2D out_tap;
layout(binding = 11) uniform sampler2D in_specular;
layout(binding = 12) uniform sampler2D in_specular_confidence;
#elif defined(SPECULAR)
layout(binding = 4) uniform sampler2D in_specular;
layout(binding = 5) uniform sampler2D in_specular_confidence;
layout(binding = 8, rg32ui) uniform writeonly uimage2D out_tap;
#elif defined(DIRECTIONAL)
layout(binding = 9, rg32ui) uniform writeonly uimage2D out_tap;
#else
layout(binding = 9, r32ui) uniform writeonly uimage2D out_tap;
#endif

#if defined(DIFFUSE) && defined(SPECULAR)
#define TILES 13
#elif defined(DIFFUSE)
#define TILES 11
#else
#define TILES 9
#endif
#include "../common/tiles.glsl"

const int SPAN = 6;   /* quads of 2 x 2 pixels: the group's 4 x 4 and those around */
/* What a pixel takes of them: its own one and those beside; for changes of reflections, which vary more, also those at its corners: with fewer, light that
   flickers is off by 8 %. Without them the four quads at the corners of all are nobody's neighbours. */
const int QUADS_AROUND = HAS_SPECULAR == 1 ? 9 : 5, QUADS_LOADED = HAS_SPECULAR == 1 ? 36 : 32;
const float CHANGED_FRAMES = 4.0;   /* what history counts for after a certain change */
/* Motion of the reflection, in footprints of the lobe, that cuts history to a quarter. 0.12 to 0.5 tried: more trails, less flickers. */
const float LOBE_SHIFT = 0.2;
const float LEAST_FOOTPRINT = 0.35;   /* px; below, bilinear reconstruction smears more */
/* Radius of the disc in px from which samples of the pixel's own quad count as its own, wholly from the second on; then those of the quads
   around. 1 to 2.5 .. 4 to 8 tried for the latter: less loses contact shadows, more flickers more. */
const vec2 QUAD_REACH = vec2(0.7, 1.5), AROUND_REACH = vec2(3.0, 6.0);
/* What reflections hide has finer detail: their discs count as so much smaller. 0 to 1 tried: more flickers less and softens it. */
const float SPECULAR_SHARE = 0.25;
/* Normals of quads count so much more than those of single pixels: 1 loses the relief of bricks. */
const float QUAD_BEND = 3.0;

/* Sums over the pixels of a quad, per lobe. Quads are told apart by their mean depth: one across an edge lies on neither side's plane. */
#ifdef DIFFUSE
shared vec4 s_diffuse[SPAN * SPAN];   /* samples, their reciprocals, normalised hit distances; mean view z, 0: none */
#endif
#ifdef SPECULAR
shared vec4 s_specular[SPAN * SPAN];
#endif
shared vec4 s_surface[SPAN * SPAN];   /* of one of its pixels: normal, kind_of() */
#ifdef DIRECTIONAL
shared vec3 s_moment[SPAN * SPAN];
#endif
#ifdef DIFFUSE
#define QUAD_Z(i) s_diffuse[i].w
#else
#define QUAD_Z(i) s_specular[i].w
#endif
shared vec4 s_changes[64];            /* of this group's pixels, per lobe: sample minus history, most that its variance can be; 0: no history to speak of */
#ifdef DIFFUSE
shared vec3 s_diffuse_changes[SPAN * SPAN];   /* of the quads: number, sample minus history, variance; 0 outside of the group */
#endif
#ifdef SPECULAR
shared vec3 s_specular_changes[SPAN * SPAN];
#endif

#ifdef DIRECTIONAL
float diffuse_hit_dist(vec4 texel) { return texel.w; }
vec4 gather_diffuse(vec2 corner) { return textureGather(in_diffuse, corner * g.texel_uv.xy, 3); }

/* Never longer than the hit distance. */
vec3 load_moment(ivec2 pixel, float hit_dist)
{
    vec3 moment = texelFetch(in_diffuse, noisy_texel(pixel, DIFFUSE_LOBE), 0).xyz;
    return nrd_is_finite(moment) ? moment * min(1.0, hit_dist / max(length(moment), 1e-6)) : vec3(0.0);
}
#else
#ifdef DIFFUSE
float diffuse_hit_dist(vec4 texel) { return texel.x; }
vec4 gather_diffuse(vec2 corner) { return textureGather(in_diffuse, corner * g.texel_uv.xy, 0); }
#endif
vec3 load_moment(ivec2 pixel, float hit_dist) { return vec3(0.0); }
#endif

#ifdef DIFFUSE
float load_diffuse(ivec2 pixel) { return is_traced(pixel, DIFFUSE_LOBE) ? diffuse_hit_dist(texelFetch(in_diffuse, noisy_texel(pixel, DIFFUSE_LOBE), 0)) : 0.0; }
#endif
#ifdef SPECULAR
vec4 gather_specular(vec2 corner) { return textureGather(in_specular, corner * g.texel_uv.xy, 0); }
float load_specular(ivec2 pixel) { return is_traced(pixel, SPECULAR_LOBE) ? texelFetch(in_specular, noisy_texel(pixel, SPECULAR_LOBE), 0).x : 0.0; }
#endif

vec4 sanitize_quad(vec4 v)
{
    return vec4(nrd_sanitize_norm_hit_dist(v.x), nrd_sanitize_norm_hit_dist(v.y), nrd_sanitize_norm_hit_dist(v.z), nrd_sanitize_norm_hit_dist(v.w));
}

float sum_of(vec4 v) { return dot(v, vec4(1.0)); }

vec3 quad_sums(vec4 noisy, vec4 usable)
{
    noisy = sanitize_quad(noisy);
    vec4 sampled = mix(usable, vec4(0.0), equal(noisy, vec4(0.0)));
    return vec3(sum_of(sampled), dot(sampled, 1.0 / max(noisy, vec4(LEAST_RADIUS))), dot(sampled, noisy));
}

nrd_surface decode_surface(ivec2 pixel) { return nrd_decode_normal_roughness(texelFetch(in_normal_roughness, pixel + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT); }

/* Roughness + 1, and in its two last bits the material as masks tell materials apart. */
uint kind_of(nrd_surface surface)
{
    uint material = is_absent(NRD_ABSENT_MATERIALS) ? 0u : max(surface.material_id, g.min_material) & 3u;
    return (floatBitsToUint(surface.roughness + 1.0) & ~3u) | material;
}

/* Of the first threads: the group's quads, then the sides, then the corners. */
ivec2 own_quad()
{
    int i = int(gl_LocalInvocationIndex), k = (i & 3) + 1, far = (i & 4) != 0 ? SPAN - 1 : 0;
    if (i >= 32) return ivec2(i & 1, (i >> 1) & 1) * (SPAN - 1);
    return i < 16 ? ivec2(k, (i >> 2) + 1) : i < 24 ? ivec2(k, far) : ivec2(far, k);
}

/* One quad per thread of the first. */
void load_quads()
{
    if (gl_LocalInvocationIndex < uint(QUADS_LOADED)) {
        ivec2 quad = own_quad(), pixel = tile * 8 + quad * 2 - 2;
        int i = quad.y * SPAN + quad.x;
        vec2 corner = vec2(pixel + 1);   /* where the four meet */
        vec4 z = textureGather(in_view_z, (corner + vec2(rect_origin())) * g.texel_uv.xy, 0) * g.view_z_scale;
        ivec4 x = pixel.x + ivec4(0, 1, 1, 0), y = pixel.y + ivec4(1, 1, 0, 0);   /* the order of textureGather() */
        vec4 usable;
        for (int k = 0; k < 4; k++) usable[k] = in_rect(ivec2(x[k], y[k])) && !is_sky(z[k]) ? 1.0 : 0.0;
        float number = sum_of(usable);
        int first = usable[0] > 0.0 ? 0 : usable[1] > 0.0 ? 1 : usable[2] > 0.0 ? 2 : 3;
        nrd_surface surface = decode_surface(clamp(ivec2(x[first], y[first]), ivec2(0), rect_size() - 1));
        s_surface[i] = vec4(surface.normal, uintBitsToFloat(kind_of(surface)));   /* of anything where nothing counts */
        float mean_z = number > 0.0 ? sum_of(mix(vec4(0.0), abs(z), greaterThan(usable, vec4(0.0)))) / number : 0.0;
#ifdef DIFFUSE
        vec4 diffuse = vec4(0.0);
        if (!is_checkerboarded(DIFFUSE_LOBE)) diffuse = gather_diffuse(corner);
        else for (int k = 0; k < 4; k++) diffuse[k] = load_diffuse(ivec2(x[k], y[k]));
        s_diffuse[i] = vec4(quad_sums(diffuse, usable), mean_z);
#ifdef DIRECTIONAL
        s_moment[i] = vec3(0.0);
        for (int k = 0; k < 4; k++) {
            float hit_dist = usable[k] * nrd_sanitize_norm_hit_dist(diffuse[k]);
            if (hit_dist > 0.0) s_moment[i] += load_moment(ivec2(x[k], y[k]), hit_dist);
        }
#endif
#endif
#ifdef SPECULAR
        vec4 specular = vec4(0.0);
        if (!is_checkerboarded(SPECULAR_LOBE)) specular = gather_specular(corner);
        else for (int k = 0; k < 4; k++) specular[k] = load_specular(ivec2(x[k], y[k]));
        s_specular[i] = vec4(quad_sums(specular, usable), mean_z);
#endif
    }
    barrier();
}

/* Bilinear weights of the 2 x 2 texels from base on, 0 where a texel is not the same surface. */
vec4 footprint(Reprojection r, ivec2 base, vec2 f, uvec2 taps[4], nrd_surface surface)
{
    Plane plane = make_plane(mat3(g.world_to_view_prev) * surface.normal, r.position, (vec2(base) + 0.5) * g.px_uv.zw + jitter_prev_uv(), g.px_uv.zw, g.frustum_prev,
                             g.orthographic_prev, 1.0 / r.tolerance, g.denoising_range_prev);
    vec4 w = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    uvec2 own = pack_surface(1.0, surface);
    for (int i = 0; i < 4; i++) {
        ivec2 offset = ivec2(i & 1, i >> 1);
        bool inside = all(lessThan(uvec2(base + offset), uvec2(g.rect_width_prev, g.rect_height_prev)));
        bool on_plane = abs(plane_distance(plane, vec2(offset), tap_relative_depth(taps[i]))) < 1.0;
        bool same = same_material(tap_material(taps[i]), surface.material_id) && (is_alike(taps[i], own) || tap_bend(taps[i], surface.normal) < WIDEST_BEND);
        if (!inside || !on_plane || tap_is_sky(taps[i]) || !same) w[i] = 0.0;
    }
    return w;
}

/* What the previous frame knows of this surface; frames 0: nothing. */
struct History {
    Lobe diffuse, specular;
    float bend;   /* 1 - cos of the angle to its normals */
};

void add_lobe(inout Lobe sum, Lobe lobe, float w)
{
    sum.occlusion += w * lobe.occlusion;
    sum.frames += w * lobe.frames;
    sum.radius += w * lobe.radius;
    sum.moment += w * lobe.moment;
}

Lobe no_lobe() { return Lobe(0.0, 0.0, 0.0, vec3(0.0)); }
History no_history() { return History(no_lobe(), no_lobe(), 0.0); }

History fetch_history(Reprojection r, nrd_surface surface)
{
    vec2 place = place_prev(r.uv), corner = floor(place), f = place - corner;
    vec2 uv = (corner + 1.0) * g.texel_uv.zw;   /* where the four meet */
    uvec4 x = textureGather(prev_tap, uv, 0).wzxy, y = uvec4(0u), states = uvec4(0u);
#if defined(SPECULAR) || defined(DIRECTIONAL)
    y = textureGather(prev_tap, uv, 1).wzxy;
#endif
#ifdef DIFFUSE
    states = textureGather(prev_state, uv, 0).wzxy;
#endif
    uvec2 taps[4] = uvec2[](uvec2(x[0], y[0]), uvec2(x[1], y[1]), uvec2(x[2], y[2]), uvec2(x[3], y[3]));
    vec4 w = footprint(r, ivec2(corner), f, taps, surface);
    float sum = w.x + w.y + w.z + w.w;
    History h = no_history();
    if (!(sum > 0.01)) return h;
    for (int i = 0; i < 4; i++) {
        Texel texel = Texel(taps[i], states[i]);
#ifdef DIFFUSE
        add_lobe(h.diffuse, diffuse_lobe(texel), w[i] / sum);
#endif
#ifdef SPECULAR
        add_lobe(h.specular, specular_lobe(texel), w[i] / sum);
#endif
        h.bend += w[i] / sum * tap_bend(taps[i], surface.normal);
    }
    h.diffuse.frames *= sqrt(sum);   /* part of the footprint is gone: the rest is stretched */
    h.specular.frames *= sqrt(sum);
    return h;
}

float threshold_at(ivec2 pixel)
{
    if ((SPEC_FEATURES & NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX) != 0 && has_flag(NRD_FLAG_DISOCCLUSION_MIX))
        return mix(g.disocclusion_threshold, g.disocclusion_threshold_alternate, texelFetch(in_threshold_mix, pixel, 0).x);
    return g.disocclusion_threshold;
}

/* Frames that specular history is worth: a static world seen in a plane at hit_dist moves over the surface by the parallax between the
   surface and the mirrored point; what the surface itself moves counts as far as it turns the mirror. Both against the lobe's footprint.
   attached: what is seen moves with the camera. */
float specular_limit(vec3 position, vec2 uv_prev, float hit_dist, float roughness, float bend, bool attached)
{
    vec3 ray = g.orthographic > 0.5 ? vec3(0.0, 0.0, 1.0) : normalize(position);
    float distance = length(position), q = hit_dist / (hit_dist + distance), alpha = max(roughness * roughness, 1e-4);
    vec2 rect_prev = g.rect_px.zw;
    vec2 still = project_prev((g.view_to_view_prev * vec4(position, 1.0)).xyz);
    vec2 mirrored = project_prev((g.view_to_view_prev * vec4(position + ray * hit_dist, 1.0)).xyz);
    float shift = is_absent(NRD_ABSENT_MOTION) || attached ? 0.0 : length((mirrored - still) * rect_prev) + q * length((uv_prev - still) * rect_prev);
    float footprint = max(alpha * q * distance / (g.pixel_unproject * mix(position.z, 1.0, g.orthographic)), LEAST_FOOTPRINT);
    float relative = shift / (LOBE_SHIFT * footprint), lobe = alpha + 0.03;
    float share = 1.0 / ((1.0 + 3.2 * relative * relative) * (1.0 + 2.0 * bend / (lobe * lobe))), frames = g.max_accumulated_frames * share;
    return frames * clamp(frames - 0.5 * (1.0 - share), 0.0, 1.0);   /* less than a frame is not worth a trail */
}

/* specular: this frame's sample, normalised. The farther of it and of what was around moves most. */
History find_history(ivec2 pixel, float signed_z, nrd_surface surface, float specular)
{
    if (is_reset()) return no_history();
    vec3 motion = is_absent(NRD_ABSENT_MOTION) ? vec3(0.0) : texelFetch(in_motion, pixel + rect_origin(), 0).xyz * g.motion_scale.xyz;
    Reprojection r = reproject(motion, pixel_uv(pixel), abs(signed_z), signed_z, threshold_at(pixel), surface.material_id);
    History h = fetch_history(r, surface);
    bool confident = (SPEC_FEATURES & NRD_FEATURE_HISTORY_CONFIDENCE) != 0 && has_flag(NRD_FLAG_HISTORY_CONFIDENCE);
#ifdef DIFFUSE
    if (confident) h.diffuse.frames *= clamp(textureLod(in_diffuse_confidence, r.uv, 0.0).x, 0.0, 1.0);
    h.diffuse.frames = min(h.diffuse.frames, g.max_accumulated_frames);
#endif
#ifdef SPECULAR
    if (confident) h.specular.frames *= clamp(textureLod(in_specular_confidence, r.uv, 0.0).x, 0.0, 1.0);
    vec3 position = view_position(ray_uv(pixel), abs(signed_z), g.frustum, g.orthographic);
    float hit_dist = nrd_denormalize_hit_dist(max(specular, h.specular.radius), position.z, surface.roughness, g.hit_distance);
    bool attached = HAS_MATERIALS && surface.material_id == special_material(NRD_MATERIAL_CAMERA_ATTACHED);
    h.specular.frames = min(h.specular.frames, specular_limit(position, r.uv + jitter_uv(), hit_dist, surface.roughness, h.bend, attached));
#endif
    return h;
}

/* Sums over a lobe's samples on the same surface. */
struct Sums {
    vec3 samples;    /* number, reciprocal, normalised hit distance */
    vec3 own;        /* the same, of the pixel's own quad alone */
    vec3 changes;    /* number, sample minus history, variance */
    vec3 moment, own_moment;
};
struct Around { Sums diffuse, specular; };

/* Of the pixel alone: so that there is one. */
Sums start_sums(float noisy, vec3 moment)
{
    vec3 own = noisy > 0.0 ? vec3(1.0, 1.0 / max(noisy, LEAST_RADIUS), noisy) : vec3(0.0);
    return Sums(own, own, vec3(0.0), moment, moment);
}

void add_quad(inout Sums s, vec3 samples, vec3 changes, vec3 moment, float w, bool own)
{
    s.samples += w * samples;
    s.changes += w * changes;
    s.moment += w * moment;
    if (own) s.own = s.samples;
    if (own) s.own_moment = s.moment;
}

vec3 change_in_quad(int first, int lobe)
{
    vec3 sum = vec3(0.0);
    for (int k = 0; k < 4; k++) {
        vec4 changes = s_changes[first + (k & 1) + (k >> 1) * 8];
        vec2 change = lobe == 0 ? changes.xy : changes.zw;
        sum += vec3(change.y > 0.0 ? 1.0 : 0.0, change);
    }
    return sum;
}

void sum_changes(vec2 diffuse, vec2 specular)
{
    s_changes[gl_LocalInvocationIndex] = vec4(diffuse, specular);
    barrier();
    if (gl_LocalInvocationIndex < uint(QUADS_LOADED)) {
        ivec2 quad = own_quad();
        bool inside = gl_LocalInvocationIndex < 16u;
        int i = quad.y * SPAN + quad.x, first = inside ? (quad.y - 1) * 16 + (quad.x - 1) * 2 : 0;
#ifdef DIFFUSE
        s_diffuse_changes[i] = inside ? change_in_quad(first, 0) : vec3(0.0);
#endif
#ifdef SPECULAR
        s_specular_changes[i] = inside ? change_in_quad(first, 1) : vec3(0.0);
#endif
    }
    barrier();
}

/* Over the pixels of the quads around; changes: those in the group. noisy: the pixel's own. */
Around look_around(ivec2 pixel, vec3 position, nrd_surface surface, vec2 noisy, vec3 moment)
{
    ivec2 quad = ivec2(gl_LocalInvocationID.xy) >> 1;
    Plane plane = make_plane(surface.normal * mat3(g.view_to_world), position, ray_uv(pixel), g.px_uv.xy, g.frustum, g.orthographic,
                             1.0 / plane_tolerance(g.plane_distance_sensitivity, position.z), 1.0);
    vec2 center = 0.5 - vec2(pixel & 1);   /* of its quad */
    uint kind = kind_of(surface);
    float diffuse_scale = QUAD_BEND * diffuse_bend_scale(), specular_scale = QUAD_BEND * specular_bend_scale(surface.roughness);
    Around a = Around(start_sums(noisy.x, moment), start_sums(noisy.y, vec3(0.0)));
    const ivec2 offsets[9] = ivec2[9](ivec2(0), ivec2(1, 0), ivec2(0, 1), ivec2(-1, 0), ivec2(0, -1), ivec2(1, 1), ivec2(-1, 1), ivec2(-1, -1), ivec2(1, -1));
    UNROLL for (int k = 0; k < QUADS_AROUND; k++) {
        ivec2 offset = offsets[k];
        int at = (quad.y + offset.y + 1) * SPAN + quad.x + offset.x + 1;
        uint quad_kind = floatBitsToUint(s_surface[at].w);
        float quad_z = QUAD_Z(at), bend = 1.0 - dot(surface.normal, s_surface[at].xyz);
        bool same = quad_z != 0.0 && abs(plane_distance(plane, center + vec2(offset) * 2.0, quad_z)) < 1.0 && ((quad_kind ^ kind) & 3u) == 0u;
#ifdef DIFFUSE
#ifdef DIRECTIONAL
        vec3 quad_moment = s_moment[at];
#else
        vec3 quad_moment = vec3(0.0);
#endif
        add_quad(a.diffuse, s_diffuse[at].xyz, s_diffuse_changes[at], quad_moment, same ? exp2(diffuse_scale * bend) : 0.0, k == 0);
#endif
#ifdef SPECULAR
        float w = same ? exp2(specular_scale * bend) * roughness_weight(uintBitsToFloat(quad_kind & ~3u) - 1.0, surface.roughness) : 0.0;
        add_quad(a.specular, s_specular[at].xyz, s_specular_changes[at], vec3(0.0), w, k == 0);
#endif
    }
    return a;
}

/* What a sample says about history. Its variance is not known, but a mean h of numbers in [0,1] allows no more than h (1 - h). */
vec2 change_of(Lobe h, float noisy)
{
    return noisy > 0.0 && h.frames > CHANGED_FRAMES ? vec2(noisy - h.occlusion, max(h.occlusion * (1.0 - h.occlusion), 1e-3)) : vec2(0.0);
}

/* Where the samples around differ from their histories by more than chance allows, something has moved: history is shifted by the
   difference, which keeps its detail, and counts as short. */
Lobe follow(Lobe h, Sums around)
{
    float n = max(around.changes.x, 1.0), difference = around.changes.y / n, error = sqrt(around.changes.z) / n;
    float certainty = around.changes.x < 8.0 ? 0.0 : clamp(abs(difference) / (g.antilag_sigma_scale * error + 1e-6) - 1.0, 0.0, 1.0);
    if (h.frames <= CHANGED_FRAMES) return h;
    h.occlusion = clamp(h.occlusion + certainty * difference, 0.0, 1.0);
    h.frames = mix(h.frames, CHANGED_FRAMES, certainty);
    h.radius = mix(h.radius, around.samples.x / max(around.samples.y, 1e-3), certainty);
    return h;
}

Lobe update_radius(Lobe h, vec3 around)
{
    if (around.x > 0.0) h.radius = mix(h.radius, around.x / around.y, 1.0 / (1.0 + h.frames));
    else if (!(h.frames > 0.0)) h.radius = 1.0;
    return h;
}

float ramp(float reach, vec2 range) { return clamp((reach - range.x) / (range.y - range.x), 0.0, 1.0); }

/* A pixel that was not sampled keeps what it knows, or takes its neighbours' mean, or is open where nobody knows. sums: of look_around();
   reach: radius of the disc, px. */
Lobe accumulate(Lobe h, float noisy, vec3 moment, Sums sums, float reach)
{
    float alpha = 1.0 / (1.0 + h.frames), of_quad = ramp(reach, QUAD_REACH), of_around = ramp(reach, AROUND_REACH);
    bool sampled = noisy > 0.0, fresh = !(h.frames > 0.0);
    vec3 mean = mix(sums.own, sums.samples, of_around), mean_moment = mix(sums.own_moment, sums.moment, of_around);
    if (sampled) h.moment = mix(h.moment, mix(moment, mean_moment / mean.x, of_quad), alpha);
    if (sampled) h.occlusion = mix(h.occlusion, mix(noisy, mean.z / mean.x, of_quad), alpha);
    else if (fresh) h.occlusion = sums.samples.x > 0.0 ? sums.samples.z / sums.samples.x : 1.0;
    if (sampled || fresh) h.frames = min(h.frames + 1.0, 63.0);
    return h;
}

/* Px per unit in the surface, where it is foreshortened most. */
float px_per_unit(vec3 position, vec3 normal)
{
    vec3 ray = normalize(mix(position, vec3(0.0, 0.0, 1.0), g.orthographic));
    return abs(dot(normal * mat3(g.view_to_world), ray)) / pixel_size(position.z);
}

void process(ivec2 pixel)
{
    ivec2 inside = min(pixel, rect_size() - 1);   /* what everything waits for is loaded before the first branch */
    float signed_z = texelFetch(in_view_z, inside + rect_origin(), 0).x * g.view_z_scale;
    nrd_surface surface = decode_surface(inside);
    vec2 noisy = vec2(0.0);
#ifdef DIFFUSE
    noisy.x = nrd_sanitize_norm_hit_dist(load_diffuse(inside));
#endif
#ifdef SPECULAR
    noisy.y = nrd_sanitize_norm_hit_dist(load_specular(inside));
#endif
    load_quads();
    bool visible = in_rect(pixel) && !is_sky(signed_z);
    noisy = mix(vec2(0.0), noisy, bvec2(visible));
    float z = max(abs(signed_z), 1e-10 * g.denoising_range);   /* what is stored ends above that */
    signed_z = signed_z < 0.0 ? -z : z;
    History h = no_history();
    if (visible) h = find_history(pixel, signed_z, surface, noisy.y);
    sum_changes(change_of(h.diffuse, noisy.x), change_of(h.specular, noisy.y));
    if (!visible) {
        if (in_rect(pixel)) imageStore(out_tap, pixel, uvec4(TAP_SKY, 0u, 0u, 0u));
        return;
    }
    vec3 moment = load_moment(pixel, noisy.x), position = view_position(ray_uv(pixel), z, g.frustum, g.orthographic);
    Around around = look_around(pixel, position, surface, noisy, moment);
    float scale = px_per_unit(position, surface.normal);
    Lobe d = no_lobe(), s = no_lobe();
#ifdef DIFFUSE
    d = update_radius(follow(h.diffuse, around.diffuse), around.diffuse.samples);
    d = accumulate(d, noisy.x, moment, around.diffuse, min(diffuse_reach(d.radius, z) * scale, g.max_blur_radius));
#endif
#ifdef SPECULAR
    s = update_radius(follow(h.specular, around.specular), around.specular.samples);
    s = accumulate(s, noisy.y, vec3(0.0), around.specular, SPECULAR_SHARE * min(specular_reach(s.radius, position, surface.roughness, 0.0) * scale, g.max_blur_radius));
#endif
    float random = (float(hash(uint(pixel.x), uint(pixel.y), g.frame_index) >> 24) + 0.5) / 256.0;
    Texel texel = pack_lobes(pack_surface(z, surface), d, s, random);
    imageStore(out_tap, pixel, uvec4(texel.tap, 0u, 0u));
#ifdef DIFFUSE
    imageStore(out_state, pixel, uvec4(texel.state, 0u, 0u, 0u));
#endif
}
