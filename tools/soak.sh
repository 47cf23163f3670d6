#!/usr/bin/env bash
# Runs the soak (firmware/src/bin/soak) for a number of ticks, by a seed (the number of ticks, if none is named). Time is instructions, so
# neither this machine's speed nor its load has a part in the result.
set -euo pipefail
elf=$1 ticks=$2 seed=${3:-$2}
exec qemu-system-arm -machine mps2-an386 -display none -monitor none -serial null \
    -icount shift=3,align=off,sleep=off \
    -semihosting-config "enable=on,target=native,arg=soak,arg=$ticks,arg=$seed" -kernel "$elf"
