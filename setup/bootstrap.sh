#!/usr/bin/env bash
# Installs what `make demo` and `make test` need besides Rust, and reports each step. Later runs are quick and silent. It installs
# Debian packages (setup/tools.txt), a Python venv (setup/requirements.txt), and the photographs of Debian's
# opencv-doc, which go into the cache folder and are not distributed with the project. Arguments are further Debian
# packages, each with the name of its command.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf 'setup: %s\n' "$*"; }
stop() { printf 'setup: %s\n' "$*" >&2; exit 2; }

if ! command -v cargo >/dev/null; then
    [ -x "$HOME/.cargo/bin/cargo" ] || stop "cargo is not installed; install Rust with rustup, then run this again"
fi

# apt-get as root: as it is, or through sudo.
apt() {
    command -v apt-get >/dev/null || stop "apt-get is missing, so this is not Debian; install by hand: $missing"
    if [ "$(id -u)" -eq 0 ]; then
        DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@" </dev/null
    else
        command -v sudo >/dev/null || stop "neither root nor sudo; as root run: apt-get install $missing"
        sudo DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@"
    fi
}

# Debian packages whose command is not on the PATH, or whose file does not exist.
missing=""
while IFS='|' read -r package command _; do
    package=${package// /} command=${command// /}
    [[ -z $package || $package == \#* ]] && continue
    [[ $command == /* && -e $command ]] || command -v "$command" >/dev/null || missing+="$package "
done <setup/tools.txt
for package in "$@"; do
    command -v "$package" >/dev/null || missing+="$package "
done
python_with_venv() { python3 -c 'import ensurepip, venv' 2>/dev/null; }
if ! python_with_venv; then missing+="python3-venv "; fi
if [ -n "$missing" ]; then
    say "installing Debian packages: $missing"
    apt update
    # shellcheck disable=SC2086  # a list of words on purpose
    apt install -y --no-install-recommends $missing >/dev/null
fi

# The Python venv, created again if its requirements or the interpreter have changed.
want="$(python3 -c 'import sys; print(sys.version)') $(sha256sum setup/requirements*.txt)"
if [ "$(cat .venv/made-from 2>/dev/null)" != "$want" ]; then
    say "creating the Python venv .venv"
    rm -rf .venv
    python3 -m venv .venv
    .venv/bin/pip install --quiet --disable-pip-version-check -r setup/requirements.txt
    # Without their dependency cocotb. If they are not available, the tests that use them are skipped.
    .venv/bin/pip install --quiet --disable-pip-version-check --no-deps -r setup/requirements-cocotb.txt ||
        say "packages written for cocotb are not available: their tests will be skipped"
    printf '%s' "$want" >.venv/made-from
fi

# The photographs.
pictures="${HOVERLOCK_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/hoverlock}/pictures"
names="aero1.jpg aero3.jpg aloeL.jpg graf1.png graf3.png H1to3p.xml"
complete=yes
for name in $names; do [ -s "$pictures/$name" ] || complete=no; done
if [ "$complete" = no ]; then
    missing="opencv-doc"
    say "fetching photographs (Debian's opencv-doc, 96 MB, once) into $pictures"
    mkdir -p "$pictures"
    work=$(mktemp -d "$pictures.XXXXXX") # in the same folder, so that the move is a rename and no incomplete picture is left
    trap 'rm -rf "$work"' EXIT
    command -v apt-get >/dev/null || stop "apt-get is missing; put $names of opencv-doc into $pictures by hand"
    fetch() { (cd "$work" && apt-get -qq download opencv-doc 2>"$work/log"); }
    fetch || { apt update; fetch; } || stop "opencv-doc cannot be fetched: $(tail -n 1 "$work/log")"
    dpkg-deb --fsys-tarfile "$work"/opencv-doc_*.deb | tar -x -C "$work" ./usr/share/doc/opencv-doc/examples/data
    for name in $names; do
        mv "$work/usr/share/doc/opencv-doc/examples/data/$name" "$pictures/"
    done
fi
