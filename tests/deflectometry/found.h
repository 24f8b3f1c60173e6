/* SPDX-License-Identifier: Apache-2.0 */
/* What deflectometry finds of a scene, for tests. */
#ifndef MCVISI_TESTS_DEFLECTOMETRY_FOUND_H
#define MCVISI_TESTS_DEFLECTOMETRY_FOUND_H

#include "../api/api.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What one call finds. */
typedef struct found {
    mcv_picture *picture;
    char *report;
} found;

static inline found find(mcv_session *session, const mcv_rig *rig, const char *options) {
    found f = {NULL, NULL};
    WELL(mcv_session_deflectometry(session, rig, options, NULL, NULL, &f.picture, &f.report,
                                   &error));
    return f;
}

static inline void drop(found *f) {
    mcv_picture_free(f->picture);
    mcv_text_free(f->report);
}

/* The planes of the part of this name, of `channels` channels. */
static inline const float *map_of(const found *f, const char *name, uint32_t channels) {
    for (uint32_t i = 0; i < mcv_picture_part_count(f->picture); ++i) {
        mcv_part part = {.size = sizeof part};
        WELL(mcv_picture_part(f->picture, i, &part, &error));
        if (strcmp(part.name, name) != 0) continue;
        assert_int_equal(part.channels, channels);
        return part.planes;
    }
    fail_msg("there is no part %s", name);
    return NULL;
}

/* A number of the report: the one behind the given member of a group, or of the report itself. */
static inline double told(const found *f, const char *group, const char *key) {
    const char *at = f->report;
    char name[64];
    assert_non_null(at);
    if (group) at = strstr(at, group);
    snprintf(name, sizeof name, "\"%s\":", key);
    at = at ? strstr(at, name) : NULL;
    if (!at) {
        fail_msg("the report has no %s", key);
        return 0;
    }
    return strtod(at + strlen(name), NULL);
}

/* K1 by its integral. */
static inline double bessel_k1(double x) {
    const double step = 1e-3;
    double sum = 0;
    for (int i = 0; i < 12000; ++i) {
        const double t = (i + 0.5) * step;
        sum += exp(-x * cosh(t)) * cosh(t) * step;
    }
    return sum;
}

#endif
