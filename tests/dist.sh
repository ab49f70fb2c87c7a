#!/bin/sh
# dist.sh: an engine that has only a C compiler, the Vulkan headers and what `make dist` lays out builds and runs. Run from the
# repository root after `make dist`; prints one line per case and a total, exits 1 if any case failed.
set -u
. tests/shell/report.sh

sdk=$build/nrd-sdk

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

# ---- engines: every language, every way to reach Vulkan, one file or two; from the folder and Vulkan's headers alone
mkdir "$work/small"
cp tests/dist/* "$work/small"
ln -s "$(command -v c++)" "$work/bin/c++"
engine() { # name, how the implementation is compiled or "-", how engine.c is compiled, libraries
    (
        cd "$work/small" || exit 1
        flags="-Wall -Wextra -pedantic -Werror -O0 -I../nrd-sdk"
        export "PATH=$work/bin"
        objects=engine.o
        # shellcheck disable=SC2086 # lists of words
        $3 $flags -c engine.c -o engine.o || exit 1
        if [ "$2" != - ]; then
            # shellcheck disable=SC2086
            $2 $flags -c implementation.c -o implementation.o || exit 1
            objects="engine.o implementation.o"
        fi
        # shellcheck disable=SC2086
        c++ $objects -lm -ldl $4 -o engine && ./engine
    ) > "$work/log" 2>&1
    report $? "$1"
}
engines() { # way to reach Vulkan, its macro, libraries
    for language in "cc -std=c99" "cc -std=c11" "c++ -std=c++17 -x c++"; do
        engine "$language, $1" - "$language $2" "$3"
    done
    nvidia=-DENGINE_NVIDIA
    engine "two files, $1, beside another library's NRD_ macros" "cc -std=c99 $2 $nvidia" "cc -std=c99 $2 $nvidia -DENGINE_TWO_FILES" "$3"
    engine "two files, C and C++, $1" "cc -std=c11 $2" "c++ -std=c++17 -x c++ $2 -DENGINE_TWO_FILES" "$3"
}
engines "VK_NO_PROTOTYPES" "" ""
engines "static prototypes" -DENGINE_PROTOTYPES -lvulkan
if echo '#include <volk.h>' | cc -E - > /dev/null 2>&1; then
    engines "volk" -DENGINE_VOLK ""
else
    skip "volk: no volk.h here (Debian: libvulkan-volk-dev)"
fi

total dist
