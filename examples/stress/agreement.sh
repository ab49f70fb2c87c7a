#!/bin/sh
# agreement.sh: how far devices agree on the same frames; from the repository root. NRD_BUILD: another build.
#   agreement.sh dump FILE         what the first device gives, to be carried to others
#   agreement.sh run FILE          rows of the first device against the one that wrote the file, and against itself when the frames run again
#   agreement.sh table             README's table, of what is published
#   agreement.sh publish ROWS...   takes files of rows into published_agreement.txt, in place of those of the same devices, and writes the table
#                                  into README.md, between the marks
# A row: device|the other|denoiser|rms difference|most|share of pixels|most|values that differ when repeated
set -eu
known=examples/stress/published_agreement.txt
stress=${NRD_BUILD:-build}/nrd-stress

dump() { "$stress" --quiet --only agreement --dump "$1" > /dev/null; }

# The worst of all scenes. A line: ok or FAIL, denoiser, scene, guarantee, number, "of", most.
run() {
    other=$(sed -n '1s/^device //p' "$1")
    [ -n "$other" ] || { echo "agreement: $1 names no device; agreement.sh dump FILE writes one" >&2; exit 1; }
    "$stress" --only agreement --compare "$1" | awk -v other="$other" '
        /^(ok|FAIL)/ { sub(/DEVICES_8_BIT/, "DEVICES")
                       if (!($2 in seen)) { seen[$2]; name[++denoisers] = $2 }
                       if (!(($2, $(NF - 3)) in worst) || $(NF - 2) + 0 > worst[$2, $(NF - 3)] + 0) worst[$2, $(NF - 3)] = $(NF - 2)
                       most[$2, $(NF - 3)] = $NF }
        blank { device = $0 }
        { blank = $0 == "" }
        END { for (d = 1; d <= denoisers; d++)
                  print device "|" other "|" name[d] "|" worst[name[d], "DEVICES"] "|" most[name[d], "DEVICES"] "|" worst[name[d], "DEVICES_FLIPS"] "|" most[name[d], "DEVICES_FLIPS"] "|" worst[name[d], "REPEAT"] }'
}

table() {
    awk -F'|' '
        !($1 in place) { place[$1] = ++devices; short = $1; sub(/ \(.*, /, ", ", short); sub(/\)$/, "", short); head = head " | " short " | pixels | repeated"; rule = rule "|---|---|---" }
        NR == 1 { print "Difference to " $2 ", all channels, root mean square over that of the picture; share of the pixels that differ by more than a fifth of"
                  print "that, at most " $7 "; values that differ when the same frames run again.\n" }
        { if (!($3 in line)) name[++denoisers] = $3
          most[$3] = $5; line[$3] = line[$3] " | " $4 " | " $6 " | " $8 }
        END { print "| | at most" head " |\n|---|---" rule "|"; for (d = 1; d <= denoisers; d++) print "| " name[d] " | " most[name[d]] line[name[d]] " |" }' "$known"
}

publish() {
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    for file in "$@"; do
        grep -q '^..*|..*|reblur_diffuse|[0-9.e-]*|[0-9.e-]*|[0-9.e-]*|[0-9.e-]*|[0-9]*$' "$file" || { echo "agreement: $file has no rows of a comparison" >&2; exit 1; }
    done
    [ -f "$known" ] || : > "$known"
    awk -F'|' -v known="$known" '
        FILENAME != known { if (!($1 in now)) order[++devices] = $1; now[$1] = now[$1] $0 "\n"; next }
        !($1 in now) { print; next }
        { printf "%s", now[$1]; now[$1] = "" }
        END { for (d = 1; d <= devices; d++) printf "%s", now[order[d]] }' "$@" "$known" > "$work/known"
    cat "$work/known" > "$known"
    table > "$work/table"
    . examples/report/marks.sh
    replace README.md "<!-- agreement" "$work/table"
}

case ${1:-}/$# in
    dump/2) dump "$2" ;;
    run/2) run "$2" ;;
    table/1) table ;;
    publish/1) echo "agreement: publish ROWS..." >&2; exit 2 ;;
    publish/*) shift; publish "$@" ;;
    *) sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
