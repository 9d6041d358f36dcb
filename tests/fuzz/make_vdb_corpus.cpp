// SPDX-License-Identifier: MIT
/* Writes the small OpenVDB and NanoVDB files of corpus/vdb and corpus/nvdb: a ball of each kind and
 * type. Not part of the build; by hand, in the corpus folder:
 *   g++ -std=c++17 -O1 -DNANOVDB_USE_ZIP -DNANOVDB_USE_BLOSC -DNANOVDB_USE_OPENVDB \
 *     make_vdb_corpus.cpp -o make -lopenvdb -ltbb -lImath-3_1 -lz -lblosc */
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/LevelSetUtil.h>

#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

namespace {

openvdb::FloatGrid::Ptr ball(float radius) {
    auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
        radius, openvdb::Vec3f(1.5f, -2, 3), 0.5f, 2);
    grid->setName("ball");
    return grid;
}

template <class Grid> typename Grid::Ptr cast(const openvdb::FloatGrid &from, double factor) {
    using value = typename Grid::ValueType;
    auto grid = Grid::create(value(factor * from.background()));
    grid->setTransform(from.transform().copy());
    grid->setName("whole");
    for (auto it = from.cbeginValueOn(); it; ++it)
        grid->tree().addTile(it.getLevel(), it.getCoord(), value(factor * *it), true);
    return grid;
}

void write(const char *name, const openvdb::GridPtrVec &grids, uint32_t compression) {
    openvdb::io::File file(std::string("vdb/") + name + ".vdb");
    file.setCompression(compression);
    file.write(grids);
}

template <class Grid> void write_nano(const char *name, Grid &grid, nanovdb::io::Codec codec) {
    nanovdb::io::writeGrid(std::string("nvdb/") + name + ".nvdb", nanovdb::openToNanoVDB(grid),
                           codec);
}

} // namespace

int main() {
    using namespace openvdb;
    initialize();
    auto level_set = ball(3);
    auto fog = level_set->deepCopy();
    tools::sdfToFogVolume(*fog);
    fog->setName("density");
    auto half = ball(2.5f);
    half->setSaveFloatAsHalf(true);
    auto doubles = cast<DoubleGrid>(*level_set, 1);
    auto ints = cast<Int32Grid>(*level_set, 100);
    auto longs = cast<Int64Grid>(*level_set, 1e6);
    auto bits = tools::sdfInteriorMask(*level_set);
    bits->setName("inside");
    auto mask = MaskGrid::create();
    mask->topologyUnion(*level_set);
    mask->setName("mask");
    auto vectors = Vec3SGrid::create();
    vectors->setName("velocity");
    vectors->tree().setValue(Coord(1, 2, 3), Vec3s(1, 2, 3));
    auto frustum = ball(2);
    frustum->setName("frustum");
    frustum->setTransform(
        math::Transform::createFrustumTransform(BBoxd(Vec3d(0), Vec3d(100)), 0.5, 10, 0.1));
    const uint32_t packed = io::COMPRESS_ACTIVE_MASK;
    write("level_set_blosc", {level_set}, packed | io::COMPRESS_BLOSC);
    write("level_set_zip", {level_set}, packed | io::COMPRESS_ZIP);
    write("half", {half}, packed | io::COMPRESS_ZIP);
    write("fog_and_vectors", {fog, vectors}, packed | io::COMPRESS_BLOSC);
    write("several", {level_set, fog, bits, mask}, packed | io::COMPRESS_ZIP);
    write("double", {doubles}, packed | io::COMPRESS_BLOSC);
    write("int32", {ints}, packed | io::COMPRESS_BLOSC);
    write("int64", {longs}, packed | io::COMPRESS_BLOSC);
    write("bool", {bits}, packed);
    write("mask", {mask}, packed);
    write("frustum", {frustum}, packed | io::COMPRESS_ZIP);
    write_nano("level_set_zip", *level_set, nanovdb::io::Codec::ZIP);
    write_nano("level_set_blosc", *level_set, nanovdb::io::Codec::BLOSC);
    write_nano("fog_zip", *fog, nanovdb::io::Codec::ZIP);
    write_nano("double_zip", *doubles, nanovdb::io::Codec::ZIP);
    write_nano("int32_zip", *ints, nanovdb::io::Codec::ZIP);
    write_nano("int64_zip", *longs, nanovdb::io::Codec::ZIP);
    write_nano("bool_zip", *bits, nanovdb::io::Codec::ZIP);
    write_nano("mask_zip", *mask, nanovdb::io::Codec::ZIP);
    nanovdb::OpenToNanoVDB<float, nanovdb::FpN> packer;
    nanovdb::io::writeGrid("nvdb/packed_zip.nvdb", packer(*level_set), nanovdb::io::Codec::ZIP);
    return 0;
}
