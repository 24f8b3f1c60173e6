/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/merge.h"

#include "core/json.h"
#include "io/exr_json.h"
#include "scene/camera_model.h"
#include "verbs/checkpoint.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_FILMS = 40 }; /* sizes are powers of two below 2^31 */

/* --- writing a part --- */

/* The attributes without those that JSON cannot hold. */
static json_t *known_attributes(const mcv_exr *exr) {
    json_t *attributes = mcv_attributes_json(exr);
    for (uint32_t i = 0; attributes && i < exr->attribute_count; ++i)
        if (json_is_null(json_object_get(attributes, exr->attributes[i].name)))
            json_object_del(attributes, exr->attributes[i].name);
    return attributes;
}

mcv_result mcv_part_write(const char *path, json_t *identity, const mcv_rendered *rendered,
                          mcv_error *error) {
    const mcv_film *film = rendered->film;
    const mcv_round none = {.count = 0};
    const uint64_t first = rendered->options->first;
    mcv_exr exr;
    MCV_TRY(mcv_rendered_develop(rendered, &exr, error));
    json_t *facts = mcv_checkpoint_facts(identity, rendered->stats);
    json_object_del(json_object_get(facts, "identity"), "samples");
    mcv_json_put(
        &facts, "range",
        json_pack("[I, I]", (json_int_t)first, (json_int_t)first + (json_int_t)film->samples));
    mcv_json_put(&facts, "attributes", known_attributes(&exr));
    mcv_exr_free(&exr);
    if (!facts) return mcv_fail(error, MCV_FAILED, "%s: no memory for its text", path);
    const mcv_result result = mcv_film_file_write(path, film, &none, facts, error);
    json_decref(facts);
    return result;
}

/* --- what is known of parts before their sums are read --- */

typedef struct part {
    const char *path;
    uint64_t first, last;
    json_t *facts;
} part;

static mcv_result look(const char *path, part *p, mcv_error *error) {
    mcv_film_file file;
    MCV_TRY(mcv_film_file_look(path, &file, error));
    const json_t *range = json_object_get(file.facts, "range");
    p->path = path;
    p->facts = json_incref(file.facts);
    const json_int_t first = json_integer_value(json_array_get(range, 0)),
                     last = json_integer_value(json_array_get(range, 1));
    mcv_film_file_free(&file);
    if (json_array_size(range) != 2)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is a checkpoint: finish the render by --resume; parts to merge are "
                        "written by --samples A:B --film FILE",
                        path);
    if (first < 0 || last <= first || last > (json_int_t)1 << 31)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: its range of samples is damaged", path);
    p->first = (uint64_t)first;
    p->last = (uint64_t)last;
    return MCV_OK;
}

static int by_first(const void *a, const void *b) {
    const part *x = a, *y = b;
    return x->first != y->first ? (x->first < y->first ? -1 : 1)
                                : (x->last > y->last) - (x->last < y->last);
}

/* Of an aligned power of two of samples: the least one that holds [first, last). */
static uint64_t whole_length(uint64_t first, uint64_t last) {
    uint64_t length = 1;
    while (first / length != (last - 1) / length) length *= 2;
    return length;
}

static mcv_result missing(uint64_t first, uint64_t last, mcv_error *error) {
    return mcv_fail(error, MCV_BAD_INPUT,
                    "samples %llu:%llu are missing: render them by --samples, and merge all",
                    (unsigned long long)first, (unsigned long long)last);
}

