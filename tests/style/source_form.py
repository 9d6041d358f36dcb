#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The outer form of the source: SPDX line, line length, blanks, tabs, file size, a README in
every folder (tests/README.md speaks for all folders below it).

usage: source_form.py SOURCE_ROOT [--self-test]
Lines between "// clang-format off" and "// clang-format on" are tables and may be longer.
"""
import os
import re
import sys
import tempfile

FOLDERS = ("src", "octree", "cms", "dmc", "gpu", "tests", "models")
SOURCES = (".c", ".h", ".cpp", ".hpp", ".cu", ".cuh")
SCRIPTS = (".py", ".sh")
LONGEST_LINE = 100
MOST_LINES = 700


def line_problems(text):
    table = False
    for number, line in enumerate(text.split("\n"), 1):
        if "clang-format off" in line:
            table = True
        if "clang-format on" in line:
            table = False
        if len(line) > LONGEST_LINE and not table:
            yield number, "%d columns; at most %d" % (len(line), LONGEST_LINE)
        if line != line.rstrip():
            yield number, "blanks at the end of the line"
        if "\t" in line:
            yield number, "a tab"


def file_problems(path, text):
    lines = text.split("\n")
    first = lines[:3]
    if not any("SPDX-License-Identifier: MIT" in line for line in first):
        yield 1, "no SPDX-License-Identifier line among the first three"
    if path.endswith(SOURCES):
        yield from line_problems(text)
        if len(lines) > MOST_LINES:
            yield len(lines), "%d lines; at most %d: split the file" % (len(lines), MOST_LINES)
    if text and not text.endswith("\n"):
        yield len(lines), "no line end at the end of the file"
    if re.search(r"\b(TODO|FIXME|XXX)\b", text) and not path.endswith("source_form.py"):
        yield 1, "an unfinished-work word"


def check(root):
    problems, count = [], 0
    for top in FOLDERS:
        for folder, folders, names in os.walk(os.path.join(root, top)):
            folders[:] = [name for name in folders if not name.startswith((".", "__"))]
            place = os.path.relpath(folder, root).replace(os.sep, "/")
            sources = [name for name in names if name.endswith(SOURCES) and not name.endswith(".h")]
            told_above = place in ("src", "src/qn") or place.startswith("tests/")
            if (sources or place in FOLDERS) and "README.md" not in names and not told_above:
                problems.append("%s: no README.md" % place)
            for name in sorted(names):
                if not name.endswith(SOURCES + SCRIPTS):
                    continue
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    text = file.read()
                for line, problem in file_problems(name, text):
                    problems.append("%s/%s:%d: %s" % (place, name, line, problem))
                count += 1
    return problems, count


def self_test():
    good = "// SPDX-License-Identifier: MIT\nint a;\n"
    bad = {
        "long.c": good + "x" * 133 + "\n",
        "blank.c": good + "int b; \n",
        "tab.h": good + "\tint b;\n",
        "spdx.c": "int a;\n",
        "end.c": good + "int b;",
        "size.c": good + "int b;\n" * 701,
        "word.py": "# SPDX-License-Identifier: MIT\n# TO" + "DO\n",
    }
    fine = {"fine.c": good, "README.md": "x\n",
            "only.h": good, "table.c": good + "// clang-format off\n" + "x" * 200 + "\n// clang-format on\n"}
    with tempfile.TemporaryDirectory() as root:
        os.makedirs(os.path.join(root, "src", "core"))
        for name, text in {**bad, **fine}.items():
            with open(os.path.join(root, "src", "core", name), "w", encoding="utf-8") as file:
                file.write(text)
        found = {problem.split(":")[0].split("/")[-1] for problem in check(root)[0]}
        assert found == set(bad), "found %s, not %s" % (sorted(found), sorted(bad))
        os.remove(os.path.join(root, "src", "core", "README.md"))
        assert any("README" in problem for problem in check(root)[0])
    print("self-test: all %d faults were found" % (len(bad) + 1))


def main():
    if sys.argv[2:] == ["--self-test"]:
        self_test()
        return 0
    problems, count = check(sys.argv[1])
    for problem in problems:
        print(problem)
    print("%d files read, %d faults" % (count, len(problems)))
    return 1 if problems or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
