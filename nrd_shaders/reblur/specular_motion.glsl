/* Finds, for the specular signal, where the previous frame saw the same reflected point: the surface moves one way, what it mirrors another.
   The point of the previous frame's surface that mirrored it is found by a Newton step on that frame's own positions and normals, with
   the curvature of this frame's; the history of the surface or that of the reflection is taken, whichever can be the same light for longer.
   Newton steps on a reflecting surface: W. Jakob, S. Marschner, "Manifold Exploration", SIGGRAPH 2012; surface against virtual
   history: D. Zhdan, GTC 2020.

   Everything is scaled by two numbers: q = hit distance / (hit distance + distance to the camera), and the footprint, the width in pixels
   of what the lobe sees. World space is relative to the current camera. */
#ifndef SPECULAR_MOTION_GLSL
#define SPECULAR_MOTION_GLSL

#include "../common/ring.glsl"

shared vec4 s_surface[RING_SIDE * RING_SIDE]; /* world normal, view depth; depth 0: nothing there */
shared float s_tracked[RING_SIDE * RING_SIDE]; /* q of the noisy sample, -1: not sampled */
shared uint s_glossy;

/* Footprints over which a history may be smeared in all. 0.25 to 2 tried, and lengths that fall with the square of the shift: those let a
   small shift of every frame add up to a blur of pixels; shorter ones flicker more in mirrors. */
const float SMEAR = 0.25;
const float DRIFT = 0.2;            /* footprints, over the whole history, below which surface and reflection move alike */
const float LEAST_FOOTPRINT = 0.35; /* px: what a pixel itself sees */
const float NARROWEST_LOBE = 0.01;  /* squared width from which on normal maps are told apart */
const float BUMPY = 0.002;          /* variance of normals that no curvature explains, above which Newton steps lead astray */

/* q: the nearest on this surface around the pixel, -1 where nothing was sampled; sigma: the deviation there. */
struct Tracking { float q, sigma; };

struct Curvature {
    mat2 turn;           /* change of the normal by way along the tangents, 1/units */
    float bump;          /* variance of the normals around that */
    vec3 tangent, bitangent; /* world */
};

struct VirtualMotion {
    vec2 uv;
    vec3 position;       /* previous view space */
    vec3 normal;         /* world */
    float error;         /* px: what a further step would move; negative: there is none */
    float bow;           /* units by which the surface leaves its tangent plane on the way */
};

/* Without a branch: those before loads take a tenth of the pass's time. place: of the cell; what is seen there, or nearest to it in the rectangle. */
void fill_cell(ivec2 place, Seen seen)
{
    ivec2 at = tile * 8 - 1 + place, pixel = clamp(at, ivec2(0), rect_size() - 1);
    float z = abs(seen.signed_z), norm_hit_dist = 0.0;
    if (is_reconstructed()) norm_hit_dist = load_reconstructed(SPECULAR_SIGNAL, pixel);
    else if (is_traced(pixel, SPECULAR_LOBE)) norm_hit_dist = sanitize(texelFetch(in_spec_unblurred, noisy_texel(pixel, SPECULAR_LOBE), 0)).w;
    bool there = in_rect(at) && !is_sky(seen.signed_z), tracked = there && norm_hit_dist > 0.0 && !is_too_rough(seen.surface.roughness);
    float hit_dist = nrd_denormalize_hit_dist(norm_hit_dist, z, seen.surface.roughness, g.hit_distance);
    int cell = place.y * RING_SIDE + place.x;
    vec3 normal = is_absent(NRD_ABSENT_MOTION | NRD_ABSENT_MIRRORS) ? vec3(0.0) : seen.surface.normal;   /* of measure_curvature() alone */
    s_surface[cell] = mix(vec4(0.0), vec4(normal, z), bvec4(there));
    s_tracked[cell] = mix(-1.0, hit_dist / (hit_dist + distance_to_camera(ray_uv(pixel), z)), tracked);
}

/* Lets all threads know whether any pixel of the tile has a specular signal. */
bool has_glossy_pixel(ivec2 pixel, Seen own)
{
    if (!HAS_ROUGHNESS_LIMIT || SIGNALS == 1) return true;   /* else the tile is not listed */
    if (gl_LocalInvocationIndex == 0u) s_glossy = 0u;
    barrier();
    if (in_rect(pixel) && !is_too_rough(own.surface.roughness)) s_glossy = 1u;
    barrier();
    return s_glossy != 0u;
}

