/* Which signals a pass works on: built with -DDIFFUSE, -DSPECULAR or both. Arrays over signals have diffuse first. */
#ifndef SIGNALS_GLSL
#define SIGNALS_GLSL

#if defined(DIFFUSE) && defined(SPECULAR)
const int SIGNALS = 2;
#else
const int SIGNALS = 1;
#endif
#ifdef SPECULAR
const int SPECULAR_SIGNAL = SIGNALS - 1;
#else
const int SPECULAR_SIGNAL = -1;
#endif

/* Code for the textures of one signal. */
#if defined(DIFFUSE) && defined(SPECULAR)
#define OF_SIGNAL(s, diffuse, specular) if (s == SPECULAR_SIGNAL) { specular; } else { diffuse; }
#elif defined(DIFFUSE)
#define OF_SIGNAL(s, diffuse, specular) diffuse;
#else
#define OF_SIGNAL(s, diffuse, specular) specular;
#endif

/* The track of a signal, and what the specular signal tracks; the pass binds in_track. */
#ifdef SPECULAR
#define TRACK_WORD(pixel, guide, s) texelFetch(in_track, pixel, 0)[s]
#define TRACKED(pixel) unpack_track(texelFetch(in_track, pixel, 0)[SPECULAR_SIGNAL]).hit_dist
#else
#define TRACK_WORD(pixel, guide, s) (guide).y
#define TRACKED(pixel) 0.0
#endif

/* History lengths and tracks. Diffuse alone: in the guide (common/guide.glsl). With specular the tracks are in a texture of their own, one word a
   signal, and the lengths in the guide's first word.
   A track: bits 8-15 hit distance, 16-31 stabilised luma of the previous frame, reprojected. */
struct Track {
    float hit_dist;    /* diffuse: normalised; specular: hit distance / (hit distance + distance to the camera) */
    float stabilized;
};

/* random: [0, 1), decides the rounding of the hit distance, so that its average survives 8 bits. */
uint pack_track(Track t, float random)
{
    uint hit_dist = uint(clamp(t.hit_dist * 255.0 + random, 0.0, 255.0));
    return (hit_dist << 8) | (packHalf2x16(round_half(vec4(0.0, t.stabilized, 0.0, 0.0)).xy) & 0xffff0000u);
}

Track unpack_track(uint t) { return Track(float((t >> 8) & 255u) / 255.0, unpackHalf2x16(t).y); }

/* History lengths in quarter frames, [0, 63.75]. */
uint pack_frames(float frames) { return uint(clamp(frames, 0.0, 63.75) * 4.0 + 0.5); }
float unpack_frames(uint code) { return float(code & 255u) * 0.25; }
#ifdef SPECULAR
float guide_frames(uvec2 guide, int signal) { return unpack_frames(guide.x >> (16 + 8 * signal)); }
#else
float guide_frames(uvec2 guide, int signal) { return unpack_frames(guide.y); }
#endif

/* Surfaces that are too rough for a specular signal have none of its frames; where there is no other signal, they are marked as sky. What is not to
   happen for that signal follows IF_HEARD. IF_WORTH_IT is for what would do no harm: with SH, whose passes are large, such branches cost a
   twentieth of the time even where the compiler can tell that they are never taken. */
#if defined(DIFFUSE) && defined(SPECULAR)
bool is_silent(uvec2 guide) { return HAS_ROUGHNESS_LIMIT && guide.x < 0x1000000u; }
bool silent;               /* of this invocation's pixel */
#define IF_HEARD(s) if (s != SPECULAR_SIGNAL || !silent)
#define IF_SILENT(guide, s) if (s == SPECULAR_SIGNAL && is_silent(guide))   /* of any pixel */
#define HEAR(guide) silent = is_silent(guide)
#else
bool is_silent(uvec2 guide) { return false; }
#define IF_SILENT(guide, s) if (false)
#define IF_HEARD(s)
#define HEAR(guide)
#endif
#ifdef SH
#define IF_WORTH_IT(s)
#else
#define IF_WORTH_IT(s) IF_HEARD(s)
#endif

/* Roughness times 255 / 256, and 1. */
float guide_roughness_point(uvec2 guide) { return uintBitsToFloat(((guide.y >> 7) & 0x7f8000u) | 0x3f800000u); }
float guide_roughness(uvec2 guide) { return guide_roughness_point(guide) * (256.0 / 255.0) - 256.0 / 255.0; }

float distance_to_camera(vec2 uv, float z) { return mix(length(view_position(uv, z, g.frustum, g.orthographic)), z, g.orthographic); }

/* Width in pixels of what a specular lobe sees: alpha * hit / (hit + distance) / angle of a pixel. Every tolerance of the specular signal
   is a multiple of it. tracked: Track.hit_dist. */
float lobe_footprint(float alpha, float tracked, float z, vec2 uv)
{
    float reach = distance_to_camera(uv, z) * (g.orthographic > 0.5 ? tracked / max(1.0 - tracked, 1e-3) : tracked);
    return alpha * reach / pixel_size(z);
}

#endif
