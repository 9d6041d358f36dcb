#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Each public header compiles by itself, as C11 and as C++17, without a warning.

usage: headers_alone.py SOURCE_ROOT COMPILER...
"""
import os
import shutil
import subprocess
import sys

WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wundef", "-Wshadow", "-Werror"]


def compile_header(compiler, flags, root, header):
    source = "#include <qn/%s>\n#include <qn/%s>\n" % (header, header)  # twice: the guard works
    return subprocess.run(compiler + flags + WARNINGS + ["-fsyntax-only", "-I", os.path.join(root, "src"), "-"],
                          input=source.encode(), stderr=subprocess.PIPE)


def main():
    root, compiler = sys.argv[1], sys.argv[2:]
    languages = [(compiler, ["-std=c11", "-x", "c", "-Wstrict-prototypes"])]
    cpp = os.environ.get("CXX") or shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if cpp:
        languages.append((cpp.split(), ["-std=c++17", "-x", "c++"]))
    else:
        print("skipped: C++17, there is no C++ compiler")
    headers = sorted(os.listdir(os.path.join(root, "src", "qn")))
    failed = 0
    for header in (name for name in headers if name.endswith(".h")):
        for command, flags in languages:
            done = compile_header(command, flags, root, header)
            if done.returncode:
                failed += 1
                print("qn/%s as %s:\n%s" % (header, flags[0], done.stderr.decode()))
    print("%d headers, %d failures" % (len(headers), failed))
    return 1 if failed or not headers else 0


if __name__ == "__main__":
    sys.exit(main())
