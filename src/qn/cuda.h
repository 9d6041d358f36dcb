// SPDX-License-Identifier: MIT
/* Surfaces of samples that lie in the memory of a CUDA device, left there as meshes. No CUDA header
 * is needed to include this; builds without CUDA answer QN_ERROR_UNSUPPORTED. */
#ifndef QN_CUDA_H
#define QN_CUDA_H

#include <qn/surface.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The current CUDA device (the first, unless the thread chose another), a stream, and the device
 * memory that calls have needed so far: it is kept, so a call like the one before allocates
 * nothing. One thread at a time. */
typedef struct qn_cuda qn_cuda;

/* `stream` is a cudaStream_t, NULL for the default one; it and the context must outlive the result.
 *
 * QN_ERROR_UNSUPPORTED  built without CUDA, no driver, no device, or one too old: the message says
 * which QN_ERROR_OUT_OF_MEMORY */
QN_API qn_status qn_cuda_create(qn_context *context, void *stream, qn_cuda **cuda_out,
                                qn_error *error);
QN_API void qn_cuda_destroy(qn_cuda *cuda);

/* A mesh in device memory, as <qn/mesh.h> describes its arrays. They belong to the qn_cuda and end
 * with its next call. Arrays that were not asked for, or have no entry, are NULL. */
typedef struct qn_cuda_mesh {
    int64_t vertex_count, quad_count;
    const float *positions;          /* [vertex_count][3] */
    const float *normals;            /* [vertex_count][3] */
    const uint32_t *quads;           /* [quad_count][4] */
    const uint32_t *twin;            /* [4 quad_count], with options->halfedges */
    const uint32_t *vertex_halfedge; /* [vertex_count], likewise */
} qn_cuda_mesh;

/* As qn_surface() for one iso-value, with the same bytes. `grid->samples` is device memory, ready
 * on the stream; the call returns when the mesh is.
 *
 * options  NULL for defaults; isovalues are not looked at.
 * report   may be NULL.
 *
 * QN_ERROR_INVALID_ARGUMENT  as qn_volume_create() and qn_surface()
 * QN_ERROR_UNSUPPORTED       exact topology, simplify_passes below 0, relaxation, untangling,
 *                            triangles, count_only; an open surface without keep_doubled; samples
 * in foreign byte order or not contiguous along x QN_ERROR_OUT_OF_MEMORY     the device's memory is
 * full, or more than 2^32 - 1 vertices */
QN_API qn_status qn_cuda_surface(qn_cuda *cuda, const qn_grid *grid, double isovalue,
                                 const qn_surface_options *options, qn_cuda_mesh *mesh_out,
                                 qn_surface_report *report, qn_error *error);

#ifdef __cplusplus
}
#endif
#endif
