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

# What README.md says of devices is what is published, of all denoisers and two devices at least, and kept by limits that are today's.
sh examples/stress/agreement.sh table > "$folder/table" && sed '1,/<!-- agreement begin/d; /<!-- agreement end/,$d' README.md | cmp - "$folder/table"
report $? "README.md's table of devices is not of published_agreement.txt: agreement.sh publish ROWS..."
"$program" --only agreement --denoiser sigma_shadow --compare "$folder/here" > "$folder/log"
"$program" --only agreement --denoiser reblur_diffuse --compare "$folder/here" >> "$folder/log"
awk -F'|' -v denoisers=13 '
    FNR == NR { if (/ DEVICES(_8_BIT)? /) { n = split($0, v, " "); limit[v[2]] = v[n] } next }
    { rows[$1]++; if (!($4 <= $5 && $6 <= $7 && $8 == 0) || ($3 in limit && limit[$3] != $5)) bad = 1 }
    END { for (d in rows) { devices++; if (rows[d] != denoisers) bad = 1 } exit bad || devices < 2 }' "$folder/log" examples/stress/published_agreement.txt
report $? "published_agreement.txt lacks a denoiser, or breaks a limit, or has another one"

"$program" --quiet --only agreement --denoiser reblur_diffuse --compare "$folder/here" --plant bright > "$folder/log"
[ $? -eq 1 ]
report $? "a planted fault is not noticed"

wait "$first"
report $? "a guarantee is broken, or nrd-stress did not run:"
cat "$folder/first"

echo "stress: $passed passed, $failed failed"
[ "$failed" -eq 0 ]
