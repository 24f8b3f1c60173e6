/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/options.h"

#include "scene/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum option_kind {
    KIND_flag,
    KIND_text,
    KIND_list,
    KIND_number,
    KIND_channels,
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
    {name, argument, preset, doc, (double)(min), (double)(max), offsetof(mcv_command, field), KIND_##kind, verbs, letter},
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

/* --- values ----------------------------------------------------------------------------------------------------- */

/* A decimal integer that ends where `end` (a set of letters, or "" for the end of the text) begins. */
static bool parse_count(const char **text, char end, double min, double max, uint64_t *value) {
    const size_t digits = strspn(*text, "0123456789");
    if (digits == 0 || digits > 18 || (*text)[digits] != end) return false;
    *value = strtoull(*text, NULL, 10);
    *text += digits + (end != '\0');
    return (double)*value >= min && (double)*value <= max;
}

static bool parse_pair(const char *text, char between, double min, double max, uint64_t pair[2]) {
    return parse_count(&text, between, min, max, pair) && parse_count(&text, '\0', min, max, pair + 1);
}

static bool parse_number(const char *text, double *value) {
    char *end;
    if (text[strspn(text, "0123456789.eE+-")]) return false; /* strtod would take "inf", "nan" and hexadecimal too */
    *value = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*value);
}

static bool parse_number_in(const char *text, double min, double max, double *value) {
    return parse_number(text, value) && *value > min && *value <= max;
}

