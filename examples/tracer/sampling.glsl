// Random numbers: padded pairs of the Sobol sequence, shuffled and Owen-scrambled by hashes (Burley, "Practical
// Hash-based Owen Scrambling", JCGT 9(4), 2020). A pair depends on (seed, index, dimension) alone, so frames repeat bit
// for bit.

#ifndef TRACER_SAMPLING_GLSL
#define TRACER_SAMPLING_GLSL

#include "lang.glsl"

#define PT_PI 3.14159265f

PT_STRUCT(pt_rng)
{
    uint seed;  // of the pixel and frame
    uint index; // of the sample in the pixel
};

// PCG-RXS-M-XS output function on one LCG step (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3),
// 2020).
PT_FN uint pt_hash(uint x)
{
    uint state = x * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

PT_FN uint pt_hash_combine(uint a, uint b) { return pt_hash(a ^ pt_hash(b)); }

// Owen scramble, of a number whose bits are reversed (the Laine-Karras permutation).
PT_FN uint pt_scramble_reversed(uint x, uint seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

// Second dimension of the Sobol sequence, bits reversed; the first one is the index itself, bits reversed. Its matrix
// is Pascal's triangle mod 2, whose entry (j, k) is 1 where the bits of j are among those of k: sums over supersets.
PT_FN uint pt_sobol1_reversed(uint x)
{
    x ^= (x >> 1) & 0x55555555u;
    x ^= (x >> 2) & 0x33333333u;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 8) & 0x00ff00ffu;
    return x ^ ((x >> 16) & 0x0000ffffu);
}

PT_FN float pt_unit(uint x) { return TO_FLOAT(x >> 8) * (1.0f / 16777216.0f); }

// Two numbers in [0, 1) for one decision of a path; `pair` names the decision.
PT_FN vec2 pt_random2(pt_rng rng, uint pair)
{
    uint seed = pt_hash_combine(rng.seed, pair);
    uint index = bitfieldReverse(pt_scramble_reversed(bitfieldReverse(rng.index), seed));
    uint x = pt_scramble_reversed(index, pt_hash(seed ^ 0x68bc21ebu));
    uint y = pt_scramble_reversed(pt_sobol1_reversed(index), pt_hash(seed ^ 0x02e5be93u));
    return vec2(pt_unit(bitfieldReverse(x)), pt_unit(bitfieldReverse(y)));
}

PT_FN vec3 pt_tangent(vec3 n)
{
    // Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
    float s = n[2] < 0.0f ? -1.0f : 1.0f;
    float a = -1.0f / (s + n[2]);
    return vec3(1.0f + s * n[0] * n[0] * a, s * n[0] * n[1] * a, -s * n[0]);
}

// The vector with components (x, y, z) along (tangent, cross(n, tangent), n).
PT_FN vec3 pt_from_frame(vec3 n, float x, float y, float z)
{
    vec3 t = pt_tangent(n);
    return t * x + cross(n, t) * y + n * z;
}

PT_FN vec3 pt_cosine_direction(vec3 n, vec2 u)
{
    float r = sqrt(u[0]);
    float phi = 2.0f * PT_PI * u[1];
    return pt_from_frame(n, r * cos(phi), r * sin(phi), sqrt(max(1.0f - u[0], 0.0f)));
}

// Uniform over the disk of directions within atan(tan_radius) of `axis`.
PT_FN vec3 pt_disk_direction(vec3 axis, float tan_radius, vec2 u)
{
    float r = tan_radius * sqrt(u[0]);
    float phi = 2.0f * PT_PI * u[1];
    return normalize(pt_from_frame(axis, r * cos(phi), r * sin(phi), 1.0f));
}

PT_FN float pt_power_heuristic(float a, float b) { return a * a / max(a * a + b * b, 1e-30f); }

#endif
