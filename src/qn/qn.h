// SPDX-License-Identifier: MIT
/* All of Quoin's public interface, in reading order. */
#ifndef QN_QN_H
#define QN_QN_H

#include <qn/base.h>
#include <qn/volume.h>
#include <qn/solid.h>
#include <qn/surface.h>
#include <qn/cuda.h>
#include <qn/mesh.h>
#include <qn/band.h>
#include <qn/solid.h>

#endif
