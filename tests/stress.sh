#!/bin/sh
# stress.sh: the quick part of nrd-stress, in two processes at a time, and the same bits on lavapipe whatever its vector width and number of threads.
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

# Pictures are so small that lavapipe's threads wait for each other more than they work: without any, two processes take half the time of one.
LP_NUM_THREADS=0 "$program" --quiet --only extremes,time,fuzz > "$folder/first" 2>&1 &
first=$!
LP_NUM_THREADS=0 "$program" --quiet --only analytic,space,sensitivity,agreement --dump "$folder/here" > "$folder/second" 2>&1
report $? "a guarantee is broken, or nrd-stress did not run:"
cat "$folder/second"

# The same bits of all denoisers: threads, bits of a vector.
agree() {
    LP_NATIVE_VECTOR_WIDTH=$2 LP_NUM_THREADS=$1 "$program" --quiet --only agreement --dump "$folder/there" > "$folder/log" &&
        sed 1d "$folder/here" > "$folder/a" && sed 1d "$folder/there" > "$folder/b" && cmp "$folder/a" "$folder/b"
    report $? "$1 threads and vectors of $2 bits give other bits than none and those of this machine"
}
if grep -q llvmpipe "$folder/second"; then
    agree 1 128
    agree 2 256
fi
"$program" --quiet --only agreement --denoiser reblur_diffuse --compare "$folder/here" --plant bright > "$folder/log"
[ $? -eq 1 ]
report $? "a planted fault is not noticed"

wait "$first"
report $? "a guarantee is broken, or nrd-stress did not run:"
cat "$folder/first"

echo "stress: $passed passed, $failed failed"
[ "$failed" -eq 0 ]
