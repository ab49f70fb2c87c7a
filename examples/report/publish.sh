#!/bin/sh
# publish.sh: what README.md and nrd.h say of error against run time; from the repository root.
#   publish.sh run FOLDER [OPTIONS]  measures what is published with the nrd-report of NRD_BUILD (build) on its first device
#   publish.sh take FOLDER...        takes finished reports, one per device, into examples/report/published*.txt, in place of what is
#                                    there of these devices, and writes from it: nrd.h (what nrd_suggest knows), README.md (tables)
#                                    and examples/report.svg (chart). Everything between the marks is replaced.
set -eu
usage() { sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2; }
[ $# -gt 1 ] || usage
verb=$1
shift
case $verb in
    run) folder=$1; shift; exec "${NRD_BUILD:-build}/nrd-report" "$folder" --scenes interior,moving,glass --paths 1 "$@" ;;
    take) ;;
    *) usage ;;
esac
for folder in "$@"; do
    for file in report.csv tiles.csv; do
        [ -f "$folder/$file" ] || { echo "publish: $folder/$file is not there" >&2; exit 1; }
    done
done
known=examples/report/published.txt
known_tiles=examples/report/published_tiles.txt
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# One line per device, denoiser and preset at one path per pixel: geometric means over scenes and signals (but `final`, which
# contains the others), and what the same scenes and signals have as noisy input, filtered, and traced with more paths instead.
# device|class|size|denoiser|preset|ns per pixel|ms|motion|rest|flicker|flip|noisy|filtered|paths
for folder in "$@"; do
    awk '
    function add(key, i, value) { if (value > 0) { sum[key, i] += log(value); used[key, i]++ } }
    function mean(key, i) { return used[key, i] ? sprintf("%.4g", exp(sum[key, i] / used[key, i])) : "" }
    NR == 1 { n = split($0, names, ","); for (i = 1; i <= n; i++) column[names[i]] = i; next }
    { match($0, /^"[^"]*"/); device = substr($0, 2, RLENGTH - 2); $0 = "x" substr($0, RLENGTH + 1); split($0, v, ",")
      if (v[column["paths"]] != 1 || v[column["signal"]] == "final") next
      class = device ~ /llvmpipe/ ? "CPU" : device ~ /H[12]00/ ? "DATACENTER" : ""
      size = v[column["time_width"]] "x" v[column["time_height"]]
      place = v[column["scene"]] "|" v[column["width"]] "|" v[column["signal"]]
      error = v[column["motion_trimmed"]]
      if (v[column["kind"]] == "noisy") noisy[place] = error
      if (v[column["kind"]] == "spatial") filtered[place, v[column["denoiser"]]] = error
      if (v[column["kind"]] == "more paths") traced[place, v[column["denoiser"]]] = error
      if (v[column["kind"]] != "denoiser") next
      key = v[column["denoiser"]] "|" v[column["preset"]]
      if (!(key in places)) order[++keys] = key
      places[key] = places[key] " " place
      m = split("ns_per_pixel ms motion_trimmed rest_trimmed rest_flicker motion_flip", wanted, " ")
      for (i = 1; i <= m; i++) add(key, i, v[column[wanted[i]]]) }
    END { for (k = 1; k <= keys; k++) {
              key = order[k]; line = device "|" class "|" size "|" key; split(key, part, "|"); count = split(places[key], list, " ")
              for (i = 1; i <= count; i++) {
                  add(key, "noisy", noisy[list[i]])
                  if (part[2] == "balanced") { add(key, "filtered", filtered[list[i], part[1]]); add(key, "traced", traced[list[i], part[1]]) } }
              for (i = 1; i <= m; i++) line = line "|" mean(key, i)
              print line "|" mean(key, "noisy") "|" mean(key, "filtered") "|" mean(key, "traced") } }' "$folder/report.csv" >> "$work/new"
