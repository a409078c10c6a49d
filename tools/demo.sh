#!/usr/bin/env bash
# From a scan to pixels: builds the programs, makes a tree of data/sculpture.ply, checks it, and draws twenty copies.
# Leaves a picture and a document of counts and times in out/, and prints their paths.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tools/software-gpu.sh
. tools/software-gpu.sh

need_compiler
need_vulkan

# The whole workspace, as test.sh builds it: whichever script runs second finds everything built.
cargo build --release --workspace --locked
bin=${CARGO_TARGET_DIR:-target}/release

mkdir -p out
"$bin/fcbuild" data/sculpture.ply -o out/demo.fct --force --report out/demo-report.json
"$bin/fct" verify out/demo.fct
"$bin/fcview" out/demo.fct --headless --instances 20 --screenshot out/demo.png --stats out/demo-stats.json

# A program that reports success without an output would otherwise pass unnoticed.
for file in out/demo.png out/demo-stats.json out/demo-report.json; do
    [[ -s $file ]] || give_up "$file was not written"
done
printf '\npicture: %s\nstats:   %s\nreport:  %s\nlook around with: %s\n' \
    "$PWD/out/demo.png" "$PWD/out/demo-stats.json" "$PWD/out/demo-report.json" "$bin/fcview out/demo.fct --instances 20"
