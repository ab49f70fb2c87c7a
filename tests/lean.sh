#!/bin/sh
# lean.sh: what is not needed is not there: objects compiled for one denoiser hold the SPIR-V of that one alone, and what
# nrd_desc.absent promises is gone from the specialized modules. Prints sizes and instruction counts. Run from the repository
# root after `make spv`; prints one line per case and a total, exits 1 if any case failed.
set -u
. tests/shell/report.sh

# ---- binaries
denoisers=$(sed -n '/^#define NRD_DENOISERS(X)/,/[^\\]$/s/.*X(\([A-Z_]*\), "\([a-z_]*\)".*/\1/p' nrd.h)
cat > "$work/only.c" << 'END'
#define NRD_IMPLEMENTATION
#include "nrd.h"
#include <stdio.h>
static void say(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    (void)severity;
    if (result == NRD_RESULT_UNKNOWN_DENOISER) snprintf((char *)user, 256, "%s", text);
}
int main(void)
{
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        char text[256] = "";
        nrd_denoiser_desc one = { 0, (nrd_denoiser)i };
        nrd_desc desc = { .width = 8, .height = 8, .denoisers = &one, .denoiser_count = 1, .message = say, .message_user = text };
        nrd *instance = NULL;
        nrd_result result = nrd_create(&desc, &instance);
        if (result == NRD_RESULT_OK) printf("%s\n", nrd_denoiser_name((nrd_denoiser)i));
        else if (result != NRD_RESULT_UNKNOWN_DENOISER || !strstr(text, nrd_denoiser_name((nrd_denoiser)i)) || !strstr(text, "NRD_ONLY_")) printf("wrong message: %s\n", text);
        nrd_destroy(instance);
    }
    return 0;
}
END

bytes_of() { # options...: of an object with both implementations
    gcc -std=c99 -O0 -Wall -Wextra -pedantic -Werror -I. "-I$build" "$@" -c tests/compile/nrd_vk.c -o "$work/object.o" > "$work/log" 2>&1 || return 1
    size "$work/object.o" | awk 'NR == 2 { print $1 + $2 }'
}

spirv_of() { # denoiser: bytes of its modules
    awk -v with="NRDI_WITH($1)" '/^#if / { mine = index($0, with) } mine && /_words\[\] =/ { sub(/.*uint32_t /, ""); sub(/_words.*/, ""); print }' "$build/nrd_spirv.h" |
        while read -r module; do wc -c < "$build/spv/$module.spv"; done | awk '{ n += $1 } END { print n }'
}

row_bytes=2048 # of the denoiser's tables, and of its modules' entries
all=$(bytes_of) && [ "$all" -gt 0 ]
report $? "all denoisers compile: ${all:-0} bytes"
reference=$(bytes_of -DNRD_ONLY_REFERENCE) || reference=0
code=$((reference - $(spirv_of REFERENCE)))
for denoiser in $denoisers; do
    only=$(bytes_of "-DNRD_ONLY_$denoiser") || only=$all
    spirv=$(spirv_of "$denoiser")
    [ "$only" -le $((code + spirv + row_bytes)) ]
    report $? "NRD_ONLY_$denoiser: $only bytes, of which SPIR-V $spirv, code $code"
    name=$(echo "$denoiser" | tr 'A-Z' 'a-z')
    gcc -std=c99 -O0 -Wall -Wextra -pedantic -Werror -I. "-DNRD_ONLY_$denoiser=1" "$work/only.c" -lm -o "$work/only" > "$work/log" 2>&1 &&
        "$work/only" > "$work/log" 2>&1 && [ "$(cat "$work/log")" = "$name" ]
    report $? "NRD_ONLY_$denoiser: nrd_create takes it, and refuses the others by name"
done
two=$(bytes_of -DNRD_ONLY_REBLUR_DIFFUSE -DNRD_ONLY_SIGMA_SHADOW) || two=0
others=$(echo "$denoisers" | sed '/^REBLUR_DIFFUSE$/d; /^SIGMA_SHADOW$/d; s/^/-DNRD_NO_/')
# shellcheck disable=SC2086
[ "$two" -gt "$code" ] && [ "$two" = "$(bytes_of $others)" ]
report $? "NRD_ONLY_ of two denoisers is NRD_NO_ of the others: $two bytes"

# ---- pipelines
modules="reblur_temporal_accumulation_diffuse_specular reblur_blur_diffuse_specular reblur_stabilization_diffuse_specular:1
         reblur_stabilization_diffuse_specular:3 reblur_diffuse_specular_occlusion_accumulation reblur_diffuse_specular_occlusion_blur
         sigma_accumulation sigma_blur"

