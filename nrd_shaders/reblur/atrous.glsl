/* One sparse step of the edge-avoiding wavelet filter over (Y, Co, Cg, deviation of Y). The includer defines
   vec4 load_color(int signal, ivec2 pixel) and bool CROSS, and binds in_guide. CROSS: 4 taps along the axes (in noise, at random, along
   the diagonals) instead of 8, for the step after the dense one: the later, full steps hide its pattern (two such steps in a row show a
   plaid), and it costs half. In performance mode all steps are such, the middle one turned against the others: no plaid is left.
   Where light comes from (light.glsl) stays as the dense step has left it: averaging it here too takes a quarter of the time of SH, for
   3 to 9 % less error on bumpy surfaces. */
#ifndef ATROUS_GLSL
#define ATROUS_GLSL

struct AtrousSums {         /* of the neighbours */
    vec3 color;
    float weight;
    float noise;             /* sum of weight^2 * variance */
    float around;            /* sum of the weights, the centre's among them, were all lumas alike */
    float luma, luma_scale;  /* of the centre, times the scale that makes squared differences comparable with variances */
    float least;             /* the centre's variance, and the least that tells lumas apart */
};

/* What the centre's variance counts for, the neighbour's being 1. With 1 the picture gets brighter where noise is skewed (moving reflections: by 2.1 %
   for 1.9), with more bright pixels lose light to nobody. */
const float OWN_DOUBT = 1.4;

AtrousSums start_sums(vec4 color)
{
    AtrousSums s;
    s.color = vec3(0.0);
    s.weight = s.noise = 0.0;
    s.around = 1.0;
    s.luma_scale = 0.8408964 / g.luminance_sigma_scale;
    s.luma = s.luma_scale * color.x;
    s.least = OWN_DOUBT * color.w * color.w + 1e-12 * color.x * color.x + 1e-24;
    return s;
}

/* Two pixels give each other the same share of their difference, so that no light is lost: both pixels' variances count, and lumas that differ take
   nothing off the sum that weights are divided by; the centre keeps what it does not give. Divided by what is left after lumas, a bright
   pixel among dark ones would give more than they take.
   Luma counts as (1 + x / sqrt(2))^-2, x the squared difference over its variance and luminance_sigma_scale^2: about exp(-sqrt(2) x), without a
   sudden end. Powers of 1 and 4 and exp itself were tried: errors within 1 %. */
void add_tap(inout AtrousSums s, vec4 tap, float factor, float exponent)
{
    float variance = tap.w * tap.w + s.least, off = s.luma - s.luma_scale * tap.x, alike = variance / (variance + off * off);
    float around = factor * exp2(exponent), w = around * alike * alike;
    if (!(w > 0.0)) return;   /* what is not usable may hold NaN */
    s.around += around;
    s.color += w * tap.xyz;
    s.noise += (w * tap.w) * (w * tap.w);
    s.weight += w;
}

vec4 finish_sums(AtrousSums s, vec4 color)
{
    float own = s.around - s.weight;
    return vec4(s.color + own * color.xyz, sqrt(s.noise + own * own * color.w * color.w)) / s.around;
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
    float w = plane_weight(c, n, guide) * kernel_weight, bend = guide_bend(guide_point(guide), c.normal), normal_scale = -LOG2_E * g.normal_sensitivity;
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_HEARD(s) {
        vec4 tap = load_color(s, n.pixel);
        add_tap(sums[s], tap, w * lobe_factor(c, s, guide), lobe_exponent(c, s, normal_scale, bend, n.squared));
    }
}

void atrous(Center c, inout vec4 color[SIGNALS])
{
    AtrousSums sums[SIGNALS];
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_HEARD(s) sums[s] = start_sums(color[s]);
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
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_HEARD(s) color[s] = finish_sums(sums[s], color[s]);
}

#endif
