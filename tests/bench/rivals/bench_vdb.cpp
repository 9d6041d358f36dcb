// SPDX-License-Identifier: MIT
/* Surfaces of sparse volumes from files: Quoin's two modes and OpenVDB's volumeToMesh at
 * adaptivity 0 and 0.5, each in a process of its own on a grid that is already in memory. What the
 * meshes are is checked afterwards by qn_mesh_check(), OpenVDB's as well. Prints a Markdown table.
 *
 * usage: bench_vdb THREADS RUNS FILE[:ISO] ...    (ISO: 0 where it is left out) */
#include "bench/rivals/apart.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <cstring>
#include <string>
#include <vector>

namespace {

struct job {
    std::string path;
    double iso;
    int threads;
};

struct outcome {
    bench_time time;
    double megabytes;
    qn_mesh_report check;
    bool refused;
    char sentence[512];
};

enum engine { DMC, CMS, OPENVDB_0, OPENVDB_HALF, ENGINES };
const char *const names[ENGINES] = {"quoin dmc", "quoin cms", "OpenVDB, adaptivity 0",
                                    "OpenVDB, adaptivity 0.5"};

qn_context *make_context(int threads) {
    qn_context *context = nullptr;
    qn_error error;
    qn_context_options options;
    qn_context_options_init(&options);
    options.threads = threads;
    apart::must(qn_context_create(&options, &context, &error), error);
    return context;
}

void check(qn_context *context, const qn_mesh *mesh, outcome *o) {
    qn_error error;
    apart::must(qn_mesh_check(context, mesh, nullptr, &o->check, &error), error);
}

qn_mesh *surface(qn_context *context, const qn_volume *volume, const job &j, bool adaptive) {
    qn_error error;
    qn_mesh *mesh = nullptr;
    const qn_inside inside = qn_volume_sparse_grid(volume)->kind == QN_SPARSE_LEVEL_SET
                                 ? QN_INSIDE_BELOW
                                 : QN_INSIDE_ABOVE;
    if (adaptive) {
        qn_solid_surface_options options;
        qn_solid_surface_options_init(&options);
        options.creases = QN_CREASES_AUTO;
        apart::must(
            qn_surface_adaptive(context, volume, j.iso, inside, &options, &mesh, nullptr, &error),
            error);
        return mesh;
    }
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = &j.iso;
    options.isovalue_count = 1;
    options.inside = inside;
    options.untangle = QN_UNTANGLE_ON;
    apart::must(qn_surface(context, volume, &options, &mesh, nullptr, &error), error);
    return mesh;
}

outcome run_quoin(const job &j, bool adaptive) {
    outcome o = {};
    qn_error error;
    qn_context *context = make_context(j.threads);
    qn_volume *volume = nullptr;
    if (qn_volume_read(context, j.path.c_str(), nullptr, &volume, &error) != QN_OK) {
        o.refused = true;
        std::snprintf(o.sentence, sizeof o.sentence, "%s", error.message);
        return o;
    }
    const apart::stretch stretch;
    qn_mesh *mesh = surface(context, volume, j, adaptive);
    o.time = stretch.time();
    o.megabytes = stretch.megabytes();
    check(context, mesh, &o);
    return o;
}

/* The first grid of floats. */
openvdb::FloatGrid::Ptr load(const job &j) {
    openvdb::io::File file(j.path);
    file.open(false);
    for (auto name = file.beginName(); name != file.endName(); ++name) {
        const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(name.gridName()));
        if (grid)
            return grid;
    }
    return nullptr;
}

outcome run_openvdb(const job &j, double adaptivity) {
    outcome o = {};
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, (size_t)j.threads);
    openvdb::initialize();
    const auto grid = load(j);
    if (!grid) {
        o.refused = true;
        std::snprintf(o.sentence, sizeof o.sentence, "no grid of floats");
        return o;
    }
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    const apart::stretch stretch;
    openvdb::tools::volumeToMesh(*grid, points, triangles, quads, j.iso, adaptivity);
    o.time = stretch.time();
    o.megabytes = stretch.megabytes();
    qn_mesh_view view = {};
    view.vertex_count = (int64_t)points.size();
    view.quad_count = (int64_t)quads.size();
    view.triangle_count = (int64_t)triangles.size();
    view.positions = reinterpret_cast<const float *>(points.data());
    view.quads = reinterpret_cast<const uint32_t *>(quads.data());
    view.triangles = reinterpret_cast<const uint32_t *>(triangles.data());
    view.space = view.unit = "";
    qn_context *context = make_context(j.threads);
    qn_mesh *mesh = nullptr;
    qn_error error;
    apart::must(qn_mesh_create(context, &view, &mesh, &error), error);
    check(context, mesh, &o);
    return o;
}

bool is_nanovdb(const job &j) {
    return j.path.size() > 5 && j.path.compare(j.path.size() - 5, 5, ".nvdb") == 0;
}

void print(const job &j, int which, const outcome &o) {
    const std::string file = j.path.substr(j.path.rfind('/') + 1);
    const qn_mesh_report &c = o.check;
    if (o.refused) {
        std::printf("| %s | | %s | refused: %s | | | | | | | |\n", file.c_str(), names[which],
                    o.sentence);
        return;
    }
    std::printf("| %s | %g | %s | %lld | %lld | %lld | %.3f | %.3f | %.1f | %s | %lld | %lld |\n",
                file.c_str(), j.iso, names[which], (long long)(c.vertex_count - c.unused_vertices),
                (long long)c.quad_count, (long long)c.triangle_count, o.time.wall, o.time.cpu,
                o.megabytes, c.closed ? "yes" : "no",
                (long long)(c.nonmanifold_edges + c.nonmanifold_vertices),
                (long long)c.self_intersections);
}

bool bench(const job &j, int runs) {
    for (int which = 0; which < ENGINES; ++which) {
        if (which >= OPENVDB_0 && is_nanovdb(j))
            continue;
        outcome best = {};
        for (int run = 0; run < runs; ++run) {
            outcome o;
            const bool good = apart::measure(
                [&] {
                    return which < OPENVDB_0 ? run_quoin(j, which == CMS)
                                             : run_openvdb(j, which == OPENVDB_0 ? 0 : 0.5);
                },
                &o);
            if (!good)
                return false;
            if (run == 0 || o.time.cpu < best.time.cpu)
                best = o;
        }
        print(j, which, best);
        std::fflush(stdout);
    }
    return true;
}

} // namespace

int main(int argc, char **argv) {
    if (argc < 4) {
        std::fprintf(stderr, "usage: bench_vdb THREADS RUNS FILE[:ISO] ...\n");
        return 2;
    }
    std::printf("| file | iso | by | vertices | quads | triangles | s | CPU s | MB | closed | not "
                "manifold | crossing pairs |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int n = 3; n < argc; ++n) {
        const char *colon = std::strrchr(argv[n], ':');
        const size_t length = colon ? (size_t)(colon - argv[n]) : std::strlen(argv[n]);
        const job j = {std::string(argv[n], length), colon ? std::atof(colon + 1) : 0,
                       std::atoi(argv[1])};
        if (!bench(j, std::atoi(argv[2]))) {
            std::fprintf(stderr, "bench_vdb: %s: a process broke\n", j.path.c_str());
            return 1;
        }
    }
    return 0;
}
