#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The quoin tool from outside: every verb, every exit code, what it prints where, what it leaves behind.

usage: test_cli.py QUOIN MAKE_VOLUME SOURCE_ROOT
"""
import array
import gzip
import json
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

QUOIN, MAKE_VOLUME, ROOT = map(os.path.abspath, sys.argv[1:4])
SIZE = 24


def sphere(nan=False):
    """Distance to the middle of a SIZE^3 lattice, minus 8."""
    middle = (SIZE - 1) / 2
    values = array.array("f")
    for k in range(SIZE):
        for j in range(SIZE):
            for i in range(SIZE):
                r = ((i - middle) ** 2 + (j - middle) ** 2 + (k - middle) ** 2) ** 0.5
                values.append(float("nan") if nan else r - 8)
    if sys.byteorder == "big":
        values.byteswap()
    return values.tobytes()


def npy(samples):
    header = "{'descr': '<f4', 'fortran_order': True, 'shape': (%d, %d, %d), }" % ((SIZE,) * 3)
    header = header.ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + samples


def key_paths(value, prefix=""):
    """Every key of nested objects as "a.b"; arrays of objects as "a[].b"."""
    paths = set()
    if isinstance(value, dict):
        for key, inner in value.items():
            paths.add(prefix + key)
            paths |= key_paths(inner, prefix + key + ".")
    elif isinstance(value, list):
        for inner in value:
            paths |= key_paths(inner, prefix[:-1] + "[].")
    return paths


def struct_fields(header, name):
    """The field names of a struct of a public header."""
    with open(os.path.join(ROOT, "src/qn", header), encoding="utf-8") as file:
        text = file.read()
    body = re.search(r"typedef struct %s \{(.*?)\n\} %s;" % (name, name), text, re.S).group(1)
    body = re.sub(r"/\*.*?\*/", "", body, flags=re.S)
    fields = set()
    for declaration in body.split(";"):
        words = declaration.strip().split(None, 1)
        if len(words) == 2:
            fields |= {re.sub(r"\[.*", "", name.strip()) for name in words[1].split(",")}
    return fields


def ply_header(data):
    head = data[: data.index(b"end_header\n")].decode()
    counts = {"vertex": 0, "face": 0}
    counts.update({name: int(n) for name, n in re.findall(r"element (\w+) (\d+)", head)})
    return head, counts


class Case(unittest.TestCase):
    def setUp(self):
        self.folder_object = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder_object.cleanup)
        self.folder = self.folder_object.name
        self.write("sphere.npy", npy(sphere()))

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, data):
        with open(self.path(name), "wb") as file:
            file.write(data)

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def quoin(self, *arguments, code=0, stdout=subprocess.PIPE, binary=False):
        """Runs quoin in the test's folder; checks the exit code; returns (stdout, stderr)."""
        done = subprocess.run([QUOIN, *arguments], cwd=self.folder, stdout=stdout,
                              stderr=subprocess.PIPE, timeout=120)
        err = done.stderr.decode()
        self.assertEqual(done.returncode, code, "quoin %s said: %s" % (" ".join(arguments), err))
        if code not in (0, 6) and arguments:
            self.assertIn("quoin: ", err)
        out = done.stdout if binary or done.stdout is None else done.stdout.decode()
        return out, err

    def mesh(self, name="sphere.ply", *arguments):
        self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", name, *arguments)
        return name

    def left(self):
        return sorted(os.listdir(self.folder))


