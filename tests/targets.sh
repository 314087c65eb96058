#!/usr/bin/env bash
# simd and core on other processors: they compile without a warning for each target, and on an emulated aarch64 processor
# every level equals its twin as it does here.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v rustup >/dev/null; then
    echo "skipped: rustup is not here to add targets"
    exit
fi
std=(aarch64-unknown-linux-gnu i686-unknown-linux-gnu riscv64gc-unknown-linux-gnu wasm32-unknown-unknown wasm32-wasip1)
no_std=(thumbv7em-none-eabihf x86_64-unknown-none)
rustup target add "${std[@]}" "${no_std[@]}"

check() {
    echo "-- $*"
    cargo clippy --quiet --locked -p mobula-simd -p mobula-core --target "$@" -- -D warnings
}
for target in "${std[@]}"; do
    check "$target" --features mobula-core/lab
done
for target in "${std[@]}" "${no_std[@]}"; do
    check "$target" --no-default-features
done
# Four lanes are an array on this target, unless it has vectors.
echo "with simd128:"
RUSTFLAGS="-C target-feature=+simd128" check wasm32-unknown-unknown --features mobula-core/lab

# The environment names an emulator of any name; Debian's is the default.
emulator=${QEMU_AARCH64:-qemu-aarch64-static}
linker=aarch64-linux-gnu-gcc
for program in "$emulator" "$linker"; do
    if ! command -v "$program" >/dev/null; then
        echo "skipped: $program is not here to test on aarch64"
        exit
    fi
done
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=$linker
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="$emulator -L /usr/aarch64-linux-gnu"
# Test names end in their level; those of x86-64 alone would only say that they are skipped.
on_aarch64() {
    cargo test --quiet --locked --target aarch64-unknown-linux-gnu --test '*' "$@" -- --skip _avx2 --skip _avx512
}
# Emulation is ten times slower: fewer cases than where the processor is the real one.
PROPTEST_CASES=64 on_aarch64 -p mobula-simd
PROPTEST_CASES=8 on_aarch64 -p mobula-core --features lab
