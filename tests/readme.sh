#!/bin/sh
# readme.sh: what README.md shows compiles, and what it names exists. Run from the repository root after `make examples`; prints one
# line per case and a total, exits 1 if any case failed. Code blocks are compiled inside what their text says the engine has.
set -u
. tests/shell/report.sh

# The first code block of a language after a heading: into $work/block; lines that begin with # into $work/head, the others into $work/body.
extract() { # heading, language
    awk -v heading="$1" -v fence="\`\`\`$2" '$0 ~ "^#+ " heading "$" { below = 1; next }
        below && $0 == fence { inside = 1; below = 0; next }
        inside && /^```/ { exit }
        inside' README.md > "$work/block"
    grep '^#' "$work/block" > "$work/head"
    grep -v '^#' "$work/block" > "$work/body"
    [ -s "$work/head" ] && [ -s "$work/body" ]
}

# ---- the code blocks
ray_gen_engine() {
    cat <<'GLSL'
layout(set = 0, binding = 0, rgba16f) uniform writeonly image2D in_diff_radiance_hitdist;
layout(set = 0, binding = 1, rgb10_a2) uniform writeonly image2D in_normal_roughness;
layout(set = 0, binding = 2, rgba16f) uniform writeonly image2D in_mv;
layout(set = 0, binding = 3, r32f) uniform writeonly image2D in_viewz;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2D diffuse_factors;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D emissions;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2D in_spec_radiance_hitdist;
layout(set = 0, binding = 8, rgba16f) uniform writeonly image2D specular_factors;
struct surface {
    vec3 position, position_prev, normal, to_camera, albedo, rf0, emission;
    float roughness;
    uint material_id;
};
layout(set = 0, binding = 6) uniform frame {
    mat4 world_to_view, view_to_clip, world_to_view_prev, view_to_clip_prev;
    surface hit;
    uint paths_per_pixel;
};
vec3 trace_diffuse_path(surface s, uint path, out float hit_dist)
{
    hit_dist = 1.0;
    return s.albedo;
}
vec3 trace_specular_path(surface s, uint path, out float hit_dist)
{
    hit_dist = NRD_HIT_DIST_MISS;
    return s.rf0;
}
GLSL
}

composition_engine() {
    cat <<'GLSL'
layout(set = 0, binding = 0) uniform sampler2D out_diff_radiance_hitdist;
layout(set = 0, binding = 1) uniform sampler2D in_viewz;
layout(set = 0, binding = 2) uniform sampler2D diffuse_factors;
layout(set = 0, binding = 3) uniform sampler2D emissions;
layout(set = 0, binding = 4) uniform frame { float denoising_range; };
layout(set = 0, binding = 6) uniform sampler2D out_spec_radiance_hitdist;
layout(set = 0, binding = 7) uniform sampler2D specular_factors;
GLSL
}

# A shader around the block: what it includes, what the engine declares, and what main() calls.
compile_glsl() { # stage, function that prints the engine's declarations, body of main()
    {
        echo "#version 460"
        echo "#extension GL_GOOGLE_include_directive : require"
        case $1 in
            rgen) echo "#extension GL_EXT_ray_tracing : require" ;;
            comp) echo "layout(local_size_x = 8, local_size_y = 8) in;"
                  echo "layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D out_color;" ;;
            frag) echo "layout(location = 0) out vec4 out_color;" ;;
        esac
        cat "$work/head"
        "$2"
        cat "$work/body"
        echo "void main() { $3 }"
    } > "$work/shader.$1"
    glslangValidator --target-env vulkan1.2 -Inrd_shaders -V "$work/shader.$1" -o "$work/shader.spv" > "$work/log" 2>&1
    status=$?
    if [ $status -eq 0 ] && grep -q '^WARNING' "$work/log"; then status=1; fi
    return $status
}

extract "4. In your ray-gen shader" glsl && compile_glsl rgen ray_gen_engine "write_denoiser_inputs(ivec2(gl_LaunchIDEXT.xy), hit);"
report $? "the ray-gen block compiles"
extract "6. In your composition shader" glsl && compile_glsl frag composition_engine "out_color = vec4(compose(ivec2(gl_FragCoord.xy)), 1.0);"
report $? "the composition block compiles in a fragment shader"
extract "6. In your composition shader" glsl &&
    compile_glsl comp composition_engine "ivec2 p = ivec2(gl_GlobalInvocationID.xy); imageStore(out_color, p, vec4(compose(p), 1.0));"
report $? "the composition block compiles in a compute shader"

# All C blocks in their order: preprocessor lines at file scope, the others as the body of a function that is given what the engine has.
: > "$work/log"
awk '/^```c$/ { inside = 1; next } /^```/ { inside = 0 } inside' README.md > "$work/block"
parameters='VkInstance instance, VkPhysicalDevice physical, VkDevice device, VkPipelineCache cache, VkCommandBuffer cmd, const float projection[16],
               const float view[16], uint32_t frame_index, bool camera_was_cut, bool window_was_resized,
               void (*print_message)(void *user, nrd_severity severity, nrd_result result, const char *text),
               nrd_vk_image (*create_image)(nrd_resource resource, VkFormat format, VkImageUsageFlags usage, uint32_t width, uint32_t height)'
{
    grep '^#' "$work/block"
    echo '#include <stdio.h>'
    echo "void integrate($parameters);"
    echo "void integrate($parameters)"
    echo "{"
    grep -v '^#' "$work/block"
    echo "}"
} > "$work/block.c"
gcc -std=c99 -Wall -Wextra -pedantic -Werror -I. "-I$build" -c "$work/block.c" -o "$work/block.o" > "$work/log" 2>&1
report $? "the $(grep -c '^```c$' README.md) C blocks compile as one program"
grep -E '^```[a-z]+$' README.md | sort | uniq -c | awk '{ print $2, $1 }' | grep -vxE '```c [0-9]+|```glsl 2' > "$work/log"
[ ! -s "$work/log" ]
report $? "no code block but these is in README.md"

# ---- what the text names
# Prints the names on standard input that the predicate refuses; fails if there are any or if there was no name at all.
refused_by() { # predicate
    : > "$work/log"
    count=0
    while read -r name; do
        count=$((count + 1))
        "$1" "$name" || echo "README.md names $name" >> "$work/log"
    done
    if [ $count -eq 0 ]; then echo "README.md names none" >> "$work/log"; fi
    [ ! -s "$work/log" ]
}

is_target() { grep -qE "^$1:" Makefile; }
grep -o 'make [a-z][a-z]*' README.md | grep -E ' (demo|test|dist|shared)$' | sed 's/make //' | sort -u > "$work/targets"
refused_by is_target < "$work/targets"
report $? "make targets: $(tr '\n' ' ' < "$work/targets")"
printf 'demo\ntest\n' | comm -23 - "$work/targets" > "$work/log"
[ ! -s "$work/log" ]
report $? "the two commands are make demo and make test"

# Names of C and GLSL, in code or in text: whole words of the sources (X-lists leave out the prefix).
is_in_sources() {
    short=$(echo "$1" | sed -E 's/^NRD_(RESOURCE|DENOISER|RESULT|FORMAT|SEVERITY)_//')
    grep -qwF -e "$1" -e "$short" nrd.h nrd_vk.h nrd_shaders/nrd.glsl
}
grep -oE '\b(nrd|NRD)_[A-Za-z0-9_]*[A-Za-z0-9]\b' README.md | grep -vxE 'NRD_|NRD_BUILD|nrd_(spirv|shared)' | sort -u > "$work/names"
refused_by is_in_sources < "$work/names"
report $? "$(wc -l < "$work/names") nrd_ and NRD_ names"

is_resource() { grep -qE "^    X\($1, " nrd.h; }
grep -oE '\b(IN|OUT)_[A-Z0-9_]+' README.md | sort -u > "$work/names"
refused_by is_resource < "$work/names"
report $? "$(wc -l < "$work/names") resources"

# Settings: `name` or `struct.name`, all lower case with an underscore. Names of captures stand in the first column of a table.
is_setting() {
    grep -qE "X\((float|uint), $1, |^ +[A-Za-z_0-9]+ (\*?[a-z_]+, )*\*?$1(\[[0-9]+\])?[;,]|\(\*$1\)" nrd.h nrd_vk.h && return 0
    grep -qE "^\| $1 \|" README.md || grep -qE "^(typedef |\} |NRD_DECL ).*\b$1\b" nrd.h nrd_vk.h || grep -qw "$1" nrd_shaders/nrd.glsl
}
grep -oE '`([a-z_]+\.)?[a-z]+_[a-z_]+(\[[0-9]\])?`' README.md | tr -d '`' | sed -e 's/.*\.//' -e 's/\[.*//' | sort -u > "$work/names"
refused_by is_setting < "$work/names"
report $? "$(wc -l < "$work/names") settings and fields"

is_denoiser() { grep -qE "^    X\($(echo "$1" | tr a-z A-Z), \"$(echo "$1" | tr A-Z a-z)\", " nrd.h; }
{
    grep -oE '\*\*[A-Z_]{6,}\*\*' README.md | tr -d '*'
    grep -oE -- '--denoiser [a-z_]+' README.md | sed 's/.* //'
} | sort -u > "$work/names"
refused_by is_denoiser < "$work/names"
report $? "$(wc -l < "$work/names") names of denoisers"

# Headings as links call them: lower case, without punctuation, spaces as dashes.
is_heading() { sed -n 's/^###* //p' README.md | tr A-Z a-z | sed -e 's/[^a-z0-9 -]//g' -e 's/ /-/g' | grep -qx -e "$1"; }

# Paths: links, and what is between backquotes and has a slash or the ending of a source. Those of build/ are made by rules of the Makefile.
is_path() {
    case $1 in
        \#*) is_heading "${1#?}" ;;
        build/nrd-sdk/ | nrd_spirv.h) return 0 ;; # laid out by make dist, which dist.sh tests
        build/nrd-*) [ -s "examples/$(basename "$1" | tr - _).c" ] ;;
        *) [ -e "$1" ] || [ -e "nrd_shaders/$1" ] || [ -e "examples/$1" ] ;;
    esac
}
{
    grep -oE '\]\([^)]*\)' README.md | sed -e 's/^](//' -e 's/)$//' | grep -v '^https*:'
    grep -oE '`[A-Za-z_./-]+(/|\.(h|c|glsl|txt|md))`' README.md | tr -d '`'
    grep -oE '\bbuild/nrd-[a-z]+/?' README.md
} | sort -u > "$work/names"
refused_by is_path < "$work/names"
report $? "$(wc -l < "$work/names") paths"

# Command lines: each option occurs in the source of the program that the line calls.
is_option() { grep -qF -- "\"--${1#*:--}\"" "examples/$(echo "${1%%:*}" | tr - _).c"; }
sed -n 's|.*build/\(nrd-[a-z]*\) \([^`#]*\).*|\1 \2|p' README.md | while read -r program words; do
    for word in $words; do
        case $word in --*) echo "$program:$word" ;; esac
    done
done | sort -u > "$work/names"
refused_by is_option < "$work/names"
report $? "$(wc -l < "$work/names") options of the programs"

# ---- the example
lines=$(awk '/^\/\* ---- denoiser -/ { inside = !inside; next } inside' examples/minimal.c | wc -l)
echo "$lines lines of minimal.c are the denoiser, 60 allowed" > "$work/log"
[ "$lines" -gt 0 ] && [ "$lines" -le 60 ]
report $? "the denoiser's part of minimal.c has at most 60 lines"
claimed=$(sed -n 's/.*(\([0-9]*\) lines of it are the denoiser).*/\1/p' README.md)
echo "README.md says ${claimed:-nothing}, minimal.c has $lines" > "$work/log"
[ "$claimed" = "$lines" ]
report $? "README.md tells that number right"

total readme
