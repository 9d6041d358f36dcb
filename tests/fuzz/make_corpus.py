#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Write the beginnings of the volume readers' fuzz corpus: small files of every format, good and bad.

Usage: make_corpus.py [FOLDER]     (default: corpus beside this script)

Files that fuzzing found lie beside these and have other names; nothing is deleted.
"""
import gzip
import os
import struct
import sys
import zlib

SIZE = (4, 3, 5)
COUNT = 60
KINDS = {"u1": "B", "i1": "b", "u2": "H", "i2": "h", "u4": "I", "i4": "i", "f4": "f", "f8": "d"}


def samples(kind, big=False):
    values = [(n * 0.375 - 3) if kind[0] == "f" else n * 2 for n in range(COUNT)]
    return struct.pack((">" if big else "<") + f"{COUNT}" + KINDS[kind], *values)


def packed(data, wrap):
    if wrap == "gzip":
        return gzip.compress(data, mtime=0)
    return zlib.compress(data)


def nifti(version, kind, big=False, paired=False, qform=0, sform=0, slope=0.0, dim=None, datatype=None,
          offset=None, quatern=(0.0, 0.0, 0.0)):
    order = ">" if big else "<"
    codes = {"u1": 2, "i1": 256, "u2": 512, "i2": 4, "u4": 768, "i4": 8, "f4": 16, "f8": 64}
    code = codes[kind] if datatype is None else datatype
    dims = dim or (3,) + SIZE + (1, 1, 1, 1)
    pixdim = (1.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0)
    rows = (1.0, 0.0, 0.0, -5.0, 0.0, 2.0, 0.25, -6.0, 0.0, 0.0, 3.0, -7.0)
    if offset is None:
        offset = 0 if paired else 352 if version == 1 else 544
    if version == 1:
        head = struct.pack(order + "i36x8h14xhhh8ffff3xB", 348, *dims, code, 8, 0, *pixdim, float(offset),
                           slope, 1.0, 2)
        head = head.ljust(252, b"\0") + struct.pack(order + "hh6f12f16x", qform, sform, *quatern, 1.0,
                                                    2.0, 3.0, *rows)
        head += b"ni1\0" if paired else b"n+1\0"
    else:
        magic = b"ni2\0\r\n\x1a\n" if paired else b"n+2\0\r\n\x1a\n"
        head = struct.pack(order + "i8shh8q24x8dqdd", 540, magic, code, 8, *dims, *pixdim, offset, slope,
                           1.0)
        head = head.ljust(344, b"\0") + struct.pack(order + "ii6d12dii40x", qform, sform, *quatern, 1.0,
                                                    2.0, 3.0, *rows, 0, 2)
    return head + b"\0\0\0\0" + (b"" if paired else samples(kind, big))


def nifti_files():
    for version in (1, 2):
        for big in (False, True):
            for kind in KINDS:
                yield f"v{version}_{'be' if big else 'le'}_{kind}", nifti(version, kind, big)
        yield f"v{version}_qform", nifti(version, "u1", qform=1, quatern=(0.1, 0.2, 0.3))
        yield f"v{version}_bad_quatern", nifti(version, "u1", qform=1, quatern=(9.0, 9.0, float("nan")))
        yield f"v{version}_sform", nifti(version, "i2", sform=2, slope=0.5)
        yield f"v{version}_gz", packed(nifti(version, "f4", sform=1), "gzip")
        yield f"v{version}_rgb", nifti(version, "u1", datatype=128)
        yield f"v{version}_4d", nifti(version, "u1", dim=(4,) + SIZE + (2, 1, 1, 1))
        yield f"v{version}_negative", nifti(version, "u1", dim=(3, 4, -3, 5, 1, 1, 1, 1))
        yield f"v{version}_far", nifti(version, "u1", offset=10 ** 6)
        yield f"v{version}_pair", nifti(version, "u1", paired=True)
    huge = 2 ** 62
    yield "v2_huge", nifti(2, "u1", dim=(3, huge, huge, huge, 1, 1, 1, 1))
    yield "v1_cut", nifti(1, "u1")[:300]


def nrrd(kind="uchar", data=b"", encoding="raw", more="", sizes="4 3 5", dimension=3):
    return (f"NRRD0004\n# comment\ntype: {kind}\ndimension: {dimension}\nsizes: {sizes}\nendian: little\n"
            f"encoding: {encoding}\n{more}\n").encode() + data


def nrrd_files():
    names = {"u1": "uint8", "i1": "signed char", "u2": "ushort", "i2": "short", "u4": "uint", "i4": "int",
             "f4": "float", "f8": "double"}
    for kind, name in names.items():
        yield f"raw_{kind}", nrrd(name, samples(kind))
    text = " ".join(str(n) for n in range(COUNT)).encode()
    yield "text", nrrd("short", text, "text")
    yield "text_commas", nrrd("float", b"1e3, -2.5,nan,inf\n" + text, "ascii")
    yield "gzip", nrrd("short", packed(samples("i2"), "gzip"), "gzip")
    yield "gzip_cut", nrrd("short", packed(samples("i2"), "gzip")[:-6], "gz")
    yield "whole_gzip", packed(nrrd("short", samples("i2")), "gzip")
    yield "packed_twice", packed(nrrd("short", packed(samples("i2"), "gzip"), "gzip"), "gzip")
    yield "space", nrrd("uchar", samples("u1"), more="space: left-posterior-superior\nspace directions: "
                        "(0,2,0) (-3,0,0.5) (0,0,4)\nspace origin: (1,2,3)\nspace units: \"mm\" \"mm\" \"mm\"\n")
    yield "spacings", nrrd("uchar", samples("u1"), more="spacings: 1 nan 2.5\nkey:=value\n")
    yield "skips", nrrd("uchar", b"line\nxyz" + samples("u1"), more="line skip: 1\nbyte skip: 3\n")
    yield "from_end", nrrd("uchar", b"anything" + samples("u1"), more="byte skip: -1\n")
    yield "detached", nrrd("uchar", samples("u1"), more="data file: other.raw\n")
    yield "list", nrrd("uchar", samples("u1"), more="data file: LIST\n")
    yield "huge", nrrd("double", samples("u1"), sizes="2000000000 2000000000 2000000000")
    yield "vector", nrrd("uchar", samples("u1"), sizes="3 4 3 5", dimension=4)


def metaimage(kind="MET_UCHAR", data=b"", more="", name="LOCAL"):
    return (f"ObjectType = Image\nNDims = 3\nDimSize = 4 3 5\nElementType = {kind}\n{more}"
            f"ElementDataFile = {name}\n").encode() + data


def metaimage_files():
    names = {"u1": "MET_UCHAR", "i1": "MET_CHAR", "u2": "MET_USHORT", "i2": "MET_SHORT", "u4": "MET_UINT",
             "i4": "MET_INT", "f4": "MET_FLOAT", "f8": "MET_DOUBLE"}
    for kind, name in names.items():
        yield f"raw_{kind}", metaimage(name, samples(kind))
    yield "big", metaimage("MET_SHORT", samples("i2", True), "BinaryDataByteOrderMSB = True\n")
    z = packed(samples("i2"), "zlib")
    yield "zlib", metaimage("MET_SHORT", z, f"CompressedData = True\nCompressedDataSize = {len(z)}\n")
    yield "gzip", metaimage("MET_SHORT", packed(samples("i2"), "gzip"), "CompressedData = True\n")
    yield "zlib_cut", metaimage("MET_SHORT", z[:-5], "CompressedData = True\n")
    yield "matrix", metaimage("MET_UCHAR", samples("u1"), "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 1 2 3\n"
                              "ElementSpacing = 2 3 4\nAnatomicalOrientation = RAI\n")
    yield "text", metaimage("MET_INT", b"7 " * COUNT, "BinaryData = False\n")
    yield "from_end", metaimage("MET_UCHAR", b"head" + samples("u1"), "HeaderSize = -1\n")
    yield "header", metaimage("MET_UCHAR", b"head" + samples("u1"), "HeaderSize = 4\n")
    yield "detached", metaimage("MET_UCHAR", samples("u1"), "", "other.raw")
    yield "channels", metaimage("MET_UCHAR", samples("u1"), "ElementNumberOfChannels = 3\n")
    yield "list", metaimage("MET_UCHAR", samples("u1"), "", "LIST")


def npy(text, data, version=1):
    head = text.encode()
    size = struct.pack("<H" if version == 1 else "<I", len(head))
    return b"\x93NUMPY" + bytes([version, 0]) + size + head + data


def npy_files():
    for kind in KINDS:
        for order in "<>":
            yield (f"{'le' if order == '<' else 'be'}_{kind}",
                   npy(f"{{'descr': '{order}{kind}', 'fortran_order': False, 'shape': (4, 3, 5), }}\n",
                       samples(kind, order == ">")))
    for version in (2, 3):
        yield (f"v{version}_fortran",
               npy("{'descr': '<f4', 'fortran_order': True, 'shape': (4, 3, 5), }\n", samples("f4"), version))
    yield "bool", npy("{'descr': '|b1', 'fortran_order': False, 'shape': (4, 3, 5), }\n", b"\0\1" * 30)
    yield "structured", npy("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (4, 3, 5), }\n", b"")
    yield "huge", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2000000000, 2000000000, 9), }", b"")
    yield "four_axes", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (4, 3, 5, 1), }", b"")
    yield "python2", npy("{'descr': '|u1', 'fortran_order': False, 'shape': (4L, 3L, 5L), }", samples("u1"))
    yield "gz", packed(npy("{'descr': '<i2', 'fortran_order': False, 'shape': (4, 3, 5), }", samples("i2")),
                       "gzip")


def inr(kind, bits, cpu="decm", more=""):
    head = f"#INRIMAGE-4#{{\nXDIM=4\nYDIM=3\nZDIM=5\nVDIM=1\nTYPE={kind}\nPIXSIZE={bits} bits\nCPU={cpu}\n{more}"
    return head.encode().ljust(252, b"\n") + b"##}\n"


def inr_files():
    types = {"u1": ("unsigned fixed", 8), "i2": ("signed fixed", 16), "u4": ("unsigned fixed", 32),
             "f4": ("float", 32), "f8": ("float", 64)}
    for kind, (name, bits) in types.items():
        yield kind, inr(name, bits) + samples(kind)
        yield kind + "_be", inr(name, bits, "sun", "VX=0.5\nTX=3\n") + samples(kind, True)
    yield "odd_bits", inr("float", 24) + samples("f4")
    yield "cut", inr("float", 32)[:200]


def mitsuba(sizes=SIZE, box=(0.0, 0.0, 0.0, 1.0, 2.0, 3.0), encoding=1, channels=1):
    return b"VOL\3" + struct.pack("<5i6f", encoding, *sizes, channels, *box)


def mitsuba_files():
    yield "plain", mitsuba() + samples("f4")
    yield "flat_box", mitsuba(box=(0.0,) * 6) + samples("f4")
    yield "nan_box", mitsuba(box=(float("nan"),) * 6) + samples("f4")
    yield "half", mitsuba(encoding=2) + samples("f4")
    yield "rgb", mitsuba(channels=3) + samples("f4")
    yield "huge", mitsuba(sizes=(2 ** 31 - 1,) * 3) + samples("f4")
    yield "negative", mitsuba(sizes=(-4, 3, 5)) + samples("f4")
    yield "gz", packed(mitsuba() + samples("f4"), "gzip")


def raw_files():
    for number, kind in enumerate(("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8")):
        yield kind, bytes((4, 3, 5, number, 0, 0, 0, 0)) + samples(kind)
    yield "be_header", bytes((4, 3, 5, 3, 1, 6, 0, 0)) + b"header" + samples("i2", True)
    yield "gz", bytes((4, 3, 5, 6, 0, 0, 0, 0)) + packed(samples("f4"), "gzip")
    yield "gz_long", bytes((4, 3, 4, 6, 0, 0, 0, 0)) + packed(samples("f4"), "gzip")
    yield "gz_members", bytes((4, 3, 5, 0, 0, 0, 0, 0)) + packed(samples("u1")[:9], "gzip") + packed(
        samples("u1")[9:], "gzip")
    yield "gz_zeros", bytes((200, 200, 100, 0, 0, 0, 0, 0)) + packed(bytes(4000000), "gzip")[:3900]
    yield "huge", bytes((0, 0, 0, 7, 0, 0, 0, 0)) + samples("f8")
    yield "huge_header", bytes((4, 3, 5, 0, 0, 255, 55, 0)) + samples("u1")


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    top = sys.argv[1] if len(sys.argv) > 1 else os.path.join(here, "corpus")
    makers = {"nifti": nifti_files, "nrrd": nrrd_files, "metaimage": metaimage_files, "npy": npy_files,
              "inr": inr_files, "mitsuba": mitsuba_files, "raw": raw_files}
    for name, maker in makers.items():
        folder = os.path.join(top, name)
        os.makedirs(folder, exist_ok=True)
        for file_name, data in maker():
            with open(os.path.join(folder, file_name), "wb") as file:
                file.write(data)


if __name__ == "__main__":
    main()
