#!/bin/sh
# dist.sh: an engine that has only a C compiler, the Vulkan headers and what `make dist` lays out builds and runs. Run from the
# repository root after `make dist`; prints one line per case and a total, exits 1 if any case failed.
set -u

build=${NRD_BUILD:-build}
sdk=$build/nrd-sdk
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
passed=0
failed=0

report() { # result, name
    if [ "$1" -eq 0 ]; then
        passed=$((passed + 1))
        echo "pass  $2"
    else
        failed=$((failed + 1))
        echo "FAIL  $2"
        cat "$work/log"
    fi
}

: > "$work/log"
for file in nrd.h nrd_vk.h nrd_spirv.h nrd_shaders/nrd.glsl nrd_shaders/common/nrd_shared.glsl LICENSE README.md; do
    [ -s "$sdk/$file" ]
    report $? "$file is there"
done

# The engine: the example, its two helper files, a copy of the folder, and a PATH with the compiler and nothing else.
mkdir -p "$work/engine/common" "$work/bin"
cp -R "$sdk" "$work/nrd-sdk"
cp examples/minimal.c "$work/engine"
cp examples/common/gpu.[ch] examples/common/half.[ch] "$work/engine/common"
for tool in cc as ld; do
    ln -s "$(command -v $tool)" "$work/bin/$tool"
done
(cd "$work/engine" && env -i "PATH=$work/bin" cc -std=c99 -Wall -Wextra -pedantic -Werror -O1 -I. -I../nrd-sdk \
    minimal.c common/gpu.c common/half.c -lm -ldl -o "$work/program") > "$work/log" 2>&1
report $? "the example compiles from the folder alone"

(cd "$work/engine" && "$work/program") > "$work/log" 2>&1
report $? "the example runs"

# The point of it all: what it prints last is the error of the input and that of the output.
awk '/^relative error: / { good = $6 > 0 && $6 + 0 < $4 / 4 } { print } END { exit !good }' "$work/log" > "$work/copy"
report $? "its output has less than a quarter of its input's error"

echo "dist: $passed passed, $failed failed"
[ "$failed" -eq 0 ]
