#!/bin/sh
# needs.sh: what five typical engines pay, each with the denoisers that it needs and nothing else; from the repository root.
#   needs.sh plan              rows without times: touches no device
#   needs.sh run [SIZE] [N]    rows with times on the first device, at SIZE (1920x1080), medians of N (60) frames; NRD_BUILD: another build
#   needs.sh table             README's table: what the SDK is made of today, times as published
#   needs.sh publish ROWS...   takes the times of files of rows into published_needs.txt, in place of those of the same devices, and writes
#                              the table into README.md, between the marks
# A row: need|denoisers|size|absent|features|passes|modules|kB of SPIR-V|MB|creation ms|us|device, time size
set -eu
known=examples/report/published_needs.txt   # device|time size|need|creation ms|us
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

# Three columns for each device, in the order of the file of times.
table() {
    rows plan | awk -F'|' '
        function short(device) { sub(/^NVIDIA /, "", device); sub(/ \(.*/, "", device); return device }
        FNR == NR { if (!($1 in place)) { name[++devices] = $1; place[$1] = $1 ", " $2 }
                    ms[$1, $3] = $4; us[$1, $3] = $5; next }
        FNR == 1 { printf "Passes to memory at 1920x1080; creation (no pipeline cache) and time on "
                   for (d = 1; d <= devices; d++) printf "%s%s", (d > 1 ? " and on " : ""), place[name[d]]
                   printf ".\n\n| need | denoisers | absent | passes | modules | SPIR-V kB | MB"; rule = "|---|---|---|---|---|---|---"
                   for (d = 1; d <= devices; d++) { printf " | %s creation ms | µs | of everything", short(name[d]); rule = rule "|---|---|---" }
                   print " |\n" rule "|" }
        { printf "| %s | %s | %s | %s | %s | %s | %s", $1, $2, $4, $6, $7, $8, $9
          for (d = 1; d <= devices; d++) printf " | %s | %s | %.1f %%", ms[name[d], $1], us[name[d], $1], 100 * us[name[d], $1] / us[name[d], "everything"]
          print " |" }' "$known" -
}

publish() {
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    for file in "$@"; do
        grep -q '^everything|.*|[0-9.]*|[0-9.]*|..*, [0-9]*x[0-9]*$' "$file" || { echo "needs: $file has no row for everything with times" >&2; exit 1; }
    done
    [ -f "$known" ] || : > "$known"
    # The size is that of the whole picture: the last row's.
    awk -F'|' -v known="$known" '
        FILENAME != known { need[++n] = $1; ms[n] = $10; us[n] = $11; device = $12; sub(/, [0-9]*x[0-9]*$/, "", device); size = substr($12, length(device) + 3) }
        FILENAME != known && $1 == "everything" { now[device] = ""; for (i = 1; i <= n; i++) now[device] = now[device] device "|" size "|" need[i] "|" ms[i] "|" us[i] "\n"; n = 0 }
        FILENAME == known { if (!($1 in now)) print; else { printf "%s", now[$1]; now[$1] = "" } }
        END { for (device in now) printf "%s", now[device] }' "$@" "$known" > "$work/known"
    cat "$work/known" > "$known"
    table > "$work/table"
    . examples/report/marks.sh
    replace README.md "<!-- needs" "$work/table"
}

case ${1:-} in
    plan) rows plan ;;
    run) rows run "${2:-1920x1080}" "${3:-60}" ;;
    table) table ;;
    publish) [ $# -gt 1 ] || { echo "needs: publish ROWS..." >&2; exit 2; }; shift; publish "$@" ;;
    *) sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
