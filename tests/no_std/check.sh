#!/usr/bin/env bash
# Links simd and core into a program without std, runs it, and looks for std among its symbols.
set -euo pipefail
cd "$(dirname "$0")"
target=${CARGO_TARGET_DIR:-$PWD/target}
cargo run --quiet --release --locked --target-dir "$target"
if command -v nm >/dev/null && nm "$target/release/mobula-no-std" | grep -q '3std'; then
    echo "std was linked" >&2
    exit 1
fi
echo "simd and core link and trace without std"
