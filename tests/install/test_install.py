#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A user's view: install into a temporary folder, then build and run programs with nothing but pkg-config.

usage: test_install.py BUILD_FOLDER SOURCE_ROOT MESON...
The programs: a C one, a C++ one, and the C snippets of README.md.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

BUILD, ROOT, MESON = sys.argv[1], sys.argv[2], sys.argv[3:]
HERE = os.path.join(ROOT, "tests", "install")


def fail(text):
    print("FAILED:", text)
    sys.exit(1)


def run(command, **more):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **more)
    if done.returncode:
        fail("%s\n%s" % (" ".join(command), done.stdout.decode()))
    return done.stdout.decode()


def readme_snippets():
    """All ```c blocks of README.md."""
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
        found = re.findall(r"^```c\n(.*?)^```$", file.read(), re.S | re.M)
    if len(found) < 2:
        fail("README.md has fewer than two C snippets")
    return found


def find_one(folder, name):
    for place, _, names in os.walk(folder):
        if name in names:
            return os.path.join(place, name)
    fail("%s was not installed" % name)
    return None


def install(folder):
    """meson install into FOLDER; returns the environment in which pkg-config finds it there."""
    run(MESON + ["install", "-C", BUILD, "--no-rebuild", "--destdir", folder])
    config = find_one(folder, "quoin.pc")
    with open(config, encoding="utf-8") as file:
        prefix = re.search(r"^prefix=(.*)$", file.read(), re.M).group(1)
    environment = dict(os.environ)
    environment["PKG_CONFIG_PATH"] = os.path.dirname(config)
    environment["PREFIX"] = folder + prefix
    library = os.path.dirname(find_one(folder, "libquoin.so"))
    environment["LD_LIBRARY_PATH"] = library + ":" + environment.get("LD_LIBRARY_PATH", "")
    return environment


def flags(environment):
    pkg_config = shutil.which("pkg-config") or shutil.which("pkgconf")
    if not pkg_config:
        print("skipped: there is no pkg-config")
        sys.exit(77)
    return run([pkg_config, "--define-variable=prefix=" + environment["PREFIX"], "--cflags", "--libs", "quoin"],
               env=environment).split()


def build_and_run(name, compiler, standard, source, environment, folder):
    program = os.path.join(folder, os.path.splitext(name)[0])
    extra = ["-fsanitize=address,undefined"] if "sanitize" in os.path.basename(BUILD) else []
    run(compiler + [standard, "-Wall", "-Wextra", "-Werror", source, "-o", program] + extra
        + flags(environment) + ["-lm"], env=environment)
    done = subprocess.run([program], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment, cwd=folder)
    text = done.stdout.decode().strip()
    if done.returncode and "lapacke" in text:
        print("skipped: %s: %s" % (name, text))
    elif done.returncode:
        fail("%s\n%s" % (program, text))
    print("%s: %s" % (name, text))


def read_vdb(tool, root, environment):
    """The installed tool reads OpenVDB files by the installed quoin-vdb; without it, it says so and ends with 7."""
    model = os.path.join(ROOT, "tests", "fuzz", "corpus", "vdb", "double.vdb")
    environment = {name: text for name, text in environment.items() if name != "QUOIN_VDB_PROGRAM"}
    if "leaves of 8^3 samples" not in run([tool, "info", model], env=environment):
        fail("the installed tool does not read " + model)
    program = find_one(root, "quoin-vdb")
    os.rename(program, program + ".away")
    done = subprocess.run([tool, "info", model], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != 7 or b"quoin-vdb is missing" not in done.stdout:
        fail("without quoin-vdb: %d %s" % (done.returncode, done.stdout.decode()))
    os.rename(program + ".away", program)


def main():
    cc = os.environ.get("CC", "cc").split()
    cxx = os.environ.get("CXX") or shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    with tempfile.TemporaryDirectory() as folder:
        environment = install(os.path.join(folder, "root"))
        tool = find_one(os.path.join(folder, "root"), "quoin")
        print(run([tool, "--version"], env=environment).strip())
        find_one(os.path.join(folder, "root"), "quoin.1")
        if os.path.exists(os.path.join(BUILD, "src", "volume", "quoin-vdb")):
            read_vdb(tool, os.path.join(folder, "root"), environment)
        build_and_run("sphere.c", cc, "-std=c11", os.path.join(HERE, "sphere.c"), environment, folder)
        shutil.copy(os.path.join(ROOT, "models", "ct-head.nrrd"), folder)
        for number, text in enumerate(readme_snippets()):
            name = "readme%d.c" % number
            snippet = os.path.join(folder, name)
            with open(snippet, "w", encoding="utf-8") as file:
                file.write(text)
            build_and_run(name, cc, "-std=c11", snippet, environment, folder)
        if not cxx:
            print("skipped: C++, there is no C++ compiler")
            return
        build_and_run("sphere.cpp", cxx.split(), "-std=c++17", os.path.join(HERE, "sphere.cpp"), environment, folder)


if __name__ == "__main__":
    main()
