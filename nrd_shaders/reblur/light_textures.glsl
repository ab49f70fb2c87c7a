/* Binds the lights of the spatial passes from binding SH_FIRST on: with SH_FROM_OUT read from OUT_..._SH1 and written packed, else the reverse.
   Packed, one texel holds those of both signals. */
#ifndef LIGHT_TEXTURES_GLSL
#define LIGHT_TEXTURES_GLSL
#ifdef SH

#if defined(DIFFUSE) && defined(SPECULAR)
#define WORDS_FORMAT rg32ui
#else
#define WORDS_FORMAT r32ui
#endif

#ifdef SH_FROM_OUT
#ifdef DIFFUSE
layout(binding = SH_FIRST) uniform sampler2D in_diff_light;
#endif
#ifdef SPECULAR
layout(binding = SH_FIRST + HAS_DIFFUSE) uniform sampler2D in_spec_light;
#endif
layout(binding = SH_FIRST + HAS_DIFFUSE + HAS_SPECULAR, WORDS_FORMAT) uniform writeonly uimage2D out_lights;

vec4 load_light(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(in_diff_light, p, 0), return texelFetch(in_spec_light, p, 0)) }

void load_lights(ivec2 p, out vec4 light[SIGNALS]) { UNROLL for (int s = 0; s < SIGNALS; s++) light[s] = load_light(s, p); }

void store_lights(ivec2 p)
{
    uvec4 words = uvec4(0u);
    UNROLL for (int s = 0; s < SIGNALS; s++) words[s] = pack_light(lights[s]);
    imageStore(out_lights, p, words);
}
#else
layout(binding = SH_FIRST) uniform usampler2D in_lights;
#ifdef DIFFUSE
layout(binding = SH_FIRST + 1, rgba16f) uniform writeonly image2D out_diff_light;
#endif
#ifdef SPECULAR
layout(binding = SH_FIRST + 1 + HAS_DIFFUSE, rgba16f) uniform writeonly image2D out_spec_light;
#endif

void load_lights(ivec2 p, out vec4 light[SIGNALS])
{
    uvec4 words = texelFetch(in_lights, p, 0);
    UNROLL for (int s = 0; s < SIGNALS; s++) light[s] = unpack_light(words[s]);
}

void store_light(int s, ivec2 p, vec4 light) { vec4 v = round_half(light); OF_SIGNAL(s, imageStore(out_diff_light, p, v), imageStore(out_spec_light, p, v)) }

void store_lights(ivec2 p) { UNROLL for (int s = 0; s < SIGNALS; s++) IF_HEARD(s) store_light(s, p, lights[s]); }
#endif

#endif
#endif
