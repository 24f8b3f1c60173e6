/* SPDX-License-Identifier: Apache-2.0 */
/* Options of a command as JSON, and JSON as a command line: experiment files. */
#include "core/json.h"

#include "core/basics.h"
#include "options/option_table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Whether the value differs from the default. */
static bool is_given(const mcv_option *o, const mcv_command *command, const mcv_command *defaults) {
    const void *field = (const char *)command + o->offset,
               *usual = (const char *)defaults + o->offset;
    switch (o->kind) {
    case MCV_KIND_flag:
        return false;
    case MCV_KIND_text:
        return *(const char *const *)field &&
               *(const char *const *)field != *(const char *const *)usual;
    case MCV_KIND_list:
        return ((const mcv_list *)field)->count > 0;
    case MCV_KIND_number:
    case MCV_KIND_time:
    case MCV_KIND_bytes:
        return memcmp(field, usual, sizeof(double)) != 0;
    case MCV_KIND_channels:
    case MCV_KIND_lengths:
        return memcmp(field, usual, 3 * sizeof(double)) != 0;
    case MCV_KIND_count:
    case MCV_KIND_choice:
        return *(const uint64_t *)field != *(const uint64_t *)usual;
    case MCV_KIND_size:
    case MCV_KIND_range:
        return memcmp(field, usual, 2 * sizeof(uint64_t)) != 0;
    }
    return false;
}

static json_t *list_json(const mcv_list *texts) {
    json_t *list = json_array();
    for (size_t i = 0; i < texts->count; ++i)
        if (json_array_append_new(list, json_string(texts->items[i])) != 0) {
            json_decref(list);
            return NULL;
        }
    return list;
}

/* NULL without memory. */
static json_t *value_json(const mcv_option *o, const mcv_command *command) {
    const void *field = (const char *)command + o->offset;
    const double *numbers = field;
    const uint64_t *counts = field;
    switch (o->kind) {
    case MCV_KIND_flag:
        return json_boolean(*(const bool *)field);
    case MCV_KIND_text:
        return json_string(*(const char *const *)field);
    case MCV_KIND_list:
        return list_json(field);
    case MCV_KIND_number:
    case MCV_KIND_time:
    case MCV_KIND_bytes:
        return json_real(*numbers);
    case MCV_KIND_channels:
    case MCV_KIND_lengths:
        return json_sprintf("%.17g,%.17g,%.17g", numbers[0], numbers[1], numbers[2]);
    case MCV_KIND_count:
        return json_integer((json_int_t)*counts);
    case MCV_KIND_size:
    case MCV_KIND_range:
        return json_sprintf("%llu%c%llu", (unsigned long long)counts[0],
                            o->kind == MCV_KIND_size ? 'x' : ':', (unsigned long long)counts[1]);
    case MCV_KIND_choice: {
        const char *word = o->argument;
        for (uint64_t i = 0; i < *counts; ++i) word += strcspn(word, "|") + 1;
        return json_stringn(word, strcspn(word, "|"));
    }
    }
    return NULL;
}

/* Does the option stand on the command line? */
static bool stands_there(const mcv_option *o, const mcv_command *command) {
    const size_t length = strlen(o->name);
    for (int i = 1; i < command->argc; ++i) {
        const char *word = command->argv[i];
        if (strncmp(word, "--", 2) == 0 && strncmp(word + 2, o->name, length) == 0 &&
            (word[2 + length] == '\0' || word[2 + length] == '='))
            return true;
    }
    return false;
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
        if (is_given(o, command, &defaults)) mcv_json_put(&object, o->name, value_json(o, command));
    }
    return object;
}

void mcv_command_stated(const mcv_command *command, json_t **options) {
    for (size_t i = 0; *options && i < MCV_OPTION_COUNT; ++i) {
        const mcv_option *o = mcv_options + i;
        if (o->kind != MCV_KIND_flag && o->verbs >> command->verb & 1 &&
            !json_object_get(*options, o->name) && stands_there(o, command))
            mcv_json_put(options, o->name, value_json(o, command));
    }
}

