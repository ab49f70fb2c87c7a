#!/bin/sh
# needs.sh: what five typical engines pay, each with the denoisers that it needs and nothing else; from the repository root.
#   needs.sh plan              rows without times: touches no device
#   needs.sh run [SIZE] [N]    rows with times on the first device, at SIZE (1920x1080), medians of N (60) frames
#   needs.sh publish ROWS      writes the rows of a file into README.md, between the marks
# A row: need|denoisers|size|absent|features|passes|modules|kB of SPIR-V|MB|creation ms|us|device, time size
set -eu
bench=${NRD_BUILD:-build}/nrd-bench

# need|denoisers|size divisor|absent|features
needs="ambient occlusion only|reblur_diffuse_occlusion|1|materials|0
sun shadow only|sigma_shadow|1||0
diffuse GI at half resolution|reblur_diffuse|2|materials|0
glossy reflections only|reblur_specular|1|materials|0
everything|reblur_diffuse_specular,reblur_diffuse_occlusion,sigma_shadow|1||15"

plan_of() { # denoisers, size, absent, features
    "$bench" --plan 1 --denoiser "$1" --size "$2" --absent "$3" --features "$4" |
        sed -n 's/^plan: .*: \([0-9]*\) passes, \([0-9]*\) modules, \([0-9.]*\) kB SPIR-V, \([0-9.]*\) MB$/\1|\2|\3|\4/p'
}

times_of() { # denoisers, size, absent, features, frames
    "$bench" --denoiser "$1" --size "$2" --absent "$3" --features "$4" --frames "$5" | awk -v size="$2" '
        / us  total/ { us = $1 } / ms  creation/ { ms = $1 } /, median of/ { sub(/, [a-z_,]*, [0-9]*x[0-9]*, median.*/, ""); device = $0 }
        END { if (us == "") exit 1; printf "%s|%s|%s, %s", ms, us, device, size }'
}

half() { echo "$1" | awk -Fx -v by="$2" '{ printf "%dx%d", $1 / by, $2 / by }'; }

rows() { # plan or run, time size, frames
    echo "$needs" | while IFS='|' read -r need denoisers divisor absent features; do
        size=$(half 1920x1080 "$divisor")
        printf '%s|%s|%s|%s|%s|%s|' "$need" "$denoisers" "$size" "$absent" "$features" "$(plan_of "$denoisers" "$size" "$absent" "$features")"
        [ "$1" = plan ] && echo '||' || echo "$(times_of "$denoisers" "$(half "$2" "$divisor")" "$absent" "$features" "$3")"
    done
}

publish() {
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    grep -q '^everything|' "$1" || { echo "needs: $1 has no row for everything" >&2; exit 1; }
    awk -F'|' '
        FNR == NR { if ($1 == "everything") { whole = $11; place = $12 } next }
        FNR == 1 { printf "Passes to memory at 1920x1080; creation (no pipeline cache) and time on %s.\n\n", place
                   print "| need | denoisers | absent | passes | modules | SPIR-V kB | MB | creation ms | µs | of everything |\n|---|---|---|---|---|---|---|---|---|---|" }
        { printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s | %.1f %% |\n", $1, $2, $4, $6, $7, $8, $9, $10, $11, 100 * $11 / whole }' "$1" "$1" > "$work/table"
    awk -v with="$work/table" '
        /<!-- needs end/ { skip = 0 } !skip { print }
        /<!-- needs begin/ { while ((getline line < with) > 0) print line; skip = 1 }' README.md > "$work/new"
    cat "$work/new" > README.md
}

case ${1:-} in
    plan) rows plan ;;
    run) rows run "${2:-1920x1080}" "${3:-60}" ;;
    publish) publish "${2:?needs.sh publish ROWS}" ;;
    *) sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
