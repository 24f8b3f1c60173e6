/* SPDX-License-Identifier: Apache-2.0 */
/* Renders of shipped scenes whose light is recorded by element of an emitter, and its sums. */
#ifndef MCVISI_TESTS_RECORDS_H
#define MCVISI_TESTS_RECORDS_H

#include "estimates.h"

#include "device/pack.h"
#include "loader/load.h"
#include "mcvisi/tables.h"
#include "scene/sensors.h"
#include "scene/spectra.h"

enum { SAMPLES = 4, DEPTH = 8 };

/* What the records of a render add up to. */
typedef struct sums {
    double *cells;   /* [pixel][replicate][channel] */
    uint64_t digest; /* of all records, in any order */
    size_t count;
    uint32_t channels, cell_count, element_count;
} sums;

static inline uint64_t mix(uint64_t word) {
    word = (word ^ word >> 31) * 0x9e3779b97f4a7c15u;
    return word ^ word >> 29;
}

static inline mcv_result add_records(void *user, const uint32_t *records, size_t count,
                                     mcv_error *error) {
    sums *s = user;
    const size_t words = MCV_RECORD_WORDS(s->channels);
    (void)error;
    for (size_t i = 0; i < count; ++i, records += words) {
        uint64_t digest = 0;
        if (records[0] >= s->cell_count || records[1] >= s->element_count)
            fail_msg("a record of cell %u, element %u: there are %u and %u", records[0], records[1],
                     s->cell_count, s->element_count);
        for (size_t k = 0; k < words; ++k) digest = mix(digest + records[k]);
        s->digest += digest;
        for (uint32_t c = 0; c < s->channels; ++c) {
            float value;
            memcpy(&value, records + 2 + c, sizeof value);
            s->cells[(size_t)records[0] * s->channels + c] += value;
        }
    }
    s->count += count;
    return MCV_OK;
}

static inline mcv_scene *load(const char *name) {
    char path[512];
    mcv_scene *scene;
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, name);
    BUILD(mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &builder_error));
    return scene;
}

/* Renders with records; bytes: room for those of a launch. */
static inline mcv_film record(const mcv_scene *scene, uint32_t schedule, size_t bytes, sums *s) {
    mcv_record_sink sink = {add_records, s, bytes};
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    uint32_t width, height;
    mcv_sensor_film_size(&scene->sensors[0], &width, &height);
    options.last = SAMPLES;
    options.depth = DEPTH;
    options.schedule = schedule;
    options.records = &sink;
    *s = (sums){.channels = mcv_scene_channels(scene),
                .cell_count = width * height * options.replicates};
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        s->element_count += mcv_emitter_elements(scene, scene->emitters + i);
    s->cells = calloc((size_t)s->cell_count * s->channels, sizeof *s->cells);
    assert_non_null(s->cells);
    BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    assert_non_null(strstr(stats.features, "records"));
    return film;
}

#endif
