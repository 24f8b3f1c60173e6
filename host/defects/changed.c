/* SPDX-License-Identifier: Apache-2.0 */
/* What a defect has changed. */
#include "defects/defects.h"

#include <float.h>
#include <math.h>

/* Of the depth of a relief: what is lower than this share counts as unchanged. */
static const double least_height = 0.01;

/* On the face of a ball or plane. Its triangles are chords of less than size/16384; vertices are
 * rounded to float32. */
static bool is_cut_face(const mcv_defect *d, const double p[3], double largest) {
    double normal[3];
    const double off = p[2] - mcv_defect_cut(d, p[0], p[1], normal),
                 tolerance = fmax(d->size / 4096, 4 * (double)FLT_EPSILON * largest);
    if (d->type == MCV_DEFECT_CHIP && p[0] * p[0] + p[1] * p[1] > d->size * d->size / 4)
        return false;
    return fabs(off) <= tolerance;
}

/* On or in a ball, the outermost tube of a stria or the disc of a crack; all lie along p[2]. */
static bool is_inside(const mcv_defect *d, const double p[3], double largest) {
    const double r = mcv_defect_outer_radius(d) + 4 * (double)FLT_EPSILON * largest,
                 half = d->type == MCV_DEFECT_CRACK ? d->depth / 2 : d->length / 2;
    if (d->type == MCV_DEFECT_BUBBLE || d->type == MCV_DEFECT_INCLUSION)
        return hypot(hypot(p[0], p[1]), p[2]) <= r;
    return hypot(p[0], p[1]) <= r && fabs(p[2]) <= half + 4 * (double)FLT_EPSILON * largest;
}

bool mcv_defect_changed(const mcv_defect *d, uint32_t instance, const double world[3]) {
    const mcv_defect_kind kind = mcv_defect_kind_of(d->type);
    double p[3], slope[2], largest = 0;
    if (kind != MCV_KIND_INSIDE && (instance < d->instances[0] || instance >= d->instances[1]))
        return false; /* those of a defect inside of a body are not its node's */
    for (int k = 0; k < 3; ++k) {
        p[k] = 0;
        for (int i = 0; i < 3; ++i) p[k] += (world[i] - d->centre[i]) * d->axes[k][i];
        largest = fmax(largest, fabs(world[k]));
    }
    if (kind == MCV_KIND_INSIDE) return is_inside(d, p, largest);
    if (kind == MCV_KIND_CUT) return is_cut_face(d, p, largest);
    if (fabs(p[2]) > d->size + d->depth) return false; /* the back */
    if (kind != MCV_KIND_RELIEF) return mcv_defect_outline(d, p) > 0;
    return fabs(mcv_defect_height(d, p[0], p[1], slope)) > least_height * d->depth;
}