class Mesh(Case):
    def test_a_sphere_becomes_a_closed_quad_mesh(self):
        out, err = self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "sphere.ply", "--check")
        self.assertEqual(out, "")
        head, counts = ply_header(self.read("sphere.ply"))
        self.assertEqual(counts["vertex"] - counts["face"], 2)  # quads of a sphere: V - F = 2
        self.assertIn("binary_little_endian", head)
        self.assertIn("nx", head)
        self.assertIn("{:,} vertices, {:,} quads".format(counts["vertex"], counts["face"]), err)
        self.assertIn("check: passed", err)

    def test_choices_that_shape_the_mesh_are_told(self):
        _, err = self.quoin("mesh", "sphere.npy", "-o", "a.ply")
        for word in ("iso-value 0 chosen", "below", "--inside above", "--closed off"):
            self.assertIn(word, err)
        _, err = self.quoin("mesh", "sphere.npy", "-o", "a.ply", "-q")
        self.assertEqual(err, "")
        _, err = self.quoin("mesh", "sphere.npy", "-o", "a.ply", "--iso", "0", "--inside", "below",
                            "--closed", "on")
        self.assertEqual(len(err.splitlines()), 1)

    def test_options_change_what_is_written(self):
        quads = ply_header(self.read(self.mesh()))[1]["face"]
        head, counts = ply_header(self.read(self.mesh("t.ply", "--tris", "--no-normals")))
        self.assertEqual(counts["face"], 2 * quads)
        self.assertNotIn("nx", head)
        self.assertIn(b"format ascii", self.read(self.mesh("a.ply", "--ascii")))
        self.assertEqual(self.read(self.mesh("s.any", "--to", "stl"))[80:84],
                         struct.pack("<I", 2 * quads))
        self.assertTrue(self.read(self.mesh("a.stl", "--ascii")).startswith(b"solid"))
        self.assertIn(b"OFF\n", self.read(self.mesh("a.off"))[:8])
        self.assertEqual(self.read(self.mesh("a.glb"))[:4], b"glTF")
        self.assertIn(b"\nf ", self.read(self.mesh("a.obj")))

    def test_mode_cms_makes_few_triangles(self):
        _, err = self.quoin("mesh", "sphere.npy", "--iso", "0", "--mode", "cms", "--tol", "0.2", "-o", "a.ply",
                            "--check", "--report", "r.json")
        self.assertIn("closed, manifold, oriented, no self-intersections", err)
        with open(self.path("r.json")) as file:
            report = json.load(file)
        surface = report["surfaces"][0]
        self.assertEqual(report["options"]["mode"], "cms")
        self.assertEqual(surface["check"]["euler_characteristic"], 2)
        self.assertEqual(surface["isovalue"], 0)
        self.quoin("mesh", "sphere.npy", "--iso", "0", "--mode", "cms", "--uniform", "-o", "b.ply")
        self.assertLess(ply_header(self.read("a.ply"))[1]["face"], ply_header(self.read("b.ply"))[1]["face"] / 2)
        _, err = self.quoin("mesh", "sphere.npy", "--mode", "cms", "--simplify", "-o", "c.ply", code=2)
        self.assertIn("--simplify belongs to --mode dmc", err)
        self.quoin("mesh", "sphere.npy", "--mode", "cms", "--iso", "1000", "-o", "c.ply", code=4)

    def test_inside_turns_the_surface_round(self):
        self.assertNotEqual(self.read(self.mesh("a.ply", "--inside", "above")),
                            self.read(self.mesh("b.ply", "--inside", "below")))
        self.assertEqual(self.read(self.mesh("c.ply")), self.read("b.ply"))

    def test_several_isovalues_in_one_call(self):
        self.quoin("mesh", "sphere.npy", "--iso", "-2,0,1.5", "-o", "s_{iso}.ply")
        self.assertEqual(self.left(), ["s_-2.ply", "s_0.ply", "s_1.5.ply", "sphere.npy"])
        self.assertEqual(self.read("s_0.ply"), self.read(self.mesh("one.ply")))
        _, err = self.quoin("mesh", "sphere.npy", "--iso", "-2,0", "-o", "s.ply", code=2)
        self.assertIn("{iso}", err)
        self.quoin("mesh", "sphere.npy", "--iso", "1,1", "-o", "s_{iso}.ply", code=2)

    def test_one_of_several_isovalues_is_empty(self):
        _, err = self.quoin("mesh", "sphere.npy", "--iso", "0,99", "-o", "s_{iso}.ply", code=4)
        self.assertIn("iso 99", err)
        self.assertEqual(self.left(), ["s_0.ply", "sphere.npy"])

    def test_same_bytes_for_any_number_of_threads(self):
        self.assertEqual(self.read(self.mesh("a.ply", "-t", "1")),
                         self.read(self.mesh("b.ply", "-t", "3")))

    def test_stdout_carries_the_mesh(self):
        expected = self.read(self.mesh())
        out, _ = self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "-", "--to", "ply", binary=True)
        self.assertEqual(out, expected)
        for mode, before in (("wb", b""), ("ab", b"before")):  # "> file" and ">> file"
            self.write("redirected", b"before")
            with open(self.path("redirected"), mode) as file:
                self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "-", "--to", "ply", stdout=file)
            self.assertEqual(self.read("redirected"), before + expected)
        self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "-", code=2)
        self.quoin("mesh", "sphere.npy", "-o", "-", "--to", "ply", "--report", "-", code=2)

    def test_stdin_is_read(self):
        expected = self.read(self.mesh())
        for name, source in (("-", ["--from", "npy"]), ("/dev/stdin", [])):
            done = subprocess.run([QUOIN, "mesh", name, *source, "--iso", "0", "-o", "in.ply"],
                                  input=self.read("sphere.npy"), cwd=self.folder,
                                  stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(self.read("in.ply"), expected)
        done = subprocess.run([QUOIN, "check", "-", "--from", "ply"], input=expected,
                              stdout=subprocess.PIPE)
        self.assertIn(b"good: closed", done.stdout)
        self.quoin("mesh", "-", "--iso", "0", "-o", "in.ply", code=2)

    def test_raw_files_are_told_their_shape(self):
        expected = self.read(self.mesh())
        self.write("v.raw", b"head" + sphere())
        self.write("v.raw.gz", gzip.compress(b"head" + sphere()))
        for name in ("v.raw", "v.raw.gz"):
            self.quoin("mesh", name, "--shape", "24,24,24", "--dtype", "f32le", "--header", "4",
                       "--iso", "0", "-o", "r.ply")
            self.assertEqual(self.read("r.ply"), expected)
        self.quoin("mesh", "v.raw", "--iso", "0", "-o", "r2.ply", code=2)

    def test_spacing_and_origin_place_the_mesh(self):
        self.mesh("a.off", "--spacing", "2,2,2", "--origin", "100,0,0")
        rows = self.read("a.off").split(b"\n")
        first = next(row for row in rows if re.match(rb"[0-9.e+-]+ [0-9.e+-]+ [0-9.e+-]*\.", row))
        self.assertGreater(float(first.split()[0]), 100)

    def test_curvature_of_a_sphere(self):
        self.mesh("c.ply", "--curvature", "--ascii")
        head, rows = self.read("c.ply").split(b"end_header\n")
        self.assertIn(b"property float mean_curvature\nproperty float gaussian_curvature\n", head)
        vertices = [[float(word) for word in row.split()] for row in rows.split(b"\n")]
        vertices = [row for row in vertices if len(row) == 8]
        means = sorted(abs(row[6]) for row in vertices)
        radius = sum(sum((row[a] - 11.5) ** 2 for a in range(3)) ** 0.5
                     for row in vertices) / len(vertices)
        self.assertLess(abs(means[len(means) // 2] * radius - 1), 0.05)
        gaussian = sorted(row[7] for row in vertices)
        self.assertLess(abs(gaussian[len(gaussian) // 2] * radius ** 2 - 1), 0.1)
        self.mesh("b.ply", "--curvature")
        plain = self.mesh("a.ply")
        added = b"property float mean_curvature\nproperty float gaussian_curvature\n"
        self.assertEqual(len(self.read("b.ply")),
                         len(self.read(plain)) + 8 * len(vertices) + len(added))
        self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "c.stl", "--curvature", code=2)

    def test_dry_run_writes_nothing(self):
        quads = ply_header(self.read(self.mesh()))[1]["face"]
        before = self.left()
        _, err = self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "dry.ply", "--dry-run")
        self.assertEqual(self.left(), before)
        self.assertIn("{:,} quads".format(quads), err)
        self.assertIn("nothing written", err)
        out, _ = self.quoin("mesh", "sphere.npy", "--iso", "0", "--dry-run", "--report", "-")
        report = json.loads(out)
        self.assertEqual(report["surfaces"][0]["quads"], quads)
        self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "dry.ply", "--dry-run", "--report",
                   "report.json")
        estimate = json.loads(self.read("report.json"))["surfaces"][0]["output"]["bytes"]
        self.assertLess(abs(estimate - len(self.read("sphere.ply"))), 1000)

    def test_the_report_has_the_committed_keys(self):
        self.quoin("mesh", "sphere.npy", "-o", "s.ply", "--report", "report.json")
        report = json.loads(self.read("report.json"))
        with open(os.path.join(ROOT, "tests/unit/report_keys.txt"), encoding="utf-8") as file:
            committed = {line.strip() for line in file if line.strip() and line[0] != "#"}
        self.assertEqual(key_paths(report) ^ committed, set())
        self.assertEqual((report["schema"], report["exit_code"]), (1, 0))
        self.assertTrue(report["surfaces"][0]["check"]["closed"])
        self.assertEqual(report["surfaces"][0]["output"]["bytes"], len(self.read("s.ply")))

    def test_the_report_has_every_field_of_the_headers(self):
        out, _ = self.quoin("mesh", "sphere.npy", "-o", "s.ply", "--report", "-")
        surface = json.loads(out)["surfaces"][0]
        self.assertLessEqual(struct_fields("surface.h", "qn_surface_report"), set(surface))
        self.assertEqual(struct_fields("mesh.h", "qn_mesh_report"), set(surface["check"]))

    def test_numbers_that_are_not_finite_are_null(self):
        self.write("nan.npy", npy(sphere(nan=True)))
        out, _ = self.quoin("info", "nan.npy", "--json")
        self.assertIsNone(json.loads(out)["statistics"]["minimum"])


class ExitCodes(Case):
    def test_2_usage(self):
        for arguments, words in (
                ((), ["usage"]),
                (("mash",), ["did you mean 'quoin mesh'"]),
                (("sphere.npy",), ["verb", "quoin info sphere.npy"]),
                (("mesh",), ["VOLUME"]),
                (("mesh", "sphere.npy"), ["-o"]),
                (("mesh", "sphere.npy", "more", "-o", "a.ply"), ["too many"]),
                (("mesh", "sphere.npy", "-o", "a.xyz"), [".ply"]),
                (("mesh", "sphere.npy", "-o", "a.ply.gz"), ["gzip"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--iso", "12abc"), ["--iso", "12abc", "300"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--iso", "1,,2"), ["--iso"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--iso", "nan"), ["--iso", "finite"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--iso"), ["--iso", "argument"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--threads", "-1"), ["--threads"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--threads", "2x"), ["--threads", "2x"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--closed", "maybe"), ["on|off"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--spacing", "1,1"), ["--spacing"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--spacing", "1,1,0"), ["positive"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--dtype", "i12"), ["i16le"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--fail-on", "ugly"), ["ugly", "open"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--closd", "on"), ["did you mean --closed"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--edges"), ["--edges", "view"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "--quads=1"), ["takes no argument"]),
                (("mesh", "sphere.npy", "-o", "a.ply", "-x"), ["-x"]),
                (("mesh", "mesh.ply", "-o", "a.ply"), ["volume"]),
                (("check", "sphere.npy"), ["quoin mesh"]),
                (("view", "sphere.npy", "-o", "a.png"), ["quoin mesh"]),
                (("view", "mesh.ply", "-o", "a.jpg"), [".png"]),
                (("view", "mesh.ply", "-o", "a.png", "--size", "800"), ["800x600"]),
                (("convert", "mesh.ply", "b.stl", "-o", "c.stl"), ["one output"]),
                (("help", "mash"), ["mesh"])):
            _, err = self.quoin(*arguments, code=2)
            for word in words:
                self.assertIn(word, err, arguments)
        self.assertEqual(self.left(), ["sphere.npy"])

    def test_3_input(self):
        self.write("short.npy", npy(sphere())[:-100])
        self.write("junk.nrrd", b"no header at all")
        self.write("cut.raw.gz", gzip.compress(sphere())[:-2000])
        self.write("junk.ply", b"ply\nformat nonsense 1.0\n")
        for name in ("missing.nii.gz", "short.npy", "junk.nrrd"):
            _, err = self.quoin("mesh", name, "--iso", "0", "-o", "a.ply", code=3)
            self.assertIn(name, err)
        self.quoin("mesh", "cut.raw.gz", "--shape", "24,24,24", "--dtype", "f32", "--iso", "0",
                   "-o", "a.ply", code=3)
        self.quoin("info", "missing.npy", code=3)
        for verb in (("check",), ("info",), ("convert", "-o", "a.stl"), ("view", "-o", "a.png")):
            self.quoin(verb[0], "missing.ply", *verb[1:], code=3)
            self.quoin(verb[0], "junk.ply", *verb[1:], code=3)
        self.assertFalse({"a.ply", "a.stl", "a.png"} & set(self.left()))

    def test_4_empty(self):
        _, err = self.quoin("mesh", "sphere.npy", "--iso", "2000", "-o", "a.ply", code=4)
        self.assertRegex(err, r"no surface at iso 2000: values run from -?[0-9.]+ to [0-9.]+; "
                              r"try --iso 0 or 'quoin info sphere.npy'")
        self.quoin("mesh", "sphere.npy", "--iso", "2000", "-o", "a.ply", "--dry-run", code=4)
        for inside, iso in (("above", "-2000"), ("below", "2000")):  # the whole volume is solid
            self.quoin("mesh", "sphere.npy", "--iso", iso, "--inside", inside, "-o", "a.ply", code=4)
        self.write("nan.npy", npy(sphere(nan=True)))
        _, err = self.quoin("mesh", "nan.npy", "-o", "a.ply", code=4)
        self.assertIn("no finite value", err)
        self.quoin("mesh", "nan.npy", "--iso", "0", "-o", "a.ply", code=4)
        self.assertEqual(self.left(), ["nan.npy", "sphere.npy"])

    def test_4_is_in_the_report(self):
        self.quoin("mesh", "sphere.npy", "--iso", "99", "-o", "a.ply", "--report", "r.json", code=4)
        report = json.loads(self.read("r.json"))
        self.assertEqual(report["exit_code"], 4)
        self.assertIsNone(report["surfaces"][0]["output"])

    def test_5_output(self):
        self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "nowhere/a.ply", code=5)
        self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "a.ply", "--report", "nowhere/r.json",
                   code=5)
        os.mkdir(self.path("folder.ply"))
        self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "folder.ply", code=5)
        if not os.path.exists("/dev/full"):
            self.skipTest("skipped: there is no /dev/full here")
        self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "/dev/full", "--to", "ply", code=5)
        with open("/dev/full", "w") as full:
            self.quoin("mesh", "sphere.npy", "--iso", "0", "-o", "-", "--to", "ply", code=5,
                       stdout=full)
            self.quoin("info", "sphere.npy", code=5, stdout=full)
            self.quoin("info", "sphere.npy", "--json", code=5, stdout=full)
            self.quoin("help", code=5, stdout=full)

    def test_5_limit_on_file_size_leaves_nothing(self):
        def limit():
            import resource
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
        done = subprocess.run([QUOIN, "mesh", "sphere.npy", "--iso", "0", "-o", "a.ply"],
                              cwd=self.folder, preexec_fn=limit, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertEqual(self.left(), ["sphere.npy"])

    def test_remesh(self):
        self.quoin("mesh", "sphere.npy", "--iso", "6", "-o", "ball.stl")
        out, _ = self.quoin("remesh", "ball.stl", "-o", "a.ply", "--dim", "20", "--check", "--report", "-")
        report = json.loads(out)
        self.assertTrue(report["model"]["closed"])
        self.assertEqual(report["model"]["sign"], "winding")
        self.assertEqual(report["check"]["self_intersections"], 0)
        self.quoin("remesh", "ball.stl", "-o", "b.ply", "--voxel", "1", "--sign", "parity", "-q")
        self.quoin("check", "b.ply")
        self.quoin("remesh", "ball.stl", "-o", "c.ply", "--depth", "4", "--dry-run")
        _, err = self.quoin("remesh", "ball.stl", "-o", "c.ply", "--voxel", "1e-4", code=2)
        self.assertIn("larger", err)
        _, err = self.quoin("remesh", "ball.stl", "-o", "c.ply", "--sign", "odd", code=2)
        self.assertIn("auto|parity|winding", err)
        self.quoin("remesh", "none.stl", "-o", "c.ply", code=3)
        self.assertEqual(self.left(), ["a.ply", "b.ply", "ball.stl", "sphere.npy"])

    def test_6_quality(self):
        self.quoin("mesh", "sphere.npy", "--iso", "6", "--closed", "off", "-o", "open.ply", "--check")
        _, err = self.quoin("mesh", "sphere.npy", "--iso", "6", "--closed", "off", "-o", "open.ply",
                            "--fail-on", "open", code=6)
        self.assertIn("boundary edge", err)
        out, _ = self.quoin("check", "open.ply", code=6)
        self.assertIn("FAILED", out)
        self.quoin("check", "open.ply", "--fail-on", "orientation,intersect")
        self.quoin("check", "open.ply", "--fail-on", "none")
        self.quoin("check", "open.ply", "--fail-on", "all", code=6)

    def test_7_no_gpu(self):
        """Asking for a GPU gives the same bytes as the processor, or exit code 7 and a sentence."""
        done = subprocess.run([QUOIN, "mesh", "sphere.npy", "--iso", "6", "-o", "gpu.ply", "--device", "cuda"],
                              cwd=self.folder, capture_output=True, text=True, check=False)
        if done.returncode == 0:
            self.quoin("mesh", "sphere.npy", "--iso", "6", "-o", "cpu.ply", "--device", "cpu")
            self.assertEqual(self.read("gpu.ply"), self.read("cpu.ply"))
            return
        self.assertEqual(done.returncode, 7, done.stderr)
        self.assertRegex(done.stderr, "CUDA is not built in: .*nvcc|no CUDA device: ")
        self.assertIn("--device cpu", done.stderr)
        self.assertEqual(self.left(), ["sphere.npy"])
        done = subprocess.run([QUOIN, "mesh", "sphere.npy", "--iso", "6", "-o", "gpu.ply", "--mode", "cms",
                               "--device", "cuda"], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 7, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn("--mode cms is the processor's", done.stderr)

    def write_ball(self):
        with open(self.path("ball.csg"), "w", encoding="utf-8") as file:
            file.write("sphere($fn = 60, $fa = 12, $fs = 2, r = 1);\n")

    def test_csg_plans_without_the_work(self):
        self.write_ball()
        out, err = self.quoin("csg", "ball.csg", "-o", "a.ply", "--depth", "12", "--dry-run", "--report", "-")
        plan = json.loads(out)["plan"]
        self.assertFalse(plan["exact"])
        self.assertGreater(plan["triangles"], 10000)
        self.assertIn("nothing written", err)
        out, _ = self.quoin("csg", "ball.csg", "--depth", "5", "--dry-run", "--report", "-")
        plan = json.loads(out)["plan"]
        self.quoin("csg", "ball.csg", "-o", "a.ply", "--depth", "5", "--report", "r.json", "-q")
        with open(self.path("r.json"), encoding="utf-8") as file:
            surface = json.load(file)["surface"]
        self.assertTrue(plan["exact"])
        self.assertEqual(plan["triangles"], surface["triangles"])
        self.assertEqual(plan["vertices"], surface["vertices"])
        self.assertEqual(self.left(), ["a.ply", "ball.csg", "r.json", "sphere.npy"])

    def test_csg_interrupted(self):
        self.write_ball()
        with subprocess.Popen([QUOIN, "csg", "ball.csg", "-o", "a.ply", "--depth", "11", "--tol", "1e-7",
                               "--progress", "bar", "-t", "1"], cwd=self.folder,
                              stderr=subprocess.PIPE) as process:
            seen = b""
            while b"%" not in seen:
                chunk = os.read(process.stderr.fileno(), 100)
                self.assertTrue(chunk, "ended before the bar was seen: %r" % seen)
                seen += chunk
            process.send_signal(signal.SIGINT)
            err = process.stderr.read().decode()
        self.assertEqual(process.returncode, 130, err)
        self.assertIn("interrupted", err)
        self.assertEqual(self.left(), ["ball.csg", "sphere.npy"])

    def test_130_interrupted(self):
        subprocess.run([MAKE_VOLUME, "iwp", "256", self.path("iwp.npy")], check=True)
        with subprocess.Popen([QUOIN, "mesh", "iwp.npy", "--iso", "0", "-o", "a.ply", "--check",
                               "--progress", "bar", "-t", "1"], cwd=self.folder,
                              stderr=subprocess.PIPE) as process:
            seen = b""
            while b"%" not in seen:  # the bar shows: work is on its way
                chunk = os.read(process.stderr.fileno(), 100)
                self.assertTrue(chunk, "ended before the bar was seen: %r" % seen)
                seen += chunk
            process.send_signal(signal.SIGINT)
            err = process.stderr.read().decode()
        self.assertEqual(process.returncode, 130, err)
        self.assertIn("interrupted", err)
        self.assertEqual(self.left(), ["iwp.npy", "sphere.npy"])


class OtherVerbs(Case):
    def test_info_of_a_volume(self):
        out, err = self.quoin("info", "sphere.npy")
        self.assertEqual(err, "")
        for word in ("npy", "24 x 24 x 24", "f32", "histogram", "NaN", "<- start here",
                     "quoin mesh sphere.npy --iso 0 -o"):
            self.assertIn(word, out)
        info = json.loads(self.quoin("info", "sphere.npy", "--json")[0])
        self.assertEqual((info["kind"], info["input"]["shape"]), ("volume", [24, 24, 24]))
        self.assertEqual(info["statistics"]["sample_count"], 24 ** 3)
        self.assertEqual(info["suggestions"][0]["isovalue"], 0)

    def test_info_of_a_mesh(self):
        out, _ = self.quoin("info", self.mesh())
        self.assertIn("quoin check sphere.ply", out)
        info = json.loads(self.quoin("info", "sphere.ply", "--json")[0])
        counts = ply_header(self.read("sphere.ply"))[1]
        self.assertEqual((info["vertex_count"], info["quad_count"]),
                         (counts["vertex"], counts["face"]))

    def test_check_of_a_good_mesh(self):
        out, err = self.quoin("check", self.mesh())
        self.assertEqual(err, "")
        self.assertIn("good: closed, manifold, oriented, no self-intersections", out)
        check = json.loads(self.quoin("check", "sphere.ply", "--json")[0])
        self.assertTrue(check["good"])
        self.assertEqual(check["check"]["euler_characteristic"], 2)
        self.assertAlmostEqual(check["check"]["volume"], 4 / 3 * 3.14159 * 8 ** 3, delta=40)
        self.quoin("check", "sphere.ply", "-q", "--report", "c.json")
        self.assertEqual(set(json.loads(self.read("c.json"))["check"]),
                         struct_fields("mesh.h", "qn_mesh_report"))

    def test_convert_keeps_the_mesh(self):
        self.mesh()
        self.quoin("convert", "sphere.ply", "a.obj")
        self.quoin("convert", "a.obj", "-o", "b.ply")
        self.assertEqual(ply_header(self.read("b.ply"))[1], ply_header(self.read("sphere.ply"))[1])
        _, err = self.quoin("convert", "sphere.ply", "c.stl")
        self.assertIn("triangles only", err)
        self.quoin("convert", "c.stl", "d.ply")
        tris = ply_header(self.read("d.ply"))[1]
        quads = ply_header(self.read("sphere.ply"))[1]
        self.assertEqual((tris["vertex"], tris["face"]), (quads["vertex"], 2 * quads["face"]))

    CUBE = (b"OFF\n8 6 0\n" + b"".join(b"%d %d %d\n" % (v & 1, v >> 1 & 1, v >> 2) for v in range(8)) +
            b"4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n")

    def test_sdf(self):
        self.write("cube.off", self.CUBE)
        _, err = self.quoin("sdf", "cube.off", "--dim", "20", "-o", "cube.npy", "--report", "s.json")
        self.assertIn("samples in the band", err)
        report = json.loads(self.read("s.json"))
        self.assertEqual(set(report["band"]), struct_fields("band.h", "qn_band_report"))
        self.assertEqual(report["band"]["voxel"], 0.05)
        self.quoin("mesh", "cube.npy", "--iso", "0", "-o", "again.ply", "--check")
        self.quoin("sdf", "cube.off", "--voxel", "0.05", "--origin", "0,0,0", "-o", "cube.nii")
        info = json.loads(self.quoin("info", "--json", "cube.nii")[0])
        self.assertAlmostEqual(info["input"]["spacing"][0], 0.05)
        self.quoin("sdf", "cube.off", code=2)
        self.quoin("sdf", "cube.off", "-o", "cube.ply", code=2)
        self.quoin("sdf", "cube.off", "--band", "1", "-o", "cube.npy", code=2)
        self.quoin("sdf", "none.off", "-o", "cube.npy", code=3)
        self.write("empty.off", b"OFF\n0 0 0\n")
        self.quoin("sdf", "empty.off", "-o", "cube.npy", code=4)

    def test_bands_become_meshes(self):
        self.write("cube.off", self.CUBE)
        self.write("cube.csg", b"cube(size = [1, 1, 1], center = false);\n")
        self.quoin("remesh", "cube.off", "--mode", "dmc", "--dim", "20", "-o", "a.ply", "--check",
                   "--report", "a.json")
        report = json.loads(self.read("a.json"))
        self.assertEqual(set(report["surface"]), struct_fields("surface.h", "qn_surface_report"))
        self.assertAlmostEqual(report["check"]["volume"], 1, delta=0.01)
        self.assertGreater(report["band"]["leaf_count"], 0)
        for name, arguments, volume in (
                ("off", ("--offset", "0.2"), 1 + 6 * 0.2 + 3 * 3.14159 * 0.04 + 4 / 3 * 3.14159 * 0.008),
                ("off", ("--offset", "-0.2"), 0.6 ** 3),
                ("off", ("--shell", "0.2", "--offset", "-0.1", "--mode", "dmc"), 1 - 0.6 ** 3)):
            self.quoin("remesh", "cube." + name, *arguments, "--dim", "40", "-o", "b.ply", "--check",
                       "--report", "b.json")
            self.assertAlmostEqual(json.loads(self.read("b.json"))["check"]["volume"], volume,
                                   delta=0.015 * volume)
        self.quoin("csg", "cube.csg", "--mode", "dmc", "--dim", "20", "-o", "c.ply", "--check")
        self.quoin("compare", "a.ply", "c.ply", "--tol", "0.03")
        self.quoin("csg", "cube.csg", "--dim", "20", "--depth", "5", "-o", "c.ply", code=2)
        for size in ("--dim", "20"), ("--voxel", "0.05"):
            out, _ = self.quoin("csg", "cube.csg", *size, "-o", "c.ply", "--check", "--report", "-")
            self.assertAlmostEqual(json.loads(out)["surface"]["finest_cell"], 0.05)
            out, _ = self.quoin("csg", "cube.csg", *size, "--dry-run", "--report", "-")
            self.assertEqual(json.loads(out)["plan"]["depth"], 5)
        self.quoin("remesh", "cube.off", "--offset", "-3", "--mode", "dmc", "-o", "none.ply", code=4)

    def test_compare(self):
        self.quoin("mesh", "sphere.npy", "--iso", "-1", "-o", "small.ply", "-q")
        self.mesh()
        out, err = self.quoin("compare", "sphere.ply", "small.ply", "--tol", "2.2", "--report", "c.json")
        self.assertEqual(err, "")
        self.assertIn("largest", out)
        report = json.loads(self.read("c.json"))
        self.assertEqual(set(report["comparison"]), struct_fields("mesh.h", "qn_mesh_comparison"))
        self.assertEqual(set(report["comparison"]["a_to_b"]), struct_fields("mesh.h", "qn_mesh_distance"))
        self.assertTrue(report["good"])
        same = json.loads(self.quoin("compare", "sphere.ply", "sphere.ply", "--json", "--samples", "500")[0])
        self.assertLess(same["comparison"]["max"], 1e-12)
        _, err = self.quoin("compare", "sphere.ply", "small.ply", "--tol", "0.01", code=6)
        self.assertIn("more than --tol 0.01", err)
        self.quoin("compare", "sphere.ply", code=2)
        self.quoin("compare", "sphere.ply", "none.ply", code=3)
        self.write("empty.off", b"OFF\n0 0 0\n")
        self.quoin("compare", "sphere.ply", "empty.off", code=4)

    def test_view_makes_a_picture(self):
        self.mesh()
        try:
            self.quoin("view", "sphere.ply", "-o", "a.png", "--size", "80x60", "--edges")
        except AssertionError as problem:
            if "not built" in str(problem) or "-Dpng" in str(problem):
                self.skipTest("skipped: built without pictures")
            raise
        data = self.read("a.png")
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">II", data[16:24]), (80, 60))

    def test_help_and_version(self):
        self.assertRegex(self.quoin("--version")[0], r"^quoin \d+\.\d+\.\d+\n$")
        self.assertIn("Exit codes", self.quoin("--help")[0])
        for verb in ("mesh", "info", "check", "convert", "view"):
            out, _ = self.quoin(verb, "--help")
            self.assertIn("usage: quoin " + verb, out)
            self.assertEqual(out, self.quoin("help", verb)[0])
            self.assertLessEqual(max(map(len, out.split("Examples:")[0].splitlines())), 80)
        man, _ = self.quoin("help", "--man")
        options = set(re.findall(r"--[a-z][a-z-]+", self.quoin("help", "mesh")[0]))
        for option in options:
            self.assertIn("\\-\\-" + option[2:].replace("-", "\\-"), man)
        self.assertIn("complete", self.quoin("help", "--completion")[0])

    def test_bundled_models_have_their_surfaces(self):
        """The CT head of models/ is meshed from its own header's spacing."""
        model = os.path.join(ROOT, "models/ct-head.nrrd")
        out, _ = self.quoin("info", model)
        self.assertIn("3.2 3.2 1.5", out)
        self.quoin("mesh", model, "--iso", "1150.5", "-o", "bone.ply", "--check")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