/* own: of this thread's pixel. */
void load_neighbourhood(ivec2 pixel, Seen own)
{
    if (!has_glossy_pixel(pixel, own)) return;
    fill_cell(own_place(), own);
    if (has_ring_place()) fill_cell(ring_place(), look(clamp(tile * 8 - 1 + ring_place(), ivec2(0), rect_size() - 1)));
    barrier();
}

void make_tangents(vec3 n, out vec3 tangent, out vec3 bitangent)
{
    tangent = normalize(abs(n.z) < 0.9 ? cross(n, vec3(0.0, 0.0, 1.0)) : cross(n, vec3(1.0, 0.0, 0.0)));
    bitangent = cross(n, tangent);
}

/* Sums over the pixels around. way: along the tangents, units; turn: of the normal. */
struct CurvatureSums {
    mat2 moments;     /* turn x way */
    vec3 spread;      /* way x way: xx, xy, yy */
    float turns, count;
};

/* Least squares of the change of normals. */
void fit_curvature(inout Curvature c, CurvatureSums s)
{
    c.turn = mat2(0.0);
    c.bump = 0.0;
    float ridge = 0.02 * (s.spread.x + s.spread.z);
    if (!(ridge > 0.0)) return;
    float xx = s.spread.x + ridge, yy = s.spread.z + ridge;
    mat2 fit = s.moments * mat2(yy, -s.spread.y, -s.spread.y, xx) / (xx * yy - s.spread.y * s.spread.y);
    float across = 0.5 * (fit[0][1] + fit[1][0]);
    c.turn = mat2(fit[0][0], across, across, fit[1][1]);
    mat2 explained = c.turn * mat2(s.spread.x, s.spread.y, s.spread.y, s.spread.z);
    float rest = s.turns - 2.0 * (dot(c.turn[0], s.moments[0]) + dot(c.turn[1], s.moments[1])) + dot(c.turn[0], explained[0]) + dot(c.turn[1], explained[1]);
    c.bump = max(rest, 0.0) / max(s.count, 1.0);
}

int own_cell() { return own_place().x + RING_SIDE * own_place().y; }

Tracking track_hit_distance(ivec2 pixel, nrd_surface surface)
{
    float z = s_surface[own_cell()].w, own = s_tracked[own_cell()], scale = 1.0 / plane_tolerance(g.plane_distance_sensitivity, z);
    vec2 uv = ray_uv(pixel);
    Plane plane = make_plane(surface.normal * mat3(g.view_to_world), view_position(uv, z, g.frustum, g.orthographic), uv, g.px_uv.xy, g.frustum,
                             g.orthographic, scale, 1.0);
    float nearest = own < 0.0 ? 2.0 : own, second = 2.0;
    vec3 sums = own < 0.0 ? vec3(0.0) : vec3(own, own * own, 1.0);
    UNROLL for (int i = 0; i < 9; i++) {
        if (i == 4) continue;
        ivec2 offset = ivec2(i % 3, i / 3) - 1;
        int cell = own_cell() + offset.x + RING_SIDE * offset.y;
        float q = s_tracked[cell];   /* -1 where there is nothing */
        bool usable = q >= 0.0 && abs(plane_distance(plane, vec2(offset), s_surface[cell].w)) < 1.0;
        float candidate = usable ? q : 2.0;
        second = min(second, max(nearest, candidate));
        nearest = min(nearest, candidate);
        if (usable) sums += vec3(q, q * q, 1.0);
    }
    if (second <= 1.0) nearest = second;   /* one stray sample of nine says nothing */
    if (nearest > 1.0) return Tracking(-1.0, 0.0);
    float footprint = lobe_footprint(max(surface.roughness * surface.roughness, 1e-4), nearest, z, uv), mean = sums.x / max(sums.z, 1.0);
    return Tracking(own < 0.0 ? nearest : mix(own, nearest, clamp(footprint / 0.5, 0.0, 1.0)), sqrt(max(sums.y / max(sums.z, 1.0) - mean * mean, 0.0)));
}

