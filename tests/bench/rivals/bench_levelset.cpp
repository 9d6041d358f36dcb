// SPDX-License-Identifier: MIT
/* Mesh to level set and back, at one voxel size: Quoin's band and dual marching cubes, Quoin's
 * adaptive surface straight from the polygons, and OpenVDB's meshToVolume and volumeToMesh. Each
 * run is a process of its own, so that its peak memory can be seen; the mesh is read before.
 *
 * usage: bench_levelset DIM THREADS RUNS MESH... */
#include <qn/qn.h>

#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace {

struct outcome {
    double there, back; /* wall seconds: mesh to level set, level set to mesh */
    double there_cpu, back_cpu;
    long long active, faces;
    long peak_kb;      /* resident memory beyond what was there when the time began */
    double difference; /* largest of OpenVDB's values from Quoin's, in voxels; -1: not taken */
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

double wall() {
    using clock = std::chrono::steady_clock;
    return std::chrono::duration<double>(clock::now().time_since_epoch()).count();
}

double cpu() {
    rusage use;
    getrusage(RUSAGE_SELF, &use);
    return (double)use.ru_utime.tv_sec + 1e-6 * (double)use.ru_utime.tv_usec +
           (double)use.ru_stime.tv_sec + 1e-6 * (double)use.ru_stime.tv_usec;
}

long peak() {
    rusage use;
    getrusage(RUSAGE_SELF, &use);
    return use.ru_maxrss;
}

void must(qn_status status, const qn_error &error) {
    if (status == QN_OK)
        return;
    std::fprintf(stderr, "%s\n", error.message);
    std::exit(1);
}

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

void run_band(const model &m, outcome *o) {
    qn_error error;
    qn_mesh *mesh = nullptr;
    const double start = wall(), start_cpu = cpu();
    qn_volume *volume = band_of(m, &o->active);
    o->there = wall() - start;
    o->there_cpu = cpu() - start_cpu;
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.inside = QN_INSIDE_BELOW;
    options.skip_normals = true;
    must(qn_surface(m.context, volume, &options, &mesh, nullptr, &error), error);
    o->back = wall() - start - o->there;
    o->back_cpu = cpu() - start_cpu - o->there_cpu;
    o->faces = qn_mesh_get_view(mesh).quad_count;
}

void run_cms(const model &m, outcome *o, int dim) {
    qn_error error;
    qn_solid *solid = nullptr;
    qn_mesh *mesh = nullptr;
    const double start = wall(), start_cpu = cpu();
    must(qn_solid_from_mesh(m.context, m.mesh, nullptr, &solid, nullptr, &error), error);
    o->there = wall() - start;
    o->there_cpu = cpu() - start_cpu;
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = (int32_t)std::ceil(std::log2((double)dim));
    must(qn_solid_surface(m.context, solid, &options, &mesh, nullptr, &error), error);
    o->back = wall() - start - o->there;
    o->back_cpu = cpu() - start_cpu - o->there_cpu;
    o->faces = qn_mesh_get_view(mesh).triangle_count;
}

double largest_difference(const model &m, const openvdb::FloatGrid &grid) {
    long long active;
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
            largest = std::fmax(largest, std::fabs(mine - (double)accessor.getValue(place)));
        }
    qn_volume_destroy(volume);
    return largest / m.voxel;
}

void run_openvdb(const model &m, outcome *o, int threads, bool compares) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, (size_t)threads);
    openvdb::initialize();
    const qn_mesh_view view = qn_mesh_get_view(m.mesh);
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles, new_triangles;
    std::vector<openvdb::Vec4I> quads, new_quads;
    for (int64_t v = 0; v < view.vertex_count; ++v)
        points.emplace_back(view.positions + 3 * v);
    for (int64_t f = 0; f < view.triangle_count; ++f)
        triangles.emplace_back(view.triangles + 3 * f);
    for (int64_t f = 0; f < view.quad_count; ++f)
        quads.emplace_back(view.quads + 4 * f);
    const auto transform = openvdb::math::Transform::createLinearTransform(m.voxel);
    const double start = wall(), start_cpu = cpu();
    const auto grid =
        openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(*transform, points, triangles, quads, 3);
    o->there = wall() - start;
    o->there_cpu = cpu() - start_cpu;
    std::vector<openvdb::Vec3s> new_points;
    openvdb::tools::volumeToMesh(*grid, new_points, new_triangles, new_quads, 0, 0);
    o->back = wall() - start - o->there;
    o->back_cpu = cpu() - start_cpu - o->there_cpu;
    o->active = (long long)grid->activeVoxelCount();
    o->faces = (long long)(new_quads.size() + new_triangles.size());
    o->peak_kb = peak();
    o->difference = compares ? largest_difference(m, *grid) : -1;
}

enum engine { BAND, CMS, OPENVDB, ENGINES };
const char *const names[ENGINES] = {"quoin band+dmc", "quoin cms", "openvdb"};

outcome run_one(const job &j, int which, bool compares) {
    outcome o = {};
    o.difference = -1;
    const model m = load(j);
    const long before = peak();
    if (which == BAND)
        run_band(m, &o);
    else if (which == CMS)
        run_cms(m, &o, j.dim);
    else
        run_openvdb(m, &o, j.threads, compares);
    o.peak_kb = (o.peak_kb ? o.peak_kb : peak()) - before;
    return o;
}

/* In a process of its own. */
bool measure(const job &j, int which, bool compares, outcome *o) {
    int ends[2];
    if (pipe(ends) != 0)
        return false;
    const pid_t child = fork();
    if (child == 0) {
        const outcome here = run_one(j, which, compares);
        const bool sent = write(ends[1], &here, sizeof here) == (ssize_t)sizeof here;
        _exit(sent ? 0 : 1);
    }
    close(ends[1]);
    const bool got = read(ends[0], o, sizeof *o) == (ssize_t)sizeof *o;
    close(ends[0]);
    int status;
    waitpid(child, &status, 0);
    return got;
}

} // namespace

int main(int argc, char **argv) {
    if (argc < 5) {
        std::fprintf(stderr, "usage: bench_levelset DIM THREADS RUNS MESH...\n");
        return 2;
    }
    std::printf(
        "model,engine,dim,threads,there_s,back_s,there_cpu_s,back_cpu_s,peak_mb,active,faces,"
        "largest_difference_voxels\n");
    for (int n = 4; n < argc; ++n)
        for (int which = 0; which < ENGINES; ++which) {
            const job j = {argv[n], std::atoi(argv[1]), std::atoi(argv[2])};
            outcome best = {};
            for (int run = 0; run < std::atoi(argv[3]); ++run) {
                outcome o = {};
                if (!measure(j, which, run == 0, &o))
                    return 1;
                const double difference = run == 0 ? o.difference : best.difference;
                if (run == 0 || o.there_cpu + o.back_cpu < best.there_cpu + best.back_cpu)
                    best = o;
                best.difference = difference;
            }
            const char *slash = std::strrchr(j.path, '/');
            std::printf("%s,%s,%d,%d,%.3f,%.3f,%.3f,%.3f,%.1f,%lld,%lld,%.3g\n",
                        slash ? slash + 1 : j.path, names[which], j.dim, j.threads, best.there,
                        best.back, best.there_cpu, best.back_cpu, (double)best.peak_kb / 1024,
                        best.active, best.faces, best.difference);
            std::fflush(stdout);
        }
    return 0;
}
