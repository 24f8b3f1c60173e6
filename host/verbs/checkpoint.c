/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/checkpoint.h"

#include "core/basics.h"
#include "core/json.h"
#include "device/light.h"
#include "options/option_table.h"
#include "scene/sensor_find.h"
#include "scene/sensors.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- to which render a file belongs --- */

/* Options that change no sample: files, the camera that reads the image out, how it is computed. */
static void list_others(const char *names[MCV_OPTION_COUNT + 1]) {
    static const char *const others[] = {
        "output", "png", "parts",  "camera",    "sensor",     "device",     "threads", "schedule",
        "json",   "set", "resume", "precision", "checkpoint", "resolution", "film"};
    size_t count = 0;
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        const mcv_option *o = mcv_options + i;
        bool other = (o->verbs & MCV_IN_CAMERA) && strcmp(o->name, "seed") != 0;
        for (size_t k = 0; k < sizeof others / sizeof others[0]; ++k)
            other = other || strcmp(o->name, others[k]) == 0;
        if (other) names[count++] = o->name;
    }
    names[count] = NULL;
}

json_t *mcv_checkpoint_identity(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                                mcv_overrides set) {
    static const char *const precisions[] = {"single", "mixed", "double"};
    const char *without[MCV_OPTION_COUNT + 1];
    char hash[32], label[128];
    uint32_t width, height, precision = 0;
    mcv_error ignored;
    list_others(without);
    json_t *identity = mcv_command_json(command, without), *items = json_array();
    (void)mcv_precision_read(command, &precision, &ignored);
    mcv_sensor_film_size(scene->sensors + sensor, &width, &height);
    mcv_sensor_label(scene, sensor, label, sizeof label);
    snprintf(hash, sizeof hash, "%016" PRIx64, scene->fingerprint);
    bool whole = items != NULL;
    for (size_t i = 0; i < set.count; ++i)
        whole = json_array_append_new(items, mcv_json_text(set.items[i])) == 0 && whole;
    mcv_json_put(&identity, "scene", json_string(hash));
    mcv_json_put(&identity, "set", whole ? json_incref(items) : NULL);
    mcv_json_put(&identity, "sensor", mcv_json_text(label));
    mcv_json_put(&identity, "resolution", json_sprintf("%ux%u", width, height));
    mcv_json_put(&identity, "precision", json_string(precisions[precision]));
    json_decref(items);
    return identity;
}

/* A value as on the command line; the caller frees it. */
static char *plain(const json_t *value) {
    return json_is_string(value) ? strdup(json_string_value(value))
                                 : json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(6));
}

void mcv_checkpoint_hash(const json_t *identity, bool replicates, char hash[MCV_RENDER_HASH]) {
    char *text = json_dumps(identity, JSON_COMPACT | JSON_SORT_KEYS);
    hash[0] = '\0';
    if (!text) return;
    uint64_t value = mcv_hash_bytes(MCV_HASH_BEGIN, text, strlen(text));
    value = mcv_hash_bytes(value, mcv_version(), strlen(mcv_version()));
    value = mcv_hash_bytes(value, &(unsigned char){replicates}, 1);
    snprintf(hash, MCV_RENDER_HASH, "%016" PRIx64, value);
    free(text);
}

static mcv_result differs(const char *path, const char *key, const json_t *before,
                          const json_t *now, mcv_error *error) {
    char *a = before ? plain(before) : NULL, *b = now ? plain(now) : NULL;
    mcv_result result;
    if (strcmp(key, "scene") == 0)
        result =
            mcv_fail(error, MCV_BAD_INPUT,
                     "%s: is of another scene, or the scene or a file that it names has changed "
                     "since: leave out --resume, or name another file",
                     path);
    else
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s: was rendered with --%s %s, not %s: give the same options, or leave "
                          "out --resume",
                          path, key, a ? a : "as it is by default", b ? b : "as it is by default");
    free(a);
    free(b);
    return result;
}

static mcv_result compare(const char *path, const json_t *facts, const json_t *identity,
                          mcv_error *error) {
    const char *key, *version = json_string_value(json_object_get(facts, "version"));
    json_t *before = json_object_get(facts, "identity"), *value;
    if (!version || strcmp(version, mcv_version()) != 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: is of version %s, not %s: leave out --resume",
                        path, version ? version : "unknown", mcv_version());
    json_object_foreach((json_t *)identity, key, value) {
        if (!json_equal(value, json_object_get(before, key)))
            return differs(path, key, json_object_get(before, key), value, error);
    }
    json_object_foreach(before, key, value) {
        if (!json_object_get(identity, key)) return differs(path, key, value, NULL, error);
    }
    return MCV_OK;
}

