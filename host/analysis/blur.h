/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The modulation transfer function of a lens, applied to an image of light: rays leave it out. The
 * lens is the same all over the image and shifts no phase. An image holds its spectrum up to the
 * Nyquist frequency only. Aliased frequencies are filtered as those that they look like.
 */
#ifndef MCVISI_HOST_ANALYSIS_BLUR_H
#define MCVISI_HOST_ANALYSIS_BLUR_H

#include "analysis/region.h"

/* Rows of an MTF given as a table, in ascending frequency [1/m]; linear between them, constant
 * beyond the last. */
typedef struct mcv_mtf_row {
    double frequency, modulation;
} mcv_mtf_row;

/* Of a lens: rows where there are any, else the aberration-free lens of a round stop. */
typedef struct mcv_lens_mtf {
    double f_number;   /* working, image side */
    double wavelength; /* [m] */
    const mcv_mtf_row *rows;
    size_t row_count;
} mcv_lens_mtf;

/*
 * Modulation at a frequency [1/m] in the image. Without a table 2/π (acos s - s √(1 - s²)), s =
 * frequency wavelength f_number, 0 from s = 1 on: incoherent light through a round stop (Goodman,
 * Introduction to Fourier Optics, chapter 6).
 */
double mcv_lens_modulation(const mcv_lens_mtf *mtf, double frequency);

/*
 * Reads a table, rows `cycles per mm, modulation`; lines that begin with # are passed over.
 * MCV_BAD_INPUT names file and line: frequencies must ascend from 0, modulations lie in 0 … 1 and
 * begin with 1. The caller frees *rows.
 */
mcv_result mcv_mtf_read(const char *path, mcv_mtf_row **rows, size_t *count, mcv_error *error);

/*
 * Blurs every channel in place, by mtf[channel] (channels beyond the third: by the third); pitch is
 * the pixel's width and height [m]. The outermost pixels continue beyond the border. Light that
 * would become negative is 0. light_error, the standard errors, may be NULL. Errors of neighbours
 * are independent before. *correlation (or NULL) gets their correlation afterwards, the mean over
 * the channels.
 */
mcv_result mcv_blur(mcv_image *light, mcv_image *light_error, const mcv_lens_mtf mtf[3],
                    const double pitch[2], mcv_correlation *correlation, mcv_error *error);

#endif
