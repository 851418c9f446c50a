# shellcheck shell=bash
# Messages, the operating system and the build's own needs. Sourced by the tools, never run.

OS_RELEASE=/etc/os-release
HOME=${HOME:-~}

say() { printf '%s\n' "$*" >&2; }

die() {
    say "tools/$(basename -- "$0"): $*"
    exit 1
}

have() { command -v "$1" >/dev/null 2>&1; }

os_field() { # FIELD: its value in os-release, without quotes; empty where there is none
    [[ ! -r $OS_RELEASE ]] || sed -n "/^$1=/{s/^$1=//;s/[\"']//g;p;q}" "$OS_RELEASE"
}

is_debian_12() { [[ $(os_field ID) == debian && $(os_field VERSION_ID) == 12 ]]; }

require_rust() { # MANIFEST: its rust-version is the oldest that will do
    local wanted found
    have cargo || die "cargo is missing. Install Rust, for instance with rustup (https://rustup.rs), then run this again."
    wanted=$(sed -n '/^rust-version = "/{s/[^"]*"\([^"]*\)".*/\1/p;q}' "$1")
    found=$(cargo --version | sed -n '1s/^cargo \([0-9.]*\).*/\1/p')
    [[ $(printf '%s\n' "$wanted" "$found" | sort -V | sed -n 1p) == "$wanted" ]] ||
        die "cargo is version $found and Nephroid needs $wanted or newer. Update Rust, for instance with 'rustup update', then run this again."
}

require_cxx_compiler() {
    local compiler=${CXX:-c++}
    have "${compiler%% *}" || die "the C++ compiler '${compiler%% *}' is missing; the kernels' GLSL compiler is built with it." \
        "Install one (on Debian and Ubuntu the package g++), then run this again."
}
