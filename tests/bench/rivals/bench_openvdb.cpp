// SPDX-License-Identifier: MIT
/* OpenVDB's volumeToMesh under the benchmark's frame. The grid is made outside of the time: leaves
 * where the surface is, with the samples' values, tiles of either sign elsewhere. It also closes
 * the mesh at the volume's border, where the background begins. */
#include "bench/bench.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace {

struct state {
    std::unique_ptr<tbb::global_control> threads;
    openvdb::FloatGrid::Ptr grid;
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
};

/* Level set values. Outside, where they are positive and the background begins, is the side of the
 * first sample. */
template <class scalar> class source {
  public:
    explicit source(const bench_volume &volume)
        : samples_(static_cast<const scalar *>(volume.samples)), size_(volume.size),
          iso_(volume.iso), sign_(static_cast<double>(samples_[0]) < volume.iso ? -1 : 1) {
    }
    float at(int64_t x, int64_t y, int64_t z) const {
        return static_cast<float>(
            sign_ * (static_cast<double>(samples_[x + size_[0] * (y + size_[1] * z)]) - iso_));
    }

  private:
    const scalar *samples_;
    const int64_t *size_;
    double iso_, sign_;
};

enum { LEAF = 8 };

/* Do the samples of a leaf, and those that touch it, lie on both sides? Samples beyond the volume
 * lie outside. */
template <class scalar>
bool is_mixed(const source<scalar> &from, const int64_t size[3], const int64_t at[3]) {
    bool inside = false, outside = false;
    int64_t low[3], high[3];
    for (int a = 0; a < 3; ++a) {
        outside = outside || at[a] == 0 || at[a] + LEAF >= size[a];
        low[a] = std::max<int64_t>(at[a] - 1, 0);
        high[a] = std::min<int64_t>(at[a] + LEAF + 1, size[a]);
    }
    for (int64_t z = low[2]; z < high[2]; ++z)
        for (int64_t y = low[1]; y < high[1]; ++y)
            for (int64_t x = low[0]; x < high[0]; ++x)
                (from.at(x, y, z) <= 0 ? inside : outside) = true;
    return inside && outside;
}

template <class scalar> void fill(openvdb::FloatGrid &grid, const bench_volume &volume) {
    const source<scalar> from(volume);
    const int64_t *size = volume.size;
    auto &tree = grid.tree();
    int64_t at[3];
    for (at[0] = 0; at[0] < size[0]; at[0] += LEAF)
        for (at[1] = 0; at[1] < size[1]; at[1] += LEAF)
            for (at[2] = 0; at[2] < size[2]; at[2] += LEAF) {
                const openvdb::Coord corner(static_cast<int>(at[0]), static_cast<int>(at[1]),
                                            static_cast<int>(at[2]));
                if (!is_mixed(from, size, at)) {
                    if (from.at(at[0], at[1], at[2]) <= 0)
                        tree.addTile(1, corner, -grid.background(), false);
                    continue;
                }
                auto *leaf = tree.touchLeaf(corner);
                for (openvdb::Index n = 0; n < LEAF * LEAF * LEAF; ++n) {
                    const openvdb::Coord c = leaf->offsetToGlobalCoord(n);
                    if (c.x() < size[0] && c.y() < size[1] && c.z() < size[2])
                        leaf->setValueOn(n, from.at(c.x(), c.y(), c.z()));
                }
            }
}

void *prepare(const bench_volume *volume, int threads, bool) {
    openvdb::initialize();
    state *s = new state;
    s->threads.reset(new tbb::global_control(tbb::global_control::max_allowed_parallelism,
                                             static_cast<size_t>(threads)));
    s->grid = openvdb::FloatGrid::create(volume->scalar == QN_F32 ? 1.0f : 1000.0f);
    s->grid->setGridClass(openvdb::GRID_LEVEL_SET);
    switch (volume->scalar) {
    case QN_U8:
        fill<uint8_t>(*s->grid, *volume);
        return s;
    case QN_U16:
        fill<uint16_t>(*s->grid, *volume);
        return s;
    case QN_I16:
        fill<int16_t>(*s->grid, *volume);
        return s;
    case QN_F32:
        fill<float>(*s->grid, *volume);
        return s;
    default:
        delete s;
        return nullptr;
    }
}

bool extract(void *user, bench_outcome *outcome) {
    state *s = static_cast<state *>(user);
    openvdb::tools::volumeToMesh(*s->grid, s->points, s->triangles, s->quads, 0.0, 0.0);
    outcome->vertices = static_cast<int64_t>(s->points.size());
    outcome->faces = static_cast<int64_t>(s->quads.size() + s->triangles.size());
    outcome->output_bytes = static_cast<int64_t>(12 * s->points.size() + 16 * s->quads.size() +
                                                 12 * s->triangles.size());
    outcome->scratch_bytes = -1;
    outcome->classify_wall = outcome->emit_wall = -1;
    return true;
}

void clear(void *user) {
    state *s = static_cast<state *>(user);
    std::vector<openvdb::Vec3s>().swap(s->points);
    std::vector<openvdb::Vec3I>().swap(s->triangles);
    std::vector<openvdb::Vec4I>().swap(s->quads);
}

} // namespace

int main(int argc, char **argv) {
    const bench_engine engine = {"openvdb", true, false, false, prepare, extract, clear};
    return bench_main(&engine, argc, argv);
}
