#!/usr/bin/env bash
# The barrier under the model checker: all interleavings of two and three threads.
# A target directory of its own: with `--cfg loom` everything is compiled anew, and the usual builds stay as they are.
set -euo pipefail
cd "$(dirname "$0")/.."
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-target}/loom"
export RUSTFLAGS="${RUSTFLAGS:-} --cfg loom"
exec cargo test -p mobula --no-default-features --locked --lib pipeline::barrier::models -- "$@"
