// SPDX-License-Identifier: MIT
/* OpenVDB's trees turned into plain arrays and back (see vdb_shim.h). OpenVDB's leaves are z
 * fastest, Quoin's x fastest. */
#include "volume/vdb_shim.h"
#include "volume/leaf_order.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>
#include <tbb/global_control.h>

#include <cstdio>
#include <cstring>
#include <fstream>
#include <mutex>
#include <new>
#include <type_traits>
#include <vector>

struct qni_vdb {
    std::unique_ptr<openvdb::io::File> file;
    std::vector<openvdb::Name> names;
    openvdb::GridBase::Ptr grid;  /* read */
    openvdb::FloatGrid::Ptr made; /* to be written */
};

namespace {

void set_text(char *text, size_t room, const char *from) {
    std::snprintf(text, room, "%s", from);
    for (char *at = text; *at; ++at) /* messages are one line, and names are printable */
        if (static_cast<unsigned char>(*at) < 32)
            *at = ' ';
}

/* Run the work; whatever it throws becomes a message. */
template <class Work> qni_vdb_result guarded(qni_vdb_message *message, Work work) noexcept {
    message->text[0] = 0;
    try {
        static std::once_flag initialized;
        std::call_once(initialized, [] { openvdb::initialize(); });
        work();
        return QNI_VDB_OK;
    } catch (const std::bad_alloc &) {
        set_text(message->text, sizeof message->text, "not enough memory");
        return QNI_VDB_NO_MEMORY;
    } catch (const std::exception &failure) {
        set_text(message->text, sizeof message->text, failure.what());
    } catch (...) {
        set_text(message->text, sizeof message->text, "OpenVDB failed without a word");
    }
    return QNI_VDB_BAD_FILE;
}

/* OpenVDB reads on behind the end of a file without a word. So where the file says that its grids
 * end is held against its length, and a table of grids that is cut short throws. */
struct length_check : openvdb::io::Archive {
    void run(const char *path) {
        std::ifstream stream(path, std::ios::binary);
        stream.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
        stream.seekg(0, std::ios::end);
        const int64_t length = stream.tellg();
        stream.seekg(0);
        auto metadata = std::make_shared<openvdb::io::StreamMetadata>();
        openvdb::io::setStreamMetadataPtr(stream, metadata, false);
        readHeader(stream);
        setFormatVersion(stream);
        setLibraryVersion(stream);
        setDataCompression(stream);
        openvdb::MetaMap().readMeta(stream);
        if (!inputHasGridOffsets())
            return;
        for (int32_t left = readGridCount(stream); left > 0; --left) {
            openvdb::io::GridDescriptor grid;
            grid.read(stream);
            if (grid.getEndPos() < 0 || grid.getEndPos() > length)
                throw std::runtime_error("it is cut short: its grids need " +
                                         std::to_string(grid.getEndPos()) + " bytes, it has " +
                                         std::to_string(length));
            grid.seekToEnd(stream);
        }
    }
    openvdb::io::Archive::Ptr copy() const override {
        return nullptr;
    }
};

/* ---- what a grid is -------------------------------------------------------------------------- */

struct known_type {
    const char *name;
    qn_scalar scalar;
};
/* Of trees of the usual shape, 5-4-3. */
const known_type known_types[] = {
    {"Tree_float_5_4_3", QN_F32}, {"Tree_double_5_4_3", QN_F64}, {"Tree_int32_5_4_3", QN_I32},
    {"Tree_int64_5_4_3", QN_F64}, {"Tree_bool_5_4_3", QN_U8},    {"Tree_mask_5_4_3", QN_U8},
};

qn_sparse_class class_of(const openvdb::GridBase &grid) {
    switch (grid.getGridClass()) {
    case openvdb::GRID_LEVEL_SET:
        return QN_SPARSE_LEVEL_SET;
    case openvdb::GRID_FOG_VOLUME:
        return QN_SPARSE_FOG;
    default:
        return QN_SPARSE_UNKNOWN;
    }
}

void describe(const openvdb::GridBase &grid, qni_vdb_grid &out) {
    set_text(out.info.type, sizeof out.info.type, grid.valueType().c_str());
    out.info.kind = class_of(grid);
    out.info.half = grid.saveFloatAsHalf();
    out.info.frustum = !grid.transform().isLinear();
    for (const known_type &known : known_types)
        if (grid.type() == known.name) {
            out.info.readable = !out.info.frustum;
            out.scalar = known.scalar;
        }
    if (out.info.frustum)
        return;
    const openvdb::Mat4d rows = grid.transform().baseMap()->getAffineMap()->getMat4();
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c)
            out.index_to_world[r][c] = rows(c, r); /* OpenVDB multiplies row vectors */
}

