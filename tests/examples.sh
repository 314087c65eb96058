#!/usr/bin/env bash
# Runs the examples that assert something. Each takes about a second once it is built.
set -euo pipefail
cd "$(dirname "$0")/.."
for example in embed two_engines deform pipeline; do
    echo "example $example"
    cargo run -p mobula --release --locked --quiet --example "$example"
done
