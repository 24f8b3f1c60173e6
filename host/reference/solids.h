/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Exact surfaces in double, piece by piece: conics by the formula for their roots, aspheres between
 * samples along the ray. A ray that starts on a piece does not hit it again at 0.
 */
#ifndef MCVISI_HOST_REFERENCE_SOLIDS_H
#define MCVISI_HOST_REFERENCE_SOLIDS_H

#include "reference/geometry.h"

enum { REF_PIECES = 3, REF_MEETINGS = 8 };

/* The distances, above 0 and unsorted, at which a ray meets a piece; returns how many. `on`: it
 * starts on the piece. */
int ref_meet_piece(const mcv_solid *solid, int piece, ref_vec origin, ref_vec direction, bool on,
                   double distances[REF_MEETINGS]);

/* Moves a point near the piece onto it, and gives the outward unit normal. */
void ref_on_piece(const mcv_solid *solid, int piece, ref_vec *position, ref_vec *normal);

bool ref_solid_holds(const mcv_solid *solid, ref_vec point);

#endif
