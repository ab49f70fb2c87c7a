#!/bin/sh
# compile.sh: the headers compile, link and run wherever an application includes them: C99 to C17, C++17 and C++20, gcc
# and clang (where installed), vulkan.h before, after or not at all. Warnings are errors. Run from the repository root after
# `make spv`; prints one line per case and a total, exits 1 if any case failed.
set -u
. tests/shell/report.sh

compile() { # compiler, source, options...
    compiler=$1
    source=tests/compile/$2
    shift 2
    name="$compiler $* $source"
    "$compiler" "$@" -O1 -Wall -Wextra -pedantic -Werror -I. "-I$build" "$source" -lm -o "$work/program" > "$work/log" 2>&1 &&
        "$work/program" >> "$work/log" 2>&1
    report $? "$name"
}

compile_all() { # extension, compiler, standard
    if ! command -v "$2" > /dev/null; then
        skip "$2 $3: no $2 here"
        return
    fi
    compile "$2" "nrd.$1" "-std=$3"
    compile "$2" "nrd_vk.$1" "-std=$3"
    compile "$2" "nrd_vk.$1" "-std=$3" -DVULKAN_BEFORE
    compile "$2" "nrd_vk.$1" "-std=$3" -DVULKAN_AFTER
    compile "$2" "nrd_vk.$1" "-std=$3" -DVULKAN_BEFORE -DVK_NO_PROTOTYPES
    compile "$2" "nrd_vk.$1" "-std=$3" -DNRD_STATIC
    compile "$2" "nrd_vk.$1" "-std=$3" -DNRD_ONLY_REFERENCE
}

compile_all c gcc c99
compile_all c clang c99
compile_all cpp g++ c++17
compile_all cpp clang++ c++17
for standard in c11 c17; do
    compile gcc nrd_vk.c -std=$standard
done
compile g++ nrd_vk.cpp -std=c++20

# One file with the implementation, one with the declarations: linked together nothing is missing and nothing is there twice.
gcc -std=c99 -Wall -Wextra -pedantic -Werror -Dmain=use_implementation -I. "-I$build" -c \
    tests/compile/nrd_vk.c -o "$work/a.o" > "$work/log" 2>&1 &&
    g++ -std=c++17 -Wall -Wextra -pedantic -Werror -I. "-I$build" -x c++ -c tests/compile/declarations.c -o "$work/b.o" \
        >> "$work/log" 2>&1 &&
    echo 'int use_declarations(); int main() { return use_declarations(); }' > "$work/main.cpp" &&
    g++ -std=c++17 "$work/main.cpp" "$work/a.o" "$work/b.o" -lm -o "$work/program" >> "$work/log" 2>&1 && "$work/program"
report $? "implementation in C, declarations in C++, linked together"

# Whatever is defined after an include has our prefix, and nothing but these functions is exported.
defined() { # file, options...
    echo "#include <$1>" | gcc -std=c99 -I. "-I$build" -dM -E - | sed -n 's/^#define \([A-Za-z0-9_]*\).*/\1/p' | sort
}
for header in nrd nrd_vk; do
    base=stdint.h
    [ $header = nrd_vk ] && base=vulkan/vulkan_core.h
    { defined $base; defined stdbool.h; defined stddef.h; defined stdint.h; } | sort -u > "$work/before"
    defined $header.h | comm -13 "$work/before" - | grep -vE '^NRDI?_' > "$work/log"
    [ ! -s "$work/log" ]
    report $? "$header.h defines only NRD_ and NRDI_ macros"
done
nm -g --defined-only "$work/a.o" | awk '{ print $3 }' | grep -v '^nrd_\|^use_implementation$' > "$work/log"
[ ! -s "$work/log" ]
report $? "the implementation exports only nrd_ names"

total compile
