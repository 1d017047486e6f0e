#!/usr/bin/env bash
# Lists the tests that were skipped according to a log of `make test`, and how to run them. Rust tests write "SKIPPED: name: what to do"
# to stderr directly, because the output of `eprintln!` is captured; pytest prints "SKIPPED [n] place: reason".
set -euo pipefail
log=$1
skipped=$(grep -oE 'SKIPPED(: | \[[0-9]+\] ).*' "$log" | sort -u || true)
if [ -z "$skipped" ]; then
    echo "no test was skipped"
else
    printf '%s tests were skipped:\n%s\n' "$(wc -l <<<"$skipped")" "$skipped"
fi
