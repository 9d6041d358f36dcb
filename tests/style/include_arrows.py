#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Who may include whom: reads every #include line of the source and prints the forbidden arrows.

usage: include_arrows.py SOURCE_ROOT [--self-test]
A file's module is its folder; src/surface.c is a module of its own, and the public headers (qn/...) are open to all.
"""
import os
import re
import sys
import tempfile

# module: the modules it may include, besides itself and the public headers
ALLOWED = {
    "core": set(),
    "volume": {"core"},
    "mesh": {"core"},
    "view": {"mesh", "core"},
    "face": {"core"},
    "solid": {"core", "volume", "mesh"},
    "band": {"solid", "mesh", "volume", "core"},
    "hermite": {"solid", "volume", "core"},
    "octree": {"hermite", "core"},
    "cms": {"octree", "face", "hermite", "mesh", "core"},
    "dmc": {"face", "volume", "mesh", "core"},
    "gpu": {"dmc", "mesh", "volume", "face", "core"},
    "surface": {"cms", "dmc", "gpu", "octree", "hermite", "solid", "face", "view", "mesh", "volume", "core"},
    "cli": set(),
    "qn": set(),
}
# What else a module's files may include (headers of other projects).
LIBRARIES = {"jansson.h": {"cli", "mesh"}, "png.h": {"view"}, "zlib.h": {"volume", "mesh"}, "omp.h": {"core"},
             "openvdb/openvdb.h": {"volume"}, "nanovdb/PNanoVDB.h": {"volume"}, "blosc.h": {"volume"}}
FOLDERS = ("src", "octree", "cms", "dmc", "gpu")
SUFFIXES = (".c", ".h", ".cpp", ".cu", ".cuh")
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.M)


def module_of(path):
    """"src/volume/dense.c" -> "volume"; "dmc/dmc.c" -> "dmc"; "src/surface.c" -> "surface"."""
    parts = path.split("/")
    if parts[0] == "src":
        parts = parts[1:]
    return parts[0] if len(parts) > 1 else os.path.splitext(parts[0])[0]


def target_of(source, name, exists):
    """The repository path that an #include "name" of a file means, or None."""
    beside = os.path.normpath(os.path.join(os.path.dirname(source), name))
    for path in (beside, "src/" + name, name):
        if exists(path):
            return path
    return None


def problems_of(path, text, exists):
    module = module_of(path)
    if module not in ALLOWED:
        yield "%s: the module '%s' is not in the table of include_arrows.py" % (path, module)
        return
    for mark, name in INCLUDE.findall(text):
        if name.startswith("qn/"):
            continue
        if name in LIBRARIES and module not in LIBRARIES[name]:
            yield "%s: <%s> belongs to %s only" % (path, name, ", ".join(sorted(LIBRARIES[name])))
        if mark == "<" and not exists("src/" + name):
            if module == "qn" and name not in ("stdbool.h", "stddef.h", "stdint.h", "string.h"):
                yield "%s: a public header may not include <%s>" % (path, name)
            continue
        if name == "qni_config.h":
            continue
        target = target_of(path, name, exists)
        if target is None:
            yield "%s: nothing is at \"%s\"" % (path, name)
            continue
        other = module_of(target)
        gpu_face = module == "surface" and other == "gpu" and target != "gpu/gpu.h"
        if gpu_face or (other != module and other not in ALLOWED[module]):
            yield "%s: %s -> %s is forbidden (\"%s\")" % (path, module, other, name)
        if path.endswith("_hd.h") and not re.search(r"(_hd|/hd)\.h$", target):
            yield "%s: a *_hd.h may include *_hd.h and hd.h only (\"%s\")" % (path, name)
        if path.endswith(".c") and target.endswith(".cuh"):
            yield "%s: a .c may not include a .cuh (\"%s\")" % (path, name)


def check(root):
    problems = []
    count = 0
    for top in FOLDERS:
        for folder, _, names in os.walk(os.path.join(root, top)):
            for name in sorted(names):
                if not name.endswith(SUFFIXES):
                    continue
                full = os.path.join(folder, name)
                path = os.path.relpath(full, root).replace(os.sep, "/")
                with open(full, encoding="utf-8") as file:
                    text = file.read()
                problems += problems_of(path, text, lambda p: os.path.isfile(os.path.join(root, p)))
                count += 1
    return problems, count


def self_test():
    """Each of these files must be found out, and the good one must not."""
    bad = {
        "src/core/a.c": '#include "mesh/mesh.h"\n',
        "src/volume/a.c": '#include "mesh/mesh.h"\n',
        "src/mesh/a.c": '#include <volume/volume.h>\n',
        "src/cli/a.c": '#include "mesh/mesh.h"\n',
        "src/core/b.c": '#include <jansson.h>\n',
        "dmc/a.c": '  #  include "cms/cms.h"\n',
        "cms/a.c": '#include "dmc/dmc.h"\n',
        "dmc/b_hd.h": '#include "dmc/dmc.h"\n',
        "src/mesh/b.c": '#include "nowhere.h"\n',
        "src/other/a.c": '#include <stdio.h>\n',
        "src/qn/a.h": '#include <stdio.h>\n',
    }
    good = {
        "src/mesh/mesh.h": "#include <qn/mesh.h>\n", "src/volume/volume.h": "", "src/qn/mesh.h": "",
        "cms/cms.h": "", "dmc/dmc.h": '#include "volume/volume.h"\n#include "mesh/mesh.h"\n#include <math.h>\n',
    }
    with tempfile.TemporaryDirectory() as root:
        for path, text in {**bad, **good}.items():
            os.makedirs(os.path.join(root, os.path.dirname(path)), exist_ok=True)
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(text)
        problems, _ = check(root)
    found = {problem.split(":")[0] for problem in problems}
    assert found == set(bad), "found %s, not %s" % (sorted(found), sorted(bad))
    print("self-test: all %d forbidden includes were found" % len(bad))


def main():
    if sys.argv[2:] == ["--self-test"]:
        self_test()
        return 0
    problems, count = check(sys.argv[1])
    for problem in problems:
        print(problem)
    print("%d files read, %d forbidden arrows" % (count, len(problems)))
    return 1 if problems or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
