// Procedural textures: a pattern in [0, 1] that mixes the two colours and roughnesses of a material.

#ifndef TRACER_TEXTURE_GLSL
#define TRACER_TEXTURE_GLSL

#include "data.glsl"
#include "sampling.glsl"

// Hash of a lattice cell in [0, 1).
PT_FN float pt_cell(float x, float y)
{
    uint a = TO_UINT(floor(x) + 32768.0f);
    uint b = TO_UINT(floor(y) + 32768.0f);
    return pt_unit(pt_hash_combine(a, b));
}

PT_FN float pt_value_noise(float x, float y)
{
    float fx = fract(x);
    float fy = fract(y);
    fx = fx * fx * (3.0f - 2.0f * fx);
    fy = fy * fy * (3.0f - 2.0f * fy);
    float bottom = lerp1(pt_cell(x, y), pt_cell(x + 1.0f, y), fx);
    float top = lerp1(pt_cell(x, y + 1.0f), pt_cell(x + 1.0f, y + 1.0f), fx);
    return lerp1(bottom, top, fy);
}

PT_FN float pt_fractal_noise(float x, float y)
{
    float sum = 0.0f;
    float weight = 0.5f;
    for (int octave = 0; octave < 4; octave++) {
        sum += weight * pt_value_noise(x, y);
        x = x * 2.03f + 17.1f;
        y = y * 2.03f + 31.7f;
        weight *= 0.5f;
    }
    return sum * (1.0f / 0.9375f);
}

// 1 in the joints of a grid of cells with the given joint width (in cells), 0 inside, with soft shoulders.
PT_FN float pt_joint(float x, float y, float width)
{
    float dx = min(fract(x), 1.0f - fract(x));
    float dy = min(fract(y), 1.0f - fract(y));
    return 1.0f - smoothstep(width * 0.6f, width, min(dx, dy));
}

PT_FN float pt_brick(float u, float v)
{
    float row = floor(v * 2.0f);
    float x = u + 0.5f * fract(row * 0.5f) * 2.0f;
    float dx = min(fract(x), 1.0f - fract(x));
    float dy = min(fract(v * 2.0f), 1.0f - fract(v * 2.0f)) * 0.5f;
    float mortar = 1.0f - smoothstep(0.02f, 0.04f, min(dx, dy));
    return max(mortar, 0.45f * pt_cell(x, v * 2.0f));
}

PT_FN float pt_wood(float u, float v)
{
    float plank = floor(v * 4.0f);
    float shift = pt_cell(plank, 3.0f) * 19.0f;
    float grain = pt_fractal_noise(u * 1.5f + shift, v * 28.0f + shift);
    float seam = 1.0f - smoothstep(0.01f, 0.03f, min(fract(v * 4.0f), 1.0f - fract(v * 4.0f)));
    return max(seam, clamp(0.65f * grain + 0.35f * pt_cell(plank, 7.0f), 0.0f, 1.0f));
}

PT_FN float pt_pattern(uint kind, float u, float v)
{
    if (kind == PT_TEXTURE_CHECKER) return fract((floor(u) + floor(v)) * 0.5f) * 2.0f;
    if (kind == PT_TEXTURE_BRICK) return pt_brick(u, v);
    if (kind == PT_TEXTURE_NOISE) return pt_fractal_noise(u, v);
    if (kind == PT_TEXTURE_WOOD) return pt_wood(u, v);
    if (kind == PT_TEXTURE_TILES) return max(pt_joint(u, v, 0.03f), 0.25f * pt_cell(u, v));
    if (kind == PT_TEXTURE_STRIPES) return smoothstep(0.45f, 0.55f, abs1(fract(u) * 2.0f - 1.0f));
    return 0.0f;
}

#endif
