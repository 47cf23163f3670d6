#!/usr/bin/env bash
# Coverage-guided fuzzing with libFuzzer on the stable compiler: the frame decoder, the
# predictor and the readers of files are built with LLVM's coverage counters and fed for a number of seconds each.
# What breaks them is kept in host/lab/fuzz/kept, where the tests try it from then on.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=$1
host=$(rustc -vV | sed -n 's/^host: //p')
counters="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
counters+=" -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
counters+=" -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing"
if ! command -v c++ >/dev/null && ! command -v g++ >/dev/null; then
    echo "fuzz: libFuzzer needs a C++ compiler (apt-get install g++)" >&2
    exit 1
fi
# A target names the platform, so that build scripts are built without counters.
RUSTFLAGS="$counters" cargo build -p stickslip-fuzz --features libfuzzer --profile fuzz --target "$host" --target-dir target/fuzz
failed=0
for target in line predictor files; do
    corpus=target/fuzz/corpus/$target
    mkdir -p "$corpus"
    echo "== $target, $seconds s"
    if ! "target/fuzz/$host/fuzz/fuzz-$target" -max_total_time="$seconds" -max_len=32768 -timeout=20 \
        -print_final_stats=1 -artifact_prefix="host/lab/fuzz/kept/$target/" "$corpus" "host/lab/fuzz/kept/$target" 2>&1 |
        grep -vE '^#[0-9]+\s+(NEW|REDUCE|pulse)|^INFO: seed corpus'; then
        failed=1
    fi
done
if [ "$failed" = 1 ]; then
    echo "fuzz: something broke; its bytes are in host/lab/fuzz/kept, where \`cargo test -p stickslip-fuzz\` tries them" >&2
    exit 1
fi
