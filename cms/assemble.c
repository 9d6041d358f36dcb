// SPDX-License-Identifier: MIT
/* The mesh of all chunks: crossings that triangles use, features that they use, inner points. */
#include "cms/stages.h"
#include "core/context.h"
#include "core/status.h"
#include "mesh/mesh.h"

#include <string.h>

typedef struct assembly {
    uint32_t *crossing_index, *feature_index; /* final ones; QNI_NONE when no triangle uses it */
    int64_t crossings, features, apexes, triangles, creases;
} assembly;

static void mark_used(const qni_stages *stages, assembly *parts) {
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        const qni_chunk *chunk = &stages->chunks[n];
        for (int64_t t = 0; t < chunk->triangle_count; ++t)
            for (int k = 0; k < 3; ++k) {
                const uint32_t ref = chunk->triangles[t][k];
                if (QNI_REF_KIND(ref) == QNI_REF_CROSSING)
                    parts->crossing_index[QNI_REF_NUMBER(ref)] = 0;
                else if (QNI_REF_KIND(ref) == QNI_REF_FEATURE)
                    parts->feature_index[QNI_REF_NUMBER(ref)] = 0;
            }
    }
}

/* Those used get their numbers, from `first` on; how many they are. */
static int64_t number_used(uint32_t *index, int64_t count, int64_t first) {
    int64_t used = 0;
    for (int64_t n = 0; n < count; ++n)
        if (index[n] == 0)
            index[n] = (uint32_t)(first + used++);
    return used;
}

static void count_parts(qni_stages *stages, assembly *parts) {
    parts->crossings = number_used(parts->crossing_index, stages->hermite->crossing_count, 0);
    parts->features = number_used(parts->feature_index, stages->feature_count, parts->crossings);
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        qni_chunk *chunk = &stages->chunks[n];
        chunk->apex_base = parts->crossings + parts->features + parts->apexes;
        chunk->triangle_base = parts->triangles;
        chunk->crease_base = parts->creases;
        parts->apexes += chunk->apex_count;
        parts->triangles += chunk->triangle_count;
        parts->creases += chunk->crease_count;
    }
}

static uint32_t final_index(const assembly *parts, const qni_chunk *chunk, uint32_t ref) {
    const uint32_t number = QNI_REF_NUMBER(ref);
    if (QNI_REF_KIND(ref) == QNI_REF_CROSSING)
        return parts->crossing_index[number];
    if (QNI_REF_KIND(ref) == QNI_REF_FEATURE)
        return parts->feature_index[number];
    return (uint32_t)chunk->apex_base + number;
}

static void fill_chunk(const qni_stages *stages, const assembly *parts, int64_t index,
                       qn_mesh *mesh) {
    const qni_chunk *chunk = &stages->chunks[index];
    for (int64_t t = 0; t < chunk->triangle_count; ++t)
        for (int k = 0; k < 3; ++k)
            mesh->triangles[3 * (chunk->triangle_base + t) + k] =
                final_index(parts, chunk, chunk->triangles[t][k]);
    if (chunk->triangle_count)
        memcpy(mesh->triangle_owners + chunk->triangle_base, chunk->owners,
               sizeof *chunk->owners * (size_t)chunk->triangle_count);
    for (int64_t c = 0; c < chunk->crease_count; ++c)
        for (int k = 0; k < 2; ++k)
            mesh->crease_edges[2 * (chunk->crease_base + c) + k] =
                final_index(parts, chunk, chunk->creases[c][k]);
    if (chunk->apex_count)
        memcpy(mesh->positions + 3 * chunk->apex_base, chunk->apexes,
               sizeof *chunk->apexes * (size_t)chunk->apex_count);
}

