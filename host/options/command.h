/* SPDX-License-Identifier: Apache-2.0 */
/* A parsed command line: its verb, its arguments and the value of each option. */
#ifndef MCVISI_HOST_OPTIONS_COMMAND_H
#define MCVISI_HOST_OPTIONS_COMMAND_H

#include "options/options.h"
#include "core/error.h"

#include <jansson.h>
#include <stdbool.h>

typedef struct mcv_list {
    const char **items;
    size_t count;
} mcv_list;

#define MCV_OPTION_FIELD_flag(field) bool field;
#define MCV_OPTION_FIELD_text(field) const char *field;
#define MCV_OPTION_FIELD_list(field) mcv_list field;
#define MCV_OPTION_FIELD_number(field) double field;
#define MCV_OPTION_FIELD_time(field) double field;
#define MCV_OPTION_FIELD_bytes(field) double field;
#define MCV_OPTION_FIELD_channels(field) double field[3];
#define MCV_OPTION_FIELD_lengths(field) double field[3];
#define MCV_OPTION_FIELD_count(field) uint64_t field;
#define MCV_OPTION_FIELD_size(field) uint64_t field[2];
#define MCV_OPTION_FIELD_range(field) uint64_t field[2];
#define MCV_OPTION_FIELD_choice(field) uint64_t field;

typedef struct mcv_command {
    unsigned verb;
    int argc; /* as given */
    char **argv;
    const char *argument; /* the scene, the image, or help's verb; NULL if not given */
    mcv_list arguments;   /* all of them, of verbs that take any number */
    const char *second;   /* the second argument of verbs that have one */
    bool help;            /* --help after the verb */
#define MCV_X(kind, field, ...) MCV_OPTION_FIELD_##kind(field)
    MCV_OPTIONS(MCV_X)
#undef MCV_X
} mcv_command;

/* Reads argv[1] …; texts point into argv. MCV_USAGE with a sentence that says what would be right.
 */
mcv_result mcv_command_parse(int argc, char **argv, mcv_command *command, mcv_error *error);
void mcv_command_free(mcv_command *command);

/*
 * The options of the command's verb that can be told from the default, by their names, as texts,
 * numbers and lists of texts such as stand on the command line; without those of `without` (names,
 * NULL at the end) and flags, which mcv_command_flags adds. NULL without memory.
 */
json_t *mcv_command_json(const mcv_command *command, const char *const *without);

/* Adds those that stand on the command line with the value of their default: they go before the
 * defaults of a session or of a sensor (mcv_json_put). */
void mcv_command_stated(const mcv_command *command, json_t **options);

/* Adds the flags that are set, as true; "json" also where it is not (mcv_json_put). */
void mcv_command_flags(const mcv_command *command, json_t **options);

/*
 * The command line with its argument replaced and the members of such an object inserted before it
 * as options; the command line has precedence. Values may be strings, numbers, true, or lists of
 * them; they are checked when the line is parsed. Freed by mcv_arguments_free.
 */
typedef struct mcv_arguments {
    char **items;
    int count;
} mcv_arguments;
mcv_result mcv_arguments_read(const json_t *object, const char *argument, const mcv_command *given,
                              const char *path, mcv_arguments *arguments, mcv_error *error);
void mcv_arguments_free(mcv_arguments *arguments);

/* Options of a verb as the library takes them: a JSON object as text, NULL or "" for none. */
typedef struct mcv_options_given {
    mcv_command command; /* its texts are those of the line; json is true unless the text says
                            "json": false */
    mcv_arguments line;
} mcv_options_given;

/* The text of options as an object, {} for NULL and ""; to be freed. MCV_USAGE for other JSON, with
 * a sentence that begins with "options: ". */
mcv_result mcv_options_object(const char *text, json_t **object, mcv_error *error);

/*
 * Reads them; those of `defaults`, an object or NULL, that the verb has count where the text says
 * nothing. `arguments` are the verb's, NULL for what it has not; `without`: names that are refused,
 * NULL at the end. MCV_USAGE with a sentence that begins with "options: ". After success they are
 * freed by mcv_options_free.
 */
mcv_result mcv_options_read(const char *text, const json_t *defaults, unsigned verb,
                            const char *const arguments[2], const char *const *without,
                            mcv_options_given *given, mcv_error *error);
void mcv_options_free(mcv_options_given *given);

/* Whether --device or --precision requests the reference renderer; MCV_USAGE for contradictory
 * options. */
bool mcv_wants_reference(const mcv_command *command);
mcv_result mcv_precision_read(const mcv_command *command, uint32_t *precision, mcv_error *error);

/* The verb's number, or an error that suggests the nearest one. */
mcv_result mcv_verb_find(const char *name, unsigned *verb, mcv_error *error);

/* The JSON schema (draft 4) of a verb's options; of verbs with experiments, that of their
 * experiment files. NULL without memory. */
json_t *mcv_verb_schema(unsigned verb);

#endif
