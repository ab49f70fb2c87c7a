/* The rays of a tile and around it, in shared memory. */
#ifndef NEIGHBORHOOD_GLSL
#define NEIGHBORHOOD_GLSL

const int REACH = 4;                     /* px that rays are looked at around a pixel */
const int SIDE = 8 + 2 * REACH;
const uint QUADS = uint(SIDE / 2);

shared vec2 s_ray[SIDE * SIDE];          /* nearness() with the sign of view z, or NO_NEIGHBOR; narrowness_of() */
shared float s_width[SIDE * SIDE];       /* width_of() */
#ifdef TRANSLUCENCY
shared uint s_color[SIDE * SIDE];        /* of blocked rays */
shared uint s_colored[QUADS];            /* of a row of quads, a bit for each */
#endif
shared uint s_kinds[QUADS];              /* likewise: lit in the lower half, blocked in the upper one */

const float NO_NEIGHBOR = 1e30;          /* where the light tells nothing */

ivec2 quad_corner(uint quad) { return 2 * ivec2(quad % QUADS, quad / QUADS); }
int ray_index(ivec2 place) { return (place.y + REACH) * SIDE + place.x + REACH; }

/* Of the ray at an index. */
Visibility ray_visibility(int at, bool lit)
{
#ifdef TRANSLUCENCY
    return max(unpackUnorm4x8(s_color[at]).xyz, Visibility(lit));
#else
    return Visibility(lit);
#endif
}

/* Four texels of one gather each; corner: the first of them. */
vec4 gather_view_z(ivec2 corner) { return textureGather(in_view_z, vec2(corner + rect_origin() + 1) * g.texel_uv.xy, 0).wzxy * g.view_z_scale; }
vec4 gather_widths(ivec2 corner, vec4 z)
{
    vec4 penumbrae = textureGather(in_penumbra, vec2(corner + 1) * g.texel_uv.xy, 0).wzxy, widths;
    UNROLL for (int i = 0; i < 4; i++) {
        bool inside = all(lessThan(uvec2(corner + ivec2(i & 1, i >> 1)), uvec2(g.rect_width, g.rect_height)));
        widths[i] = mix(NOTHING, width_of(penumbrae[i], z[i]), inside);
    }
    return widths;
}

void store_quad(uint quad, ivec2 corner, vec4 z, vec4 widths)
{
    ivec2 place = quad_corner(quad);
    uint kinds = 0u;
    bool colored = false;
    UNROLL for (int i = 0; i < 4; i++) {
        int at = (place.y + (i >> 1)) * SIDE + place.x + (i & 1);
        s_ray[at] = vec2(mix(NO_NEIGHBOR, nearness(z[i]), widths[i] > 0.0), narrowness_of(widths[i]));
        s_width[at] = widths[i];
        uint kind = kind_of(widths[i]);
        kinds |= mix(kind, 1u << 16, kind == KIND_BLOCKED);
#ifdef TRANSLUCENCY
        s_color[at] = kind == KIND_BLOCKED ? load_color(corner + ivec2(i & 1, i >> 1)) : 0u;
        colored = colored || s_color[at] != 0u;
#endif
    }
    if (kinds != 0u) atomicOr(s_kinds[quad / QUADS], kinds << quad % QUADS);
#ifdef TRANSLUCENCY
    if (colored) atomicOr(s_colored[quad / QUADS], 1u << quad % QUADS);
#endif
}

/* A thread a quad. first: the tile's first pixel. */
void load_rays(ivec2 first)
{
    uint i = gl_LocalInvocationIndex;
    ivec2 corner = first - REACH + quad_corner(i);
    vec4 z = gather_view_z(corner), widths = gather_widths(corner, z);
    if (i < QUADS) {
        s_kinds[i] = 0u;
#ifdef TRANSLUCENCY
        s_colored[i] = 0u;
#endif
    }
    barrier();
    store_quad(i, corner, z, widths);
    barrier();
}

/* True if a ray in reach tells something else: seen from the quads' kinds. */
bool may_be_penumbra(ivec2 place, float width)
{
    const uint side = uint(REACH) + 1u, columns = (1u << side) - 1u;
    uint kinds = 0u;
    uvec2 corner = uvec2(place) >> 1;
    UNROLL for (uint i = 0u; i < side; i++) kinds |= s_kinds[corner.y + i];
    kinds = kinds >> corner.x & (width == LIT ? columns << 16 : columns);
#ifdef TRANSLUCENCY
    UNROLL for (uint i = 0u; i < side; i++) kinds |= s_colored[corner.y + i] >> corner.x & columns;
#endif
    return kinds != 0u;
}

#endif