# Twice: what the optimizer has not seen before takes one round to become one function.
count() { # module or module:iteration, nrd_desc.absent, .features: instructions after specialization
    case $1 in *:*) iteration=${1#*:} ;; *) iteration=0 ;; esac
    spirv-opt --target-env=vulkan1.1 "--set-spec-const-default-value=0:0 1:0 2:${3:-0} 3:$2 4:$iteration" --freeze-spec-const --fold-spec-const-op-composite \
        --unify-const -O -O "$build/spv/${1%:*}.spv" -o "$work/module.spv" > "$work/log" 2>&1 && spirv-dis --raw-id "$work/module.spv" | grep -c '^ *\(%.* = \)\{0,1\}Op'
}

if ! command -v spirv-opt > /dev/null || ! command -v spirv-dis > /dev/null; then
    skip "instruction counts: no spirv-opt here (apt-get install spirv-tools)"
else
    for module in $modules; do
        echo "$module $(count "$module" 0)"
    done > "$work/full"
    awk '$2 > 100 { n++ } END { exit n != NR }' "$work/full"
    report $? "every module is specialized"
    # Absence, and the most that is left, in percent, of all these modules' instructions, or of the one named (.: all).
    accumulation=reblur_temporal_accumulation_diffuse_specular
    for row in "motion 60 $accumulation" "sky 99 ." "materials 99 ." "mirrors 63 $accumulation" "stabilization 99 ." "lighting_change 98 ." "blur 85 ."; do
        # shellcheck disable=SC2086 # words
        set -- $row
        name=$1
        bit=$(sed -n "s/^#define NRD_ABSENT_$(echo "$name" | tr 'a-z' 'A-Z') *\([0-9]*\)$/\1/p" nrd.h)
        while read -r module full; do
            echo "$module $full $(count "$module" "$bit")"
        done < "$work/full" > "$work/lean"
        awk -v most="$2" -v of="$3" '$1 ~ of { full += $2; lean += $3 } $3 > $2 { grown = 1 } END { exit !(lean > 0 && !grown && lean * 100 <= full * most) }' "$work/lean"
        report $? "absent $name: instructions $(awk '{ full += $2; lean += $3; if ($3 < 0.98 * $2) most = most ", " $1 " " $2 " to " $3 } END { printf "%d to %d%s", full, lean, most }' "$work/lean")"
    done
fi

# Features that are code: at least this many instructions more where they are declared, over some of these modules.
if command -v spirv-opt > /dev/null && command -v spirv-dis > /dev/null; then
    grep '^reblur_temporal\|^reblur_blur\|occlusion_accumulation' "$work/full" > "$work/some"
    for row in "HISTORY_CONFIDENCE 10" "DISOCCLUSION_THRESHOLD_MIX 5" "HIT_DISTANCE_RECONSTRUCTION 10" "CHECKERBOARD 50" "SPECULAR_MOTION 50" "MATERIALS 50" "ROUGHNESS_LIMIT 50"; do
        # shellcheck disable=SC2086 # words
        set -- $row
        bit=$(sed -n "s/^#define NRD_FEATURE_$1 *\([0-9]*\) .*/\1/p" nrd.h)
        while read -r module lean; do
            echo "$module $lean $(count "$module" 0 "$bit")"
        done < "$work/some" > "$work/with"
        awk -v least="$2" '{ lean += $2; with += $3 } $3 < 0.99 * $2 { shrunk = 1 } END { exit !(!shrunk && with >= lean + least) }' "$work/with"
        report $? "feature $1: instructions $(awk '{ lean += $2; with += $3; if ($3 > 1.02 * $2) most = most ", " $1 " " $2 " to " $3 } END { printf "%d undeclared, %d declared%s", lean, with, most }' "$work/with")"
    done
fi

# Frames and pipelines of the same denoiser, promising nothing and all that a still room allows. Times are shown, not judged.
for absent in "" motion,sky,materials,mirrors,stabilization,lighting_change; do
    "$build/nrd-bench" --denoiser reblur_diffuse_specular --size 128x72 --frames 9 --absent "$absent" > "$work/log" 2>&1
    report $? "absent ${absent:-nothing}: $(sed -n 's/^ *\([0-9.]*\) us  total.*/\1 us a frame/p' "$work/log"), $(sed -n 's/^ *\([0-9.]*\) ms  creation.*/\1 ms creation/p' "$work/log")"
done

total lean
