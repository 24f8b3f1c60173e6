/* SPDX-License-Identifier: Apache-2.0 */
/* The lists of options/options.h as tables, for those who parse and explain them; nothing else
 * needs this. */
#ifndef MCVISI_HOST_OPTIONS_OPTION_TABLE_H
#define MCVISI_HOST_OPTIONS_OPTION_TABLE_H

#include "options/command.h"

typedef enum mcv_option_kind {
    MCV_KIND_flag,
    MCV_KIND_text,
    MCV_KIND_list,
    MCV_KIND_number,
    MCV_KIND_time,
    MCV_KIND_bytes,
    MCV_KIND_channels,
    MCV_KIND_lengths,
    MCV_KIND_count,
    MCV_KIND_size,
    MCV_KIND_range,
    MCV_KIND_choice,
} mcv_option_kind;

typedef struct mcv_option {
    const char *name, *argument, *preset, *doc;
    double min, max;
    size_t offset; /* in mcv_command */
    mcv_option_kind kind;
    unsigned verbs;
    char letter; /* or 0 */
} mcv_option;

typedef struct mcv_verb {
    const char *name, *argument, *doc;
} mcv_verb;

extern const mcv_verb mcv_verbs[MCV_VERB_COUNT];

enum {
#define MCV_X(...) +1
    MCV_OPTION_COUNT = 0 MCV_OPTIONS(MCV_X)
#undef MCV_X
};
extern const mcv_option mcv_options[MCV_OPTION_COUNT];

/* The option of a verb by the first `length` letters of a name, or NULL. */
const mcv_option *mcv_option_find(unsigned verb_index, const char *name, size_t length);

/* The option of a verb by its letter, or NULL. */
const mcv_option *mcv_option_find_letter(unsigned verb_index, char letter);

/* MCV_USAGE with the nearest option that the verb takes. */
mcv_result mcv_option_fail_unknown(unsigned verb_index, const char *name, mcv_error *error);

/* option_values.c: whether a text is one of the words of a choice. */
bool mcv_option_has_word(const mcv_option *o, const char *text);

/* option_values.c: sets the option's field of the command from a text. MCV_USAGE if the text is not
 * of its kind. */
mcv_result mcv_option_set(const mcv_option *o, const char *text, mcv_command *command,
                          mcv_error *error);

#endif
