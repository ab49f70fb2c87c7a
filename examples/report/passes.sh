#!/bin/sh
# passes.sh: how long every pass of every denoiser takes, which nrd_explain tells; from the repository root.
#   passes.sh run [SIZE] [N]   rows of the first device, at SIZE (2560x1440), medians of N (40) frames; NRD_BUILD: another build
#   passes.sh publish ROWS     puts a file of rows in place of published_passes.txt, and into nrd.h, between the marks
# A row: device|size|denoiser|pass|nanoseconds per pixel
set -eu
known=examples/report/published_passes.txt

denoisers() { sed -n '/^#define NRD_DENOISERS(X)/,/[^\\]$/s/.*X([A-Z_]*, "\([a-z_]*\)".*/\1/p' nrd.h; }

# Rows of nrdi_pass_ns, a number for each pass.
table() {
    awk -F'|' 'function close_row() { if (line != "") print line " },\n#endif" }
        $3 != last { close_row(); last = $3; print "#if NRDI_WITH(" toupper(last) ")"; line = "    {"; comma = "" }
        { line = line comma " " $5 "f"; comma = "," }
        END { close_row() }' "$1"
}

publish() { # rows
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    cut -d'|' -f3 "$1" | uniq > "$work/has"
    denoisers > "$work/needs"
    cmp -s "$work/has" "$work/needs" && ! grep -vq '^[^|]*|[0-9]*x[0-9]*|[a-z_]*|[^|]*|0\.[0-9]*[1-9][0-9]*$' "$1" ||
        { echo "passes: $1 has not a time for every denoiser, in the order of nrd.h" >&2; exit 1; }
    table "$1" > "$work/table"
    cat "$1" > "$work/known"
    cat "$work/known" > "$known"
    . examples/report/marks.sh
    replace nrd.h ">>pass times" "$work/table"
}

case ${1:-} in
    run) "${NRD_BUILD:-build}/nrd-bench" --costs 1 --denoiser "$(denoisers | paste -sd, -)" --size "${2:-2560x1440}" --frames "${3:-40}" ;;
    publish) [ $# -eq 2 ] || { echo "passes: publish ROWS" >&2; exit 2; }; publish "$2" ;;
    *) sed -n '2,5s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
