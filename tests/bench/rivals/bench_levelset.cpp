// SPDX-License-Identifier: MIT
/* Mesh to level set and back, at one voxel size: Quoin's band and dual marching cubes, Quoin's
 * adaptive surface straight from the polygons, and OpenVDB's meshToVolume (as it is by default, and
 * without renormalization and trimming, which change its exact distances) and volumeToMesh. Each
 * run is a process of its own; the mesh is read before. How far the result is from the model is
 * measured afterwards. Prints a Markdown table.
 *
 * usage: bench_levelset DIM THREADS RUNS MESH... */
#include "bench/rivals/apart.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace {

struct outcome {
    bench_time there, back; /* mesh to level set, level set to mesh */
    double voxel;
    double megabytes; /* most memory beyond what was there when the time began */
    long long active, faces;
    double difference, far_share; /* of OpenVDB's values from Quoin's; -1: not taken */
    qn_mesh_comparison apart;     /* model and result, world units */
    int64_t crossings, broken; /* of the result: crossing pairs, non-manifold edges and vertices */
};

struct job {
    const char *path;
    int dim, threads;
};

struct model {
    qn_context *context = nullptr;
    qn_mesh *mesh = nullptr;
    double low[3], voxel;
};

using apart::must;

model load(const job &j) {
    model m;
    qn_error error;
    qn_context_options options;
    qn_context_options_init(&options);
    options.threads = j.threads;
    must(qn_context_create(&options, &m.context, &error), error);
    must(qn_mesh_read(m.context, j.path, nullptr, &m.mesh, &error), error);
    const qn_mesh_view view = qn_mesh_get_view(m.mesh);
    double high[3], side = 0;
    for (int i = 0; i < 3; ++i) {
        m.low[i] = high[i] = (double)view.positions[i];
        for (int64_t v = 0; v < view.vertex_count; ++v) {
            m.low[i] = std::fmin(m.low[i], (double)view.positions[3 * v + i]);
            high[i] = std::fmax(high[i], (double)view.positions[3 * v + i]);
        }
        side = std::fmax(side, high[i] - m.low[i]);
    }
    m.voxel = side / j.dim;
    return m;
}

/* Sample (0, 0, 0) at the world's origin, as OpenVDB has it. */
qn_volume *band_of(const model &m, long long *active) {
    qn_error error;
    qn_volume *volume = nullptr;
    qn_band_report report;
    qn_band_options options;
    qn_band_options_init(&options);
    options.voxel = m.voxel;
    options.has_origin = true;
    must(qn_volume_from_mesh(m.context, m.mesh, &options, &volume, &report, &error), error);
    *active = report.active_count;
    return volume;
}

void judge(const model &m, const qn_mesh *mesh, outcome *o) {
    qn_error error;
    qn_mesh_report report;
    must(qn_mesh_compare(m.context, m.mesh, mesh, nullptr, &o->apart, &error), error);
    must(qn_mesh_check(m.context, mesh, nullptr, &report, &error), error);
    o->crossings = report.self_intersections;
    o->broken = report.nonmanifold_edges + report.nonmanifold_vertices;
    o->faces = report.quad_count + report.triangle_count;
}

void run_band(const model &m, outcome *o) {
    qn_error error;
    qn_mesh *mesh = nullptr;
    const apart::stretch stretch;
    qn_volume *volume = band_of(m, &o->active);
    o->there = stretch.time();
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.inside = QN_INSIDE_BELOW;
    options.skip_normals = true;
    options.untangle = QN_UNTANGLE_ON;
    must(qn_surface(m.context, volume, &options, &mesh, nullptr, &error), error);
    o->back = stretch.time();
    o->megabytes = stretch.megabytes();
    judge(m, mesh, o);
}

void run_cms(const model &m, outcome *o, int dim) {
    qn_error error;
    qn_solid *solid = nullptr;
    qn_mesh *mesh = nullptr;
    const apart::stretch stretch;
    must(qn_solid_from_mesh(m.context, m.mesh, nullptr, &solid, nullptr, &error), error);
    o->there = stretch.time();
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = (int32_t)std::ceil(std::log2((double)dim));
    must(qn_solid_surface(m.context, solid, &options, &mesh, nullptr, &error), error);
    o->back = stretch.time();
    o->megabytes = stretch.megabytes();
    judge(m, mesh, o);
}

/* OpenVDB's values beside Quoin's, where both are in the band: the share that is more than a
 * hundredth of a voxel apart, and the largest difference of the others. */
void compare_values(const model &m, const openvdb::FloatGrid &grid, outcome *o) {
    long long active, seen = 0, apart = 0;
    qn_volume *volume = band_of(m, &active);
    const qn_sparse_grid *leaves = qn_volume_sparse_grid(volume);
    auto accessor = grid.getConstAccessor();
    double largest = 0;
    for (int64_t n = 0; n < leaves->leaf_count; ++n)
        for (int s = 0; s < 512; ++s) {
            const int32_t *at = leaves->origins[n];
            const openvdb::Coord place(at[0] + (s & 7), at[1] + (s >> 3 & 7), at[2] + (s >> 6));
            if (!(leaves->masks[n][s >> 6] >> (s & 63) & 1) || !accessor.isValueOn(place))
                continue;
            const double mine = (double)static_cast<const float *>(leaves->values)[512 * n + s];
            const double difference = std::fabs(mine - (double)accessor.getValue(place)) / m.voxel;
            ++seen;
            if (difference > 0.01)
                ++apart;
            else
                largest = std::fmax(largest, difference);
        }
    qn_volume_destroy(volume);
    o->difference = largest;
    o->far_share = seen ? (double)apart / (double)seen : 0;
}