/* The parts, sorted, hold each sample of an aligned power of two once. */
static mcv_result check_ranges(const part *parts, size_t count, mcv_error *error) {
    const uint64_t first = parts[0].first, last = parts[count - 1].last;
    for (size_t i = 0; i < count; ++i) {
        const uint64_t length = parts[i].last - parts[i].first;
        if ((length & (length - 1)) != 0 || parts[i].first % length != 0)
            return mcv_fail(error, MCV_BAD_INPUT, "%s: its range of samples is damaged",
                            parts[i].path);
        if (i == 0) continue;
        if (parts[i].first < parts[i - 1].last)
            return mcv_fail(error, MCV_BAD_INPUT, "%s and %s: both hold samples %llu:%llu",
                            parts[i - 1].path, parts[i].path, (unsigned long long)parts[i].first,
                            (unsigned long long)(parts[i].last < parts[i - 1].last
                                                     ? parts[i].last
                                                     : parts[i - 1].last));
        if (parts[i].first > parts[i - 1].last)
            return missing(parts[i - 1].last, parts[i].first, error);
    }
    const uint64_t length = whole_length(first, last), begin = first / length * length;
    if (begin < first) return missing(begin, first, error);
    return begin + length > last ? missing(last, begin + length, error) : MCV_OK;
}

static mcv_result check_same(const part *parts, size_t count, mcv_report *report,
                             mcv_error *error) {
    bool told = false;
    for (size_t i = 1; i < count; ++i) {
        MCV_TRY(mcv_checkpoint_same(parts[0].path, parts[0].facts, parts[i].path, parts[i].facts,
                                    error));
        if (told || json_equal(json_object_get(parts[0].facts, "device"),
                               json_object_get(parts[i].facts, "device")))
            continue;
        char sentence[1024];
        snprintf(sentence, sizeof sentence,
                 "%s and %s were rendered by different devices or drivers: the bits may differ "
                 "from those of one render, within the noise",
                 parts[0].path, parts[i].path);
        mcv_report_tell(report, "warning", sentence);
        told = true;
    }
    return MCV_OK;
}

/* --- joining --- */

typedef struct joined {
    mcv_film film;
    uint64_t first;
} joined;

/* Films of the fixed tree of sums: two halves of an aligned power of two become one. */
static mcv_result join_halves(joined *films, size_t *count, mcv_error *error) {
    while (*count > 1) {
        joined *a = films + *count - 2, *b = films + *count - 1;
        if (a->film.samples != b->film.samples || a->first % (2 * a->film.samples) != 0)
            return MCV_OK;
        MCV_TRY(mcv_film_merge(&a->film, &b->film, error));
        mcv_film_free(&b->film);
        --*count;
    }
    return MCV_OK;
}

static mcv_result join(const part *parts, size_t part_count, joined films[MOST_FILMS],
                       size_t *count, mcv_error *error) {
    for (size_t i = 0; i < part_count; ++i) {
        mcv_film_file file;
        if (*count == MOST_FILMS)
            return mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be joined", parts[i].path);
        MCV_TRY(mcv_film_file_read(parts[i].path, &file, error));
        films[*count] = (joined){file.film, parts[i].first};
        const bool right = file.film.samples == parts[i].last - parts[i].first && !file.film.levels;
        ++*count;
        file.film = (mcv_film){0}; /* it has changed owners */
        mcv_film_file_free(&file);
        if (!right)
            return mcv_fail(error, MCV_BAD_INPUT, "%s: its range of samples is damaged",
                            parts[i].path);
        MCV_TRY(join_halves(films, count, error));
    }
    return MCV_OK;
}

static double number_of(const json_t *facts, const char *object, const char *key) {
    return json_number_value(json_object_get(json_object_get(facts, object), key));
}

/* Of the render of all samples at once. */
static void hash_whole(const part *parts, const mcv_film *film, bool replicates,
                       char hash[MCV_RENDER_HASH]) {
    json_t *identity = json_copy(json_object_get(parts[0].facts, "identity"));
    json_object_set_new(
        identity, "samples",
        json_sprintf("%" PRIu64 ":%" PRIu64, parts[0].first, parts[0].first + film->samples));
    mcv_checkpoint_hash(identity, replicates, hash);
    json_decref(identity);
}

