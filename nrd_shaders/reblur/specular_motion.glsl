/* Finds, for the specular signal, where the previous frame saw the same reflected point: the surface moves one way, what it mirrors another.
   The point of the previous frame's surface that mirrored it is found by a Newton step on that frame's own positions and normals, with
   the curvature of this frame's; then both histories, of the surface and of the reflection, count as far as they can be the same light.
   Reflection geometry as in J. Tessendorf's and others' specular manifold walks: W. Jakob, S. Marschner, "Manifold Exploration",
   SIGGRAPH 2012; surface against virtual history: D. Zhdan, GTC 2020.

   Everything is scaled by two numbers: q = hit distance / (hit distance + distance to the camera), and the footprint, the width in pixels
   of what the lobe sees. World space is relative to the current camera. */
#ifndef SPECULAR_MOTION_GLSL
#define SPECULAR_MOTION_GLSL

const int SIDE = 10;                /* of a group with one pixel around it */
shared vec4 s_surface[SIDE * SIDE]; /* world normal, view depth; depth 0: nothing there */
shared float s_tracked[SIDE * SIDE]; /* q of the noisy sample, -1: not sampled */

const float PARALLAX_FALLOFF = 3.2;
const float LEAST_FOOTPRINT = 0.35; /* px: what a pixel itself sees */
const float NARROWEST_LOBE = 0.01;  /* squared width from which on normal maps are told apart */
const float BUMPY = 0.002;          /* variance of normals that no curvature explains, above which Newton steps lead astray */

