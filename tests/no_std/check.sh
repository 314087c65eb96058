#!/usr/bin/env bash
# Links simd and core into a program without std, runs it, looks for std among its symbols, and reads in them at which
# level, of how many rays and over which leaves a traversal is.
set -euo pipefail
cd "$(dirname "$0")"
target=${CARGO_TARGET_DIR:-$PWD/target}
cargo run --quiet --release --locked --target-dir "$target"
program=$target/release/mobula-no-std
if ! command -v nm >/dev/null; then
    echo "skipped: nm is not here, so nobody looked at the symbols"
else
    # Not a pipe into `grep -q`: that ends at the first match, and nm, cut off, would count as failed.
    symbols=$(nm -C "$program")
    if nm "$program" | grep '3std'; then
        echo "std was linked" >&2
        exit 1
    fi
    if [ "$(uname -m)" = x86_64 ]; then
        for level in scalar::Scalar sse2::Sse2 avx2::Avx2 avx512::Avx512; do
            if ! grep -q "<mobula_simd::$level as .*Token>::run::region::<mobula_core::.*64, .*[Tt]riangle" <<<"$symbols"; then
                echo "no symbol names a traversal of 64 rays over triangles at $level." >&2
                echo "RUSTFLAGS in the environment replaces what .cargo/config.toml asks for: ${RUSTFLAGS-it is not set}" >&2
                exit 1
            fi
        done
    fi
fi
echo "simd and core link and trace without std"
