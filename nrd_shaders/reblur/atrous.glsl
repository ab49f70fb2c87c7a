/* One sparse step of the edge-avoiding wavelet filter over (Y, Co, Cg, deviation of Y). The includer defines
   vec4 load_color(int signal, ivec2 pixel) and bool CROSS, and binds in_guide; with SH it includes light_textures.glsl. CROSS: 4 taps along the axes (in noise, at random, along
   the diagonals) instead of 8, for the step after the dense one: the later, full steps hide its pattern (two such steps in a row show a
   plaid), and it costs half. In performance mode all steps are such, the middle one turned against the others: no plaid is left. */
#ifndef ATROUS_GLSL
#define ATROUS_GLSL

struct AtrousSums {
    vec3 color;
    float weight;
    float noise;             /* sum of weight^2 * variance */
    float luma, least;       /* of the centre; its variance, and the least that tells lumas apart */
#ifdef SH
    LightSums light;
#endif
};

AtrousSums start_sums(vec4 color)
{
    AtrousSums s;
    s.color = color.xyz;
    s.weight = 1.0;
    s.noise = color.w * color.w;
    s.luma = color.x;
    s.least = s.noise + 1e-12 * color.x * color.x + 1e-24;
    return s;
}

/* Both pixels' variances count: with the centre's alone dark pixels reject bright ones more than the reverse, and the picture darkens. */
/* Returns the weight. */
float add_tap(inout AtrousSums s, vec4 tap, float factor, float exponent)
{
    float tap_variance = tap.w * tap.w;
    float luma = abs(s.luma - tap.x) * inversesqrt(tap_variance + s.least);
    float w = factor * exp2(exponent - LOG2_E * 1.4142136 / g.luminance_sigma_scale * luma);
    if (!(w > 0.0)) return 0.0;   /* what is not usable may hold NaN */
    s.color += w * tap.xyz;
    s.noise += w * w * tap_variance;
    s.weight += w;
    return w;
}

/* Relative deviation from which on the cross is turned at random: what it leaves behind in noise is a weave. */
const float WEAVING = 0.4;

/* Of the 4 taps of a step that has 8 otherwise: 0.75 to 1.6 tried: more loses detail where there is little noise, less leaves more of it. */
const float LONE_WEIGHT = 1.0;

bool is_turned(ivec2 pixel, vec4 color[SIGNALS])
{
    bool noisy = false;
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_HEARD(s) noisy = noisy || color[s].w > WEAVING * color[s].x;
    return noisy && (hash(uint(pixel.x), uint(pixel.y), g.frame_index) & 1u) != 0u;
}

void add_neighbour(Center c, Neighbour n, float kernel_weight, inout AtrousSums sums[SIGNALS])
{
    uvec2 guide = texelFetch(in_guide, n.pixel, 0).xy;
    float w = plane_weight(c, n, guide.x) * kernel_weight, bend = normal_bend(c, guide), normal_scale = -LOG2_E * g.normal_sensitivity;
    SH_ONLY(vec4 light[SIGNALS]; load_lights(n.pixel, light);)
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_WORTH_IT(s) {
        vec4 tap = load_color(s, n.pixel);
        float added = add_tap(sums[s], tap, w * lobe_factor(c, s, guide), lobe_exponent(c, s, normal_scale, bend, n.squared));
        SH_ONLY(if (added > 0.0) add_light(sums[s].light, light[s], tap.x, guide_tap_normal(guide), added);)
    }
}

void atrous(Center c, inout vec4 color[SIGNALS])
{
    AtrousSums sums[SIGNALS];
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_WORTH_IT(s) {
        sums[s] = start_sums(color[s]);
        SH_ONLY(sums[s].light = no_light(); add_light(sums[s].light, lights[s], color[s].x, c.normal_vs, 1.0);)
    }
    if (CROSS || has_flag(NRD_FLAG_PERFORMANCE)) {
        bool turned = is_turned(c.pixel, color) != (SPEC_ITERATION == 2u);
        UNROLL for (int i = 0; i < 4; i++) {
            const ivec2 axes[4] = ivec2[4](ivec2(1, 0), ivec2(0, 1), ivec2(-1, 0), ivec2(0, -1));
            const ivec2 diagonals[4] = ivec2[4](ivec2(1, 1), ivec2(-1, 1), ivec2(-1, -1), ivec2(1, -1));
            add_neighbour(c, find_neighbour(c, turned ? diagonals[i] : axes[i]), CROSS ? 0.75 : LONE_WEIGHT, sums);
        }
    } else {
        UNROLL for (int i = 0; i < 9; i++) {
            ivec2 grid = ivec2(i % 3, i / 3) - 1;
            if (i != 4) add_neighbour(c, find_neighbour(c, grid), kernel(grid), sums);
        }
    }
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_WORTH_IT(s) {
        color[s] = vec4(sums[s].color, sqrt(sums[s].noise)) / sums[s].weight;
        SH_ONLY(lights[s] = finish_light(sums[s].light, c.receiver, s, mat3(g.view_to_world) * sums[s].light.normal / sums[s].weight, sums[s].color.x, FILTERED_SAMPLES * c.frames[s] * sums[s].weight);)
    }
}

#endif
