#!/bin/sh
# demo.sh: renders a scene in motion with one path per pixel, denoises it, and says what that cost and gained. Run from the
# repository root after `make examples`, or as `make demo`. Environment: DEMO_SCENE (moving; `nrd-render --list` names others),
# DEMO_SIZE (320x180), DEMO_FRAMES (32), DEMO_REF (samples per pixel of the reference, 512).
set -eu

build=${NRD_BUILD:-build}
scene=${DEMO_SCENE:-moving}
size=${DEMO_SIZE:-320x180}
frames=${DEMO_FRAMES:-32}
samples=${DEMO_REF:-512}
denoisers="reference reblur_diffuse"
out=$build/demo
log=$out/log.txt
started=$(date +%s)

step() { # text, command: its output is shown if it fails
    text=$1
    shift
    step_started=$(date +%s)
    printf '%s ... ' "$text"
    "$@" > "$log" 2>&1 || {
        echo failed
        cat "$log" >&2
        exit 1
    }
    echo "$(($(date +%s) - step_started)) s"
}

rm -rf "$out"
mkdir -p "$out"
last=$(printf '%04d' $((frames - 1)))

step "rendering $frames frames of '$scene', $size, 1 path per pixel (GLSL path tracer)" \
    "$build/nrd-render" "$scene" "$out/noisy" --size "$size" --frames "$frames" --tracer vulkan --ref 0
# The two tracers are one text, compiled as GLSL and as C: up to rounding they draw the same paths. On the CPU, Embree makes a
# reference of the last frame affordable.
step "rendering the last frame's reference, $samples paths per pixel (Embree)" \
    "$build/nrd-render" "$scene" "$out/truth" --size "$size" --frames "$frames" --ref "$samples" --ref-frames last

row='%-16s %10s %9s %8s %8s %9s %9s\n'
# shellcheck disable=SC2059 # a format on purpose
table() {
    printf "$row" diffuse ms/frame relMSE PSNR SSIM bias flicker
    awk -v row="$row" '$1 == "diffuse" && $2 == "noisy" { printf row, "noisy input", "-", $3, $7, $8, $9, $10 }' \
        "$out/score.reblur_diffuse.txt"
    for denoiser in $denoisers; do
        ms=$(sed -n 's/.*median \([0-9.]*\) ms per frame.*/\1/p' "$out/time.$denoiser.txt")
        awk -v row="$row" -v name="$denoiser" -v ms="$ms" \
            '$1 == "diffuse" && $2 == "denoised" { printf row, name, ms, $3, $7, $8, $9, $10 }' "$out/score.$denoiser.txt"
    done
}

for denoiser in $denoisers; do
    step "denoising: $denoiser" "$build/nrd-denoise" --denoiser "$denoiser" "$out/noisy" "$out/$denoiser"
    cp "$log" "$out/time.$denoiser.txt"
    step "comparing with the reference" "$build/nrd-score" "$out/truth" "$out/$denoiser"
    cp "$log" "$out/score.$denoiser.txt"
    step "drawing noisy | denoised | reference" "$build/nrd-view" "$out/truth" "$out/$denoiser" "$out/$denoiser.png" \
        --signal diffuse --frame "$((frames - 1))" --side-by-side --label
done

device=$(sed -n 's/.* per frame on \(.*\)/\1/p' "$out/time.reblur_diffuse.txt")
echo
echo "$scene, $size, frame $((frames - 1)), on $device"
table | tee "$out/table.txt"
echo
echo "pictures: $out/*.png    frames: $out/*/frame.$last.exr    $(($(date +%s) - started)) s in all"
