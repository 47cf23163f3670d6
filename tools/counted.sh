#!/usr/bin/env bash
# Runs targets of the Makefile one after another, all of them though one fails, and sums up their tests in the last line:
# `tools/counted.sh TARGET...`. With `--beside "TARGET..."` first, these are built at the same time; the target `beside`
# in the list waits for them and shows what they printed.
set -uo pipefail
cd "$(dirname "$0")/.."
kept=target/counted
mkdir -p "$kept"
log=$(mktemp "$kept/XXXXXX")
trap 'rm -f "$log" "$log.beside"; [ -z "${beside-}" ] || kill "$beside" 2>/dev/null' EXIT
began=$(date +%s)

name=$1
shift
beside=
if [ "${1-}" = --beside ]; then
    # shellcheck disable=SC2086
    make --no-print-directory -k $2 >"$log.beside" 2>&1 &
    beside=$!
    beside_targets=$2
    shift 2
fi

failed=()
for target in "$@"; do
    if [ "$target" = beside ]; then
        wait "$beside" || failed+=("$beside_targets")
        cat "$log.beside"
    else
        make --no-print-directory "$target" 2>&1 | tee -a "$log" || failed+=("$target")
    fi
done

# As both test harnesses print it, one line a program.
sums=$(awk '/^test result:/ { for (i = 2; i <= NF; i++) {
        if ($i ~ /^passed/) p += $(i - 1); if ($i ~ /^failed/) f += $(i - 1); if ($i ~ /^ignored/) g += $(i - 1) } n++ }
    END { printf "%d passed, %d failed, %d ignored in %d programs", p, f, g, n }' "$log")
seconds=$(($(date +%s) - began))
verdict=passed
[ ${#failed[@]} -eq 0 ] || verdict="FAILED in: ${failed[*]}"
echo "make $name: $verdict; tests: $sums; $((seconds / 60)) min $((seconds % 60)) s"
[ ${#failed[@]} -eq 0 ]