/* ---- from a tree to arrays ------------------------------------------------------------------- */

/* The number that is stored for a value; integers beyond 2^53 are none of a double. */
template <class To, class From> To stored(From value) {
    if constexpr (std::is_same<From, int64_t>::value)
        if (value > (INT64_C(1) << 53) || value < -(INT64_C(1) << 53))
            throw std::runtime_error("holds integers beyond 2^53, which a double cannot");
    return static_cast<To>(value);
}

/* A tile's value. A damaged file can leave a bool that is neither 0 nor 1, which may not be looked
 * at as one. */
template <class Value> Value clean(const Value &value) {
    return value;
}
template <> bool clean(const bool &value) {
    unsigned char byte;
    std::memcpy(&byte, &value, 1);
    return byte != 0;
}

/* Visits all leaves, and all tiles that are not inactive background; neighbouring tiles along z
 * that are alike come as one. */
template <class Tree, class OnLeaf, class OnTile>
void visit(Tree &tree, OnLeaf on_leaf, OnTile on_tile) {
    using root_type = typename Tree::RootNodeType;
    using upper_type = typename root_type::ChildNodeType;
    const auto background = clean(tree.background());
    auto tiles_of = [&](auto &node) {
        using node_type = typename std::remove_reference<decltype(node)>::type;
        constexpr openvdb::Index side = 1u << node_type::LOG2DIM, count = side * side * side;
        constexpr int32_t edge = node_type::ChildNodeType::DIM;
        for (openvdb::Index n = 0; n < count; ++n) {
            if (node.getChildMask().isOn(n))
                continue;
            const auto value = clean(node.getTable()[n].getValue());
            const bool active = node.isValueMaskOn(n);
            if (!active && value == background)
                continue;
            openvdb::Index end = n + 1;
            while (end % side != 0 && !node.getChildMask().isOn(end) &&
                   clean(node.getTable()[end].getValue()) == value &&
                   node.isValueMaskOn(end) == active)
                ++end;
            const openvdb::Coord at = node.offsetToGlobalCoord(n);
            on_tile(at, edge, edge * static_cast<int32_t>(end - n), value, active);
            n = end - 1;
        }
    };
    for (auto it = tree.root().cbeginValueAll(); it; ++it)
        if (it.isValueOn() || clean(it.getValue()) != background)
            on_tile(it.getCoord(), static_cast<int32_t>(upper_type::DIM),
                    static_cast<int32_t>(upper_type::DIM), clean(it.getValue()), it.isValueOn());
    for (auto upper = tree.root().beginChildOn(); upper; ++upper) {
        tiles_of(*upper);
        for (auto lower = upper->beginChildOn(); lower; ++lower) {
            tiles_of(*lower);
            for (auto leaf = lower->beginChildOn(); leaf; ++leaf)
                on_leaf(*leaf);
        }
    }
}

template <class Tree> void count(Tree &tree, qni_vdb_counts &counts) {
    visit(
        tree, [&](auto &) { ++counts.leaf_count; },
        [&](const openvdb::Coord &, int32_t, int32_t, auto, bool) { ++counts.tile_count; });
    counts.background = stored<double>(clean(tree.background()));
}

template <class Leaf> void turn_mask(const Leaf &leaf, uint64_t out[8]) {
    uint64_t words[8];
    for (openvdb::Index x = 0; x < 8; ++x)
        words[x] = leaf.getValueMask().template getWord<uint64_t>(x);
    qni_leaf_turn_mask(words, out);
}

