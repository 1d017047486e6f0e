#!/usr/bin/env bash
# Names the tests that a log of `make test` says were skipped, and how to run them. Rust tests write "SKIPPED: name: what to do"
# to stderr itself, as what `eprintln!` prints is captured; pytest prints "SKIPPED [n] place: reason".
set -euo pipefail
log=$1
skipped=$(grep -oE 'SKIPPED(: | \[[0-9]+\] ).*' "$log" | sort -u || true)
if [ -z "$skipped" ]; then
    echo "no test was skipped"
else
    printf '%s tests were skipped:\n%s\n' "$(wc -l <<<"$skipped")" "$skipped"
fi
