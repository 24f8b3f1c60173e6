/* SPDX-License-Identifier: Apache-2.0 */
/* Joining film files of sample ranges (`render --samples A:B --film`) to the film, and the bits, of
 * one render. */
#ifndef MCVISI_HOST_VERBS_MERGE_H
#define MCVISI_HOST_VERBS_MERGE_H

#include "core/basics.h"
#include "film/film_file.h"
#include "verbs/render_picture.h"
#include "verbs/report.h"

/*
 * Writes the film of a render of a sample range, with all that its picture needs
 * (verbs/checkpoint.h lists the facts):
 *
 *     range       [first, last) of the samples of each replicate
 *     attributes  of the picture
 */
mcv_result mcv_part_write(const char *path, json_t *identity, const mcv_rendered *rendered,
                          mcv_error *error);

/*
 * Joins the parts, in any order, to a picture. Notes in the report tell of devices that differ.
 * MCV_BAD_INPUT for parts of different renders (what differs is named), and for samples that are
 * missing or there twice. At any time it holds as many films as the number of parts has binary
 * digits, and one.
 */
mcv_result mcv_parts_merge(mcv_texts paths, bool replicates, mcv_exr *exr, mcv_report *report,
                           mcv_error *error);

#endif