/* From the four pixels beside it: those at the corners tell no more. */
Curvature measure_curvature(ivec2 pixel, vec3 normal)
{
    Curvature c;
    float z = s_surface[own_cell()].w, tolerance = plane_tolerance(g.plane_distance_sensitivity, z);
    vec3 position = view_position(ray_uv(pixel), z, g.frustum, g.orthographic);
    CurvatureSums s = CurvatureSums(mat2(0.0), vec3(0.0), 0.0, 0.0);
    make_tangents(normal, c.tangent, c.bitangent);
    vec3 normal_vs = normal * mat3(g.view_to_world), tangent_vs = c.tangent * mat3(g.view_to_world), bitangent_vs = c.bitangent * mat3(g.view_to_world);
    UNROLL for (int i = 1; i < 9; i += 2) {
        ivec2 offset = ivec2(i % 3, i / 3) - 1;
        vec4 tap = s_surface[own_cell() + offset.x + RING_SIDE * offset.y];
        vec3 move = view_position(ray_uv(pixel + offset), tap.w, g.frustum, g.orthographic) - position;
        float near = tap.w > 0.0 && abs(dot(normal_vs, move)) < tolerance ? 1.0 : 0.0;
        vec2 way = vec2(dot(tangent_vs, move), dot(bitangent_vs, move)), turn = vec2(dot(c.tangent, tap.xyz), dot(c.bitangent, tap.xyz));
        s.moments += near * outerProduct(turn, way);
        s.spread += near * vec3(way.x * way.x, way.x * way.y, way.y * way.y);
        s.turns += near * dot(turn, turn);
        s.count += near;
    }
    fit_curvature(c, s);
    return c;
}

/* Towards the dominant direction of a GGX lobe, [0,1]: 1 is the mirror's. Fit of S. Lagarde, "Moving Frostbite to PBR", 2014, refined. */
float dominant_factor(float n_dot_v, float roughness)
{
    float q = 0.298475 * log(39.4115 - 39.0029 * roughness);
    return clamp(q + (1.0 - q) * pow(1.0 - n_dot_v, 10.8649), 0.0, 1.0);
}

vec3 to_world(vec3 position_prev_vs) { return (position_prev_vs - g.world_to_view_prev[3].xyz) * mat3(g.world_to_view_prev); }

/* The move along the tangent plane (t, b of the result's world space) after which a surface point mirrors `target` into the previous camera. */
vec3 newton_step(vec3 point, vec3 normal, vec3 target, Curvature c, mat2 turn, out bool regular)
{
    vec3 camera = -g.world_to_view_prev[3].xyz * mat3(g.world_to_view_prev), forward = vec3(0.0, 0.0, 1.0) * mat3(g.world_to_view_prev);
    vec3 to_camera = camera - point, to_target = target - point;
    float flat_view = g.orthographic_prev, distance = length(to_camera), hit = max(length(to_target), 1e-6);
    vec3 v = flat_view > 0.5 ? -forward : to_camera / max(distance, 1e-6), l = to_target / hit;
    vec3 tangent = normalize(c.tangent - normal * dot(normal, c.tangent)), bitangent = cross(normal, tangent);
    vec2 side = vec2(dot(tangent, v), dot(bitangent, v)), rest = side + vec2(dot(tangent, l), dot(bitangent, l));
    float bend = (flat_view > 0.5 ? 0.0 : 1.0 / max(distance, 1e-6)) + 1.0 / hit;
    mat2 plane = bend * (mat2(1.0) - outerProduct(side, side));
    mat2 a = plane + 2.0 * abs(dot(normal, v)) * turn;
    regular = abs(determinant(a)) >= 0.1 * determinant(plane);
    vec2 move = inverse(regular ? a : plane) * rest;
    return tangent * move.x + bitangent * move.y;
}

/* The mean is one of points of the guide's map: of unit length, and decoded once. */
vec3 mean_normal(Footprint f, vec3 otherwise)
{
    vec2 sum = vec2(0.0);
    float weight = 0.0;
    UNROLL for (int i = 0; i < 4; i++) {
        if (!(f.weights[i] > 0.0)) continue;
        sum += f.weights[i] * guide_point(footprint_guide(f, i));
        weight += f.weights[i];
    }
    return weight > 1e-3 ? guide_normal(sum / weight) * mat3(g.world_to_view_prev) : otherwise;
}

/* Nothing around was sampled: what history tracked. */
Tracking recall_tracking(Footprint f)
{
    uvec4 tracks = gather_tracks_at(SPECULAR_SIGNAL, f.seconds, f.corner_uv);
    float sum = 0.0, q = 0.0;
    for (int i = 0; i < 4; i++) {
        sum += f.weights[i];
        q += f.weights[i] * unpack_track(tracks[i]).hit_dist;
    }
    return Tracking(q / max(sum, 1e-3), 0.0);
}

