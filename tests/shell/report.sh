# report.sh: what the shell tests share; they source it from the repository root, after `set -u`.
# $build: the build to test. $work: a folder that goes when the test ends. Cases print to $work/log what is shown when they fail.
build=${NRD_BUILD:-build}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
passed=0
failed=0
skipped=0
: > "$work/log"

report() { # exit status of the case, its name
    if [ "$1" -eq 0 ]; then
        passed=$((passed + 1))
        echo "pass  $2"
    else
        failed=$((failed + 1))
        echo "FAIL  $2"
        cat "$work/log"
    fi
}

skip() { # name and reason
    skipped=$((skipped + 1))
    echo "skip  $1"
}

total() { # name of the test
    echo "$1: $passed passed, $failed failed, $skipped skipped"
    [ "$failed" -eq 0 ]
}
