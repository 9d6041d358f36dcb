// SPDX-License-Identifier: MIT
/* What the targets of the mesh readers share. */
#define _GNU_SOURCE /* memfd_create */
#include "fuzz/fuzz_mesh.h"

#include <qn/qn.h>

#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

static void demand(bool holds, const char *what) {
    if (holds)
        return;
    fprintf(stderr, "fuzz: %s\n", what);
    abort();
}

static void check_mesh(const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    for (int64_t i = 0; i < 4 * view.quad_count; ++i)
        demand((int64_t)view.quads[i] < view.vertex_count,
               "a quad names a vertex that is not there");
    for (int64_t i = 0; i < 3 * view.triangle_count; ++i)
        demand((int64_t)view.triangles[i] < view.vertex_count,
               "a triangle names a vertex that is not there");
}

int fuzz_mesh_read(const char *format, const uint8_t *bytes, size_t size) {
    int descriptor = memfd_create("fuzz", 0);
    demand(descriptor >= 0 && write(descriptor, bytes, size) == (ssize_t)size, "no file in memory");
    char path[64];
    snprintf(path, sizeof path, "/proc/self/fd/%d", descriptor);
    qn_context_options options;
    qn_context_options_init(&options);
    options.threads = 1;
    qn_context *context;
    demand(qn_context_create(&options, &context, NULL) == QN_OK, "no context");
    qn_mesh *mesh;
    qn_error error = {0};
    qn_status status = qn_mesh_read(context, path, format, &mesh, &error);
    if (status == QN_OK)
        check_mesh(mesh);
    else
        demand(!mesh && error.status == status && error.message[0] && status == QN_ERROR_INPUT,
               "a failure without its sentence");
    qn_mesh_destroy(mesh);
    demand(qn_context_memory(context).current_bytes == 0, "memory was not given back");
    qn_context_destroy(context);
    close(descriptor);
    return 0;
}
