#!/usr/bin/env bash
# Checks everything that a change must pass: format, lints, and the whole suite on Mesa lavapipe, a
# software Vulkan driver, so that every machine tests the same kernels on the same adapter. Installs
# lavapipe and the Vulkan loader through apt where they are missing. From a fresh Debian or Ubuntu with
# Rust this is all the set-up there is.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf 'tests/run.sh: %s\n' "$*"; }
fail() { printf 'tests/run.sh: error: %s\n' "$*" >&2; exit 1; }

command -v cargo >/dev/null || fail "there is no cargo; install Rust (https://rustup.rs)"
# Rust from rustup's minimal profile lacks these two.
if ! cargo fmt --version >/dev/null 2>&1 || ! cargo clippy --version >/dev/null 2>&1; then
    command -v rustup >/dev/null || fail "rustfmt or clippy is missing; install both with your Rust"
    rustup component add rustfmt clippy
fi

# The driver's manifest; its name carries the architecture (lvp_icd.x86_64.json, lvp_icd.json ...).
lavapipe() {
    local file
    for file in /usr/share/vulkan/icd.d/lvp_icd*.json /usr/local/share/vulkan/icd.d/lvp_icd*.json /etc/vulkan/icd.d/lvp_icd*.json; do
        if [ -f "$file" ]; then
            printf '%s' "$file"
            return
        fi
    done
}

loader() {
    local file
    for file in /usr/lib/*/libvulkan.so.1 /usr/lib/libvulkan.so.1 /usr/lib64/libvulkan.so.1 /usr/local/lib/libvulkan.so.1; do
        if [ -e "$file" ]; then
            printf '%s' "$file"
            return
        fi
    done
}

if [ -z "$(lavapipe)" ] || [ -z "$(loader)" ]; then
    command -v apt-get >/dev/null ||
        fail "lavapipe or the Vulkan loader is missing and there is no apt-get; install Mesa's lavapipe (often called mesa-vulkan-drivers or vulkan-swrast) and the Vulkan loader"
    root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || fail "run 'apt-get install mesa-vulkan-drivers libvulkan1' as root first; there is no sudo here"
        root=(sudo)
    fi
    say "installing mesa-vulkan-drivers and libvulkan1"
    "${root[@]}" apt-get update -qq
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends mesa-vulkan-drivers libvulkan1
fi

icd="$(lavapipe)"
[ -n "$icd" ] || fail "mesa-vulkan-drivers is installed and brings no lavapipe (no lvp_icd*.json)"
# The loader knows the first name from 1.3.207 on, and the second before and after.
export VK_DRIVER_FILES="$icd" VK_ICD_FILENAMES="$icd"
# Mesa's device-select layer would look for a Wayland server and complain on standard error.
export NODEVICE_SELECT=1
say "on lavapipe: $icd"

cargo fmt --check
cargo clippy --all-targets --locked -- -D warnings
# Cargo's own harness does as well; nextest runs the files side by side.
if cargo nextest --version >/dev/null 2>&1; then
    cargo nextest run --locked --no-fail-fast
else
    cargo test --locked --no-fail-fast
fi

if [ ! -d ../shared/corpus ]; then
    say "note: there is no ../shared/corpus, so the tests over the corpus of glTF files had nothing to run on"
fi
say "all passed"