struct Tracking {
    float q, sigma;      /* nearest on this surface around the pixel, and the deviation there */
    mat2 curvature;      /* change of the normal by way along the tangents, 1/units */
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

void load_cell(int cell)
{
    ivec2 pixel = ivec2(gl_WorkGroupID.xy) * 8 - 1 + ivec2(cell % SIDE, cell / SIDE);
    s_surface[cell] = vec4(0.0);
    s_tracked[cell] = -1.0;
    if (!in_rect(pixel)) return;
    float signed_z = texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale, z = abs(signed_z);
    if (is_sky(signed_z)) return;
    nrd_surface surface = nrd_decode_normal_roughness(texelFetch(in_normal_roughness, pixel + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT);
    s_surface[cell] = vec4(surface.normal, z);
    float norm_hit_dist = nrd_sanitize_norm_hit_dist(texelFetch(in_spec_unblurred, pixel, 0).w);
    float hit_dist = nrd_denormalize_hit_dist(norm_hit_dist, z, surface.roughness, g.hit_distance);
    if (norm_hit_dist > 0.0) s_tracked[cell] = hit_dist / (hit_dist + distance_to_camera(pixel_uv(pixel), z));
}

void load_neighbourhood()
{
    for (int cell = int(gl_LocalInvocationIndex); cell < SIDE * SIDE; cell += 64) load_cell(cell);
    barrier();
}

void make_tangents(vec3 n, out vec3 tangent, out vec3 bitangent)
{
    tangent = normalize(abs(n.z) < 0.9 ? cross(n, vec3(0.0, 0.0, 1.0)) : cross(n, vec3(1.0, 0.0, 0.0)));
    bitangent = cross(n, tangent);
}

/* Least squares of the change of normals over the 3 x 3 pixels. */
void fit_curvature(inout Tracking t, vec2 way[8], vec2 turn[8], float usable[8])
{
    mat2 moments = mat2(0.0), spread = mat2(0.0);
    float count = 0.0;
    for (int i = 0; i < 8; i++) {
        moments += usable[i] * outerProduct(turn[i], way[i]);
        spread += usable[i] * outerProduct(way[i], way[i]);
        count += usable[i];
    }
    t.curvature = mat2(0.0);
    t.bump = 0.0;
    float ridge = 0.02 * (spread[0][0] + spread[1][1]);
    if (!(ridge > 0.0)) return;
    mat2 s = moments * inverse(spread + mat2(ridge, 0.0, 0.0, ridge));
    t.curvature = 0.5 * (s + transpose(s));
    for (int i = 0; i < 8; i++) {
        vec2 rest = turn[i] - t.curvature * way[i];
        t.bump += usable[i] * dot(rest, rest);
    }
    t.bump /= max(count, 1.0);
}

Tracking find_tracking(ivec2 pixel, vec3 normal, float roughness)
{
    Tracking t;
    ivec2 local = ivec2(gl_LocalInvocationID.xy) + 1;
    vec4 center = s_surface[local.x + SIDE * local.y];
    vec3 position = view_position(pixel_uv(pixel), center.w, g.frustum, g.orthographic);
    float own = s_tracked[local.x + SIDE * local.y], nearest = own < 0.0 ? 2.0 : own, second = 2.0, sum = max(own, 0.0), squares = sum * sum, count = own < 0.0 ? 0.0 : 1.0;
    float tolerance = plane_tolerance(g.plane_distance_sensitivity, center.w);
    vec2 way[8], turn[8];
    float usable[8];
    make_tangents(normal, t.tangent, t.bitangent);
    for (int i = 0; i < 8; i++) {
        ivec2 offset = ivec2((i + i / 4) % 3, (i + i / 4) / 3) - 1;   /* 4 is the centre */
        int cell = local.x + offset.x + SIDE * (local.y + offset.y);
        vec4 tap = s_surface[cell];
        vec3 step_ws = mat3(g.view_to_world) * (view_position(pixel_uv(pixel + offset), tap.w, g.frustum, g.orthographic) - position);
        bool near = tap.w > 0.0 && abs(dot(normal, step_ws)) < tolerance;
        usable[i] = near ? 1.0 : 0.0;
        way[i] = vec2(dot(t.tangent, step_ws), dot(t.bitangent, step_ws));
        turn[i] = vec2(dot(t.tangent, tap.xyz - normal), dot(t.bitangent, tap.xyz - normal));
        float q = s_tracked[cell];
        if (!near || q < 0.0) continue;
        second = min(second, max(nearest, q));
        nearest = min(nearest, q);
        sum += q;
        squares += q * q;
        count += 1.0;
    }
    if (second <= 1.0) nearest = second;   /* one stray sample of nine says nothing */
    nearest = nearest > 1.0 ? 0.0 : nearest;
    float alpha = max(roughness * roughness, 1e-4), mean = sum / max(count, 1.0);
    float footprint = lobe_footprint(alpha, nearest, center.w, pixel_uv(pixel));
    t.q = own < 0.0 ? nearest : mix(own, nearest, clamp(footprint / 0.5, 0.0, 1.0));
    t.sigma = sqrt(max(squares / max(count, 1.0) - mean * mean, 0.0));
    fit_curvature(t, way, turn, usable);
    return t;
}

/* Towards the dominant direction of a GGX lobe, [0,1]: 1 is the mirror's. Fit of S. Lagarde, "Moving Frostbite to PBR", 2014, refined. */
float dominant_factor(float n_dot_v, float roughness)
{
    float q = 0.298475 * log(39.4115 - 39.0029 * roughness);
    return clamp(q + (1.0 - q) * pow(1.0 - n_dot_v, 10.8649), 0.0, 1.0);
}

vec3 to_world(vec3 position_prev_vs) { return (position_prev_vs - g.world_to_view_prev[3].xyz) * mat3(g.world_to_view_prev); }

/* The move along the tangent plane (t, b of the result's world space) after which a surface point mirrors `target` into the previous camera. */
vec3 newton_step(vec3 point, vec3 normal, vec3 target, Tracking t, mat2 curvature, out bool regular)
{
    vec3 camera = -g.world_to_view_prev[3].xyz * mat3(g.world_to_view_prev), forward = vec3(0.0, 0.0, 1.0) * mat3(g.world_to_view_prev);
    vec3 to_camera = camera - point, to_target = target - point;
    float flat_view = g.orthographic_prev, distance = length(to_camera), hit = max(length(to_target), 1e-6);
    vec3 v = flat_view > 0.5 ? -forward : to_camera / max(distance, 1e-6), l = to_target / hit;
    vec3 tangent = normalize(t.tangent - normal * dot(normal, t.tangent)), bitangent = cross(normal, tangent);
    vec2 side = vec2(dot(tangent, v), dot(bitangent, v)), rest = side + vec2(dot(tangent, l), dot(bitangent, l));
    float bend = (flat_view > 0.5 ? 0.0 : 1.0 / max(distance, 1e-6)) + 1.0 / hit;
    mat2 plane = bend * (mat2(1.0) - outerProduct(side, side));
    mat2 a = plane + 2.0 * abs(dot(normal, v)) * curvature;
    regular = abs(determinant(a)) >= 0.1 * determinant(plane);
    vec2 move = inverse(regular ? a : plane) * rest;
    return tangent * move.x + bitangent * move.y;
}

vec3 mean_normal(Footprint f, vec3 otherwise)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; i++)
        if (f.weights[i] > 0.0) sum += f.weights[i] * normalize(guide_fine_direction(uvec2(f.guides[i], f.seconds[i])));
    return dot(sum, sum) > 1e-6 ? normalize(sum) : otherwise;
}

