#!/bin/sh
# publish.sh: writes into README.md, between the marks, the guarantees with what nrd-stress of NRD_BUILD (build) measures on the first device, and what
# rounding costs every pass of every denoiser; from the repository root. Takes some two minutes. A broken guarantee publishes nothing.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
LP_NUM_THREADS=0 "${NRD_BUILD:-build}/nrd-stress" --markdown > "$work/log" || { grep '^FAIL' "$work/log" >&2; exit 1; }

{
    printf '| | at most | measured | worst |\n|---|---|---|---|\n'
    grep '^| ' "$work/log"
} > "$work/guarantees"

# A table for each family: passes down, its denoisers across; a cell: computing in 32 bits, storing. Lines: ok, denoiser, [directions:] pass, one of
# "in 32 bits" and "stored as on the device", guarantee, number, "of", most.
awk '
    function family(name) { return name ~ /sigma/ ? "shadows" : name ~ /occlusion/ ? "occlusion" : name ~ /reblur/ ? "light" : "the mean" }
    /^ok .* (in 32 bits|stored as on the device) / {
        kind = / in 32 bits / ? 1 : 2; f = family($2); name = $2; pass = $3
        for (i = 4; i <= NF && !($i == "in" && $(i + 1) == "32") && $i != "stored"; i++) pass = pass " " $i
        if (sub(/^directions: /, "", pass)) pass = pass ", directions"
        if (!(f in families)) { families[f]; order[++n] = f }
        if (!((f, name) in known)) { known[f, name]; names[f, ++columns[f]] = name }
        if (!((f, pass) in known)) { known[f, pass]; passes[f, ++rows[f]] = pass }
        cost[f, name, pass, kind] = $(NF - 2) }
    END { for (o = 1; o <= n; o++) {
              f = order[o]; head = "| " f; rule = "|---"
              for (c = 1; c <= columns[f]; c++) { head = head " | " names[f, c]; rule = rule "|---" }
              print (o > 1 ? "\n" : "") head " |\n" rule "|"
              for (r = 1; r <= rows[f]; r++) {
                  line = "| " passes[f, r]
                  for (c = 1; c <= columns[f]; c++) {
                      name = names[f, c]; pass = passes[f, r]
                      line = line " | " ((f, name, pass, 1) in cost ? sprintf("%.1e, %.1e", cost[f, name, pass, 1], cost[f, name, pass, 2]) : "") }
                  print line " |" } } }' "$work/log" > "$work/rounding"

. examples/report/marks.sh
for table in guarantees rounding; do replace README.md "<!-- $table" "$work/$table"; done
