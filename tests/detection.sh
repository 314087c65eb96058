#!/usr/bin/env bash
# On emulated x86-64 processors without AVX and without AVX-512, `mobula` chooses the best level that they have, refuses
# the one that they lack, and renders the bytes that this level gives on this machine.
#
#     bash tests/detection.sh [PROGRAM]    PROGRAM: a built `mobula`; without it one is built
set -euo pipefail
cd "$(dirname "$0")/.."

emulator=${QEMU_X86_64:-qemu-x86_64-static}
if ! command -v "$emulator" >/dev/null; then
    echo "skipped: $emulator is not here to emulate processors"
    exit
fi
if [ "$(uname -m)" != x86_64 ]; then
    echo "skipped: this machine has no level of an x86-64 processor to compare with"
    exit
fi
mobula=${1:-}
if [ -z "$mobula" ]; then
    cargo build --locked -p mobula --bin mobula
    mobula=${CARGO_TARGET_DIR:-target}/debug/mobula
fi
pictures=$(mktemp -d)
trap 'rm -r "$pictures"' EXIT
errors=$pictures/errors

fail() {
    echo "$*" >&2
    cat "$errors" >&2
    exit 1
}
# render LEVEL NAME PROGRAM...: the picture NAME.png, at LEVEL if it is not empty; prints the level that was used.
render() {
    local level=$1 name=$2
    shift 2
    MOBULA_ISA=$level "$@" render --size 64x48 --threads 2 --json -o "$pictures/$name.png" 2>"$errors" |
        sed -n 's/.*"level": *"\([a-z0-9]*\)".*/\1/p'
}

# processor, the level it has, the next one
while read -r processor level better; do
    emulated=("$emulator" -cpu "$processor" "$mobula")
    chosen=$(render "" emulated "${emulated[@]}") || fail "$processor: rendering failed"
    [ "$chosen" = "$level" ] || fail "$processor: chose ${chosen:-no level} instead of $level"
    if render "$better" refused "${emulated[@]}" >/dev/null; then
        fail "$processor: rendered at $better, which it lacks"
    fi
    grep -q "level $better is not available" "$errors" || fail "$processor: refused $better for another reason"
    if ! render "$level" native "$mobula" >/dev/null; then
        grep -q "level $level is not available" "$errors" || fail "rendering at $level failed here"
        echo "$processor: chose $level; its picture is not compared: skipped, as this machine lacks $level"
        continue
    fi
    cmp "$pictures/emulated.png" "$pictures/native.png" || fail "$processor: another picture than $level gives here"
    echo "$processor: chose $level, refused $better, and gave the picture of $level"
done <<'PROCESSORS'
Nehalem sse2 avx2
Haswell avx2 avx512
PROCESSORS
