/* SPDX-License-Identifier: Apache-2.0 */
/* The tables of verbs and options, and look-ups in them. */
#include "options/option_table.h"

#include "scene/params.h"

#include <stdio.h>
#include <string.h>

const mcv_option mcv_options[MCV_OPTION_COUNT] = {
#define MCV_X(kind, field, name, letter, argument, verbs, preset, min, max, doc) \
    {name, \
     argument, \
     preset, \
     doc, \
     (double)(min), \
     (double)(max), \
     offsetof(mcv_command, field), \
     MCV_KIND_##kind, \
     verbs, \
     letter},
    MCV_OPTIONS(MCV_X)
#undef MCV_X
};

const mcv_verb mcv_verbs[MCV_VERB_COUNT] = {
#define MCV_X(verb, VERB, name, argument, doc) {name, argument, doc},
    MCV_VERBS(MCV_X)
#undef MCV_X
};

mcv_result mcv_verb_find(const char *name, unsigned *verb_index, mcv_error *error) {
    const char *words[MCV_VERB_COUNT];
    for (unsigned i = 0; i < MCV_VERB_COUNT; ++i) {
        words[i] = mcv_verbs[i].name;
        if (strcmp(name, words[i]) != 0) continue;
        *verb_index = i;
        return MCV_OK;
    }
    const char *nearest = mcv_nearest_word(name, words, MCV_VERB_COUNT);
    if (nearest)
        return mcv_fail(error, MCV_USAGE, "unknown verb %s: did you mean %s?", name, nearest);
    return mcv_fail(error, MCV_USAGE, "unknown verb %s: `mcvisi help` lists the verbs", name);
}

mcv_result mcv_option_fail_unknown(unsigned verb_index, const char *name, mcv_error *error) {
    const char *words[MCV_OPTION_COUNT];
    size_t count = 0;
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        if (mcv_options[i].verbs >> verb_index & 1) words[count++] = mcv_options[i].name;
        for (unsigned v = 0; v < MCV_VERB_COUNT; ++v)
            if (mcv_options[i].verbs >> v & 1 && strcmp(mcv_options[i].name, name) == 0)
                return mcv_fail(error, MCV_USAGE,
                                "--%s is an option of %s, not of %s: leave it out", name,
                                mcv_verbs[v].name, mcv_verbs[verb_index].name);
    }
    const char *nearest = mcv_nearest_word(name, words, count);
    if (nearest)
        return mcv_fail(error, MCV_USAGE, "unknown option --%s: did you mean --%s?", name, nearest);
    return mcv_fail(error, MCV_USAGE, "unknown option --%s: `mcvisi help %s` lists the options",
                    name, mcv_verbs[verb_index].name);
}

const mcv_option *mcv_option_find(unsigned verb_index, const char *name, size_t length) {
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i)
        if (mcv_options[i].verbs >> verb_index & 1 && strlen(mcv_options[i].name) == length &&
            strncmp(mcv_options[i].name, name, length) == 0)
            return mcv_options + i;
    return NULL;
}

const mcv_option *mcv_option_find_letter(unsigned verb_index, char letter) {
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i)
        if (mcv_options[i].verbs >> verb_index & 1 && mcv_options[i].letter == letter)
            return mcv_options + i;
    return NULL;
}
