// SPDX-License-Identifier: MIT
/* vtkFlyingEdges3D on samples in memory, which it reads where they are. */
#ifndef BENCH_VTK_ENGINE_H
#define BENCH_VTK_ENGINE_H

#include "bench/bench.h"

#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>

struct vtk_engine {
    vtkNew<vtkImageData> image;
    vtkSmartPointer<vtkFlyingEdges3D> filter;
    bool normals;
    double iso;
};

/* nullptr for scalar types it was not given. */
vtk_engine *vtk_engine_make(const bench_volume &volume, int threads, bool normals);
/* A fresh filter each time: VTK would answer a second request from its cache. */
vtkPolyData *vtk_engine_run(vtk_engine &engine);
int64_t vtk_engine_bytes(vtkPolyData *mesh);

#endif
