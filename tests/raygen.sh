#!/bin/sh
# raygen.sh: examples/raygen traces, denoises and composes: with the ray tracing pipeline where a device has one, and with its
# stand-in everywhere. Run from the repository root after `make examples`; prints one line per case and a total, exits 1 if any failed.
set -u
. tests/shell/report.sh

render() { # options...
    "$build/nrd-raygen" "$work/out.png" --size 96x64 --frames 8 --reference 64 "$@" > "$work/log" 2>&1
}

# Denoising took at least two thirds of the error.
is_better() {
    sed -n 's/.*whole picture: noisy \([0-9.]*\), denoised \([0-9.]*\)$/\1 \2/p' "$work/log" | awk '{ n++; bad += !($2 > 0 && $2 < $1 / 3) } END { exit n != 1 || bad }'
}

render --compute && [ -s "$work/out.png" ] && is_better
report $? "the compute shader's picture has less than a third of its input's error"

if render && grep -q '^skipped: ' "$work/log"; then
    skip "the ray tracing pipeline: $(sed 's/^skipped: //' "$work/log")"
else
    [ -s "$work/out.png" ] && is_better
    report $? "the ray tracing pipeline's picture has less than a third of its input's error"
fi

render --compute --without mirrors --without strands --without mix && is_better
report $? "the options leave a picture with less than a third of its input's error"

for arguments in "--without x" "--size 8x8" "--frames 0" "--paths x" "--size" "--unknown 1"; do
    # shellcheck disable=SC2086 # arguments are words
    ! "$build/nrd-raygen" $arguments > "$work/log" 2>&1 && [ "$(wc -l < "$work/log")" -eq 1 ] && grep -q '^nrd-raygen: .*--' "$work/log"
    report $? "refused with one line that names the option: $arguments"
done

total raygen