/* The point that is mirrored, world. */
vec3 mirrored_point(vec3 position_vs, vec3 normal, float roughness, float q)
{
    vec3 point = mat3(g.view_to_world) * position_vs, forward = mat3(g.view_to_world) * vec3(0.0, 0.0, 1.0);
    vec3 view = g.orthographic > 0.5 ? forward : normalize(point);
    float distance = mix(length(position_vs), position_vs.z, g.orthographic), hit = min(q / max(1.0 - q, 1e-5), 1e5) * distance;
    return point + reflect(view, normal) * hit * dominant_factor(abs(dot(view, normal)), roughness);
}

VirtualMotion find_virtual_motion(vec3 target, Reprojection r, vec3 normal_prev, vec3 normal, Curvature c)
{
    VirtualMotion m;
    bool smooth_surface = c.bump < BUMPY, regular;
    vec3 start = to_world(r.position);
    float mean_turn = 0.5 * (c.turn[0][0] + c.turn[1][1]);
    mat2 turn = smooth_surface ? c.turn : mat2(mean_turn, 0.0, 0.0, mean_turn);
    m.normal = smooth_surface ? normal_prev : normal;
    vec3 move = newton_step(start, m.normal, target, c, turn, regular);
    vec2 way = vec2(dot(c.tangent, move), dot(c.bitangent, move)), turned = turn * way;
    vec3 point = start + move - 0.5 * dot(way, turned) * m.normal, bent = normalize(m.normal + turned.x * c.tangent + turned.y * c.bitangent);
    bool again;   /* the first step leaves hundredths of a pixel, which every frame adds to the last one's */
    vec3 further = newton_step(point, bent, target, c, turn, again);
    if (again) point += further;
    m.position = (g.world_to_view_prev * vec4(point, 1.0)).xyz;
    m.uv = project_prev(m.position) - jitter_uv();
    m.bow = 0.5 * abs(dot(way, turned));
    m.error = regular && all(lessThan(abs(m.uv - 0.5), vec2(0.5))) ? 0.0 : -1.0;
    return m;
}

/* Motion that the app gives of what is reflected. */
struct GivenMotion {
    bool of_image, of_hit;   /* neither: not given */
    vec3 motion;             /* of the image: xy, uv; of the hit: world */
};

GivenMotion load_given_motion(ivec2 pixel)
{
    if ((SPEC_FEATURES & NRD_FEATURE_SPECULAR_MOTION) == 0 || !has_flag(NRD_FLAG_SPECULAR_MOTION)) return GivenMotion(false, false, vec3(0.0));
    bool hit = has_flag(NRD_FLAG_SPECULAR_MOTION_HIT), scaled = !hit && (g.motion_mode | opaque_zero()) != NRD_MOTION_WORLD;
    vec3 motion = load_specular_motion(pixel + rect_origin()) * vec3(scaled ? g.motion_scale.xy : vec2(1.0), hit ? 1.0 : 0.0);
    bool given = nrd_is_finite(motion) && all(lessThan(abs(motion), vec3(60000.0)));
    return GivenMotion(given && !hit, given && hit, given ? motion : vec3(0.0));
}

/* Where the previous frame's view through uv meets a plane, previous view space. */
vec3 meet_plane(vec2 uv, vec3 normal_vs, vec3 point)
{
    vec3 near = view_position(uv, 0.0, g.frustum_prev, g.orthographic_prev), along = view_position(uv, 1.0, g.frustum_prev, g.orthographic_prev) - near;
    float facing = dot(normal_vs, along);
    return near + along * dot(normal_vs, point - near) / (abs(facing) > 1e-6 ? facing : 1e-6);
}

/* The surface where the previous picture showed the same reflection. */
VirtualMotion take_virtual_motion(vec2 uv_prev, Reprojection r, vec3 normal_prev, vec3 normal, Curvature c)
{
    VirtualMotion m;
    m.uv = uv_prev;
    m.normal = c.bump < BUMPY ? normal_prev : normal;
    m.position = meet_plane(uv_prev + jitter_uv(), mat3(g.world_to_view_prev) * m.normal, r.position);
    vec3 move = to_world(m.position) - to_world(r.position);
    vec2 way = vec2(dot(c.tangent, move), dot(c.bitangent, move));
    m.bow = 0.5 * abs(dot(way, c.turn * way));
    m.error = m.position.z > 0.0 && all(lessThan(abs(uv_prev - 0.5), vec2(0.5))) ? 0.0 : -1.0;
    return m;
}

