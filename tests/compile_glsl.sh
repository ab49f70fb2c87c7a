#!/bin/sh
# compile_glsl.sh: nrd.glsl compiles wherever an engine includes it. Run from the repository root; prints one line per
# case and a total, exits 1 if any case failed. Every case goes through glslangValidator and glslc (warnings are errors
# there), for each stage, GLSL 4.50 and 4.60, alone, twice, before and after other files, and with every encoding; and
# through four compilers of C and C++.
set -u
. tests/shell/report.sh

# A file such as an engine has: macros and functions with names that denoiser helpers are tempted to use.
cat > "$work/engine.glsl" <<'GLSL'
#ifndef ENGINE_GLSL
#define ENGINE_GLSL
#define PI 3.14159265
#define EPSILON 1e-4
#define saturate(x) clamp((x), 0.0, 1.0)
#define sqr(x) ((x) * (x))
#define lerp mix
#define float3 vec3
#define FLT_MAX 3.402823466e38
const float HALF_MAX = 65504.0;
struct Surface { vec3 normal; float roughness; };
float luminance(vec3 c) { return dot(c, vec3(0.2126, 0.7152, 0.0722)); }
vec3 demodulate(vec3 c, vec3 f) { return c / f; }
vec2 clip_to_uv(vec4 clip) { return clip.xy / clip.w; }
bool is_finite(float x) { return x == x; }
#endif
GLSL

# The text of a shader that calls into nrd.glsl; the includes come from the third argument on.
write_shader() { # stage, version, include...
    stage=$1
    echo "#version $2"
    shift 2
    echo "#extension GL_GOOGLE_include_directive : require"
    case $stage in
        rgen | rchit | rmiss) echo "#extension GL_EXT_ray_tracing : require" ;;
        comp) echo "layout(local_size_x = 8, local_size_y = 8) in;" ;;
        frag) echo "layout(location = 0) out vec4 out_color;" ;;
    esac
    for file in "$@"; do
        echo "#include \"$file\""
    done
    cat <<'GLSL'
layout(set = 0, binding = 0) uniform frame_block { vec4 texel, params, color, view; } frame;
layout(set = 0, binding = 1) buffer result_block { vec4 result; } result;
void main()
{
    nrd_surface surface = nrd_unpack_normal_roughness(frame.texel);
    vec3 diffuse_factor, specular_factor;
    nrd_material_factors(surface.normal, frame.view.xyz, frame.color.xyz, vec3(0.04), surface.roughness,
                         diffuse_factor, specular_factor);
    float norm = nrd_normalize_hit_dist(frame.texel.x, frame.view.w, 1.0, frame.params);
    vec4 packed_radiance = nrd_pack_radiance_hit_dist(nrd_demodulate(frame.color.xyz, diffuse_factor), norm, true);
    vec4 sh0, sh1;
    nrd_pack_sh(frame.color.xyz, norm, surface.normal, true, sh0, sh1);
    nrd_sg light = nrd_unpack_sh(sh0, sh1);
    vec3 resolved = nrd_resolve_diffuse(light, surface.normal, frame.view.xyz, surface.roughness) +
                    nrd_resolve_specular(light, surface.normal, frame.view.xyz, surface.roughness);
    resolved.xy *= nrd_rejitter(light, light, frame.view.xyz, surface.roughness, frame.view.w, surface.normal,
                                frame.view.wwww, surface.normal, surface.normal, surface.normal, surface.normal);
    nrd_mirror chain = nrd_mirror_add(nrd_mirror_begin(), frame.view.xyz, surface.normal);
    resolved += nrd_mirror_point(chain, frame.color.xyz) * nrd_split_threshold(1u, 2u, 3u, 0.5);
    result.result = nrd_round_to_half(nrd_unpack_radiance_hit_dist(packed_radiance)) + vec4(resolved, 0.0) +
                    nrd_pack_normal_roughness(surface.normal, surface.roughness, surface.material_id) +
                    nrd_pack_directional_occlusion(surface.normal, norm, true) +
                    nrd_upsample_weights(frame.texel.xy, frame.view.w, 1.0, frame.params, frame.texel);
GLSL
    [ "$stage" = frag ] && echo "    out_color = result.result;"
    echo "}"
}

compile() { # name, stage, version, extra options ("" if none), include...
    name=$1
    stage=$2
    version=$3
    options=$4
    shift 4
    write_shader "$stage" "$version" "$@" > "$work/shader.$stage"
    target="--target-env vulkan1.1"
    case $stage in rgen | rchit | rmiss) target="--target-env vulkan1.2" ;; esac
    # shellcheck disable=SC2086 # options are words
    glslangValidator -V $target $options "-I$work" -Inrd_shaders "$work/shader.$stage" -o "$work/out.spv" \
        > "$work/log" 2>&1 && ! grep -qi warning "$work/log"
    report $? "glslangValidator $stage $version $name"
    # shellcheck disable=SC2086
    glslc "--target-env=${target#* }" -Werror $options -I "$work" -I nrd_shaders "$work/shader.$stage" \
        -o "$work/out.spv" > "$work/log" 2>&1
    report $? "glslc            $stage $version $name"
}

