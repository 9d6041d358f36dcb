// SPDX-License-Identifier: MIT
/* One surface on a device, in the order of its stages. Knows kernels by name only, so that it runs
 * as well where the processor plays the device. */
#ifndef QNI_GPU_DRIVER_H
#define QNI_GPU_DRIVER_H

#include <qn/surface.h>
#include "gpu/device.h"
#include "volume/field.h"

/* What is asked for, and what came out: arrays in device memory, of the pool, valid until its next
 * use. */
typedef struct qni_gpu_job {
    qni_gpu_pool *pool;
    qni_field field; /* measured, as soon as a sample is found not to be finite */
    qni_gpu_args args;
    bool with_normals, with_halfedges, with_repair;
    bool with_valences; /* and colours, for simplification; then with halfedges as well */
    bool is_slab;       /* a part of the volume, and layers of leaves on either side */

    int64_t vertex_count, quad_count; /* of the finished mesh */
    int64_t doubled_count, split_count;
    int64_t fallback_points; /* of repair */
    qni_gpu_totals totals;

    uint8_t *host_valences, *host_colours; /* of the host's mesh, for what it simplifies */
} qni_gpu_job;

/* Set the job up for samples that lie in device memory, packed or with rows and planes apart. */
void qni_gpu_job_init(qni_gpu_job *job, qni_gpu_pool *pool, const qni_field *field,
                      const void *device_samples, int64_t row, int64_t plane);
/* Layers of leaves that a slab has below its own; above it is one. Vertices and halfedges look one
 * layer down. Repair numbers split quads: those of the layer below are all known only where the
 * layer under it is there as well. */
int32_t qni_gpu_layers_below(const qni_gpu_job *job);
/* Let the job be a slab instead: layers of leaves from own[0] to own[1]. The samples begin with
 * plane `first_plane` of the volume's. */
void qni_gpu_job_cut(qni_gpu_job *job, const int32_t own[2], int64_t first_plane);
/* Pass 1: what there will be. One synchronisation. */
qn_status qni_gpu_count_surface(qni_gpu_job *job, qn_error *error);
/* Pass 2: the mesh; finished when the device is. */
qn_status qni_gpu_emit_surface(qni_gpu_job *job, qn_error *error);
/* Read what pass 2 counted; after this the device has nothing left to do. */
qn_status qni_gpu_finish_surface(qni_gpu_job *job, qn_error *error);

/* The same of a slab. Its counts include the layers beside its own; totals.own tells these apart.
 * Samples that are not finite are met, not measured. */
qn_status qni_gpu_count_slab(qni_gpu_job *job, qn_error *error);
/* After it, what repair will add to the slab: totals.own_splits, own_split_quads. */
qn_status qni_gpu_count_splits(qni_gpu_job *job, qn_error *error);
/* Search planes args.measured_from on, args.measured_planes, for samples that are not finite. */
qn_status qni_gpu_measure_slab(qni_gpu_job *job, qn_error *error);

/* From these counts, and totals.largest_bits, the field's rule for such samples. */
void qni_gpu_apply_measure(qni_gpu_job *job);

/* Entries of an array. */
typedef struct qni_gpu_range {
    int64_t first, count;
} qni_gpu_range;
/* After qni_gpu_emit_surface(): numbers in the slab become numbers in the mesh in these parts: of
 * the vertices plain ones, those of doubled edges, of split quads; of the quads plain and new ones.
 */
qn_status qni_gpu_renumber_slab(qni_gpu_job *job, const qni_gpu_shifts *shifts,
                                const qni_gpu_range vertices[3], const qni_gpu_range quads[2],
                                qn_error *error);

/* data[n] becomes the sum of those before it, for n up to and with *length, which is in device
 * memory and at most `most`; args.scan_sums has room. */
qn_status qni_gpu_scan(qni_gpu_job *job, uint32_t *data, const uint64_t *length, int64_t most,
                       uint64_t *total, qn_error *error);

/* Device memory that the call used beside samples and mesh. */
int64_t qni_gpu_scratch_bytes(const qni_gpu_job *job);
void qni_gpu_fill_report(const qni_gpu_job *job, qn_surface_report *report);

#endif
