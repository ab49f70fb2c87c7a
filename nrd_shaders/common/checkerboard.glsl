/* Checkerboarded noisy inputs: half as wide, they hold the pixels of one colour (nrd_checkerboard_color), at (x / 2, y). */
#ifndef CHECKERBOARD_GLSL
#define CHECKERBOARD_GLSL

const int DIFFUSE_LOBE = 0;
const int SPECULAR_LOBE = 1;

/* Bits of a lobe: it is checkerboarded, and of colour 1. Those of the specular lobe follow those of the diffuse one. */
bool is_checkerboarded(int lobe) { return (SPEC_FEATURES & NRD_FEATURE_CHECKERBOARD) != 0 && has_flag(NRD_FLAG_DIFFUSE_CHECKERBOARD << (2 * lobe)); }

bool is_traced(ivec2 pixel, int lobe)
{
    uint color = has_flag(NRD_FLAG_DIFFUSE_WHITE << (2 * lobe)) ? 1u : 0u;
    return !is_checkerboarded(lobe) || nrd_checkerboard_color(uint(pixel.x), uint(pixel.y), g.frame_index) == color;
}

/* Where the input holds a pixel, or the other one of its pair. */
ivec2 noisy_texel(ivec2 pixel, int lobe) { return is_checkerboarded(lobe) ? ivec2(pixel.x >> 1, pixel.y) : pixel; }

/* What the pixels to the left and to the right, which are traced, count for one that is not. Across an edge nothing is taken, unless both
   lie there: a guess is better than black. */
vec2 side_weights(ivec2 pixel, float z, sampler2D view_z)
{
    vec2 weights;
    for (int i = 0; i < 2; i++) {
        ivec2 at = pixel + ivec2(2 * i - 1, 0);
        float z_at = texelFetch(view_z, clamp(at, ivec2(0), rect_size() - 1) + rect_origin(), 0).x * g.view_z_scale;
        bool inside = at.x >= 0 && at.x < rect_size().x && !is_sky(z_at);
        weights[i] = !inside ? 0.0 : abs(abs(z_at) - z) <= 0.02 * z ? 1.0 : 1e-3;
    }
    return weights / max(weights.x + weights.y, 1e-6);
}

/* Where the input holds the pixel to the left (side -1) or to the right (1) of one that is not traced. */
ivec2 side_texel(ivec2 pixel, int side, int lobe) { return noisy_texel(ivec2(clamp(pixel.x + side, 0, rect_size().x - 1), pixel.y), lobe); }

#endif
