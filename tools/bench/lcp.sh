#!/usr/bin/env bash
# The complementarity solvers and their peers on the same problems. Peers are installed outside
# the repository: Python packages into ~/.cache/stickslip-bench, Siconos from Debian.
set -euo pipefail
cd "$(dirname "$0")/../.."
venv="${STICKSLIP_BENCH_VENV:-$HOME/.cache/stickslip-bench}"
as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi
}
install() {
    as_root apt-get update -qq &&
        as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null
}

if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv" || { install python3-venv && python3 -m venv "$venv"; }
fi
"$venv/bin/python" -c 'import numpy, quantecon, pydrake' 2>/dev/null ||
    "$venv/bin/pip" install --quiet numpy quantecon drake
if [ ! -e /usr/include/siconos/numerics/lcp_cst.h ]; then
    install libsiconos-numerics-dev ||
        echo "libsiconos-numerics-dev could not be installed: Siconos is left out" >&2
fi
cargo build --quiet --release -p stickslip-cli
exec "$venv/bin/python" tools/bench/lcp_peers.py target/release/stickslip "$@"