/* One number for all channels, or three with commas between them. */
static bool parse_channels(const char *text, double min, double max, double values[3]) {
    char part[64];
    size_t count = 0;
    for (;; ++count, ++text) {
        const size_t length = strcspn(text, ",");
        if (count == 3 || length >= sizeof part) return false;
        memcpy(part, text, length);
        part[length] = '\0';
        if (!parse_number_in(part, min, max, values + count)) return false;
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

static mcv_result set_value(const option *o, const char *text, mcv_command *command, mcv_error *error) {
    void *field = (char *)command + o->offset;
    switch (o->kind) {
    case KIND_flag:
        *(bool *)field = true;
        return MCV_OK;
    case KIND_text:
        if (text[0] == '\0') return mcv_fail(error, MCV_USAGE, "--%s: is empty: must be %s", o->name, o->argument);
        *(const char **)field = text;
        return MCV_OK;
    case KIND_list:
        ((mcv_list *)field)->items[((mcv_list *)field)->count++] = text;
        return MCV_OK;
    case KIND_number:
        if (parse_number_in(text, o->min, o->max, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be a number above %g and at most %g", o->name, text, o->min, o->max);
    case KIND_channels:
        if (parse_channels(text, o->min, o->max, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be one number or three with commas, each above %g and at most %g", o->name, text,
                        o->min, o->max);
    case KIND_count: {
        const char *rest = text;
        if (parse_count(&rest, '\0', o->min, o->max, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be an integer from %.0f to %.0f", o->name, text, o->min, o->max);
    }
    case KIND_size:
        if (parse_pair(text, 'x', o->min, o->max, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be %s, as in 640x480, each from %.0f to %.0f", o->name, text, o->argument, o->min,
                        o->max);
    case KIND_range:
        if (parse_pair(text, ':', o->min, o->max, field) && ((uint64_t *)field)[0] < ((uint64_t *)field)[1]) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be %s with A < B, as in 0:64, each from %.0f to %.0f", o->name, text, o->argument,
                        o->min, o->max);
    case KIND_choice:
        if (parse_choice(text, o->argument, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be one of %s", o->name, text, o->argument);
    }
    return MCV_OK;
}

/* --- command line ----------------------------------------------------------------------------------------------- */

mcv_result mcv_verb_find(const char *name, unsigned *verb_index, mcv_error *error) {
    const char *words[MCV_VERB_COUNT];
    for (unsigned i = 0; i < MCV_VERB_COUNT; ++i) {
        words[i] = verbs[i].name;
        if (strcmp(name, words[i]) != 0) continue;
        *verb_index = i;
        return MCV_OK;
    }
    const char *nearest = mcv_nearest_word(name, words, MCV_VERB_COUNT);
    if (nearest) return mcv_fail(error, MCV_USAGE, "unknown verb %s: did you mean %s?", name, nearest);
    return mcv_fail(error, MCV_USAGE, "unknown verb %s: `mcvisi help` lists the verbs", name);
}

static mcv_result fail_unknown(unsigned verb_index, const char *name, mcv_error *error) {
    const char *words[OPTION_COUNT];
    size_t count = 0;
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        if (options[i].verbs >> verb_index & 1) words[count++] = options[i].name;
        for (unsigned v = 0; v < MCV_VERB_COUNT; ++v)
            if (options[i].verbs >> v & 1 && strcmp(options[i].name, name) == 0)
                return mcv_fail(error, MCV_USAGE, "--%s is an option of %s, not of %s: leave it out", name, verbs[v].name,
                                verbs[verb_index].name);
    }
    const char *nearest = mcv_nearest_word(name, words, count);
    if (nearest) return mcv_fail(error, MCV_USAGE, "unknown option --%s: did you mean --%s?", name, nearest);
    return mcv_fail(error, MCV_USAGE, "unknown option --%s: `mcvisi help %s` lists the options", name, verbs[verb_index].name);
}

static const option *find_option(unsigned verb_index, const char *name, size_t length) {
    for (size_t i = 0; i < OPTION_COUNT; ++i)
        if (options[i].verbs >> verb_index & 1 && strlen(options[i].name) == length && strncmp(options[i].name, name, length) == 0)
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
 * The option at argv[*i], its value included: --name=value, --name value, -o value, -ovalue. Not by getopt_long, which takes
 * any beginning of a name: what --s means would then change with each new option.
 */
static mcv_result parse_option(char **argv, int argc, int *i, mcv_command *command, mcv_error *error) {
    const char *text = argv[*i];
    const option *o;
    const char *value = NULL;
    if (text[1] == '-') {
        const char *name = text + 2;
        const size_t length = strcspn(name, "=");
        if (!(o = find_option(command->verb, name, length))) {
            char known[64];
            snprintf(known, sizeof known, "%.*s", (int)(length < sizeof known ? length : sizeof known), name);
            return fail_unknown(command->verb, known, error);
        }
        if (name[length] == '=') value = name + length + 1;
    } else {
        if (!(o = find_letter(command->verb, text[1])))
            return mcv_fail(error, MCV_USAGE, "unknown option %s: `mcvisi help %s` lists the options", text, verbs[command->verb].name);
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
    memset(command, 0, sizeof *command);
    if (argc < 2) return mcv_fail(error, MCV_USAGE, "a verb is missing, as in `mcvisi render SCENE`: `mcvisi help` lists the verbs");
    MCV_TRY(mcv_verb_find(argv[1], &command->verb, error));
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        mcv_list *list = (mcv_list *)((char *)command + options[i].offset);
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
        } else if (!only_arguments && (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)) {
            command->help = true;
        } else if (!only_arguments && is_option(argv[i])) {
            MCV_TRY(parse_option(argv, argc, &i, command, error));
        } else if (v->argument[0] == '\0') {
            return mcv_fail(error, MCV_USAGE, "%s takes no argument: leave out %s", v->name, argv[i]);
        } else if (!command->argument) {
            command->argument = argv[i];
        } else if (takes_two && !command->second) {
            command->second = argv[i];
        } else {
            return mcv_fail(error, MCV_USAGE, "%s takes %s%s: leave out %s", v->name, takes_two ? "" : "one ", v->argument, argv[i]);
        }
    }
    const bool whole = takes_two ? command->second : command->argument;
    if (!whole && !command->help && v->argument[0] != '\0' && v->argument[0] != '[')
        return mcv_fail(error, MCV_USAGE, "%s is missing: `mcvisi %s %s`", v->argument, v->name, v->argument);
    return MCV_OK;
}

void mcv_command_free(mcv_command *command) {
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        mcv_list *list = (mcv_list *)((char *)command + options[i].offset);
        if (options[i].kind != KIND_list) continue;
        free(list->items);
        *list = (mcv_list){NULL, 0};
    }
}

/* --- help ------------------------------------------------------------------------------------------------------- */

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
    for (unsigned i = 0; i < MCV_VERB_COUNT; ++i) print_wrapped(verbs[i].doc, printf("  mcvisi %s %s", verbs[i].name, verbs[i].argument));
    print_wrapped("the version", printf("  mcvisi --version"));
    puts("\nExit codes:");
#define MCV_X(name, code, meaning) printf("  %3d  %s\n", code, meaning);
    MCV_RESULTS(MCV_X)
#undef MCV_X
}

void mcv_help_print_verb(unsigned verb_index) {
    const verb *v = verbs + verb_index;
    printf("mcvisi %s%s%s [OPTIONS]: %s\n\n", v->name, v->argument[0] ? " " : "", v->argument, v->doc);
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        const option *o = options + i;
        if (!(o->verbs >> verb_index & 1)) continue;
        int at = o->letter ? printf("  -%c, --%s", o->letter, o->name) : printf("      --%s", o->name);
        if (o->argument) at += printf(" %s", o->argument);
        char doc[1024];
        snprintf(doc, sizeof doc, "%s%s%s%s", o->doc, o->preset ? " (" : "", o->preset ? o->preset : "", o->preset ? ")" : "");
        print_wrapped(doc, at);
    }
}