/* Values of leaves that keep an array; it is let go afterwards. */
template <class To, class Leaf> void turn_values(Leaf &leaf, To *out) {
    const auto *from = leaf.buffer().data();
    if (!from)
        throw std::runtime_error("a leaf's values could not be read");
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z)
                out[x + 8 * y + 64 * z] = stored<To>(from[64 * x + 8 * y + z]);
    typename Leaf::Buffer none(openvdb::PartialCreate(), leaf.buffer().getValue(0));
    leaf.swap(none);
}

/* Values of leaves that keep bits. */
template <class Leaf> void turn_bits(const Leaf &leaf, uint8_t *out) {
    for (openvdb::Index n = 0; n < 512; ++n)
        out[(n >> 6) + (n & 0x38) + 64 * (n & 7)] = leaf.getValue(n) ? 1 : 0;
}

void check_taken(bool taken) {
    if (!taken)
        throw std::runtime_error("nobody takes what was read");
}

template <class To, class Tree> void take(Tree &tree, const qni_vdb_sink &sink) {
    using leaf_type = typename Tree::LeafNodeType;
    visit(
        tree,
        [&](leaf_type &leaf) {
            const int32_t origin[3] = {leaf.origin().x(), leaf.origin().y(), leaf.origin().z()};
            uint64_t mask[8];
            To values[512];
            turn_mask(leaf, mask);
            if constexpr (std::is_same<typename Tree::ValueType, bool>::value)
                turn_bits(leaf, values);
            else
                turn_values(leaf, values);
            check_taken(sink.leaf(sink.user, origin, mask, values, sizeof(To)));
        },
        [&](const openvdb::Coord &at, int32_t edge, int32_t length, auto value, bool active) {
            const qn_sparse_tile tile = {
                {at.x(), at.y(), at.z()}, {edge, edge, length}, stored<double>(value), active};
            check_taken(sink.tile(sink.user, &tile));
        });
}

/* Call `work` with the grid's tree and the type its values are stored as. */
template <class Work> void with_tree(openvdb::GridBase &grid, Work work) {
    if (auto *floats = dynamic_cast<openvdb::FloatGrid *>(&grid))
        work(floats->tree(), float());
    else if (auto *doubles = dynamic_cast<openvdb::DoubleGrid *>(&grid))
        work(doubles->tree(), double());
    else if (auto *whole = dynamic_cast<openvdb::Int32Grid *>(&grid))
        work(whole->tree(), int32_t());
    else if (auto *wide = dynamic_cast<openvdb::Int64Grid *>(&grid))
        work(wide->tree(), double());
    else if (auto *bits = dynamic_cast<openvdb::BoolGrid *>(&grid))
        work(bits->tree(), uint8_t());
    else if (auto *mask = dynamic_cast<openvdb::MaskGrid *>(&grid))
        work(mask->tree(), uint8_t());
    else
        throw std::runtime_error("the grid is of no type that can be read");
}

/* ---- from arrays to a tree ------------------------------------------------------------------- */

void fill_box(openvdb::FloatTree &tree, const qn_sparse_tile &tile) {
    const openvdb::Coord low(tile.origin[0], tile.origin[1], tile.origin[2]);
    const openvdb::Coord size(tile.size[0], tile.size[1], tile.size[2]);
    tree.sparseFill(openvdb::CoordBBox(low, low + size.offsetBy(-1)),
                    static_cast<float>(tile.value), tile.active);
}

void add_leaf(openvdb::FloatTree &tree, const int32_t origin[3], const uint64_t *mask,
              const float *from) {
    auto *leaf = new openvdb::FloatTree::LeafNodeType(
        openvdb::Coord(origin[0], origin[1], origin[2]), tree.background(), !mask);
    tree.addLeaf(leaf); /* which owns it from here on */
    float *to = leaf->buffer().data();
    for (openvdb::Index x = 0; x < 8; ++x)
        for (openvdb::Index y = 0; y < 8; ++y)
            for (openvdb::Index z = 0; z < 8; ++z) {
                to[64 * x + 8 * y + z] = from[x + 8 * y + 64 * z];
                if (mask && mask[z] >> (x + 8 * y) & 1)
                    leaf->setValueOn(64 * x + 8 * y + z);
            }
}

