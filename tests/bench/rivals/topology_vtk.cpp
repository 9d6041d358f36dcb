// SPDX-License-Identifier: MIT
/* The rows of VTK's Flying Edges in the topology table. */
#include "bench/rivals/vtk_engine.h"
#include "bench/topology.h"

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <vector>

static std::vector<float> positions;
static std::vector<uint32_t> triangles;

static bool surface(const uint16_t *samples, const int64_t size[3], double iso,
                    qn_mesh_view *view) {
    const bench_volume volume = {"noisy", QN_U16, false, {size[0], size[1], size[2]}, samples, iso};
    vtk_engine *engine = vtk_engine_make(volume, 2, false);
    vtkPolyData *mesh = vtk_engine_run(*engine);
    positions.assign(
        static_cast<float *>(mesh->GetPoints()->GetVoidPointer(0)),
        static_cast<float *>(mesh->GetPoints()->GetVoidPointer(3 * mesh->GetNumberOfPoints())));
    triangles.clear();
    auto face = vtk::TakeSmartPointer(mesh->GetPolys()->NewIterator());
    for (face->GoToFirstCell(); !face->IsDoneWithTraversal(); face->GoToNextCell()) {
        vtkIdType count;
        const vtkIdType *corners;
        face->GetCurrentCell(count, corners);
        if (count != 3)
            return false;
        for (int n = 0; n < 3; ++n)
            triangles.push_back(static_cast<uint32_t>(corners[n]));
    }
    *view = qn_mesh_view();
    view->vertex_count = static_cast<int64_t>(positions.size() / 3);
    view->triangle_count = static_cast<int64_t>(triangles.size() / 3);
    view->positions = positions.data();
    view->triangles = triangles.data();
    view->space = view->unit = "";
    delete engine;
    return true;
}

int main() {
    const topology_engine engine = {"vtk-fe", surface, false, false};
    return topology_main(&engine);
}
