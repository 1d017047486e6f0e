#!/usr/bin/env bash
# Fails and names each line of Rust longer than rustfmt's max_width. rustfmt leaves strings and comments alone.
set -euo pipefail
cd "$(dirname "$0")/.."
width=$(sed -n 's/^max_width = //p' rustfmt.toml)
if git ls-files -z '*.rs' | LC_ALL=C.UTF-8 xargs -0 grep -nE "^.{$((width + 1)),}" >&2; then
    printf 'these lines have more than %s characters (rustfmt.toml)\n' "$width" >&2
    exit 1
fi
