#!/bin/sh
# needs.sh: README's table of five engines' needs is made anew, from what the SDK is made of today and the times as published, and compared.
# Run from the repository root after `make examples`; prints one line per row and a total, exits 1 if any row differs.
set -u

. tests/shell/report.sh

sh examples/report/needs.sh plan > "$work/rows" 2> "$work/log" || cat "$work/log"
sh examples/report/needs.sh table > "$work/table" 2> "$work/log" || cat "$work/log"
sed '1,/<!-- needs begin/d; /<!-- needs end/,$d' README.md > "$work/published"
# SPIR-V, which every change of a shader moves, within 10 %; all else to the letter.
line=0
while IFS= read -r row; do
    line=$((line + 1))
    [ -n "$row" ] || continue
    sed -n "${line}p" "$work/published" > "$work/other"
    printf 'now:       %s\npublished: %s\nneeds.sh run > ROWS on each device; needs.sh publish ROWS...\n' "$row" "$(cat "$work/other")" > "$work/log"
    printf '%s\n' "$row" | awk -F' *[|] *' -v path="$work/other" '
        { getline other < path; split(other, o); ok = NF > 1 ? NF == split(other, o) : $0 == other
          for (i = 1; i <= NF && ok; i++) ok = $i == o[i] || (i == 7 && $i > 0.9 * o[i] && $i < 1.1 * o[i])
          exit !ok }'
    report $? "$(printf '%s' "$row" | cut -c1-100)"
done < "$work/table"
[ "$(wc -l < "$work/table")" = "$(wc -l < "$work/published")" ]
report $? "no other rows"

# Every device has times of all five.
awk -F'|' '{ n[$1]++; if (!($4 > 0 && $5 > 0)) bad = 1 } END { for (d in n) { devices++; bad = bad || n[d] != 5 } exit bad || devices < 2 }' examples/report/published_needs.txt
report $? "times of all five needs on every device, two at least"

# Each of the four needs less of everything than the whole.
awk -F'|' '{ for (i = 6; i <= 9; i++) v[NR, i] = $i } END { ok = NR == 5; for (r = 1; r < NR; r++) for (i = 6; i <= 9; i++) ok = ok && v[r, i] + 0 < v[NR, i] + 0; exit !ok }' "$work/rows"
report $? "every part needs less than everything"

total needs