done
# One line per device, denoiser and share of active tiles: device|size|denoiser|active|ms
for folder in "$@"; do
    awk 'NR > 1 { match($0, /^"[^"]*"/); device = substr($0, 2, RLENGTH - 2); split(substr($0, RLENGTH + 2), v, ",")
                  print device "|" v[2] "x" v[3] "|" v[1] "|" v[5] "|" v[6] }' "$folder/tiles.csv" >> "$work/new_tiles"
done

# File $1 with the lines of the devices of file $2 in place of its own.
merge() {
    [ -f "$1" ] || : > "$1"
    awk -F'|' 'FNR == NR { now[$1] = now[$1] $0 "\n"; next } !($1 in now) { print; next } { printf "%s", now[$1]; now[$1] = "" }
               END { for (device in now) printf "%s", now[device] }' "$2" "$1"
}
merge "$known" "$work/new" > "$work/rows"
merge "$known_tiles" "$work/new_tiles" > "$work/tiles"
if ! cut -d'|' -f2 "$work/rows" | grep -q .; then
    echo "publish: the device is of no class that nrd.h knows: $(cut -d'|' -f1 "$work/rows" | sort -u)" >&2
    exit 1
fi

. examples/report/marks.sh
awk -F'|' '$2 != "" && $8 > 0 && ",fastest,fast,balanced,good,best," ~ "," $5 "," {
    printf "    NRDI_COST(%s, %s, %s, %sf, %sf)\n", toupper($4), toupper($5), $2, $6 ~ /[.e]/ ? $6 : $6 ".0", $8 ~ /[.e]/ ? $8 : $8 ".0" }' "$work/rows" > "$work/costs"
replace nrd.h ">>costs" "$work/costs"

awk -F'|' '
$1 != device { device = $1; printf "%s%s, times at %s\n\n", (NR > 1 ? "\n" : ""), $1, $3
    print "| | ms | ns/px | relMSE in motion | noisy input | filter instead | paths instead | at rest | flicker at rest | FLIP |\n|---|---|---|---|---|---|---|---|---|---|" }
{ printf "| %s %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", $4, $5, $7, $6, $8, $12, $13, $14, $9, $10, $11 }' "$work/rows" > "$work/table"
replace README.md "<!-- report" "$work/table"

# Times against active tiles, of GPUs.
awk -F'|' '
function show(i) { if (denoisers) print head " |\n" rule "|"; for (i = 1; i <= denoisers; i++) print "| " name[i] line[name[i]] " |"; split("", line); denoisers = 0 }
$1 ~ /llvmpipe/ { next }
$1 != device { show(); device = $1; head = "| ms on " $1 ", " $2 "; tiles that are not all sky"; rule = "|---"; split("", seen) }
{ if (!($4 in seen)) { seen[$4]; head = head sprintf(" | %.4g %%", 100 * $4); rule = rule "|---" }
  if (!($3 in line)) name[++denoisers] = $3
  line[$3] = line[$3] ($5 == "" ? " | " : sprintf(" | %.3f", $5)) }
END { show() }' "$work/tiles" > "$work/tile_table"
replace README.md "<!-- tiles" "$work/tile_table"

# The chart: error against nanoseconds per pixel, both logarithmic, one panel per device; a line through the presets of a denoiser.
awk -F'|' '
function lx(x) { return 70 + (log(x) - x0[d]) / (x1[d] - x0[d]) * 620 }
function ly(y) { return 360 * d - 40 - (log(y) - y0[d]) / (y1[d] - y0[d]) * 280 }
function least(a, b) { return a < b ? a : b }
function mark(at, error, who, filled) {
    if (!($1 in panel)) { panel[$1] = ++panels; title[panels] = $1; x0[panels] = y0[panels] = 1e9; x1[panels] = y1[panels] = -1e9 }
    n++; d = place[n] = panel[$1]; x[n] = at; y[n] = error; name[n] = who; full[n] = filled
    x0[d] = least(x0[d], log(at / 1.3)); x1[d] = -least(-x1[d], -log(at * 3)); y0[d] = least(y0[d], log(error / 1.5)); y1[d] = -least(-y1[d], -log(error * 1.5)) }