mcv_result mcv_checkpoint_same(const char *path, const json_t *facts, const char *other_path,
                               const json_t *other_facts, mcv_error *error) {
    const json_t *other = json_object_get(other_facts, "identity"),
                 *identity = json_object_get(facts, "identity");
    const char *key;
    json_t *value;
    if (!json_equal(json_object_get(facts, "version"), json_object_get(other_facts, "version")))
        return mcv_fail(error, MCV_BAD_INPUT, "%s and %s: are of different versions", path,
                        other_path);
    for (int turn = 0; turn < 2; ++turn) {
        const json_t *from = turn ? other : identity, *to = turn ? identity : other;
        json_object_foreach((json_t *)from, key, value) {
            if (!json_equal(value, json_object_get(to, key)))
                return mcv_fail(error, MCV_BAD_INPUT,
                                "%s and %s: are of different renders: %s%s differs", path,
                                other_path, strcmp(key, "scene") == 0 ? "the " : "--", key);
        }
    }
    return MCV_OK;
}

/* --- what a render has counted --- */

/* X(key, member): whole numbers, and others. */
#define COUNTS(X) \
    X("paths", paths) \
    X("rays", rays) \
    X("shadow_rays", shadow_rays) \
    X("depth_cut", depth_cut) \
    X("nonfinite", nonfinite) X("unmatched", unmatched) X("saturated", saturated)
#define NUMBERS(X) \
    X("lost_energy", lost_energy) \
    X("throughput", throughput) X("first_sample", seconds_first_sample) X("render", seconds_render)

static json_t *stats_json(const mcv_render_stats *stats) {
    json_t *object = json_object();
#define MCV_X(key, member) mcv_json_put(&object, key, json_integer((json_int_t)stats->member));
    COUNTS(MCV_X)
#undef MCV_X
#define MCV_X(key, member) mcv_json_put(&object, key, json_real(stats->member));
    NUMBERS(MCV_X)
#undef MCV_X
    return object;
}

static mcv_result read_stats(const json_t *object, const mcv_json_path *place,
                             mcv_render_stats *stats, mcv_error *error) {
    const uint64_t most = (uint64_t)1 << 62;
#define MCV_X(key, member) \
    MCV_TRY(mcv_json_uint(object, key, 0, most, &stats->member, place, error));
    COUNTS(MCV_X)
#undef MCV_X
#define MCV_X(key, member) \
    MCV_TRY(mcv_json_number(object, key, 0, 1e300, &stats->member, place, error));
    NUMBERS(MCV_X)
#undef MCV_X
    return MCV_OK;
}

/* --- files --- */

json_t *mcv_checkpoint_facts(const json_t *identity, const mcv_render_stats *stats) {
    return json_pack("{s:s, s:o, s:{s:s, s:s}, s:o}", "version", mcv_version(), "identity",
                     json_deep_copy(identity), "device", "name", stats->device, "driver",
                     stats->driver, "stats", stats_json(stats));
}

mcv_result mcv_checkpoint_write(const char *path, const json_t *identity, const mcv_unfinished *u,
                                mcv_error *error) {
    json_t *facts = mcv_checkpoint_facts(identity, u->stats),
           *state = json_pack("{s:i, s:b, s:f}", "thinning", (int)u->thinning, "decided",
                              (int)u->decided, "seconds", u->seconds);
    mcv_json_put(&facts, "state", state);
    if (!facts) return mcv_fail(error, MCV_FAILED, "%s: no memory for its text", path);
    const mcv_result result = mcv_film_file_write(path, u->film, u->round, facts, error);
    json_decref(facts);
    return result;
}

static mcv_result read_state(const char *path, mcv_checkpoint *c, mcv_error *error) {
    const mcv_json_path root = mcv_place_file(path), state = mcv_json_path_key(&root, "state"),
                        stats = mcv_json_path_key(&root, "stats");
    json_t *facts = c->file.facts, *object = json_object_get(facts, "state");
    uint64_t thinning = 0;
    mcv_unfinished *u = &c->unfinished;
    if (!json_is_object(object) || !json_is_object(json_object_get(facts, "stats")) ||
        c->file.round.count == 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is the film of a finished render, which cannot be continued", path);
    MCV_TRY(mcv_json_uint(object, "thinning", 0, MCV_NO_LIGHT_PATHS, &thinning, &state, error));
    MCV_TRY(mcv_json_bool(object, "decided", &u->decided, &state, error));
    MCV_TRY(mcv_json_number(object, "seconds", 0, 1e12, &u->seconds, &state, error));
    MCV_TRY(read_stats(json_object_get(facts, "stats"), &stats, &c->stats, error));
    u->thinning = (uint32_t)thinning;
    u->film = &c->file.film;
    u->round = &c->file.round;
    u->stats = &c->stats;
    return MCV_OK;
}

mcv_result mcv_checkpoint_read(const char *path, const json_t *identity, mcv_checkpoint *c,
                               mcv_error *error) {
    *c = (mcv_checkpoint){.file.facts = NULL};
    MCV_TRY(mcv_film_file_read(path, &c->file, error));
    mcv_result result = compare(path, c->file.facts, identity, error);
    if (result == MCV_OK) result = read_state(path, c, error);
    if (result != MCV_OK) mcv_checkpoint_free(c);
    return result;
}

void mcv_checkpoint_free(mcv_checkpoint *c) {
    mcv_film_file_free(&c->file);
    *c = (mcv_checkpoint){.file.facts = NULL};
}