/* The point that is mirrored, world. */
vec3 mirrored_point(vec3 position_vs, vec3 normal, float roughness, float q)
{
    vec3 point = mat3(g.view_to_world) * position_vs, forward = mat3(g.view_to_world) * vec3(0.0, 0.0, 1.0);
    vec3 view = g.orthographic > 0.5 ? forward : normalize(point);
    float distance = mix(length(position_vs), position_vs.z, g.orthographic), hit = min(q / max(1.0 - q, 1e-5), 1e5) * distance;
    return point + reflect(view, normal) * hit * dominant_factor(abs(dot(view, normal)), roughness);
}

VirtualMotion find_virtual_motion(vec3 target, Reprojection r, Footprint f, vec3 normal, Tracking t)
{
    VirtualMotion m;
    bool smooth_surface = t.bump < BUMPY, regular;
    vec3 start = to_world(r.position);
    float mean_curvature = 0.5 * (t.curvature[0][0] + t.curvature[1][1]);
    mat2 curvature = smooth_surface ? t.curvature : mat2(mean_curvature, 0.0, 0.0, mean_curvature);
    m.normal = smooth_surface ? mean_normal(f, normal) : normal;
    vec3 move = newton_step(start, m.normal, target, t, curvature, regular);
    m.position = (g.world_to_view_prev * vec4(start + move, 1.0)).xyz;
    m.uv = project_prev(m.position);
    vec2 way = vec2(dot(t.tangent, move), dot(t.bitangent, move));
    m.bow = 0.5 * abs(dot(way, curvature * way));
    m.error = regular && all(lessThan(abs(m.uv - 0.5), vec2(0.5))) ? 0.0 : -1.0;
    return m;
}

/* Position of the previous frame's surface in the middle of a footprint, previous view space. */
vec3 footprint_position(Footprint f, vec2 uv)
{
    float z = 0.0, sum = 0.0;
    for (int i = 0; i < 4; i++) {
        if (!(f.weights[i] > 0.0)) continue;
        z += f.weights[i] * guide_relative_depth(f.guides[i]);
        sum += f.weights[i];
    }
    return view_position(uv, z / max(sum, 1e-6) * g.denoising_range_prev, g.frustum_prev, g.orthographic_prev);
}

/* How far, in pixels, a second step from there would go: the first one's error. */
float remaining_step(Footprint f, VirtualMotion m, vec3 target, Tracking t)
{
    bool regular;
    vec3 point = to_world(footprint_position(f, m.uv));
    vec3 move = newton_step(point, mean_normal(f, m.normal), target, t, t.curvature, regular);
    vec2 uv = project_prev((g.world_to_view_prev * vec4(point + move, 1.0)).xyz);
    return regular ? min(length((uv - m.uv) * size_prev_px()), 1e3) : 0.0;
}