/* Position of the previous frame's surface in the middle of a footprint, previous view space. */
vec3 footprint_position(Footprint f, vec2 uv)
{
    float z = 0.0, sum = 0.0;
    UNROLL for (int i = 0; i < 4; i++) {
        if (!(f.weights[i] > 0.0)) continue;
        z += f.weights[i] * guide_relative_depth(f.guides[i]);
        sum += f.weights[i];
    }
    return view_position(uv + jitter_prev_uv(), z / max(sum, 1e-6) * g.denoising_range_prev, g.frustum_prev, g.orthographic_prev);
}

/* How far, in pixels, a second step from there would go: the first one's error. */
float remaining_step(Footprint f, VirtualMotion m, vec3 target, Curvature c)
{
    bool regular;
    vec3 normal = mean_normal(f, m.normal);
    vec3 point = to_world(meet_plane(m.uv + jitter_uv(), mat3(g.world_to_view_prev) * normal, footprint_position(f, m.uv)));   /* else the jitter's way counts too */
    vec3 move = newton_step(point, normal, target, c, c.turn, regular);
    vec2 uv = project_prev((g.world_to_view_prev * vec4(point + move, 1.0)).xyz) - jitter_uv();
    return regular ? min(length((uv - m.uv) * size_prev_px()), 1e3) : 0.0;
}

/* 1 for texels that had a specular signal. */
vec4 sounding(Footprint f)
{
    vec4 w = vec4(1.0);
    UNROLL for (int i = 0; i < 4; i++) w[i] = is_silent(footprint_guide(f, i)) ? 0.0 : 1.0;
    return w;
}

vec4 roughness_agreement(Footprint f, float roughness)
{
    vec4 w;
    UNROLL for (int i = 0; i < 4; i++) w[i] = clamp(1.5 - abs(guide_roughness(footprint_guide(f, i)) - roughness) / (0.02 + 0.1 * roughness), 0.0, 1.0);
    return w;
}

/* Texels that tracked something else show another reflection; matters as far as the reflection moves apart from the surface. */
vec4 tracking_agreement(Footprint f, Tracking t, float travel_px)
{
    uvec4 tracks = gather_tracks_at(SPECULAR_SIGNAL, f.seconds, f.corner_uv);
    float tolerance = 0.05 + 0.5 * t.sigma;
    vec4 w;
    UNROLL for (int i = 0; i < 4; i++) {
        float d = (unpack_track(tracks[i]).hit_dist - t.q) / tolerance;
        w[i] = exp2(-LOG2_E * d * d * clamp(travel_px, 0.0, 1.0));
    }
    return w;
}

/* Whether the surface's own texels showed something as far away, [0,1]; told apart where the lobe is sharp. What a moving object uncovers
   in a mirror does not move itself: only its distance tells it from the object. */
float still_reflected(Footprint f, Tracking t, float footprint)
{
    vec4 agreement = tracking_agreement(f, t, clamp(1.0 - 0.5 * footprint, 0.0, 1.0));
    float sum = f.weights.x + f.weights.y + f.weights.z + f.weights.w;
    return sum > 0.0 ? dot(f.weights, agreement) / sum : 1.0;
}

/* The length that a history may have whose samples lie `shift` footprints farther from where they should with each frame. */
float limit_frames(float frames, float shift)
{
    float most = max(g.max_accumulated_frames, 1.0);
    return min(frames, most / (1.0 + most * shift / SMEAR));
}

/* The lengths of histories as the footprint's texels have them. */
float mean_frames(Footprint f, int signal)
{
    float sum = 0.0, frames = 0.0;
    UNROLL for (int i = 0; i < 4; i++) {
        sum += f.weights[i];
        frames += f.weights[i] * guide_frames(footprint_guide(f, i), signal);
    }
    return sum > 0.01 ? frames / sum * sqrt(min(sum, 1.0)) : 0.0;
}

/* px between where the surface was and where something infinitely far behind it was: reflections in anything but concave mirrors lie between. */
float parallax_px(vec3 position, vec2 uv_prev)
{
    vec2 far_uv = project_prev(mat3(g.view_to_view_prev) * mix(position, vec3(0.0, 0.0, 1.0), g.orthographic));
    return min(length((far_uv - uv_prev) * size_prev_px()), 1e3);
}

