// SPDX-License-Identifier: MIT
/* A user's first C++ program: the same sphere; a wrong option is an error with a sentence, not a
 * crash. */
#include <cmath>
#include <cstdio>
#include <memory>
#include <qn/qn.h>
#include <vector>

int main() {
    const int n = 20;
    std::vector<float> samples;
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i)
                samples.push_back(float(std::hypot(i - 9.5, j - 9.5, k - 9.5)));
    qn_error error;
    qn_context *context_pointer = nullptr;
    if (qn_context_create(nullptr, &context_pointer, &error))
        return 1;
    std::unique_ptr<qn_context, void (*)(qn_context *)> context(context_pointer,
                                                                qn_context_destroy);
    qn_grid grid = {};
    grid.samples = samples.data();
    grid.scalar = QN_F32;
    grid.size[0] = grid.size[1] = grid.size[2] = n;
    qn_volume *volume_pointer = nullptr;
    if (qn_volume_create(context.get(), &grid, nullptr, nullptr, &volume_pointer, &error))
        return 1;
    std::unique_ptr<qn_volume, void (*)(qn_volume *)> volume(volume_pointer, qn_volume_destroy);
    qn_surface_options options;
    qn_surface_options_init(&options);
    double isovalue = NAN;
    options.isovalues = &isovalue;
    options.isovalue_count = 1;
    qn_mesh *mesh_pointer = nullptr;
    qn_status status =
        qn_surface(context.get(), volume.get(), &options, &mesh_pointer, nullptr, &error);
    if (status != QN_ERROR_INVALID_ARGUMENT || mesh_pointer || !error.message[0])
        return 2;
    isovalue = 7;
    options.inside = QN_INSIDE_BELOW;
    if (qn_surface(context.get(), volume.get(), &options, &mesh_pointer, nullptr, &error))
        return 3;
    std::unique_ptr<qn_mesh, void (*)(qn_mesh *)> mesh(mesh_pointer, qn_mesh_destroy);
    qn_mesh_view view = qn_mesh_get_view(mesh.get());
    std::printf("%lld vertices, %lld quads\n", (long long)view.vertex_count,
                (long long)view.quad_count);
    return view.vertex_count - view.quad_count == 2 ? 0 : 4; /* a sphere */
}
