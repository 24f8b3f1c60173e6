/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lens prescriptions of design programs, .zmx (Zemax, ASCII, UTF-8 or UTF-16) and .seq (CODE V), as glTF with MCVISI_surfaces: spherical,
 * conic and even aspheric surfaces of glasses of the catalogue or of a given index, and the stop as a disc with a hole.
 * Semi-diameters are the file's; where it gives none, those that the axial and the outermost bundle need to first order, and a twentieth
 * more.
 */
#ifndef MCVISI_HOST_SCENE_LENS_FILE_H
#define MCVISI_HOST_SCENE_LENS_FILE_H

#include <jansson.h>

#include "mcvisi/mcvisi.h"

/* `indices`: NAME=INDEX of glasses that the catalogue lacks. *scene is a glTF document; the caller releases it. */
mcv_result mcv_lens_file_read(const char *path, const char *const *indices, size_t index_count, json_t **scene, mcv_error *error);

#endif
