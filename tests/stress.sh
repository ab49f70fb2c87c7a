#!/bin/sh
# stress.sh: the quick part of nrd-stress, and the same bits on lavapipe whatever its vector width and number of threads.
set -u
program="${NRD_BUILD:-build}/nrd-stress"
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
passed=0
failed=0

report() { # status, what
    if [ "$1" -eq 0 ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "failed: $2"
    fi
}

"$program" --quiet --dump "$folder/here" > "$folder/table"
report $? "a guarantee is broken, or nrd-stress did not run:"
cat "$folder/table"
if grep -q llvmpipe "$folder/table"; then
    LP_NATIVE_VECTOR_WIDTH=128 LP_NUM_THREADS=1 "$program" --quiet --only agreement --dump "$folder/narrow" > "$folder/log" && cmp "$folder/here" "$folder/narrow"
    report $? "128-bit vectors and one thread give other bits"
fi
"$program" --quiet --only agreement --compare "$folder/here" --plant bright > "$folder/log"
[ $? -eq 1 ]
report $? "a planted fault is not noticed"

echo "stress: $passed passed, $failed failed"
[ "$failed" -eq 0 ]
