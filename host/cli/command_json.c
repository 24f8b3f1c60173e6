/* SPDX-License-Identifier: Apache-2.0 */
/* Options of a command as JSON, and JSON as a command line: experiment files. */
#include "cli/option_table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* NULL: the value is the default. */
static json_t *value_json(const mcv_option *o, const mcv_command *command,
                          const mcv_command *defaults) {
    const void *field = (const char *)command + o->offset,
               *usual = (const char *)defaults + o->offset;
    const double *numbers = field;
    const uint64_t *counts = field;
    json_t *list;
    switch (o->kind) {
    case MCV_KIND_flag:
        return NULL;
    case MCV_KIND_text:
        return *(const char *const *)field &&
                       *(const char *const *)field != *(const char *const *)usual
                   ? json_string(*(const char *const *)field)
                   : NULL;
    case MCV_KIND_list:
        if (((const mcv_list *)field)->count == 0) return NULL;
        list = json_array();
        for (size_t i = 0; i < ((const mcv_list *)field)->count; ++i)
            json_array_append_new(list, json_string(((const mcv_list *)field)->items[i]));
        return list;
    case MCV_KIND_number:
    case MCV_KIND_time:
        return memcmp(field, usual, sizeof(double)) ? json_real(*numbers) : NULL;
    case MCV_KIND_channels:
    case MCV_KIND_lengths:
        return memcmp(field, usual, 3 * sizeof(double))
                   ? json_sprintf("%.17g,%.17g,%.17g", numbers[0], numbers[1], numbers[2])
                   : NULL;
    case MCV_KIND_count:
        return *counts != *(const uint64_t *)usual ? json_integer((json_int_t)*counts) : NULL;
    case MCV_KIND_size:
    case MCV_KIND_range:
        return memcmp(field, usual, 2 * sizeof *counts)
                   ? json_sprintf("%llu%c%llu", (unsigned long long)counts[0],
                                  o->kind == MCV_KIND_size ? 'x' : ':',
                                  (unsigned long long)counts[1])
                   : NULL;
    case MCV_KIND_choice: {
        const char *word = o->argument;
        if (*counts == *(const uint64_t *)usual) return NULL;
        for (uint64_t i = 0; i < *counts; ++i) word += strcspn(word, "|") + 1;
        return json_stringn(word, strcspn(word, "|"));
    }
    }
    return NULL;
}

json_t *mcv_command_json(const mcv_command *command, const char *const *without) {
    mcv_command defaults = {0};
    mcv_error ignored;
    json_t *object = json_object();
    for (size_t i = 0; object && i < MCV_OPTION_COUNT; ++i) {
        const mcv_option *o = mcv_options + i;
        bool left_out = !(o->verbs >> command->verb & 1);
        for (const char *const *name = without; *name; ++name)
            left_out = left_out || strcmp(*name, o->name) == 0;
        if (left_out) continue;
        if (o->preset) (void)mcv_option_set(o, o->preset, &defaults, &ignored);
        json_t *value = value_json(o, command, &defaults);
        if (value) json_object_set_new(object, o->name, value);
    }
    return object;
}

static mcv_result add_argument(mcv_arguments *arguments, char *text, mcv_error *error) {
    char **items =
        text ? realloc(arguments->items, ((size_t)arguments->count + 2) * sizeof *items) : NULL;
    if (!items) {
        free(text);
        return mcv_fail(error, MCV_FAILED, "no memory for the experiment");
    }
    arguments->items = items;
    items[arguments->count++] = text;
    items[arguments->count] = NULL;
    return MCV_OK;
}

static mcv_result add_member(mcv_arguments *arguments, const char *path, const char *key,
                             const json_t *value, mcv_error *error) {
    char *text = NULL;
    int length = 0;
    if (json_is_string(value))
        length = asprintf(&text, "--%s=%s", key, json_string_value(value));
    else if (json_is_integer(value))
        length = asprintf(&text, "--%s=%lld", key, (long long)json_integer_value(value));
    else if (json_is_real(value))
        length = asprintf(&text, "--%s=%.17g", key, json_real_value(value));
    else if (json_is_true(value))
        length = asprintf(&text, "--%s", key);
    else
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: %s: must be a string, a number, true or a list of them", path, key);
    return add_argument(arguments, length < 0 ? NULL : text, error);
}

mcv_result mcv_arguments_read(const json_t *object, const char *argument, const mcv_command *given,
                              const char *path, mcv_arguments *arguments, mcv_error *error) {
    const char *key;
    json_t *value;
    *arguments = (mcv_arguments){0};
    for (int i = 0; i < 2; ++i) MCV_TRY(add_argument(arguments, strdup(given->argv[i]), error));
    json_object_foreach((json_t *)object, key, value) {
        if (mcv_option_find(given->verb, key, strlen(key)) == NULL) {
            mcv_error detail = {""};
            (void)mcv_option_fail_unknown(given->verb, key, &detail);
            return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", path, detail.text);
        }
        if (!json_is_array(value)) MCV_TRY(add_member(arguments, path, key, value, error));
        for (size_t i = 0; i < json_array_size(value); ++i)
            MCV_TRY(add_member(arguments, path, key, json_array_get(value, i), error));
    }
    for (int i = 2; i < given->argc; ++i) {
        const char *text = given->argv[i] == given->argument ? argument : given->argv[i];
        MCV_TRY(add_argument(arguments, strdup(text), error));
    }
    return MCV_OK;
}

void mcv_arguments_free(mcv_arguments *arguments) {
    for (int i = 0; i < arguments->count; ++i) free(arguments->items[i]);
    free(arguments->items);
    *arguments = (mcv_arguments){0};
}
