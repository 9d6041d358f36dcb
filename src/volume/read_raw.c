// SPDX-License-Identifier: MIT
/* Raw files: samples without a header, x fastest; shape, type and byte order come from the options.
 */
#include "core/status.h"
#include "volume/load.h"

/* The size of the file and the size the options make must be the same: another number means a wrong
 * shape, type or header, and a wrong picture. */
static qn_status check_file_size(const qni_source *source, const qn_volume_read_options *options,
                                 int64_t bytes, qn_error *error) {
    int64_t there = qni_source_bound(source), wanted;
    bool exact = !source->inflate && source->file_size >= 0;
    if (__builtin_add_overflow(bytes, options->raw_header, &wanted))
        wanted = INT64_MAX;
    if (there >= wanted && (!exact || there == wanted))
        return QN_OK;
    return qni_source_fail(
        source, error,
        "holds%s %lld bytes, but %lld x %lld x %lld samples of type %s after a header "
        "of %lld bytes are %lld; correct --shape, --dtype or --header",
        exact ? "" : " at most", (long long)there, (long long)options->raw_size[0],
        (long long)options->raw_size[1], (long long)options->raw_size[2],
        qn_scalar_name(options->raw_scalar), (long long)options->raw_header, (long long)wanted);
}

qn_status qni_read_raw(qni_source *source, const qn_volume_read_options *options,
                       qn_volume **volume_out, qn_error *error) {
    if (options->raw_size[0] == 0 && options->raw_size[1] == 0 && options->raw_size[2] == 0)
        return qni_source_fail_as(
            source, QN_ERROR_INVALID_ARGUMENT, error,
            "a raw file does not say its shape and type: give them, like --shape "
            "256,256,128 --dtype u8");
    qn_grid grid = {.scalar = options->raw_scalar,
                    .swapped = options->raw_big_endian != qni_machine_is_big_endian()};
    for (int a = 0; a < 3; ++a)
        grid.size[a] = options->raw_size[a];
    for (int a = 0; a < 4; ++a)
        grid.index_to_world[a][a] = 1;
    QN_TRY(qni_load_overrides(source, options, grid.index_to_world, error));
    int64_t bytes;
    QN_TRY(qni_load_bytes(source, &grid, &bytes, error));
    QN_TRY(check_file_size(source, options, bytes, error));
    QN_TRY(qni_source_skip(source, options->raw_header, error));
    bool more;
    QN_TRY(qni_load(source, &grid, QNI_BINARY, "raw", &more, volume_out, error));
    if (!more)
        return QN_OK;
    qn_volume_destroy(*volume_out);
    *volume_out = NULL;
    return qni_source_fail(
        source, error,
        "unpacks to more than the %lld bytes of %lld x %lld x %lld samples of type %s "
        "after a header of %lld bytes; correct --shape, --dtype or --header",
        (long long)(options->raw_header + bytes), (long long)grid.size[0], (long long)grid.size[1],
        (long long)grid.size[2], qn_scalar_name(grid.scalar), (long long)options->raw_header);
}