openvdb::FloatGrid::Ptr empty_grid(const qn_sparse_grid &from) {
    auto grid = openvdb::FloatGrid::create(static_cast<float>(from.background));
    openvdb::Mat4d rows;
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c)
            rows(c, r) = from.index_to_world[r][c];
    auto affine = std::make_shared<openvdb::math::AffineMap>(rows);
    grid->setTransform(std::make_shared<openvdb::math::Transform>(openvdb::math::simplify(affine)));
    grid->setName(from.name[0] ? from.name : from.kind == QN_SPARSE_FOG ? "density" : "surface");
    grid->setGridClass(from.kind == QN_SPARSE_LEVEL_SET ? openvdb::GRID_LEVEL_SET
                       : from.kind == QN_SPARSE_FOG     ? openvdb::GRID_FOG_VOLUME
                                                        : openvdb::GRID_UNKNOWN);
    return grid;
}

} // namespace

/* ---- the C face ------------------------------------------------------------------------------ */

qni_vdb_result qni_vdb_open(const char *path, qni_vdb **file_out, qni_vdb_message *message) {
    *file_out = nullptr;
    return guarded(message, [&] {
        /* Reading is serial anyway; so its memory does not depend on the machine's cores. */
        static tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        auto opened = std::make_unique<qni_vdb>();
        opened->file = std::make_unique<openvdb::io::File>(path);
        length_check().run(path);
        opened->file->open(false); /* delayed loading trusts the file: it asserts, which ends us */
        for (auto name = opened->file->beginName(); name != opened->file->endName(); ++name)
            opened->names.push_back(name.gridName());
        *file_out = opened.release();
    });
}

void qni_vdb_close(qni_vdb *file) {
    qni_vdb_message message;
    guarded(&message, [&] { delete file; });
}

int32_t qni_vdb_grid_count(const qni_vdb *file) {
    return static_cast<int32_t>(file->names.size());
}

qni_vdb_result qni_vdb_describe(qni_vdb *file, int32_t grid, qni_vdb_grid *grid_out,
                                qni_vdb_message *message) {
    std::memset(grid_out, 0, sizeof *grid_out);
    return guarded(message, [&] {
        const openvdb::Name &name = file->names[static_cast<size_t>(grid)];
        set_text(grid_out->info.name, sizeof grid_out->info.name, name.c_str());
        describe(*file->file->readGridMetadata(name), *grid_out);
    });
}

qni_vdb_result qni_vdb_load(qni_vdb *file, int32_t grid, qni_vdb_counts *counts_out,
                            qni_vdb_message *message) {
    std::memset(counts_out, 0, sizeof *counts_out);
    return guarded(message, [&] {
        file->grid = file->file->readGrid(file->names[static_cast<size_t>(grid)]);
        with_tree(*file->grid, [&](auto &tree, auto) { count(tree, *counts_out); });
    });
}

qni_vdb_result qni_vdb_take(qni_vdb *file, const qni_vdb_sink *sink, qni_vdb_message *message) {
    return guarded(message, [&] {
        if (!file->grid)
            throw std::runtime_error("no grid was read");
        with_tree(*file->grid,
                  [&](auto &tree, auto stored_type) { take<decltype(stored_type)>(tree, *sink); });
        file->grid.reset();
    });
}

qni_vdb_result qni_vdb_begin(const qn_sparse_grid *head, qni_vdb **file_out,
                             qni_vdb_message *message) {
    *file_out = nullptr;
    return guarded(message, [&] {
        auto opened = std::make_unique<qni_vdb>();
        opened->made = empty_grid(*head);
        *file_out = opened.release();
    });
}

qni_vdb_result qni_vdb_put_tile(qni_vdb *file, const qn_sparse_tile *tile,
                                qni_vdb_message *message) {
    return guarded(message, [&] { fill_box(file->made->tree(), *tile); });
}

qni_vdb_result qni_vdb_put_leaf(qni_vdb *file, const int32_t origin[3], const uint64_t *mask,
                                const float *values, qni_vdb_message *message) {
    return guarded(message, [&] { add_leaf(file->made->tree(), origin, mask, values); });
}

qni_vdb_result qni_vdb_finish(qni_vdb *file, const char *path, qni_vdb_message *message) {
    return guarded(message, [&] {
        openvdb::tools::pruneTiles(file->made->tree());
        openvdb::GridPtrVec grids = {file->made};
        openvdb::io::File(path).write(grids);
    });
}
