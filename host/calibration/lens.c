/* SPDX-License-Identifier: Apache-2.0 */
/* Tilt and distortion in the formats of other programs. */
#include "calibration/calibration.h"

#include <math.h>
#include <string.h>

/* How many coefficients OpenCV takes: k1 k2 p1 p2, k3, k4 k5 k6, s1 … s4, τx τy. */
static const int counts[] = {5, 8, 12, MCV_OPENCV_COEFFICIENTS};

int mcv_lens_to_opencv(const mcv_lens_map *m, double c[MCV_OPENCV_COEFFICIENTS]) {
    const double all[MCV_OPENCV_COEFFICIENTS] = {m->k[0], m->k[1], m->p[0], m->p[1], m->k[2],
                                                 m->k[3], m->k[4], m->k[5], m->s[0], m->s[1],
                                                 m->s[2], m->s[3], 0,       0};
    memcpy(c, all, sizeof all);
    if (m->tilted && isfinite(m->tilt)) {
        /* About x or y both conventions are the same. */
        c[12] = m->tilt * rint(cos(m->direction));
        c[13] = m->tilt * rint(sin(m->direction));
    } else if (m->tilted) {
        c[12] = m->tilt_xy[0];
        c[13] = m->tilt_xy[1];
    }
    int last = MCV_OPENCV_COEFFICIENTS;
    while (last > 0 && c[last - 1] == 0) --last;
    int i = 0;
    while (counts[i] < last) ++i;
    return counts[i];
}

void mcv_lens_of_opencv(const double c[MCV_OPENCV_COEFFICIENTS], mcv_lens_map *m) {
    const double k[6] = {c[0], c[1], c[4], c[5], c[6], c[7]};
    *m = mcv_lens_map_none();
    memcpy(m->k, k, sizeof k);
    memcpy(m->p, c + 2, sizeof m->p);
    memcpy(m->s, c + 8, sizeof m->s);
    for (int i = 0; i < 12; ++i)
        if (c[i] != 0) m->model = MCV_BROWN_CONRADY;
    if (c[12] != 0 || c[13] != 0) mcv_lens_map_tilt_xy(m, c[12], c[13]);
}

/* Is it about the image's x or y? */
static bool is_along_axes(const mcv_lens_map *m) {
    const double quarter = m->direction / (M_PI / 2);
    return !m->tilted || isnan(m->tilt) || fabs(quarter - rint(quarter)) < 1e-12;
}

void mcv_lens_to_halcon(const mcv_lens_map *m, double *tilt, double *rot) {
    *tilt = m->tilt, *rot = m->direction;
    if (isnan(m->tilt)) { /* one of the two is 0 */
        *tilt = m->tilt_xy[0] + m->tilt_xy[1];
        *rot = m->tilt_xy[1] != 0 ? M_PI / 2 : 0;
    }
    if (*tilt < 0) *tilt = -*tilt, *rot += M_PI;
    *tilt *= 180 / M_PI;
    *rot = fmod(fmod(*rot, 2 * M_PI) + 2 * M_PI, 2 * M_PI) * 180 / M_PI;
}

/* What a format cannot hold, and why; NULL where it can. */
static const char *lacking(const mcv_camera_model *model, mcv_calibration_format format) {
    const mcv_lens_map *m = &model->lens;
    double c[MCV_OPENCV_COEFFICIENTS];
    if (format == MCV_CALIBRATION_JSON || !mcv_lens_map_is_used(m)) return NULL;
    if (format == MCV_CALIBRATION_HALCON) {
        if (m->model == MCV_BROWN_CONRADY)
            return "k1 to s4 go from directions to pixels, HALCON's polynomial the other way";
        return isnan(m->tilt) && m->tilt_xy[0] != 0 && m->tilt_xy[1] != 0
                   ? "it has no film that is tilted by both tiltX and tiltY"
                   : NULL;
    }
    if (model->telecentric) return "it has no distortion of a telecentric lens";
    if (m->model == MCV_DIVISION) return "it has no division model";
    if (!is_along_axes(m)) return "its film is tilted about the image's x and y alone";
    const int count = mcv_lens_to_opencv(m, c);
    if (format == MCV_CALIBRATION_OPENCV || count <= 8) return NULL;
    return "it has neither s1 to s4 nor a tilted film";
}

mcv_result mcv_calibration_check_lens(const mcv_camera_model *model, const char *name,
                                      mcv_calibration_format format, const char *program,
                                      mcv_error *error) {
    const char *why = lacking(model, format);
    if (!why) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT,
                    "sensor %s: %s cannot hold its tilt or distortion, because %s: take --format "
                    "json",
                    name, program, why);
}