/* Which texels of the previous frame showed what this pixel shows, and for how many frames that may count. */
struct SpecularMatch {
    Footprint footprint;
    float frames;
    vec3 normal;
    vec2 uv;
};

/* Replaces the surface's own texels by those that mirrored the same point, where these may count for longer. Mixing both costs a second
   fetch and gains nothing. */
void follow_reflection(inout SpecularMatch match, vec3 target, vec2 uv, GivenMotion given, Reprojection r, Curvature c, nrd_surface surface, Tracking t, vec3 normal_prev, float footprint, float drift)
{
    VirtualMotion m;
    if (given.of_image) m = take_virtual_motion(uv + given.motion.xy, r, normal_prev, surface.normal, c);
    else m = find_virtual_motion(target + given.motion, r, normal_prev, surface.normal, c);
    float travel = min(length((m.uv - r.uv) * size_prev_px()), 1e3), width = max(footprint, LEAST_FOOTPRINT);
    match.frames = limit_frames(match.frames, 2.0 * travel / width);
    if (m.error < 0.0 || travel < drift) return;
    Footprint moved = fetch_footprint(m.uv);
    weigh_surface(moved, m.position, m.normal, surface.material_id, r.tolerance + m.bow);
    if (c.bump < BUMPY && !given.of_image) m.error = remaining_step(moved, m, target + given.motion, c);
    moved.weights *= sounding(moved) * material_agreement(moved, surface.material_id, NRD_MATERIAL_LEAST_SPECULAR) * roughness_agreement(moved, surface.roughness) * tracking_agreement(moved, t, travel);
    float frames = limit_frames(mean_frames(moved, SPECULAR_SIGNAL), travel * min(t.sigma / max(t.q, 1e-4), 1.0) / width);
    frames /= 1.0 + frames * m.error / (SMEAR * max(footprint, 0.5));
    float longer = max(frames, match.frames);
    if (!(frames > 0.0) || match.frames - frames > 0.5 + 0.25 * longer) return;
    match = SpecularMatch(moved, frames, m.normal, m.uv);
}

History find_specular_history(ivec2 pixel, float z, Reprojection r, Footprint f, nrd_surface surface, Tracking t, out vec2 uv_history, out vec2 change)
{
    float alpha = max(surface.roughness * surface.roughness, 1e-4), footprint = lobe_footprint(alpha, t.q, z, pixel_uv(pixel));
    vec3 position = view_position(ray_uv(pixel), z, g.frustum, g.orthographic);
    f.weights *= roughness_agreement(f, surface.roughness) * material_agreement(f, surface.material_id, NRD_MATERIAL_LEAST_SPECULAR);
    SpecularMatch match = SpecularMatch(f, mean_frames(f, SPECULAR_SIGNAL), surface.normal, r.uv);
    vec3 normal_vs = surface.normal * mat3(g.view_to_world);
    vec3 stored_normal = mat3(g.view_to_world) * guide_normal(guide_point(guide_pack(z, normal_vs, 0.0, 0u)));
    vec3 normal_prev = mean_normal(f, stored_normal);
    float drift = DRIFT * max(footprint, LEAST_FOOTPRINT) / max(match.frames, 1.0), turned_px = 2.0 * length(normal_prev - stored_normal) * footprint / alpha;
    GivenMotion given = load_given_motion(pixel);
    bool is_given = given.of_image || given.of_hit;
    if (is_given) match.frames *= still_reflected(f, t, footprint);
    bool attached = HAS_MATERIALS && surface.material_id == special_material(NRD_MATERIAL_CAMERA_ATTACHED);
    if (!is_absent(NRD_ABSENT_MOTION | NRD_ABSENT_MIRRORS) && !attached && (is_given || parallax_px(position, r.uv + jitter_uv()) + turned_px >= drift) && !is_reset()) {
        vec3 target = mirrored_point(position, stored_normal, surface.roughness, t.q);
        follow_reflection(match, target, pixel_uv(pixel), given, r, measure_curvature(pixel, surface.normal), surface, t, normal_prev, footprint, drift);
    }
    uv_history = match.uv;
    change = fetch_change(SPECULAR_SIGNAL, uv_history);
    History h = fetch_history(match.footprint, match.footprint.weights, SPECULAR_SIGNAL, match.normal);
    SH_ONLY(h.turns = match.normal == surface.normal;)
    h.frames = min(match.frames, bend_limit(h, max(alpha * alpha, NARROWEST_LOBE)));
    return h;
}

#endif
