/* SPDX-License-Identifier: Apache-2.0 */
/* A machined part as CAD programs tessellate it, for the benchmarks of the acceleration structure.
 */
#ifndef MCVISI_BENCH_CAD_MESH_H
#define MCVISI_BENCH_CAD_MESH_H

#include <stdbool.h>

#include "mesh.h"

/*
 * A plate of bores² chamfered bores, bores² / 3 tilted shafts with fillets and bores² / 9 rings,
 * about the cube [-1, 1]³, over a base of two triangles. A circle has `segments` chords, a
 * multiple of 4.
 *
 * Walls and shafts are one strip from end to end, shafts end in fans from one vertex, and the faces
 * between the bores are fans from the corners of their cells: slivers of up to some 1 : 150.
 * Even: about the same shapes, of triangles about as long as wide.
 */
mesh cad_mesh(uint32_t segments, uint32_t bores, bool even);

#endif
