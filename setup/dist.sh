#!/usr/bin/env bash
# Packs the release archive OUT/hoverlock-VERSION-MACHINE.tar.gz from the command, a folder of Python wheels and this checkout.
# Usage: setup/dist.sh COMMAND WHEELS OUT
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -eq 3 ] || { echo "usage: setup/dist.sh COMMAND WHEELS OUT" >&2; exit 2; }
command=$1 wheels=$2 out=$3

version=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)
name="hoverlock-$version-$(uname -m)-linux"
mkdir -p "$out"
work=$(mktemp -d "$out/packing.XXXXXX")
trap 'rm -rf "$work"' EXIT
root="$work/$name"
mkdir -p "$root/bin" "$root/share/man/man1" "$root/share/bash-completion/completions"

install -m 755 "$command" "$root/bin/hoverlock"
"$command" man "$root/share/man/man1" >/dev/null
"$command" completions bash >"$root/share/bash-completion/completions/hoverlock"
cp -r "$wheels" "$root/wheels"
# Verilog, register map and Platform Designer component keep their places, as the component names the Verilog by ../verilog.
mkdir "$root/rtl"
cp -r rtl/verilog rtl/registers rtl/quartus "$root/rtl/"
cp registers/src/kt27.rs "$root/rtl/registers/hoverlock_registers.rs"
cp -r designs LICENSE LICENSE-APACHE LICENSE-MIT CHANGELOG.md "$root/"
# Documents as in the checkout, so that links between them work.
git ls-files -z '*.md' 'docs/*' 'reports/report.png' | grep -zv '^docs/tables/' |
    while IFS= read -r -d '' file; do install -D -m 644 "$file" "$root/$file"; done
cat >"$root/INSTALL.md" <<TEXT
# Hoverlock $version

| folder | content |
|---|---|
| \`bin/hoverlock\` | the command: \`hoverlock --help\`; \`hoverlock doctor\` lists what is missing |
| \`wheels/\` | the Python packages: \`pip install wheels/*.whl\` |
| \`rtl/\` | Verilog, register map, and the Platform Designer component in \`rtl/quartus\` |
| \`designs/\` | the design files |
| \`share/\` | manual pages and shell completion |
| \`docs/\`, \`README.md\` | the documents; parts that refer to sources need the repository |

\`hoverlock sim PICTURE --rtl rtl/verilog\` simulates this Verilog; Verilator and a C++ compiler are needed. To emit another design, the
sources are needed.
TEXT

# The same files give the same archive: sorted names, the date of the commit, no owner.
tar --sort=name --mtime="@$(git show -s --format=%ct)" --owner=0 --group=0 --numeric-owner -C "$work" -c "$name" | gzip -n >"$work/archive"
mv "$work/archive" "$out/$name.tar.gz"
echo "$out/$name.tar.gz"
