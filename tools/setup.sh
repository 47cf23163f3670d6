#!/usr/bin/env bash
# Installs what the workspace needs beyond cargo, and only where it is missing: the
# thumbv7em target and QEMU's Arm emulator.
set -euo pipefail
target=thumbv7em-none-eabihf

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

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
