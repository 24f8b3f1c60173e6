/* SPDX-License-Identifier: Apache-2.0 */
#include "report/summary.h"

#include "core/basics.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* JSON has neither NaN nor infinity, and only UTF-8. */
static json_t *number(double value) { return isfinite(value) ? json_real(value) : json_null(); }

static json_t *string(const char *value) {
    json_t *json = value ? json_string(value) : NULL;
    return json ? json : json_null();
}

static json_t *integer(uint64_t value) { return json_integer((json_int_t)value); }

static json_t *words(const char *text) {
    json_t *array = json_array();
    for (const char *word = text; *word;) {
        const size_t length = strcspn(word, " ");
        if (length > 0) json_array_append_new(array, json_stringn(word, length));
        word += length + (word[length] == ' ');
    }
    return array;
}

static json_t *rays(const mcv_render_stats *stats) {
    return json_pack("{s:o, s:o, s:o, s:o}", "paths", integer(stats->paths), "path",
                     integer(stats->rays), "shadow", integer(stats->shadow_rays), "depth_cut",
                     integer(stats->depth_cut));
}

static json_t *seconds(const mcv_summary *s) {
    return json_pack(
        "{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "load", number(s->seconds_load), "build",
        number(s->stats.seconds_build), "compile", number(s->stats.seconds_compile), "first_sample",
        number(s->stats.seconds_first_sample), "first_picture", number(s->seconds_first_picture),
        "render", number(s->stats.seconds_render), "write", number(s->seconds_write));
}

static json_t *stages(const mcv_summary *s) {
    json_t *object = json_object();
    for (uint32_t i = 0; i < s->stats.stage_count; ++i) {
        json_object_set_new(object, s->stats.stages[i].name, number(s->stats.stages[i].seconds));
    }
    return object;
}

static json_t *light_paths(const mcv_render_stats *stats) {
    return json_pack("{s:o, s:o}", "per_sample", number(stats->light_paths), "time_without",
                     number(stats->light_ratio > 0 ? stats->light_ratio : (double)NAN));
}

mcv_result mcv_summary_json(const mcv_summary *s, char **text, mcv_error *error) {
    json_t *object = json_pack(
        "{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, "
        "s:o, "
        "s:o, s:o, s:o, s:o, s:b, s:b, s:o, s:o}",
        "scene", string(s->scene), "sensor", string(s->sensor), "image", string(s->image_path),
        "preview", string(s->preview_path), "device", string(s->stats.device), "features",
        words(s->stats.features), "width", integer(s->width), "height", integer(s->height),
        "channels", integer(s->channels), "replicates", integer(s->replicates), "samples",
        integer(s->samples), "rays", rays(&s->stats), "seconds", seconds(s), "stages", stages(s),
        "error", number(s->error), "mean", number(s->mean), "white", number(s->preview.white),
        "saturated", number(s->preview.saturated), "lost_energy", number(s->stats.lost_energy),
        "nonfinite", integer(s->stats.nonfinite), "unmatched", integer(s->stats.unmatched),
        "interrupted", (int)s->stats.interrupted, "adaptive", (int)s->adaptive, "light_paths",
        light_paths(&s->stats), "error_of_rest", number(s->error_of_rest));
    *text = object ? json_dumps(object, JSON_REAL_PRECISION(12)) : NULL;
    json_decref(object);
    return *text ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the JSON summary");
}

/* Where a pilot has found that they do not pay. */
static void print_light_paths(FILE *out, const mcv_render_stats *stats) {
    if (stats->light_paths > 0 || !(stats->light_ratio > 0)) return;
    fprintf(out,
            "  without light paths, which a pilot has found to take %.2g times as long to an error "
            "(--light-paths)\n",
            1 / stats->light_ratio);
}

/* The sentences about light that is missing from the image. */
static void print_losses(FILE *out, const mcv_render_stats *stats) {
    if (stats->lost_energy > 0) {
        fprintf(out,
                "  up to %.2g %% of the light is missing: %" PRIu64
                " paths reached the depth limit (--depth)\n",
                100 * stats->lost_energy, stats->depth_cut);
    }
    if (stats->nonfinite > 0)
        fprintf(out, "  %" PRIu64 " samples were not finite and are ignored\n", stats->nonfinite);
    if (stats->saturated > 0) {
        fprintf(out,
                "  %" PRIu64
                " light paths exceeded the range of their pixels, which are wrong: render fewer "
                "samples\n",
                stats->saturated);
    }
    if (stats->unmatched > 0) {
        fprintf(out,
                "  %" PRIu64
                " paths left a medium that they had not entered: a mesh is open, its faces are "
                "reversed, or bodies touch without overlapping\n",
                stats->unmatched);
    }
}

static void print_name(FILE *out, const char *before, const char *name, const char *after) {
    if (!name) return;
    fputs(before, out);
    mcv_print_line(out, name);
    fputs(after, out);
}

mcv_result mcv_summary_text(const mcv_summary *s, char **text, mcv_error *error) {
    size_t size = 0;
    *text = NULL;
    FILE *out = open_memstream(text, &size);
    if (!out) return mcv_fail(error, MCV_FAILED, "no memory for the summary");
    print_name(out, "", s->sensor, ": ");
    fprintf(out, "%u x %u pixels, %" PRIu64 " samples %s, ", s->width, s->height, s->samples,
            s->adaptive ? "on the average" : "each");
    if (isfinite(s->error)) fprintf(out, "error %.2g %%, ", 100 * s->error);
    fprintf(out, "%.1f s%s\n", s->stats.seconds_render,
            s->stats.interrupted ? " (interrupted)" : "");
    fprintf(out, "  mean %.5g %s", s->mean, s->unit ? s->unit : "");
    if (s->preview_path)
        fprintf(out, "; %.2g %% of the pixels are above the preview's white of %.5g",
                100 * s->preview.saturated, s->preview.white);
    fprintf(out, "\n");
    if (isfinite(s->error) && s->error_of_rest < s->error / 2)
        fprintf(out, "  without the %d %s of the largest error it is %.2g %%\n", MCV_FILM_WORST,
                s->channels > 1 ? "values" : "pixels", 100 * s->error_of_rest);
    print_light_paths(out, &s->stats);
    print_losses(out, &s->stats);
    print_name(out, "  ", s->image_path, "\n");
    print_name(out, "  ", s->preview_path, "\n");
    if (mcv_text_close(out, text)) return MCV_OK;
    return mcv_fail(error, MCV_FAILED, "no memory for the summary");
}
