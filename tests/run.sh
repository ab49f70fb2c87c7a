#!/bin/sh
# run.sh: runs every test program of the build (NRD_BUILD, default build) and every other script beside this one, from the
# repository root, and adds up what they report. Shows a program's output only if something is wrong with it. A program that
# crashes, hangs or reports nothing counts as one failure. Arguments: names of tests to run instead of all, as in test_vk.
set -u
cd "$(dirname "$0")/.." || exit 1
export NRD_BUILD="${NRD_BUILD:-build}"
export LSAN_OPTIONS="${LSAN_OPTIONS:-suppressions=tests/lsan.supp}"
limit_s=600
log=$(mktemp) || exit 1
trap 'rm -f "$log"' EXIT
passed=0
failed=0
skipped=0

# Sum of the numbers before the word $1 in the result lines that cmocka or a script wrote.
count() {
    case $1 in
        passed) tag=PASSED ;;
        failed) tag=FAILED ;;
        skipped) tag=SKIPPED ;;
    esac
    sed -n -e "s/^\[  *$tag *\] \([0-9][0-9]*\) test.*/\1/p" \
        -e "s/^[a-z_]*: \(.*[ ,]\)*\([0-9][0-9]*\) $1\(,.*\)*\$/\2/p" "$log" | awk '{ n += $1 } END { print n + 0 }'
}

# Names of skipped tests, each with the line that the test printed before it skipped.
list_skips() {
    awk '/^\[  *SKIPPED *\] [a-z]/ { name = $NF; if (!(name in seen)) print "  skipped " name ": " (why == "" ? "no reason given" : why)
                                     seen[name] = 1 }
         /^\[  *RUN/ { why = ""; next }
         /^skip / { sub(/^skip +/, ""); print "  skipped " $0; next }
         !/^\[/ && NF { why = $0 }' "$log"
}

run() { # name, command
    name=$1
    shift
    start=$(date +%s)
    timeout -k 10 "$limit_s" "$@" > "$log" 2>&1 < /dev/null
    status=$?
    p=$(count passed)
    f=$(count failed)
    s=$(count skipped)
    if [ "$f" -eq 0 ] && { [ "$status" -ne 0 ] || [ $((p + s)) -eq 0 ]; }; then
        f=1
        case $status in
            124 | 137) echo "$name: ran longer than $limit_s s" ;;
            *) echo "$name: stopped early, exit status $status" ;;
        esac
    fi
    if [ "$f" -gt 0 ]; then
        grep -vE '^\[( RUN      |       OK )\]' "$log"
    fi
    echo "$name: $p passed, $f failed, $s skipped ($(($(date +%s) - start)) s)"
    if [ "$s" -gt 0 ]; then
        list_skips
    fi
    passed=$((passed + p))
    failed=$((failed + f))
    skipped=$((skipped + s))
}

wanted() { # name, then the names asked for
    name=$1
    shift
    [ $# -eq 0 ] && return 0
    for asked in "$@"; do
        [ "$asked" = "$name" ] && return 0
    done
    return 1
}

for source in tests/test_*.c tests/*.sh; do
    name=$(basename "${source%.*}")
    wanted "$name" "$@" || continue
    case $source in
        tests/run.sh) ;;
        *.sh) run "$name" sh "$source" ;;
        *) run "$name" "$NRD_BUILD/tests/$name" ;;
    esac
done

total="$passed passed, $failed failed"
[ "$skipped" -eq 0 ] || total="$total, $skipped skipped"
echo "$total"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
