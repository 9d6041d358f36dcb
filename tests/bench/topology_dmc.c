// SPDX-License-Identifier: MIT
/* Quoin's rows of the topology table. */
#include "bench/topology.h"
#include "lib/support.h"

static qn_context *context;
static qn_mesh *mesh;

static bool surface_of(bool keep_doubled, const uint16_t *samples, const int64_t size[3],
                       double iso, qn_mesh_view *view) {
    qn_grid grid;
    memset(&grid, 0, sizeof grid);
    grid.samples = samples;
    grid.scalar = QN_U16;
    memcpy(grid.size, size, sizeof grid.size);
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = &iso;
    options.isovalue_count = 1;
    options.open = true;
    options.keep_doubled = keep_doubled;
    qn_volume *volume = NULL;
    qn_mesh_destroy(mesh);
    mesh = NULL;
    const bool good = qn_volume_create(context, &grid, NULL, NULL, &volume, NULL) == QN_OK &&
                      qn_surface(context, volume, &options, &mesh, NULL, NULL) == QN_OK;
    qn_volume_destroy(volume);
    if (good)
        *view = qn_mesh_get_view(mesh);
    return good;
}

static bool repaired(const uint16_t *samples, const int64_t size[3], double iso,
                     qn_mesh_view *view) {
    return surface_of(false, samples, size, iso, view);
}

static bool doubled(const uint16_t *samples, const int64_t size[3], double iso,
                    qn_mesh_view *view) {
    return surface_of(true, samples, size, iso, view);
}

int main(void) {
    const topology_engine with_repair = {"quoin", repaired, true, true};
    const topology_engine without = {"quoin --manifold off", doubled, true, false};
    context = test_context(0);
    const int status = topology_main(&with_repair) | topology_main(&without);
    qn_mesh_destroy(mesh);
    qn_context_destroy(context);
    return status;
}
