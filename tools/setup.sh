#!/usr/bin/env bash
# Installs what the workspace needs beyond cargo, and only where it is missing: the
# thumbv7em target and QEMU's Arm emulator; with `browser` Chromium for the tests of the pages.
set -euo pipefail
target=thumbv7em-none-eabihf

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

# `tools/setup.sh browser`: Chromium, which clicks through the pages. Without it those tests count as ignored.
if [ "${1:-}" = browser ]; then
    for name in chromium chromium-browser google-chrome chrome; do
        if command -v "$name" >/dev/null; then exit 0; fi
    done
    echo "setup: installing chromium"
    if ! { as_root apt-get update -qq &&
        as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium; }; then
        echo "setup: no chromium: the pages are not clicked through" >&2
    fi
    exit 0
fi

if ! command -v qemu-system-arm >/dev/null; then
    echo "setup: installing qemu-system-arm"
    as_root apt-get update -qq
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends qemu-system-arm
fi

if [ -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ]; then
    exit 0
fi
echo "setup: adding the target $target"
if command -v rustup >/dev/null && rustup target add "$target"; then
    exit 0
fi
cat >&2 <<EOF
setup: rustup cannot fetch $target. Where rustup has no network, Debian's packages
rustc-web, cargo-web, rust-web-src and lld build the firmware with a standard library
of their own (docs/boards.md, "Without rustup's network").
EOF
exit 1
