#!/bin/sh
# SPDX-License-Identifier: MIT
# The same mesh bytes from gcc and clang, -O1 and -O3: the library is built four times, each time the same
# program prints the hashes of the golden meshes. The fields come from the same builds, so the compilers
# must agree on those as well.
# Arguments: source root, scratch folder (kept, so that the next run builds only what changed). Skipped
# (77) without both compilers.
set -eu
source_root=$1
scratch=$2
for tool in gcc clang meson ninja; do
    command -v $tool >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
mkdir -p "$scratch"
first=
for compiler in gcc clang; do
    for level in 1 3; do
        build=$scratch/$compiler-O$level
        [ -d "$build" ] || CC=$compiler meson setup "$build" "$source_root" -Doptimization=$level \
            -Ddebug=false -Db_ndebug=true -Dcuda=disabled -Dopenvdb=disabled >"$build.log" 2>&1 ||
            { cat "$build.log"; exit 1; }
        ninja -C "$build" tests/golden/mesh_hashes >"$build.log" 2>&1 || { cat "$build.log"; exit 1; }
        "$build/tests/golden/mesh_hashes" "$source_root/tests/golden/golden.csv" >"$build.txt"
        [ -s "$build.txt" ] || { echo "$build printed nothing"; exit 1; }
        if [ -z "$first" ]; then
            first=$build.txt
        elif ! diff "$first" "$build.txt"; then
            echo "other bytes from $compiler -O$level than from gcc -O1"
            exit 1
        fi
        echo "$compiler -O$level: $(wc -l <"$build.txt") meshes, the same bytes"
    done
done