/* OpenVDB's result as a mesh of ours, to be judged alike. */
void judge_openvdb(const model &m, const std::vector<openvdb::Vec3s> &points,
                   const std::vector<openvdb::Vec4I> &quads, outcome *o) {
    qn_mesh_view view = {};
    view.vertex_count = (int64_t)points.size();
    view.quad_count = (int64_t)quads.size();
    view.positions = reinterpret_cast<const float *>(points.data());
    view.quads = reinterpret_cast<const uint32_t *>(quads.data());
    view.space = view.unit = "";
    qn_error error;
    qn_mesh *mesh = nullptr;
    must(qn_mesh_create(m.context, &view, &mesh, &error), error);
    judge(m, mesh, o);
}

void run_openvdb(const model &m, outcome *o, const job &j, int flags, bool compares) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, (size_t)j.threads);
    openvdb::initialize();
    const qn_mesh_view view = qn_mesh_get_view(m.mesh);
    std::vector<openvdb::Vec3s> points, new_points;
    std::vector<openvdb::Vec4I> faces, quads;
    std::vector<openvdb::Vec3I> triangles;
    const auto transform = openvdb::math::Transform::createLinearTransform(m.voxel);
    /* meshToVolume() wants index space, and a triangle as a quad without its last corner. */
    for (int64_t v = 0; v < view.vertex_count; ++v)
        points.push_back(openvdb::Vec3s(
            transform->worldToIndex(openvdb::Vec3d(openvdb::Vec3s(view.positions + 3 * v)))));
    for (int64_t f = 0; f < view.triangle_count; ++f)
        faces.emplace_back(view.triangles[3 * f], view.triangles[3 * f + 1],
                           view.triangles[3 * f + 2], openvdb::util::INVALID_IDX);
    for (int64_t f = 0; f < view.quad_count; ++f)
        faces.emplace_back(view.quads + 4 * f);
    const apart::stretch stretch;
    const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec4I> adapter(points,
                                                                                             faces);
    const auto grid =
        openvdb::tools::meshToVolume<openvdb::FloatGrid>(adapter, *transform, 3.0f, 3.0f, flags);
    o->there = stretch.time();
    openvdb::tools::volumeToMesh(*grid, new_points, triangles, quads, 0, 0);
    o->back = stretch.time();
    o->megabytes = stretch.megabytes();
    o->active = (long long)grid->activeVoxelCount();
    if (compares)
        compare_values(m, *grid, o);
    judge_openvdb(m, new_points, quads, o);
}

enum engine { BAND, CMS, OPENVDB, OPENVDB_RAW, ENGINES };
const char *const names[ENGINES] = {"quoin band + dmc", "quoin cms", "OpenVDB",
                                    "OpenVDB, not renormalized"};

outcome run_one(const job &j, int which, bool compares) {
    outcome o = {};
    o.difference = -1;
    const model m = load(j);
    o.voxel = m.voxel;
    if (which == BAND)
        run_band(m, &o);
    else if (which == CMS)
        run_cms(m, &o, j.dim);
    else
        run_openvdb(m, &o, j,
                    which == OPENVDB ? 0
                                     : openvdb::tools::DISABLE_RENORMALIZATION |
                                           openvdb::tools::DISABLE_NARROW_BAND_TRIMMING,
                    compares);
    return o;
}

void print(const job &j, int which, const outcome &o) {
    const char *slash = std::strrchr(j.path, '/');
    std::printf("| %s | %s | %.3f | %.3f | %.3f | %.1f | %lld | %lld | %.3f | %.2f | %.4f | %lld | "
                "%lld |",
                slash ? slash + 1 : j.path, names[which], o.there.cpu, o.back.cpu - o.there.cpu,
                o.back.wall, o.megabytes, o.active, o.faces, o.apart.a_to_b.max / o.voxel,
                o.apart.b_to_a.max / o.voxel, o.apart.mean / o.voxel, (long long)o.broken,
                (long long)o.crossings);
    if (o.difference >= 0)
        std::printf(" %.2f %%, %.1g |\n", 100 * o.far_share, o.difference);
    else
        std::printf(" |\n");
    std::fflush(stdout);
}

} // namespace

int main(int argc, char **argv) {
    if (argc < 5) {
        std::fprintf(stderr, "usage: bench_levelset DIM THREADS RUNS MESH...\n");
        return 2;
    }
    std::printf("| model | by | there, CPU s | back, CPU s | both, s | MB | active | faces | model "
                "to it, largest | back, largest | mean | not manifold | crossing pairs | values "
                "apart |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int n = 4; n < argc; ++n) {
        const job j = {argv[n], std::atoi(argv[1]), std::atoi(argv[2])};
        for (int which = 0; which < ENGINES; ++which) {
            outcome best = {};
            for (int run = 0; run < std::atoi(argv[3]); ++run) {
                outcome o;
                if (!apart::measure([&] { return run_one(j, which, run == 0); }, &o)) {
                    std::fprintf(stderr, "bench_levelset: %s: a process broke\n", j.path);
                    return 1;
                }
                const double difference = run == 0 ? o.difference : best.difference;
                const double share = run == 0 ? o.far_share : best.far_share;
                if (run == 0 || o.back.cpu < best.back.cpu)
                    best = o;
                best.difference = difference;
                best.far_share = share;
            }
            print(j, which, best);
        }
    }
    return 0;
}
