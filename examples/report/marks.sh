# marks.sh: for the scripts that publish, which read it in from the repository root.

# Replaces what lies between the lines with "$2 begin" and "$2 end" in file $1 by file $3.
replace() {
    grep -q "$2 begin" "$1" && grep -q "$2 end" "$1" || { echo "publish: $1 has no marks '$2 begin' and '$2 end'" >&2; exit 1; }
    awk -v mark="$2" -v with="$3" '
        index($0, mark " end") { skip = 0 }
        !skip { print }
        index($0, mark " begin") { while ((getline line < with) > 0) print line; skip = 1 }' "$1" > "$3.replaced"
    cat "$3.replaced" > "$1"
}
