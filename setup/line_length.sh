#!/usr/bin/env bash
# Fails and names each line that is too long.
#   Rust                  max_width of rustfmt.toml, as rustfmt leaves strings and comments alone. Not the emitted constants, whose
#                         comments are descriptions of the register map
#   Verilog by hand       160: an assertion is read as one line
#   emitted Verilog       340: the concatenation of a ring's 32 points is one line
set -euo pipefail
cd "$(dirname "$0")/.."

status=0
# limit WIDTH PATHSPEC..
limit() {
    local width=$1
    shift
    if git ls-files -z "$@" | LC_ALL=C.UTF-8 xargs -0 --no-run-if-empty grep -nE "^.{$((width + 1)),}" >&2; then
        printf 'these lines have more than %s characters (setup/line_length.sh)\n' "$width" >&2
        status=1
    fi
}
limit "$(sed -n 's/^max_width = //p' rustfmt.toml)" '*.rs' ':!registers/src/kt27.rs'
limit 160 '*.v' '*.sv' '*.vh' ':!rtl/verilog'
limit 340 'rtl/verilog/*.v' 'rtl/verilog/*.vh'
exit $status
