#!/usr/bin/env bash
# Installs the tools that build and run the flight program for the ARM Cortex-A9, and reports each step. Later runs are quick and silent.
# The tools are Debian's cross linker and C library, qemu-user, and in the cache folder a Rust compiler with the sources of its standard
# library, which is built for the ARM together with the program. The compiler is not put on the PATH, so rustup's stays the only one there.
#
# Prints one line: the file to source before `cargo build --target armv7-unknown-linux-gnueabihf`.
set -euo pipefail

say() { printf 'setup: %s\n' "$*" >&2; }
stop() { printf 'setup: %s\n' "$*" >&2; exit 2; }

# Compiler, library and sources must be of one release. libllvm22 is the library that this compiler is linked with.
rust=1.96.0+dfsg1-1~deb12u2
packages="rustc-web=$rust libstd-rust-web-dev=$rust libstd-rust-web-1.96=$rust rust-web-src=$rust libllvm22"
cache="${HOVERLOCK_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/hoverlock}/arm-toolchain"
home="$cache/$rust"

command -v apt-get >/dev/null || stop "apt-get is missing, so this is not Debian; the flight program is built on Debian 12"

# apt-get as root: as it is, or through sudo.
apt() {
    if [ "$(id -u)" -eq 0 ]; then
        DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@" </dev/null >/dev/null
    else
        command -v sudo >/dev/null || stop "neither root nor sudo; as root run: apt-get install $missing"
        sudo DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@" >/dev/null
    fi
}

missing=""
command -v arm-linux-gnueabihf-gcc >/dev/null || missing+="gcc-arm-linux-gnueabihf "
[ -e /usr/arm-linux-gnueabihf/lib/libc.a ] || missing+="libc6-dev-armhf-cross "
command -v qemu-arm >/dev/null || missing+="qemu-user "
# The libraries that libllvm22 is linked with: it is extracted without its dependencies.
libraries=$(/sbin/ldconfig -p)
while read -r library package; do
    [[ $libraries == *"$library "* ]] || missing+="$package "
done <<LIBRARIES
libedit.so.2 libedit2
libffi.so.8 libffi8
libxml2.so.2 libxml2
libz3.so.4 libz3-4
libzstd.so.1 libzstd1
libz.so.1 zlib1g
libstdc++.so.6 libstdc++6
LIBRARIES
if [ -n "$missing" ]; then
    say "installing Debian packages: $missing"
    apt update
    # shellcheck disable=SC2086  # a list of words on purpose
    apt install -y --no-install-recommends $missing
fi

if [ ! -e "$home/cargo.env" ]; then
    say "fetching a Rust compiler with sources for the ARM (Debian's rustc-web, 137 MB, once) into $home"
    mkdir -p "$cache"
    # In the cache folder, so that the final move is a rename and an interrupted run leaves no incomplete toolchain. apt's user must be able to read it.
    work=$(mktemp -d "$cache/making.XXXXXX")
    trap 'rm -rf "$work"' EXIT
    chmod 755 "$work"
    mkdir "$work/debs" "$work/root"
    # shellcheck disable=SC2086  # a list of words on purpose
    fetch() { (cd "$work/debs" && apt-get -qq download $packages 2>"$work/log"); }
    fetch || { missing=$packages; apt update; fetch; } || stop "the Rust packages cannot be fetched: $(tail -n 1 "$work/log")"
    for package in "$work"/debs/*.deb; do dpkg-deb --extract "$package" "$work/root"; done
    # Only the sources of the standard library are needed.
    rm -r "$work/debs" "$work/log" "$work/root/usr/share" "$work"/root/usr/src/rustc-*/{compiler,src}

    # Debian's compiler finds its own libraries only where Debian installs them.
    cat >"$work/rustc" <<WRAPPER
#!/bin/sh
LD_LIBRARY_PATH="$home/root/usr/lib/x86_64-linux-gnu:$home/root/usr/lib\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}"
export LD_LIBRARY_PATH
exec "$home/root/usr/bin/rustc" --sysroot "$home/root/usr" "\$@"
WRAPPER
    chmod 755 "$work/rustc"
    cat >"$work/cargo.env" <<ENVIRONMENT
# The target's flags. The name of the CPU alone leaves NEON off. No fused multiply-add: the Cortex-A9 has none, and rustc does not fuse operations.
export RUSTC="$home/rustc" RUSTC_BOOTSTRAP=1
export CARGO_TARGET_ARMV7_UNKNOWN_LINUX_GNUEABIHF_LINKER=arm-linux-gnueabihf-gcc
export CARGO_TARGET_ARMV7_UNKNOWN_LINUX_GNUEABIHF_RUNNER="qemu-arm -cpu cortex-a9"
export CARGO_TARGET_ARMV7_UNKNOWN_LINUX_GNUEABIHF_RUSTFLAGS="-C target-cpu=cortex-a9 -C target-feature=+neon,+crt-static"
ENVIRONMENT
    rm -rf "$home"
    mv "$work" "$home"
    trap - EXIT
fi
"$home/rustc" --version >/dev/null || stop "the Rust compiler for the ARM does not run; remove $home and run this again"
echo "$home/cargo.env"
