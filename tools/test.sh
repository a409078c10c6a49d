#!/usr/bin/env bash
# Everything that must hold before a change is taken: formatting, build, tests, lints, documents, dependencies.
# Stops at the first failure. Nothing is skipped: what is missing is installed, or the script fails and says what.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tools/software-gpu.sh
. tools/software-gpu.sh

step() {
    printf '\n== %s\n' "$*" >&2
    "$@"
}

# A minimal toolchain comes without them.
need_component() {
    cargo "$1" --version >/dev/null 2>&1 && return
    command -v rustup >/dev/null || give_up "cargo $1 is missing; install it beside your Rust toolchain"
    step rustup component add "$2"
}

need_compiler
need_vulkan
need_virtual_display
need_component fmt rustfmt
need_component clippy clippy
# For all platforms, since cargo-deny looks at the dependencies of all of them and is run without the network.
step cargo fetch --locked

step cargo fmt --all --check
step cargo build --release --workspace --locked
step cargo test --release --workspace --locked
# Into target/: what is committed is made with scans, which are not here.
step cargo run --release --package xtask --locked -- figures --quick
# Lints and documents in the release profile too: build scripts and macros are then those of the build above.
step cargo clippy --release --workspace --all-targets --locked -- -D warnings
# The viewer without its window is a build of its own.
step cargo clippy --release -p fcview --no-default-features --all-targets --locked -- -D warnings
RUSTDOCFLAGS=-Dwarnings step cargo doc --release --workspace --no-deps --locked

cargo deny --version >/dev/null 2>&1 || step cargo install cargo-deny --version 0.20.2 --locked
step cargo deny --offline check bans licenses sources

printf '\nall checks passed\n'