static void fill_places(const qni_stages *stages, const assembly *parts, float *positions) {
    const qni_hermite *hermite = stages->hermite;
#pragma omp parallel for schedule(static) num_threads(stages->threads)
    for (int64_t n = 0; n < hermite->crossing_count; ++n)
        if (parts->crossing_index[n] != QNI_NONE)
            memcpy(positions + 3 * (int64_t)parts->crossing_index[n], hermite->crossings[n].place,
                   3 * sizeof(float));
#pragma omp parallel for schedule(static) num_threads(stages->threads)
    for (int64_t n = 0; n < stages->feature_count; ++n)
        if (parts->feature_index[n] != QNI_NONE)
            memcpy(positions + 3 * (int64_t)parts->feature_index[n], stages->features[n].place,
                   3 * sizeof(float));
}

static void fill_mesh(const qni_stages *stages, const assembly *parts, qn_mesh *mesh) {
#pragma omp parallel for schedule(dynamic, 16) num_threads(stages->threads)
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        fill_chunk(stages, parts, n, mesh);
        qni_chunk_free_made(stages->context, &stages->chunks[n]);
    }
}

static qn_status allocate(qni_stages *stages, const assembly *parts, qn_mesh **mesh_out) {
    qn_context *context = stages->context;
    QN_TRY(qni_mesh_alloc(context, parts->crossings + parts->features + parts->apexes, 0,
                          parts->triangles, false, mesh_out, stages->error));
    qn_mesh *mesh = *mesh_out;
    mesh->triangle_owners = qni_alloc(context, parts->triangles, sizeof *mesh->triangle_owners);
    if (parts->creases)
        mesh->crease_edges = qni_alloc(context, parts->creases, 2 * sizeof *mesh->crease_edges);
    mesh->crease_edge_count = mesh->crease_edges ? parts->creases : 0;
    if (mesh->triangle_owners && (!parts->creases || mesh->crease_edges))
        return QN_OK;
    qn_mesh_destroy(mesh);
    *mesh_out = NULL;
    return qni_fail_memory(stages->error, "a mesh");
}

/* The places of crossings and features, which are given up for the mesh. */
static float *take_places(qni_stages *stages, const assembly *parts, qni_hermite *hermite) {
    const int64_t count = parts->crossings + parts->features;
    float *places = qni_alloc(stages->context, count, 3 * sizeof *places);
    if (!places)
        return NULL;
    fill_places(stages, parts, places);
    qni_hermite_drop_crossings(hermite);
    qni_return_memory(stages->context);
    return places;
}

static qn_status make_mesh(qni_stages *stages, qni_hermite *hermite, assembly *parts,
                           qn_mesh **mesh_out) {
    memset(parts->crossing_index, 0xff, sizeof(uint32_t) * (size_t)stages->hermite->crossing_count);
    memset(parts->feature_index, 0xff, sizeof(uint32_t) * (size_t)stages->feature_count);
    mark_used(stages, parts);
    count_parts(stages, parts);
    const int64_t count = parts->crossings + parts->features;
    float *places = take_places(stages, parts, hermite);
    if (!places)
        return qni_fail_memory(stages->error, "a mesh");
    const qn_status status = allocate(stages, parts, mesh_out);
    if (status == QN_OK) {
        if (count)
            memcpy((*mesh_out)->positions, places, 3 * sizeof *places * (size_t)count);
        fill_mesh(stages, parts, *mesh_out);
    }
    qni_free(stages->context, places, count, 3 * sizeof *places);
    return status;
}

qn_status qni_stages_assemble(qni_stages *stages, qni_hermite *hermite, qn_mesh **mesh_out) {
    const int64_t crossings = stages->hermite->crossing_count, features = stages->feature_count;
    assembly parts = {
        .crossing_index = qni_alloc(stages->context, crossings, sizeof(uint32_t)),
        .feature_index = qni_alloc(stages->context, features, sizeof(uint32_t)),
    };
    const qn_status status = parts.crossing_index && parts.feature_index
                                 ? make_mesh(stages, hermite, &parts, mesh_out)
                                 : qni_fail_memory(stages->error, "a mesh");
    qni_free(stages->context, parts.crossing_index, crossings, sizeof(uint32_t));
    qni_free(stages->context, parts.feature_index, features, sizeof(uint32_t));
    return status;
}
