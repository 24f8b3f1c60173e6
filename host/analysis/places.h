/* SPDX-License-Identifier: Apache-2.0 */
/* Where to measure in an image, as texts; those in a part's coordinates become pixels. */
#ifndef MCVISI_HOST_ANALYSIS_PLACES_H
#define MCVISI_HOST_ANALYSIS_PLACES_H

#include "core/basics.h"
#include "scene/camera_model.h"

/* What is found in boxes: X(form, FORM, kind of figures, what to give); the form is the option's
 * name, and form + "s" the list in JSON. */
#define MCV_FORMS(X) \
    X(edge, EDGE, edge, "a rectangle with one straight edge in it") \
    X(line, LINE, line, "rectangles that one straight edge passes") \
    X(caliper, CALIPER, caliper, "a rectangle across two opposite edges") \
    X(circle, CIRCLE, circle, "a rectangle around a circle") \
    X(arc, ARC, circle, "a rectangle with a part of a circle in it")
enum {
#define MCV_X(form, FORM, figures, what) MCV_FORM_##FORM,
    MCV_FORMS(MCV_X)
#undef MCV_X
        MCV_FORM_COUNT
};

/* Regions as mcv_roi_parse reads them, and the boxes of each form. */
typedef struct mcv_places {
    mcv_texts regions;
    const char *background; /* the region that the others stand out of, or NULL */
    mcv_texts boxes[MCV_FORM_COUNT];
    bool bound; /* the figure `bound` is known */
} mcv_places;

/* How many boxes there are, of all forms. */
size_t mcv_places_boxes(const mcv_places *places);

/*
 * The same places as pixels (analysis/part_place.h). model: of the image, or NULL. *resolved is
 * freed by mcv_places_free, after failure as well.
 */
mcv_result mcv_places_resolve(const mcv_places *given, const mcv_camera_model *model,
                              mcv_places *resolved, mcv_error *error);
void mcv_places_free(mcv_places *resolved);

#endif
