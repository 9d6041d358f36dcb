#!/bin/sh
# SPDX-License-Identifier: MIT
# Every *_hd.h compiles alone as CUDA, without contraction. Skipped (77) without nvcc.
# Arguments: source root, scratch folder.
set -eu
source_root=$1
scratch=$2
command -v nvcc >/dev/null || { echo "skipped: no nvcc"; exit 77; }
mkdir -p "$scratch"
cd "$source_root"
headers=$(find src dmc gpu cms octree -name '*_hd.h' 2>/dev/null | sort)
[ -n "$headers" ] || { echo "no *_hd.h found"; exit 1; }
for header in $headers; do
    unit=$scratch/$(echo "$header" | tr / _).cu
    printf '#include "%s"\n' "$source_root/$header" >"$unit"
    nvcc -arch=sm_80 -fmad=false -std=c++17 -I. -Isrc -c "$unit" -o "$unit.o"
    echo "compiled $header"
done
