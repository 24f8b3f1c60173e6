/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of the public interface share. They see mcvisi/mcvisi.h alone. */
#ifndef MCVISI_TESTS_API_H
#define MCVISI_TESTS_API_H

#include "test.h"

#include "mcvisi/mcvisi.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A camera in a world that is equally bright everywhere: whoever renders it gets 2.5 in each pixel,
 * without noise. */
static const char sky_rig[] =
    "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 1]}],"
    " \"extensionsUsed\": [\"MCVISI_sensors\", \"MCVISI_emitters\"],"
    " \"extensions\": {\"MCVISI_sensors\": {\"sensors\": [{\"name\": \"camera\","
    " \"type\": \"pinhole\", \"imageDistance\": \"12.5mm\", \"resolution\": [16, 12],"
    " \"pixelSize\": \"10um\"}]}, \"MCVISI_emitters\": {\"emitters\": [{\"name\": \"sky\","
    " \"type\": \"environment\", \"radiance\": 2.5}]}},"
    " \"nodes\": [{\"name\": \"camera\", \"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}}},"
    " {\"name\": \"sky\", \"extensions\": {\"MCVISI_emitters\": {\"emitter\": 0}}}]}";

static inline void well(mcv_result result, const mcv_error *error, const char *call) {
    if (result != MCV_OK) fail_msg("%s: %d: %s", call, result, error->text);
}

/* The call succeeds. */
#define WELL(call) \
    do { \
        mcv_error error = {""}; \
        well((call), &error, #call); \
    } while (0)

static inline void fails(mcv_result got, const mcv_error *error, mcv_result code, const char *says,
                         const char *call) {
    if (got != code || !strstr(error->text, says) || strchr(error->text, '\n'))
        fail_msg("%s: %d, \"%s\"\n  must be %d and say in one line \"%s\"", call, got, error->text,
                 code, says);
}

/* The call fails with this code, and with a sentence that says this. */
#define FAILS(code, says, call) \
    do { \
        mcv_error error = {""}; \
        fails((call), &error, code, says, #call); \
    } while (0)

static inline mcv_rig *parse_rig(const char *text) {
    mcv_rig *rig = NULL;
    WELL(mcv_rig_parse(text, strlen(text), NULL, &rig, &error));
    return rig;
}

static inline mcv_session *open_session(const char *options) {
    mcv_session *session = NULL;
    WELL(mcv_session_open(options, &session, &error));
    return session;
}

static inline mcv_picture *render(mcv_session *session, const mcv_rig *rig, const char *options) {
    mcv_picture *picture = NULL;
    WELL(mcv_session_render(session, rig, options, NULL, NULL, &picture, NULL, &error));
    assert_non_null(picture);
    return picture;
}

static inline mcv_part part_of(const mcv_picture *picture, uint32_t index) {
    mcv_part part = {.size = sizeof part};
    WELL(mcv_picture_part(picture, index, &part, &error));
    return part;
}

#endif
