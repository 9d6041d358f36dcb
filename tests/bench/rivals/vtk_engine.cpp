// SPDX-License-Identifier: MIT
/* vtkFlyingEdges3D on samples in memory, which it reads where they are. */
#include "bench/rivals/vtk_engine.h"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>
#include <vtkShortArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnsignedShortArray.h>

template <class array, class scalar>
static void lend(vtkImageData *image, const bench_volume &volume) {
    vtkNew<array> values;
    scalar *samples = const_cast<scalar *>(static_cast<const scalar *>(volume.samples));
    values->SetArray(samples, bench_sample_count(&volume), 1);
    image->GetPointData()->SetScalars(values);
}

vtk_engine *vtk_engine_make(const bench_volume &volume, int threads, bool normals) {
    vtkSMPTools::Initialize(threads);
    vtk_engine *engine = new vtk_engine;
    engine->normals = normals;
    engine->iso = volume.iso;
    engine->image->SetDimensions(static_cast<int>(volume.size[0]), static_cast<int>(volume.size[1]),
                                 static_cast<int>(volume.size[2]));
    switch (volume.scalar) {
    case QN_U8:
        lend<vtkUnsignedCharArray, unsigned char>(engine->image, volume);
        return engine;
    case QN_U16:
        lend<vtkUnsignedShortArray, unsigned short>(engine->image, volume);
        return engine;
    case QN_I16:
        lend<vtkShortArray, short>(engine->image, volume);
        return engine;
    case QN_F32:
        lend<vtkFloatArray, float>(engine->image, volume);
        return engine;
    default:
        delete engine;
        return nullptr;
    }
}

vtkPolyData *vtk_engine_run(vtk_engine &engine) {
    engine.filter = vtkSmartPointer<vtkFlyingEdges3D>::New();
    engine.filter->SetInputData(engine.image);
    engine.filter->SetValue(0, engine.iso);
    engine.filter->SetComputeNormals(engine.normals);
    engine.filter->ComputeGradientsOff();
    engine.filter->ComputeScalarsOff();
    engine.filter->Update();
    return engine.filter->GetOutput();
}

int64_t vtk_engine_bytes(vtkPolyData *mesh) {
    return 1024 * static_cast<int64_t>(mesh->GetActualMemorySize());
}
