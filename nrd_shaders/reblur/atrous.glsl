/* One sparse step of the edge-avoiding wavelet filter over (Y, Co, Cg, deviation of Y). The includer defines
   vec4 load_color(ivec2 pixel) and bool CROSS, and binds in_guide. CROSS: 4 taps along the axes instead of 8, for the step after the
   dense one: the later, full steps hide its pattern (two such steps in a row show a plaid), and it costs half. */
#ifndef ATROUS_GLSL
#define ATROUS_GLSL

/* Both pixels' variances count: with the centre's alone dark pixels reject bright ones more than the reverse, and the picture darkens. */
vec4 atrous(Center c, vec4 color)
{
    vec3 sum = color.xyz;
    float weight = 1.0, variance = color.w * color.w, noise = variance;
    float normal_scale = -LOG2_E * g.normal_sensitivity, luma_scale = -LOG2_E * 1.4142136 / g.luminance_sigma_scale;
    float least = 1e-12 * color.x * color.x + 1e-24;
    for (int i = 0; i < 9; i++) {
        if (i == 4 || (CROSS && (i & 1) == 0)) continue;
        ivec2 grid = ivec2(i % 3, i / 3) - 1;
        Neighbour n = find_neighbour(c, grid);
        uint code = texelFetch(in_guide, n.pixel, 0).x;
        vec4 neighbour = load_color(n.pixel);
        float neighbour_variance = neighbour.w * neighbour.w;
        float luma = abs(color.x - neighbour.x) * inversesqrt(variance + neighbour_variance + least);
        float w = plane_weight(c, n, code) * (CROSS ? 0.75 : kernel(grid)) * exp2(normal_scale * guide_bend(code, c.normal) + luma_scale * luma);
        if (!(w > 0.0)) continue;   /* what is not usable may hold NaN */
        sum += w * neighbour.xyz;
        noise += w * w * neighbour_variance;
        weight += w;
    }
    return vec4(sum, sqrt(noise)) / weight;
}

#endif
