// SPDX-License-Identifier: MIT
/* The tables of [DMC21] with columns for VTK's plain marching cubes and Flying Edges. */
#include "bench/rivals/vtk_engine.h"
#include "bench/tables.h"

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkMarchingCubes.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <vector>

/* A mesh of what a filter made, and what it made is given up. */
static qn_mesh *take(qn_context *context, vtkPolyData *mesh) {
    std::vector<uint32_t> triangles;
    auto face = vtk::TakeSmartPointer(mesh->GetPolys()->NewIterator());
    for (face->GoToFirstCell(); !face->IsDoneWithTraversal(); face->GoToNextCell()) {
        vtkIdType count;
        const vtkIdType *corners;
        face->GetCurrentCell(count, corners);
        for (int n = 0; n < count; ++n)
            triangles.push_back(static_cast<uint32_t>(corners[n]));
    }
    qn_mesh_view view = qn_mesh_view();
    view.vertex_count = mesh->GetNumberOfPoints();
    view.triangle_count = static_cast<int64_t>(triangles.size() / 3);
    view.positions = static_cast<float *>(mesh->GetPoints()->GetVoidPointer(0));
    view.triangles = triangles.data();
    view.space = view.unit = "";
    qn_mesh *result = nullptr;
    return qn_mesh_create(context, &view, &result, nullptr) == QN_OK ? result : nullptr;
}

static qn_mesh *flying_edges(qn_context *context, const bench_volume *volume) {
    if (volume->swapped)
        return nullptr;
    vtk_engine *engine = vtk_engine_make(*volume, 1, false);
    qn_mesh *mesh = engine ? take(context, vtk_engine_run(*engine)) : nullptr;
    delete engine;
    return mesh;
}

static qn_mesh *marching_cubes(qn_context *context, const bench_volume *volume) {
    if (volume->swapped)
        return nullptr;
    vtk_engine *engine = vtk_engine_make(*volume, 1, false);
    if (!engine)
        return nullptr;
    vtkNew<vtkMarchingCubes> filter;
    filter->SetInputData(engine->image);
    filter->SetValue(0, volume->iso);
    filter->ComputeNormalsOff();
    filter->ComputeGradientsOff();
    filter->ComputeScalarsOff();
    filter->Update();
    qn_mesh *mesh = take(context, filter->GetOutput());
    delete engine;
    return mesh;
}

int main(int argc, char **argv) {
    const tables_method rivals[] = {{"VTK MC", marching_cubes}, {"VTK Flying Edges", flying_edges}};
    return tables_main(rivals, 2, argc, argv);
}
