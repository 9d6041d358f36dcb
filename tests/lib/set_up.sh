# SPDX-License-Identifier: MIT
# shellcheck shell=sh
# Sourced by ./run and ./test: finds what the build needs, installs it where that is possible, builds.
#   set_up ROOT BUILD [--with-tests] [meson options...]
# QUIET=1 prints nothing unless something has to be done. QUOIN_NO_APT=1 never installs.

started=$(date +%s)

# One line for each step, with the seconds since the start.
step() {
    printf '[%4d s] %s\n' "$(($(date +%s) - started))" "$*" >&2
}

quiet_step() {
    [ "${QUIET:-0}" = 1 ] || step "$@"
}

# Does a program with this header and these libraries compile and link?
links() {
    header=$1
    shift
    probe_folder=$(mktemp -d)
    printf '#include <stddef.h>\n#include <stdio.h>\n#include <stdarg.h>\n#include <setjmp.h>\n' \
        >"$probe_folder/probe.c"
    printf '#include <stdint.h>\n#include <%s>\nint main(void) { return 0; }\n' "$header" \
        >>"$probe_folder/probe.c"
    # CC may hold options: it is split on purpose.
    # shellcheck disable=SC2086
    ${CC:-cc} "$probe_folder/probe.c" -o "$probe_folder/probe" "$@" >/dev/null 2>&1
    result=$?
    rm -rf "$probe_folder"
    return $result
}

have() {
    command -v "$1" >/dev/null 2>&1
}

# Fills $missing with the packages the build cannot do without, $wanted with those it can do without.
find_missing() {
    missing='' wanted=''
    links stdlib.h || missing="$missing gcc libc6-dev"
    have meson || missing="$missing meson"
    have ninja || have ninja-build || have samu || missing="$missing ninja-build"
    have pkg-config || have pkgconf || missing="$missing pkg-config"
    links zlib.h -lz || missing="$missing zlib1g-dev"
    links jansson.h -ljansson || missing="$missing libjansson-dev"
    links png.h -lpng || wanted="$wanted libpng-dev"
    links lapacke.h -llapacke || wanted="$wanted liblapacke-dev"
    links nifti/nifti2_io.h -idirafter /usr/include/nifti -lnifti2 || wanted="$wanted libnifti2-dev"
    [ -e /usr/include/openvdb/openvdb.h ] || wanted="$wanted libopenvdb-dev g++"
    [ -e /usr/include/boost/version.hpp ] || wanted="$wanted libboost-dev"
    [ -e /usr/include/nanovdb/PNanoVDB.h ] || wanted="$wanted libnanovdb-dev"
    links blosc.h -lblosc || wanted="$wanted libblosc-dev"
    links libqhull_r/qhull_ra.h -lqhull_r -lm || wanted="$wanted libqhull-dev"
    [ "$1" = yes ] || return 0
    links cmocka.h -lcmocka || missing="$missing libcmocka-dev"
    have "${CXX:-c++}" || wanted="$wanted g++"
    have python3 || missing="$missing python3"
}

# Installs as root or through sudo; otherwise prints the line to type.
install_packages() {
    line="apt-get install -y --no-install-recommends$1"
    as=
    [ "$(id -u)" = 0 ] || as=sudo
    if [ "${QUOIN_NO_APT:-0}" = 1 ] || ! have apt-get || { [ -n "$as" ] && ! have sudo; }; then
        return 1
    fi
    step "installing:$1"
    # The options are several words on purpose.
    # shellcheck disable=SC2086
    if ! { $as apt-get update && $as env DEBIAN_FRONTEND=noninteractive $line; } >"$log" 2>&1; then
        fail_with_log "the packages could not be installed"
    fi
}

need_packages() {
    find_missing "$1"
    [ -n "$missing$wanted" ] || return 0
    if install_packages "$missing$wanted"; then
        return 0
    fi
    if [ -z "$missing" ]; then
        step "going on without:$wanted (see the end of 'meson setup' for what that leaves out)"
        return 0
    fi
    {
        echo "Missing:$missing$wanted"
        echo "On Debian or Ubuntu type this, then start again:"
        echo "    sudo apt-get update && sudo apt-get install -y --no-install-recommends$missing$wanted"
    } >&2
    exit 3
}

fail_with_log() {
    echo "---- the last lines of $log:" >&2
    tail -n 30 "$log" >&2
    echo "---- $1; all of it is in $log" >&2
    exit 1
}

run_ninja() {
    for program in ninja ninja-build samu; do
        if have $program; then
            $program "$@"
            return
        fi
    done
    return 127
}

set_up() {
    root=$1 build=$1/$2
    shift 2
    tests=no
    if [ "${1:-}" = --with-tests ]; then
        tests=yes
        shift
    fi
    log=$build/log.txt
    mkdir -p "$build"
    if [ ! -f "$build/build.ninja" ]; then
        step "looking for what the build needs"
        need_packages $tests
        step "meson setup (log: $log)"
        with_tests=false
        [ $tests = no ] || with_tests=true
        meson setup "$build" "$root" --buildtype=release -Dtests=$with_tests "$@" >"$log" 2>&1 ||
            fail_with_log "meson setup failed"
        [ $tests = no ] || : >"$build/.with-tests"
    elif [ $tests = yes ] && [ ! -f "$build/.with-tests" ]; then
        step "adding the tests to the build"
        need_packages yes
        meson configure "$build" -Dtests=true "$@" >"$log" 2>&1 || fail_with_log "meson failed"
        : >"$build/.with-tests"
    fi
    quiet_step "building (ninja)"
    run_ninja -C "$build" >"$log" 2>&1 || fail_with_log "the build failed"
}
