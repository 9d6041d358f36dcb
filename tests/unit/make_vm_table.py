#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Write vm_table.h: values of .vm files at random points, evaluated line by line in plain Python, independently of the
library. Usage: make_vm_table.py FOLDER_OF_VM_FILES > vm_table.h"""
import math
import random
import sys

NAMES = ["colonnade", "hi", "quarter", "tanglecube"]
UNARY = {"neg": lambda a: -a, "abs": abs, "square": lambda a: a * a,
         "sqrt": lambda a: math.sqrt(a) if a >= 0 else math.nan}
BINARY = {"add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "min": min, "max": max}


def evaluate(lines, point):
    known, last = {}, None
    for line in lines:
        words = line.split("#")[0].split()
        if not words:
            continue
        name, operation, *operands = words
        if operation == "const":
            last = float(operands[0])
        elif operation.startswith("var-"):
            last = point["xyz".index(operation[4])]
        elif operation in UNARY:
            last = UNARY[operation](known[operands[0]])
        else:
            last = BINARY[operation](known[operands[0]], known[operands[1]])
        known[name] = last
    return last


def main():
    generator = random.Random(3)
    print("// SPDX-License-Identifier: MIT\n/* Written by make_vm_table.py: file, point, value. */")
    print("static const struct {\n    const char *name;\n    double point[3], value;\n} vm_table[] = {")
    for name in NAMES:
        lines = open(f"{sys.argv[1]}/{name}.vm").read().splitlines()
        for _ in range(40):
            point = [round(generator.uniform(-1, 1), 6) for _ in range(3)]
            values = ", ".join(repr(p) for p in point)
            print(f'    {{"{name}", {{{values}}}, {evaluate(lines, point)!r}}},')
    print("};")


main()