vec4 roughness_agreement(Footprint f, float roughness)
{
    vec4 w;
    for (int i = 0; i < 4; i++) w[i] = clamp(1.5 - abs(guide_roughness(uvec2(f.guides[i], f.seconds[i])) - roughness) / (0.02 + 0.1 * roughness), 0.0, 1.0);
    return w;
}

/* Texels that tracked something else show another reflection; matters as far as the reflection moves apart from the surface. */
vec4 tracking_agreement(Footprint f, Tracking t, float travel_px)
{
    uvec4 tracks = gather_tracks_at(SPECULAR_SIGNAL, f.seconds, f.corner_uv);
    float tolerance = 0.05 + 0.5 * t.sigma;
    vec4 w;
    for (int i = 0; i < 4; i++) {
        float d = (unpack_track(tracks[i]).hit_dist - t.q) / tolerance;
        w[i] = exp2(-LOG2_E * d * d * clamp(travel_px, 0.0, 1.0));
    }
    return w;
}

float square(float x) { return x * x; }

/* The length that a history may have whose samples lie `shift` pixels apart per frame from where they should, under a footprint. */
float limit_frames(float frames, float shift, float footprint)
{
    return min(frames, max(g.max_accumulated_frames, 1.0) / (1.0 + PARALLAX_FALLOFF * square(shift / footprint)));
}

History mix_histories(History a, History b, float amount)
{
    History h = no_history();
    h.color = mix(a.color, b.color, amount);
    h.frames = mix(a.frames, b.frames, amount);
    h.hit_dist = mix(a.hit_dist, b.hit_dist, amount);
    h.stabilized = mix(a.stabilized, b.stabilized, amount);
    return h;
}

History find_specular_history(ivec2 pixel, float z, Reprojection r, Footprint f, nrd_surface surface, Tracking t, out vec2 uv_history)
{
    float alpha = max(surface.roughness * surface.roughness, 1e-4);
    vec2 uv = pixel_uv(pixel);
    vec3 position = view_position(uv, z, g.frustum, g.orthographic);
    vec3 target = mirrored_point(position, normalize(guide_fine_direction(uvec2(guide_pack(z, surface.normal, 0u), guide_pack_fine(surface.normal)))), surface.roughness, t.q);
    VirtualMotion m = find_virtual_motion(target, r, f, surface.normal, t);
    float travel = min(length((m.uv - r.uv) * size_prev_px()), 1e3);
    f.weights *= roughness_agreement(f, surface.roughness);
    History still = fetch_history(f, f.weights, SPECULAR_SIGNAL, surface.normal), virtual = no_history();
    if (m.error >= 0.0 && !is_reset()) {
        Footprint fv = fetch_footprint(m.uv);
        weigh_surface(fv, m.position, m.normal, surface.material_id, r.tolerance + m.bow);
        if (t.bump < BUMPY) m.error = remaining_step(fv, m, target, t);
        fv.weights *= roughness_agreement(fv, surface.roughness) * tracking_agreement(fv, t, travel);
        virtual = fetch_history(fv, fv.weights, SPECULAR_SIGNAL, m.normal);
    }
    float footprint = lobe_footprint(alpha, t.q, z, uv);
    still.frames = min(still.frames, bend_limit(still, max(alpha * alpha, NARROWEST_LOBE)));
    virtual.frames = min(virtual.frames, bend_limit(virtual, max(alpha * alpha, NARROWEST_LOBE)));
    still.frames = limit_frames(still.frames, travel, 0.5 * max(footprint, LEAST_FOOTPRINT));
    virtual.frames = limit_frames(virtual.frames, travel * min(t.sigma / max(t.q, 1e-4), 1.0), max(footprint, LEAST_FOOTPRINT));
    virtual.frames /= 1.0 + 0.1 * virtual.frames * square(m.error / max(footprint, 0.5));
    float amount = clamp(1.0 + (virtual.frames - still.frames) / (1.0 + 0.5 * max(virtual.frames, still.frames)), 0.0, 1.0);
    uv_history = mix(r.uv, m.error < 0.0 ? r.uv : m.uv, amount);
    return mix_histories(still, virtual, amount);
}

#endif
