// SPDX-License-Identifier: MIT
/* VTK's Flying Edges under the benchmark's frame. */
#include "bench/rivals/vtk_engine.h"

#include <vtkPolyData.h>

static void *prepare(const bench_volume *volume, int threads, bool normals) {
    return vtk_engine_make(*volume, threads, normals);
}

static bool extract(void *state, bench_outcome *outcome) {
    vtkPolyData *mesh = vtk_engine_run(*static_cast<vtk_engine *>(state));
    outcome->vertices = mesh->GetNumberOfPoints();
    outcome->faces = mesh->GetNumberOfPolys();
    outcome->output_bytes = vtk_engine_bytes(mesh);
    outcome->scratch_bytes = -1;
    outcome->classify_wall = outcome->emit_wall = -1;
    return true;
}

static void clear(void *state) {
    static_cast<vtk_engine *>(state)->filter = nullptr;
}

int main(int argc, char **argv) {
    const bench_engine engine = {"vtk-fe", true, true, false, prepare, extract, clear};
    return bench_main(&engine, argc, argv);
}
