/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of light transport matrices share. */
#ifndef MCVISI_TESTS_TRANSPORT_H
#define MCVISI_TESTS_TRANSPORT_H

#include "../api/api.h"

static inline mcv_transport *transport_of(mcv_session *session, const mcv_rig *rig,
                                          const char *options) {
    mcv_transport *transport = NULL;
    WELL(mcv_session_transport(session, rig, options, NULL, NULL, &transport, NULL, &error));
    return transport;
}

static inline mcv_matrix_entries entries_of(const mcv_transport *transport) {
    mcv_matrix_entries e = {.size = sizeof e};
    WELL(mcv_transport_entries(transport, &e, &error));
    return e;
}

/* The planes of a picture's part. */
static inline const float *planes_of(const mcv_picture *picture, uint32_t part) {
    mcv_part p = {.size = sizeof p};
    WELL(mcv_picture_part(picture, part, &p, &error));
    return p.planes;
}

/* The picture of a projector. */
static inline void write_grey(uint32_t width, uint32_t height) {
    float grey[64];
    mcv_picture *picture = NULL;
    assert_true(width * height <= 64);
    for (uint32_t i = 0; i < width * height; ++i) grey[i] = 100;
    WELL(mcv_picture_make(width, height, 1, grey, NULL, "{\"mcvisi:bits\": 8}", &picture, &error));
    WELL(mcv_picture_write(picture, "transport-grey.png", "{\"preview\": true}", &error));
    mcv_picture_free(picture);
}

/* A rig with a path, so that it finds its picture. */
static inline mcv_rig *open_text(const char *path, const char *text) {
    mcv_rig *rig = NULL;
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    WELL(mcv_rig_open(path, &rig, &error));
    return rig;
}

#endif
