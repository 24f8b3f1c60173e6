/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/options.h"

#include "render/render.h"
#include "core/json.h"
#include "scene/params.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum option_kind {
    KIND_flag,
    KIND_text,
    KIND_list,
    KIND_number,
    KIND_time,
    KIND_channels,
    KIND_lengths,
    KIND_count,
    KIND_size,
    KIND_range,
    KIND_choice,
} option_kind;

typedef struct option {
    const char *name, *argument, *preset, *doc;
    double min, max;
    size_t offset; /* in mcv_command */
    option_kind kind;
    unsigned verbs;
    char letter; /* or 0 */
} option;

static const option options[] = {
#define MCV_X(kind, field, name, letter, argument, verbs, preset, min, max, doc) \
    { \
        name, \
        argument, \
        preset, \
        doc, \
        (double)(min), \
        (double)(max), \
        offsetof(mcv_command, field), \
        KIND_##kind, \
        verbs, \
        letter},
    MCV_OPTIONS(MCV_X)
#undef MCV_X
};
enum { OPTION_COUNT = sizeof options / sizeof options[0] };

typedef struct verb {
    const char *name, *argument, *doc;
} verb;

static const verb verbs[] = {
#define MCV_X(name, NAME, argument, doc) {#name, argument, doc},
    MCV_VERBS(MCV_X)
#undef MCV_X
};

/* --- values
 * -----------------------------------------------------------------------------------------------------
 */

/* A decimal integer that ends where `end` (a set of letters, or "" for the end of the text) begins.
 */
static bool parse_count(const char **text, char end, double min, double max, uint64_t *value) {
    const size_t digits = strspn(*text, "0123456789");
    if (digits == 0 || digits > 18 || (*text)[digits] != end) return false;
    *value = strtoull(*text, NULL, 10);
    *text += digits + (end != '\0');
    return (double)*value >= min && (double)*value <= max;
}

static bool parse_pair(const char *text, char between, double min, double max, uint64_t pair[2]) {
    return parse_count(&text, between, min, max, pair) &&
           parse_count(&text, '\0', min, max, pair + 1);
}

static bool parse_number(const char *text, double *value) {
    char *end;
    if (text[strspn(text, "0123456789.eE+-")])
        return false; /* strtod would take "inf", "nan" and hexadecimal too */
    *value = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*value);
}

/* A number with a unit of time, in seconds. */
static bool parse_time(const char *text, double *value) {
    static const struct {
        const char *name;
        double factor, divisor; /* divided, because 1e3 is exact in binary and 1e-3 is not */
    } units[] = {{"us", 1, 1e6}, {"µs", 1, 1e6}, {"ms", 1, 1e3},
                 {"s", 1, 1},    {"min", 60, 1}, {"h", 3600, 1}};
    char digits[64];
    const size_t length = strspn(text, "0123456789.eE+-"),
                 unit = length + strspn(text + length, " ");
    if (length >= sizeof digits) return false;
    snprintf(digits, sizeof digits, "%.*s", (int)length, text);
    if (!parse_number(digits, value)) return false;
    for (size_t i = 0; i < sizeof units / sizeof units[0]; ++i) {
        if (strcmp(text + unit, units[i].name) != 0) continue;
        *value = *value * units[i].factor / units[i].divisor;
        return true;
    }
    return false;
}

/* With a unit where the kind of option has one. */
static bool parse_number_in(option_kind kind, const char *text, double min, double max,
                            double *value) {
    const bool parsed = parse_number(text, value) ||
                        (kind == KIND_time && parse_time(text, value)) ||
                        (kind == KIND_lengths && mcv_parse_quantity(text, MCV_PARAM_length, value));
    return parsed && *value > min && *value <= max;
}