for stage in comp frag rgen rchit rmiss; do
    for version in 450 460; do
        # GL_EXT_ray_tracing itself asks for 4.60.
        case $stage$version in rgen450 | rchit450 | rmiss450) continue ;; esac
        compile "alone" "$stage" "$version" "" nrd.glsl
        compile "before another file" "$stage" "$version" "" nrd.glsl engine.glsl
        compile "after another file" "$stage" "$version" "" engine.glsl nrd.glsl
    done
done

compile "included twice" comp 450 "" nrd.glsl nrd.glsl
for encoding in RGB10A2_UNORM RGBA8_UNORM RGBA8_SNORM RGBA16_UNORM RGBA16_SNORM; do
    compile "normals as $encoding" comp 450 "-DNRD_NORMAL_FORMAT=NRD_NORMAL_FORMAT_$encoding" nrd.glsl
done
for encoding in LINEAR SQ_LINEAR SQRT_LINEAR; do
    compile "roughness as $encoding" comp 450 "-DNRD_ROUGHNESS_FORMAT=NRD_ROUGHNESS_FORMAT_$encoding" nrd.glsl
done
for form in 4_PARAMETERS 3_PARAMETERS; do
    compile "hit distance with $form" comp 450 "-DNRD_HIT_DIST_FORM=NRD_HIT_DIST_FORM_$form" nrd.glsl
done

# The values shared with nrd.h are the same: a redefinition to another value does not compile.
if [ -f nrd_shaders/common/nrd_shared.glsl ]; then
    compile "before nrd_shared.glsl" comp 450 "" nrd.glsl common/nrd_shared.glsl
    compile "after nrd_shared.glsl" comp 450 "" common/nrd_shared.glsl nrd.glsl
fi

# Nothing but Shader is required of the device.
compile "for the capability check" comp 450 "" nrd.glsl
spirv-dis "$work/out.spv" > "$work/log" 2>&1 && ! grep OpCapability "$work/log" | grep -qv 'OpCapability Shader$'
report $? "spirv-dis        needs no capability but Shader"

# Every function, struct and macro carries the prefix, and all but the overloads at the end are marked for C.
sed '/>>overloads/,$d' nrd_shaders/nrd.glsl | grep -nE '^[a-z][a-z0-9]* [a-z0-9_]*\(|^struct ' > "$work/log"
grep -nE '^[a-zA-Z].*\(|^ *#define ' nrd_shaders/nrd.glsl |
    grep -vE '^[0-9]+:((NRDI_FN )?[a-z0-9_]+ nrdi?_[a-z0-9_]+\(|NRDI_STRUCT\(nrd_[a-z_]+\)| *#define NRDI?_)' >> "$work/log"
[ ! -s "$work/log" ]
report $? "grep             every name starts with nrd_ or nrdi_, every function with NRDI_FN"

# ---- C and C++
cat > "$work/engine.h" <<'C'
#define vec3 engine_vec3
#define mix(a, b) ((a) < (b) ? (a) : (b))
#define clamp(x) engine_clamp(x)
C

# Leaves the engine's macros as they were and none of its own with a GLSL name.
cat > "$work/engine.c" <<'C'
#include "engine.h"
#include "nrd_c.h"
#include "nrd_c.h"
#if defined(vec2) || defined(pow) || defined(floatBitsToUint) || defined(NRDI_FN) || !defined(clamp)
#error "macros of nrd_c.h outlive it"
#endif
typedef struct vec3 { float x; } vec3;
static float use(void)
{
    nrd_vec3 normal = nrd_make_vec3(0.0f, 0.0f, 1.0f), diffuse, specular;
    nrd_material_factors(normal, normal, normal, normal, 0.5f, &diffuse, &specular);
    engine_vec3 mine;
    mine.x = mix(nrd_pack_normal_roughness(normal, 0.5f, 1).x, diffuse.x);
    return mine.x + specular.x;
}
int main(void) { return use() > 0.0f ? 0 : 1; }
C
cp "$work/engine.c" "$work/engine.cpp"
printf '#define NRD_IMPLEMENTATION\n#include "nrd.h"\n#include "nrd_shaders/nrd_c.h"\nint main(void) { return NRD_NORMAL_FORMAT_RGB10A2_UNORM; }\n' > "$work/after.c"
printf '#include "nrd_shaders/nrd_c.h"\n#define NRD_IMPLEMENTATION\n#include "nrd.h"\nint main(void) { return NRD_NORMAL_FORMAT_RGB10A2_UNORM; }\n' > "$work/before.c"

for compiler in gcc clang g++ clang++; do
    if ! command -v $compiler > /dev/null; then
        echo "skip  $compiler: not here"
        continue
    fi
    case $compiler in
        *++) options="-std=c++17 $work/engine.cpp" ;;
        *) options="-std=c99 $work/engine.c" ;;
    esac
    # shellcheck disable=SC2086 # options are words
    $compiler -Wall -Wextra -pedantic -Werror "-I$work" -Inrd_shaders $options -o "$work/engine" -lm > "$work/log" 2>&1 &&
        "$work/engine"
    report $? "$compiler compiles and runs nrd_c.h beside an engine's macros"
done
for order in before after; do
    gcc -std=c99 -Wall -Wextra -pedantic -Werror -I. -c "$work/$order.c" -o "$work/engine.o" > "$work/log" 2>&1
    report $? "gcc compiles nrd_c.h $order nrd.h"
done

total compile_glsl