function is_free(left, right, at, k) { # no label is there
    for (k = 1; k <= labels; k++) if (left < rights[k] && right > lefts[k] && at - tops[k] < 10 && tops[k] - at < 10) return 0
    return 1 }
function put_label(text, at_x, at_y, k, try) {
    for (try = 0; try < 40; try++) { k = at_y + (try % 2 ? -1 : 1) * int((try + 1) / 2) * 5; if (is_free(at_x, at_x + 5.2 * length(text), k)) break }
    labels++; lefts[labels] = at_x; rights[labels] = at_x + 5.2 * length(text); tops[labels] = k
    printf "<text x=\"%.1f\" y=\"%.1f\" fill=\"#333\">%s</text>\n", at_x, k, text }
$6 > 0 && $8 > 0 { mark($6, $8, $4, $5 == "balanced" ? 2 : 1) }
$6 > 0 && $13 > 0 { mark($6, $13, "", 0) }
END {
    printf "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 720 %d\" font-family=\"sans-serif\" font-size=\"10\">\n<rect width=\"720\" height=\"%d\" fill=\"#fff\"/>\n", 360 * panels + 20, 360 * panels + 20
    for (d = 1; d <= panels; d++) {
        printf "<rect x=\"70\" y=\"%d\" width=\"620\" height=\"280\" fill=\"none\" stroke=\"#ccc\"/><text x=\"70\" y=\"%d\" fill=\"#0b62c4\">%s</text>\n", 360 * d - 320, 360 * d - 327, title[d]
        for (e = -4; e <= 6; e++) for (k = 1; k <= 5; k += k == 2 ? 3 : 1) { t = k * exp(e * log(10))
            if (log(t) > x0[d] && log(t) < x1[d]) printf "<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%d\" y2=\"%d\" stroke=\"#eee\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\" fill=\"#666\">%g</text>\n", lx(t), lx(t), 360 * d - 320, 360 * d - 40, lx(t), 360 * d - 26, t
            if (log(t) > y0[d] && log(t) < y1[d]) printf "<line y1=\"%.1f\" y2=\"%.1f\" x1=\"70\" x2=\"690\" stroke=\"#eee\"/><text x=\"64\" y=\"%.1f\" text-anchor=\"end\" fill=\"#666\">%g</text>\n", ly(t), ly(t), ly(t) + 4, t }
        for (i = 1; i < n; i++) for (k = i + 1; k <= n; k++) # the next preset of the same denoiser
            if (place[i] == d && place[k] == d && full[i] && full[k] && name[i] == name[k]) { printf "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" stroke=\"#9bc0ea\"/>\n", lx(x[i]), ly(y[i]), lx(x[k]), ly(y[k]); break }
        for (i = 1; i <= n; i++) if (place[i] == d) printf "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%d\" stroke=\"#0b62c4\" fill=\"%s\"/>\n", lx(x[i]), ly(y[i]), full[i] == 2 ? 4 : 3, full[i] ? "#0b62c4" : "#fff"
        for (i = 1; i <= n; i++) if (place[i] == d && full[i] == 2) put_label(name[i], lx(x[i]) + 7, ly(y[i]) + 4)
        printf "<text x=\"380\" y=\"%d\" text-anchor=\"middle\">nanoseconds per pixel</text>\n", 360 * d - 10 }
    print "<text x=\"70\" y=\"14\">trimmed relMSE in motion, one path per pixel; named: balanced, on its line: faster presets; hollow: a plain filter of the same time</text></svg>"
}' "$work/rows" > examples/report.svg
cat "$work/rows" > "$known"
cat "$work/tiles" > "$known_tiles"
echo "publish: $(wc -l < "$work/costs") presets in nrd.h, $(wc -l < "$work/rows") rows in README.md, examples/report.svg"
