// SPDX-License-Identifier: MIT
/* OpenVDB files from sparse volumes, by way of quoin-vdb. The same volume gives the same bytes: the
 * random identity that OpenVDB puts into each file is replaced by one made of the rest. */
#include "core/context.h"
#include "core/file.h"
#include "core/status.h"
#include "volume/sparse.h"
#include "volume/write.h"
#include "qni_config.h"

#if QNI_HAVE_OPENVDB
#include "volume/vdb_client.h"

#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { UUID_OFFSET = 21, UUID_LENGTH = 36, PIECE = 65536 };

/* FNV-1a over all but the identity itself. */
static bool hash_file(int descriptor, unsigned char *piece, uint64_t *hash) {
    ssize_t got;
    *hash = UINT64_C(0xcbf29ce484222325);
    for (off_t offset = 0; (got = pread(descriptor, piece, PIECE, offset)) > 0; offset += got)
        for (ssize_t n = 0; n < got; ++n) {
            const off_t at = offset + n;
            const bool own = at >= UUID_OFFSET && at < UUID_OFFSET + UUID_LENGTH;
            *hash = (*hash ^ (own ? 0 : piece[n])) * UINT64_C(0x100000001b3);
        }
    return got == 0;
}

static bool settle_identity(qn_context *context, const char *path) {
    unsigned char *piece = qni_alloc(context, PIECE, 1);
    const int descriptor = open(path, O_RDWR | O_CLOEXEC);
    uint64_t hash = 0;
    char uuid[64];
    bool good = piece && descriptor >= 0 && hash_file(descriptor, piece, &hash);
    snprintf(uuid, sizeof uuid, "%08x-%04x-5%03x-8%03x-%012llx", (unsigned)(hash >> 32),
             (unsigned)(hash >> 16 & 0xffff), (unsigned)(hash >> 4 & 0xfff),
             (unsigned)(hash >> 20 & 0xfff), (unsigned long long)(hash & 0xffffffffffff));
    good = good && pwrite(descriptor, uuid, UUID_LENGTH, UUID_OFFSET) == UUID_LENGTH;
    if (descriptor >= 0)
        close(descriptor);
    qni_free(context, piece, PIECE, 1);
    return good;
}

/* What the rows hold as one value: the caller's tiles, and the gaps found to be inside. */
static qn_sparse_tile *list_runs(qn_context *context, const qni_sparse *sparse, int64_t *count) {
    *count = 0;
    for (int64_t n = 0; n < sparse->run_count; ++n)
        *count += sparse->runs[n].leaf < 0;
    qn_sparse_tile *tiles = qni_alloc(context, *count, sizeof *tiles);
    int64_t at = 0;
    for (int64_t r = 0; tiles && r < sparse->row_count; ++r)
        for (int64_t n = sparse->row_runs[r]; n < sparse->row_runs[r + 1]; ++n) {
            const qni_sparse_run *run = sparse->runs + n;
            if (run->leaf >= 0)
                continue;
            const int64_t block[3] = {run->begin, sparse->rows[r].y, sparse->rows[r].z};
            qn_sparse_tile *tile = tiles + at++;
            *tile =
                (qn_sparse_tile){.size = {(run->end - run->begin) * 8, 8, 8}, .value = run->value};
            for (int a = 0; a < 3; ++a)
                tile->origin[a] = (int32_t)((block[a] + sparse->first_block[a]) * QNI_BLOCK);
        }
    return tiles;
}

static qn_status write_grid(qn_context *context, const qn_volume *volume, const char *path,
                            qn_error *error) {
    int64_t count;
    qn_sparse_tile *fill = list_runs(context, volume->sparse, &count);
    if (!fill)
        return qni_fail_memory(error, "the tiles of a sparse volume");
    qni_vdb_message message;
    const qni_vdb_result result =
        qni_vdb_client_write(context, path, &volume->sparse->grid, fill, count, &message);
    qni_free(context, fill, count, sizeof *fill);
    if (result == QNI_VDB_CANCELLED)
        return qni_fail(error, QN_ERROR_CANCELLED, "writing was cancelled");
    if (result == QNI_VDB_ABSENT)
        return qni_fail(error, QN_ERROR_UNSUPPORTED, "'%.200s': OpenVDB files: %s", path,
                        message.text);
    if (result == QNI_VDB_NO_MEMORY)
        return qni_fail_memory(error, "an OpenVDB tree");
    if (result != QNI_VDB_OK || !settle_identity(context, path))
        return qni_fail(error, QN_ERROR_OUTPUT, "OpenVDB cannot write '%.200s': %s", path,
                        result == QNI_VDB_OK ? "the disk may be full" : message.text);
    return QN_OK;
}

qn_status qni_write_vdb(qn_context *context, const qn_volume *volume, const char *path,
                        qn_error *error) {
    if (!volume->sparse || volume->grid.scalar != QN_F32)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "'%.200s': only sparse volumes of f32 samples are written as .vdb; take "
                        ".npy or .nii",
                        path);
    qni_output output;
    QN_TRY(qni_output_open(&output, context, path, error));
    qn_status status = output.direct
                           ? qni_fail(error, QN_ERROR_OUTPUT,
                                      "'%.200s' is no regular file, which a .vdb needs", path)
                           : write_grid(context, volume, output.temporary, error);
    if (status != QN_OK) {
        qni_output_abandon(&output);
        return status;
    }
    return qni_output_commit(&output, error);
}

#else

qn_status qni_write_vdb(qn_context *context, const qn_volume *volume, const char *path,
                        qn_error *error) {
    (void)context;
    (void)volume;
    return qni_fail(
        error, QN_ERROR_UNSUPPORTED,
        "'%.200s': this build does not write OpenVDB files: install libopenvdb-dev, libboost-dev "
        "and build with -Dopenvdb=enabled",
        path);
}

#endif