void mcv_command_flags(const mcv_command *command, json_t **options) {
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        const mcv_option *o = mcv_options + i;
        if (o->kind != MCV_KIND_flag || !(o->verbs >> command->verb & 1)) continue;
        const bool set = *(const bool *)((const char *)command + o->offset);
        if (set || strcmp(o->name, "json") == 0)
            mcv_json_put(options, o->name, value_json(o, command));
    }
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

static mcv_result add_word(mcv_arguments *arguments, const char *key, const char *word,
                           mcv_error *error) {
    char *text = NULL;
    const int length = asprintf(&text, "--%s=%s", key, word);
    return add_argument(arguments, length < 0 ? NULL : text, error);
}

/* One value as "--KEY=VALUE"; what is false or null is left out. */
static mcv_result add_value(mcv_arguments *arguments, const char *path, const char *key,
                            const json_t *value, mcv_error *error) {
    char *text = NULL;
    int length = 0;
    if (json_is_false(value) || json_is_null(value)) return MCV_OK;
    if (json_is_string(value)) return add_word(arguments, key, json_string_value(value), error);
    if (json_is_integer(value))
        length = asprintf(&text, "--%s=%lld", key, (long long)json_integer_value(value));
    else if (json_is_real(value))
        length = asprintf(&text, "--%s=%.17g", key, json_real_value(value));
    else if (json_is_true(value))
        length = asprintf(&text, "--%s", key);
    else
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: %s: must be a string, a number, true, false or a list of them", path,
                        key);
    return add_argument(arguments, length < 0 ? NULL : text, error);
}

/* [640, 480] for what the command line writes as 640x480. */
static mcv_result add_numbers(mcv_arguments *arguments, const char *path, const char *key,
                              const char *between, const json_t *list, mcv_error *error) {
    char *text = NULL;
    size_t size = 0, i;
    const json_t *value;
    bool numbers = json_array_size(list) > 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return add_argument(arguments, NULL, error);
    fprintf(out, "--%s=", key);
    json_array_foreach((json_t *)list, i, value) {
        if (i) fputs(between, out);
        numbers = numbers && json_is_number(value);
        if (json_is_integer(value))
            fprintf(out, "%lld", (long long)json_integer_value(value));
        else
            fprintf(out, "%.17g", json_number_value(value));
    }
    const bool memory = mcv_text_close(out, &text);
    if (numbers || !memory) return add_argument(arguments, text, error);
    free(text);
    return mcv_fail(error, MCV_BAD_INPUT, "%s: %s: must be a list of numbers, or a text", path,
                    key);
}

static mcv_result add_member(mcv_arguments *arguments, unsigned verb, const char *path,
                             const char *key, const json_t *value, mcv_error *error) {
    char name[64];
    size_t i, length = 0;
    const json_t *item;
    for (; key[length] && length + 1 < sizeof name; ++length)
        name[length] = (char)(key[length] == '_' ? '-' : key[length]);
    name[length] = '\0';
    const mcv_option *o = mcv_option_find(verb, name, length);
    if (!o) {
        mcv_error detail = {""};
        (void)mcv_option_fail_unknown(verb, name, &detail);
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", path, detail.text);
    }
    if (json_is_false(value) && o->kind == MCV_KIND_choice && mcv_option_has_word(o, "off"))
        return add_word(arguments, name, "off", error);
    if (!json_is_array(value)) return add_value(arguments, path, name, value, error);
    if (o->kind == MCV_KIND_size) return add_numbers(arguments, path, name, "x", value, error);
    if (o->kind == MCV_KIND_range) return add_numbers(arguments, path, name, ":", value, error);
    if (o->kind == MCV_KIND_channels || o->kind == MCV_KIND_lengths)
        return add_numbers(arguments, path, name, ",", value, error);
    json_array_foreach((json_t *)value, i, item) {
        MCV_TRY(add_value(arguments, path, name, item, error));
    }
    return MCV_OK;
}

