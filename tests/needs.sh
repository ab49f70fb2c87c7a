#!/bin/sh
# needs.sh: README's table of five engines' needs says what the SDK does today: every column without times is made anew and compared. Run from the
# repository root after `make examples`; prints one line per row and a total, exits 1 if any row differs.
set -u

. tests/shell/report.sh

sh examples/report/needs.sh plan > "$work/rows" 2> "$work/log" || cat "$work/log"
sed -n '/<!-- needs begin/,/<!-- needs end/p' README.md > "$work/table"
# SPIR-V, which every change of a shader moves, within 10 %.
while IFS='|' read -r need denoisers _ absent _ passes modules spirv memory _; do
    echo "README.md should have these numbers: sh examples/report/needs.sh run > rows, publish rows" > "$work/log"
    awk -F' *[|] *' -v need="$need" -v denoisers="$denoisers" -v absent="$absent" -v passes="$passes" -v modules="$modules" -v spirv="$spirv" -v memory="$memory" '
        $2 == need && $3 == denoisers && $4 == absent && $5 == passes && $6 == modules && $8 == memory && $7 > 0.9 * spirv && $7 < 1.1 * spirv { found = 1 }
        END { exit !found }' "$work/table"
    report $? "$need: $passes passes, $modules modules, $spirv kB, $memory MB"
done < "$work/rows"

# Each of the four needs less of everything than the whole.
awk -F'|' '{ for (i = 6; i <= 9; i++) v[NR, i] = $i } END { ok = NR == 5; for (r = 1; r < NR; r++) for (i = 6; i <= 9; i++) ok = ok && v[r, i] + 0 < v[NR, i] + 0; exit !ok }' "$work/rows"
report $? "every part needs less than everything"

total needs