/* One number for all channels, or three with commas between them. */
static bool parse_channels(option_kind kind, const char *text, double min, double max,
                           double values[3]) {
    char part[64];
    size_t count = 0;
    for (;; ++count, ++text) {
        const size_t length = strcspn(text, ",");
        if (count == 3 || length >= sizeof part) return false;
        memcpy(part, text, length);
        part[length] = '\0';
        if (!parse_number_in(kind, part, min, max, values + count)) return false;
        text += length;
        if (*text == '\0') break;
    }
    if (count == 0) values[1] = values[2] = values[0];
    return count != 1;
}

/* The index of text in "first|second|…". */
static bool parse_choice(const char *text, const char *words, uint64_t *index) {
    const size_t length = strlen(text);
    for (*index = 0;; ++*index) {
        const size_t word = strcspn(words, "|");
        if (word == length && strncmp(words, text, word) == 0) return true;
        if (words[word] == '\0') return false;
        words += word + 1;
    }
}

static mcv_result set_value(const option *o, const char *text, mcv_command *command,
                            mcv_error *error) {
    void *field = (char *)command + o->offset;
    switch (o->kind) {
    case KIND_flag:
        *(bool *)field = true;
        return MCV_OK;
    case KIND_text:
        if (text[0] == '\0')
            return mcv_fail(error, MCV_USAGE, "--%s: is empty: must be %s", o->name, o->argument);
        *(const char **)field = text;
        return MCV_OK;
    case KIND_list:
        ((mcv_compact_indices *)field)->items[((mcv_compact_indices *)field)->count++] = text;
        return MCV_OK;
    case KIND_number:
    case KIND_time:
        if (parse_number_in(o->kind, text, o->min, o->max, field)) return MCV_OK;
        return mcv_fail(
            error, MCV_USAGE, "--%s %s: must be a number above %g and at most %g%s", o->name, text,
            o->min, o->max,
            o->kind == KIND_time ? " [s], or with a unit (us, ms, s, min, h), as in 10ms" : "");
    case KIND_channels:
    case KIND_lengths:
        if (parse_channels(o->kind, text, o->min, o->max, field)) return MCV_OK;
        return mcv_fail(
            error, MCV_USAGE,
            "--%s %s: must be one number or three with commas, each above %g and at most %g%s",
            o->name, text, o->min, o->max,
            o->kind == KIND_lengths ? " [m], or with a unit (nm, um, mm, cm, m), as in 550nm" : "");
    case KIND_count: {
        const char *rest = text;
        if (parse_count(&rest, '\0', o->min, o->max, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be an integer from %.0f to %.0f", o->name,
                        text, o->min, o->max);
    }
    case KIND_size:
        if (parse_pair(text, 'x', o->min, o->max, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE,
                        "--%s %s: must be %s, as in 640x480, each from %.0f to %.0f", o->name, text,
                        o->argument, o->min, o->max);
    case KIND_range:
        if (parse_pair(text, ':', o->min, o->max, field) &&
            ((uint64_t *)field)[0] < ((uint64_t *)field)[1])
            return MCV_OK;
        return mcv_fail(error, MCV_USAGE,
                        "--%s %s: must be %s with A < B, as in 0:64, each from %.0f to %.0f",
                        o->name, text, o->argument, o->min, o->max);
    case KIND_choice:
        if (parse_choice(text, o->argument, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be one of %s", o->name, text, o->argument);
    }
    return MCV_OK;
}

/* --- command line
 * -----------------------------------------------------------------------------------------------
 */

mcv_result mcv_verb_find(const char *name, unsigned *verb_index, mcv_error *error) {
    const char *words[MCV_VERB_COUNT];
    for (unsigned i = 0; i < MCV_VERB_COUNT; ++i) {
        words[i] = verbs[i].name;
        if (strcmp(name, words[i]) != 0) continue;
        *verb_index = i;
        return MCV_OK;
    }
    const char *nearest = mcv_nearest_word(name, words, MCV_VERB_COUNT);
    if (nearest)
        return mcv_fail(error, MCV_USAGE, "unknown verb %s: did you mean %s?", name, nearest);
    return mcv_fail(error, MCV_USAGE, "unknown verb %s: `mcvisi help` lists the verbs", name);
}

static mcv_result fail_unknown(unsigned verb_index, const char *name, mcv_error *error) {
    const char *words[OPTION_COUNT];
    size_t count = 0;
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        if (options[i].verbs >> verb_index & 1) words[count++] = options[i].name;
        for (unsigned v = 0; v < MCV_VERB_COUNT; ++v)
            if (options[i].verbs >> v & 1 && strcmp(options[i].name, name) == 0)
                return mcv_fail(error, MCV_USAGE,
                                "--%s is an option of %s, not of %s: leave it out", name,
                                verbs[v].name, verbs[verb_index].name);
    }
    const char *nearest = mcv_nearest_word(name, words, count);
    if (nearest)
        return mcv_fail(error, MCV_USAGE, "unknown option --%s: did you mean --%s?", name, nearest);
    return mcv_fail(error, MCV_USAGE, "unknown option --%s: `mcvisi help %s` lists the options",
                    name, verbs[verb_index].name);
}

static const option *find_option(unsigned verb_index, const char *name, size_t length) {
    for (size_t i = 0; i < OPTION_COUNT; ++i)
        if (options[i].verbs >> verb_index & 1 && strlen(options[i].name) == length &&
            strncmp(options[i].name, name, length) == 0)
            return options + i;
    return NULL;
}

static const option *find_letter(unsigned verb_index, char letter) {
    for (size_t i = 0; i < OPTION_COUNT; ++i)
        if (options[i].verbs >> verb_index & 1 && options[i].letter == letter) return options + i;
    return NULL;
}

static bool is_option(const char *text) { return text[0] == '-' && text[1] != '\0'; }

/*
 * The option at argv[*i], its value included: --name=value, --name value, -o value, -ovalue. Not by
 * getopt_long, which takes any beginning of a name: what --s means would then change with each new
 * option.
 */
static mcv_result parse_option(char **argv, int argc, int *i, mcv_command *command,
                               mcv_error *error) {
    const char *text = argv[*i];
    const option *o;
    const char *value = NULL;
    if (text[1] == '-') {
        const char *name = text + 2;
        const size_t length = strcspn(name, "=");
        if (!(o = find_option(command->verb, name, length))) {
            char known[64];
            snprintf(known, sizeof known, "%.*s",
                     (int)(length < sizeof known ? length : sizeof known), name);
            return fail_unknown(command->verb, known, error);
        }
        if (name[length] == '=') value = name + length + 1;
    } else {
        if (!(o = find_letter(command->verb, text[1])))
            return mcv_fail(error, MCV_USAGE,
                            "unknown option %s: `mcvisi help %s` lists the options", text,
                            verbs[command->verb].name);
        if (text[2]) value = text + 2;
    }
    if (o->kind == KIND_flag) {
        if (value) return mcv_fail(error, MCV_USAGE, "--%s takes no value", o->name);
    } else if (!value) {
        if (*i + 1 >= argc || strncmp(argv[*i + 1], "--", 2) == 0)
            return mcv_fail(error, MCV_USAGE, "--%s needs a value: %s", o->name, o->argument);
        value = argv[++*i];
    }
    return set_value(o, value, command, error);
}

mcv_result mcv_command_parse(int argc, char **argv, mcv_command *command, mcv_error *error) {
    *command = (mcv_command){.argc = argc, .argv = argv};
    if (argc < 2)
        return mcv_fail(
            error, MCV_USAGE,
            "a verb is missing, as in `mcvisi render SCENE`: `mcvisi help` lists the verbs");
    MCV_TRY(mcv_verb_find(argv[1], &command->verb, error));
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        mcv_compact_indices *list = (mcv_compact_indices *)((char *)command + options[i].offset);
        if (options[i].kind != KIND_list) continue;
        list->items = malloc((size_t)argc * sizeof *list->items);
        if (!list->items) return mcv_fail(error, MCV_FAILED, "no memory for the command line");
    }
    for (size_t i = 0; i < OPTION_COUNT; ++i)
        if (options[i].preset) MCV_TRY(set_value(options + i, options[i].preset, command, error));

    const verb *v = verbs + command->verb;
    const bool takes_two = strchr(v->argument, ' ');
    bool only_arguments = false;
    for (int i = 2; i < argc; ++i) {
        if (!only_arguments && strcmp(argv[i], "--") == 0) {
            only_arguments = true;
        } else if (!only_arguments &&
                   (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)) {
            command->help = true;
        } else if (!only_arguments && is_option(argv[i])) {
            MCV_TRY(parse_option(argv, argc, &i, command, error));
        } else if (v->argument[0] == '\0') {
            return mcv_fail(error, MCV_USAGE, "%s takes no argument: leave out %s", v->name,
                            argv[i]);
        } else if (!command->argument) {
            command->argument = argv[i];
        } else if (takes_two && !command->second) {
            command->second = argv[i];
        } else {
            return mcv_fail(error, MCV_USAGE, "%s takes %s%s: leave out %s", v->name,
                            takes_two ? "" : "one ", v->argument, argv[i]);
        }
    }
    const bool whole = takes_two ? command->second : command->argument;
    if (!whole && !command->help && v->argument[0] != '\0' && v->argument[0] != '[')
        return mcv_fail(error, MCV_USAGE, "%s is missing: `mcvisi %s %s`", v->argument, v->name,
                        v->argument);
    return MCV_OK;
}

void mcv_command_free(mcv_command *command) {
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        mcv_compact_indices *list = (mcv_compact_indices *)((char *)command + options[i].offset);
        if (options[i].kind != KIND_list) continue;
        free(list->items);
        *list = (mcv_compact_indices){NULL, 0};
    }
}

/* --- precision
 * --------------------------------------------------------------------------------------------------
 */

static bool is_reference(const char *device) { return device && strcmp(device, "reference") == 0; }

bool mcv_wants_reference(const mcv_command *command) {
    return is_reference(command->device) || command->precision == MCV_PRECISION_DOUBLE;
}

mcv_result mcv_precision_read(const mcv_command *command, uint32_t *precision, mcv_error *error) {
    *precision = mcv_wants_reference(command) ? MCV_PRECISION_DOUBLE : (uint32_t)command->precision;
    if (command->precision == MCV_PRECISION_MIXED && is_reference(command->device))
        return mcv_fail(
            error, MCV_USAGE,
            "--precision mixed is for OpenCL devices: the reference renderer knows double only");
    if (command->precision == MCV_PRECISION_DOUBLE && command->device &&
        !is_reference(command->device))
        return mcv_fail(
            error, MCV_USAGE,
            "--precision double is the reference renderer's, on the host: leave out --device %s",
            command->device);
    if (command->precision == MCV_PRECISION_DOUBLE && command->schedule)
        return mcv_fail(error, MCV_USAGE,
                        "--precision double is the reference renderer's, which has no --schedule: "
                        "leave it out");
    return MCV_OK;
}

/* --- as JSON
 * ----------------------------------------------------------------------------------------------------
 */

/* NULL: as by default. */
static json_t *value_json(const option *o, const mcv_command *command,
                          const mcv_command *defaults) {
    const void *field = (const char *)command + o->offset,
               *usual = (const char *)defaults + o->offset;
    const double *numbers = field;
    const uint64_t *counts = field;
    json_t *list;
    switch (o->kind) {
    case KIND_flag:
        return NULL;
    case KIND_text:
        return *(const char *const *)field &&
                       *(const char *const *)field != *(const char *const *)usual
                   ? json_string(*(const char *const *)field)
                   : NULL;
    case KIND_list:
        if (((const mcv_compact_indices *)field)->count == 0) return NULL;
        list = json_array();
        for (size_t i = 0; i < ((const mcv_compact_indices *)field)->count; ++i)
            json_array_append_new(list,
                                  json_string(((const mcv_compact_indices *)field)->items[i]));
        return list;
    case KIND_number:
    case KIND_time:
        return memcmp(field, usual, sizeof(double)) ? json_real(*numbers) : NULL;
    case KIND_channels:
    case KIND_lengths:
        return memcmp(field, usual, 3 * sizeof(double))
                   ? json_sprintf("%.17g,%.17g,%.17g", numbers[0], numbers[1], numbers[2])
                   : NULL;
    case KIND_count:
        return *counts != *(const uint64_t *)usual ? json_integer((json_int_t)*counts) : NULL;
    case KIND_size:
    case KIND_range:
        return memcmp(field, usual, 2 * sizeof *counts)
                   ? json_sprintf("%llu%c%llu", (unsigned long long)counts[0],
                                  o->kind == KIND_size ? 'x' : ':', (unsigned long long)counts[1])
                   : NULL;
    case KIND_choice: {
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
    for (size_t i = 0; object && i < OPTION_COUNT; ++i) {
        const option *o = options + i;
        bool left_out = !(o->verbs >> command->verb & 1);
        for (const char *const *name = without; *name; ++name)
            left_out = left_out || strcmp(*name, o->name) == 0;
        if (left_out) continue;
        if (o->preset) (void)set_value(o, o->preset, &defaults, &ignored);
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
                        "%s: %s: must be a text, a number, true or a list of them", path, key);
    return add_argument(arguments, length < 0 ? NULL : text, error);
}

mcv_result mcv_arguments_read(const json_t *object, const char *argument, const mcv_command *given,
                              const char *path, mcv_arguments *arguments, mcv_error *error) {
    const char *key;
    json_t *value;
    *arguments = (mcv_arguments){0};
    for (int i = 0; i < 2; ++i) MCV_TRY(add_argument(arguments, strdup(given->argv[i]), error));
    json_object_foreach((json_t *)object, key, value) {
        if (find_option(given->verb, key, strlen(key)) == NULL) {
            mcv_error detail = {""};
            (void)fail_unknown(given->verb, key, &detail);
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

/* --- help
 * -------------------------------------------------------------------------------------------------------
 */

enum { HELP_INDENT = 28, HELP_WIDTH = 100 };

/* Prints words from column `at` on, broken at HELP_WIDTH. */
static void print_wrapped(const char *text, int at) {
    if (at >= HELP_INDENT) {
        putchar('\n');
        at = 0;
    }
    printf("%*s", HELP_INDENT - at, "");
    at = HELP_INDENT;
    while (*text) {
        const int word = (int)strcspn(text, " ");
        if (at > HELP_INDENT && at + 1 + word > HELP_WIDTH) {
            printf("\n%*s", HELP_INDENT, "");
            at = HELP_INDENT;
        }
        at += printf("%s%.*s", at > HELP_INDENT ? " " : "", word, text);
        text += word;
        text += strspn(text, " ");
    }
    putchar('\n');
}

void mcv_help_print(void) {
    puts("mcvisi renders machine-vision scenes (glTF with MCVISI_ extensions) by OpenCL.\n");
    for (unsigned i = 0; i < MCV_VERB_COUNT; ++i)
        print_wrapped(verbs[i].doc, printf("  mcvisi %s %s", verbs[i].name, verbs[i].argument));
    print_wrapped("the version", printf("  mcvisi --version"));
    puts("\nExit codes:");
#define MCV_X(name, code, meaning) printf("  %3d  %s\n", code, meaning);
    MCV_RESULTS(MCV_X)
#undef MCV_X
}

void mcv_help_print_verb(unsigned verb_index) {
    const verb *v = verbs + verb_index;
    printf("mcvisi %s%s%s [OPTIONS]: %s\n\n", v->name, v->argument[0] ? " " : "", v->argument,
           v->doc);
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        const option *o = options + i;
        if (!(o->verbs >> verb_index & 1)) continue;
        int at =
            o->letter ? printf("  -%c, --%s", o->letter, o->name) : printf("      --%s", o->name);
        if (o->argument) at += printf(" %s", o->argument);
        char doc[1024];
        snprintf(doc, sizeof doc, "%s%s%s%s", o->doc, o->preset ? " (" : "",
                 o->preset ? o->preset : "", o->preset ? ")" : "");
        print_wrapped(doc, at);
    }
}

/* Of one value; flags are true or left out. */
static json_t *option_schema(const option *o) {
    switch (o->kind) {
    case KIND_flag:
        return json_pack("{s:s}", "type", "boolean");
    case KIND_number:
        return json_pack("{s:s, s:f, s:b, s:f}", "type", "number", "minimum", o->min,
                         "exclusiveMinimum", 1, "maximum", o->max);
    case KIND_count:
        return json_pack("{s:s, s:f, s:f}", "type", "integer", "minimum", o->min, "maximum",
                         o->max);
    case KIND_size:
        return json_pack("{s:s, s:s}", "type", "string", "pattern", "^[0-9]+x[0-9]+$");
    case KIND_range:
        return json_pack("{s:s, s:s}", "type", "string", "pattern", "^[0-9]+:[0-9]+$");
    case KIND_time:
    case KIND_channels:
    case KIND_lengths:
        return json_pack("{s:[s,s]}", "type", "number", "string");
    case KIND_list:
        return json_pack("{s:[{s:s}, {s:s, s:{s:s}}]}", "anyOf", "type", "string", "type", "array",
                         "items", "type", "string");
    case KIND_choice: {
        json_t *words = json_array();
        for (const char *word = o->argument; *word;
             word += word[strcspn(word, "|")] ? strcspn(word, "|") + 1 : strcspn(word, "|"))
            json_array_append_new(words, json_stringn(word, strcspn(word, "|")));
        return json_pack("{s:o}", "enum", words);
    }
    case KIND_text:
        break;
    }
    return json_pack("{s:s}", "type", "string");
}

mcv_result mcv_help_print_schema(unsigned verb_index, mcv_error *error) {
    const bool experiment = verb_index == MCV_VERB_SWEEP;
    json_t *properties = json_object();
    if (experiment) {
        json_object_set_new(properties, "rig",
                            json_pack("{s:s, s:s}", "type", "string", "description",
                                      "the scene, from this file's folder"));
        json_object_set_new(properties, "note",
                            json_pack("{s:s, s:s}", "type", "string", "description", "a comment"));
        json_object_set_new(
            properties, "fingerprint",
            json_pack("{s:s, s:s}", "type", "string", "description",
                      "of the scene's files, as a sweep writes it beside its table"));
    }
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        if (!(options[i].verbs >> verb_index & 1)) continue;
        json_t *schema = option_schema(options + i);
        json_object_set_new(schema, "description", json_string(options[i].doc));
        json_object_set_new(properties, options[i].name, schema);
    }
    json_t *document =
        json_pack("{s:s, s:s, s:s, s:o, s:b}", "$schema", "http://json-schema.org/draft-04/schema",
                  "title", experiment ? "experiment of mcvisi sweep" : verbs[verb_index].name,
                  "type", "object", "properties", properties, "additionalProperties", 0);
    if (experiment) json_object_set_new(document, "required", json_pack("[s]", "rig"));
    char *text = document ? json_dumps(document, JSON_INDENT(2)) : NULL;
    json_decref(document);
    if (!text) return mcv_fail(error, MCV_FAILED, "no memory for the schema");
    puts(text);
    free(text);
    return MCV_OK;
}