static mcv_result add_members(mcv_arguments *arguments, unsigned verb, const char *path,
                              const json_t *object, mcv_error *error) {
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)object, key, value) {
        MCV_TRY(add_member(arguments, verb, path, key, value, error));
    }
    return MCV_OK;
}

mcv_result mcv_arguments_read(const json_t *object, const char *argument, const mcv_command *given,
                              const char *path, mcv_arguments *arguments, mcv_error *error) {
    *arguments = (mcv_arguments){0};
    for (int i = 0; i < 2; ++i) MCV_TRY(add_argument(arguments, strdup(given->argv[i]), error));
    MCV_TRY(add_members(arguments, given->verb, path, object, error));
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

mcv_result mcv_options_object(const char *text, json_t **object, mcv_error *error) {
    json_error_t wrong;
    *object = json_loads(text && text[0] ? text : "{}", JSON_REJECT_DUPLICATES, &wrong);
    if (!*object)
        return mcv_fail(error, MCV_USAGE, "options: line %d column %d is not JSON: %s", wrong.line,
                        wrong.column, mcv_json_wrong(&wrong));
    if (json_is_object(*object)) return MCV_OK;
    json_decref(*object);
    *object = NULL;
    return mcv_fail(error, MCV_USAGE, "options: must be a JSON object, as in {\"spp\": 64}");
}

static mcv_result read_texts(const char *text, const json_t *defaults, unsigned verb,
                             const char *const arguments[2], mcv_arguments *line, bool *people,
                             mcv_error *error) {
    json_t *object;
    MCV_TRY(mcv_options_object(text, &object, error));
    mcv_result result = MCV_OK;
    const char *const words[] = {"mcvisi", mcv_verbs[verb].name};
    for (int i = 0; i < 2 && result == MCV_OK; ++i)
        result = add_argument(line, strdup(words[i]), error);
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)defaults, key, value) {
        if (result == MCV_OK && mcv_option_find(verb, key, strlen(key)))
            result = add_member(line, verb, "options", key, value, error);
    }
    if (result == MCV_OK) result = add_members(line, verb, "options", object, error);
    if (result == MCV_OK) result = add_argument(line, strdup("--"), error);
    for (int i = 0; i < 2 && arguments[i] && result == MCV_OK; ++i)
        result = add_argument(line, strdup(arguments[i]), error);
    *people = json_is_false(json_object_get(object, "json"));
    json_decref(object);
    return result == MCV_BAD_INPUT ? MCV_USAGE : result;
}

mcv_result mcv_options_read(const char *text, const json_t *defaults, unsigned verb,
                            const char *const arguments[2], const char *const *without,
                            mcv_options_given *given, mcv_error *error) {
    *given = (mcv_options_given){0};
    bool people = false;
    mcv_result result = read_texts(text, defaults, verb, arguments, &given->line, &people, error);
    for (int i = 2; without && i < given->line.count && result == MCV_OK; ++i)
        for (const char *const *name = without; *name; ++name) {
            const char *item = given->line.items[i];
            const size_t length = strlen(*name);
            if (strncmp(item, "--", 2) == 0 && strncmp(item + 2, *name, length) == 0 &&
                (item[2 + length] == '=' || item[2 + length] == '\0'))
                result = mcv_fail(error, MCV_USAGE,
                                  "options: --%s is no option of this call: leave it out", *name);
        }
    mcv_error detail = {""};
    if (result == MCV_OK) {
        result = mcv_command_parse(given->line.count, given->line.items, &given->command, &detail);
        if (result != MCV_OK) mcv_fail(error, result, "options: %s", detail.text);
    }
    given->command.json = !people;
    if (result != MCV_OK) mcv_options_free(given);
    return result;
}

void mcv_options_free(mcv_options_given *given) {
    mcv_command_free(&given->command);
    mcv_arguments_free(&given->line);
}
