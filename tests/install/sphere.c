// SPDX-License-Identifier: MIT
/* A user's first C program: a sphere sampled here becomes a closed mesh. */
#include <math.h>
#include <qn/qn.h>
#include <stdio.h>

int main(void) {
    enum { N = 20 };
    static float samples[N][N][N];
    for (int k = 0; k < N; ++k)
        for (int j = 0; j < N; ++j)
            for (int i = 0; i < N; ++i)
                samples[k][j][i] = (float)sqrt(pow(i - 9.5, 2) + pow(j - 9.5, 2) + pow(k - 9.5, 2));
    qn_context *context = NULL;
    qn_volume *volume = NULL;
    qn_mesh *mesh = NULL;
    qn_mesh_report check;
    qn_error error;
    qn_grid grid = {.samples = samples, .scalar = QN_F32, .size = {N, N, N}};
    double isovalue = 7;
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = &isovalue;
    options.isovalue_count = 1;
    options.inside = QN_INSIDE_BELOW;
    if (qn_context_create(NULL, &context, &error) || /* each is QN_OK, 0, when all is well */
        qn_volume_create(context, &grid, NULL, NULL, &volume, &error) ||
        qn_surface(context, volume, &options, &mesh, NULL, &error) ||
        qn_mesh_check(context, mesh, NULL, &check, &error)) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    qn_mesh_view view = qn_mesh_get_view(mesh);
    printf("%lld vertices, %lld quads, volume %.0f\n", (long long)view.vertex_count,
           (long long)view.quad_count, check.volume);
    int good = view.vertex_count > 0 && view.quad_count > 0 && check.closed && check.manifold &&
               fabs(check.volume - 4.18879 * 343) < 30;
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    qn_context_destroy(context);
    return good ? 0 : 1;
}