/* What the parts have counted together becomes part of the first one's attributes. */
static mcv_result set_attributes(const part *parts, size_t count, const mcv_film *film,
                                 bool replicates, mcv_exr *exr, mcv_error *error) {
    double paths = 0, lost = 0, nonfinite = 0, seconds = 0;
    char hash[MCV_RENDER_HASH];
    for (size_t i = 0; i < count; ++i) {
        const double own = number_of(parts[i].facts, "stats", "paths");
        paths += own;
        lost += own * number_of(parts[i].facts, "stats", "lost_energy");
        nonfinite += number_of(parts[i].facts, "stats", "nonfinite");
        seconds += number_of(parts[i].facts, "stats", "render");
    }
    const mcv_attribute own[] = {
        {.name = "mcvisi:firstSample", .numbers = {(double)parts[0].first}, .count = 1},
        {.name = "mcvisi:samplesPerReplicate", .numbers = {(double)film->samples}, .count = 1},
        {.name = MCV_EXR_CHANNELS, .numbers = {mcv_film_channel_correlation(film)}, .count = 1},
        {.name = "mcvisi:lostEnergy", .numbers = {paths > 0 ? lost / paths : 0}, .count = 1},
        {.name = "mcvisi:nonfinite", .numbers = {nonfinite}, .count = 1},
        {.name = "mcvisi:seconds", .numbers = {seconds}, .count = 1},
        {.name = MCV_PICTURE_RENDER, .text = hash},
    };
    hash_whole(parts, film, replicates, hash);
    MCV_TRY(mcv_attributes_set_json(exr, json_object_get(parts[0].facts, "attributes"), error));
    return mcv_exr_set_attributes(exr, own, sizeof own / sizeof own[0], error);
}

/* The image's text in files is its camera model. */
static mcv_result describe(mcv_exr *exr, mcv_error *error) {
    const mcv_attribute *model = mcv_exr_attribute(exr, MCV_CAMERA_MODEL_KEY);
    if (!model || !model->text) return MCV_OK;
    exr->parts[0].image.description = strdup(model->text);
    return exr->parts[0].image.description
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "no memory for the camera model");
}

static mcv_result tell(const part *parts, size_t count, const mcv_film *film, mcv_report *report) {
    mcv_report_value(report, "parts", json_integer((json_int_t)count));
    mcv_report_value(report, "width", json_integer(film->width));
    mcv_report_value(report, "height", json_integer(film->height));
    mcv_report_value(report, "first", json_integer((json_int_t)parts[0].first));
    mcv_report_value(report, "samples",
                     json_integer((json_int_t)film->samples * (json_int_t)film->replicates));
    mcv_report_number(report, "error", "", mcv_film_relative_error(film));
    mcv_report_number(report, "mean", "", mcv_film_mean(film));
    return MCV_OK;
}

static mcv_result merge(part *parts, size_t count, bool replicates, mcv_exr *exr,
                        mcv_report *report, mcv_error *error) {
    joined films[MOST_FILMS];
    size_t film_count = 0;
    qsort(parts, count, sizeof *parts, by_first);
    MCV_TRY(check_same(parts, count, report, error));
    MCV_TRY(check_ranges(parts, count, error));
    mcv_result result = join(parts, count, films, &film_count, error);
    if (result == MCV_OK) result = mcv_film_parts(&films[0].film, replicates, exr, error);
    if (result == MCV_OK)
        result = set_attributes(parts, count, &films[0].film, replicates, exr, error);
    if (result == MCV_OK) result = describe(exr, error);
    if (result == MCV_OK) result = tell(parts, count, &films[0].film, report);
    while (film_count > 0) mcv_film_free(&films[--film_count].film);
    return result;
}

mcv_result mcv_parts_merge(mcv_texts paths, bool replicates, mcv_exr *exr, mcv_report *report,
                           mcv_error *error) {
    part *parts = calloc(paths.count, sizeof *parts);
    mcv_result result = parts ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the parts");
    *exr = (mcv_exr){0};
    for (size_t i = 0; i < paths.count && result == MCV_OK; ++i)
        result = look(paths.items[i], parts + i, error);
    if (result == MCV_OK) result = merge(parts, paths.count, replicates, exr, report, error);
    for (size_t i = 0; parts && i < paths.count; ++i) json_decref(parts[i].facts);
    free(parts);
    if (result != MCV_OK) mcv_exr_free(exr);
    return result;
}
