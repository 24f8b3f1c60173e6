/* SPDX-License-Identifier: Apache-2.0 */
/* Build tool: completion FILE writes the completion of bash from the list of options
 * (host/options/options.h). */
#include "options/command.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>

typedef struct option {
    const char *kind, *name, *argument;
    unsigned verbs;
    char letter; /* or 0 */
} option;

static const option options[] = {
#define MCV_X(kind, field, name, letter, argument, verbs, ...) \
    {#kind, name, argument, verbs, letter},
    MCV_OPTIONS(MCV_X)
#undef MCV_X
};
enum { OPTION_COUNT = sizeof options / sizeof options[0] };

typedef struct verb {
    const char *name, *argument;
} verb;

static const verb verbs[] = {
#define MCV_X(verb, VERB, name, argument, doc) {name, argument},
    MCV_VERBS(MCV_X)
#undef MCV_X
};

/* All else that the script does. */
static const char function[] =
    "_mcvisi() {\n"
    "    local verb=${COMP_WORDS[1]} current=${COMP_WORDS[COMP_CWORD]} option='' place=1 word "
    "words i\n"
    "    COMPREPLY=()\n"
    "    # Bash splits words at = and :, so that --samples=0:64 is five of them.\n"
    "    for ((i = 2; i < COMP_CWORD; ++i)); do\n"
    "        word=${COMP_WORDS[i]}\n"
    "        if [[ $word == [=:] ]]; then\n"
    "            [[ $option ]] || ((++i))\n"
    "        elif [[ $option ]]; then\n"
    "            option=''\n"
    "        elif [[ $word == -* ]]; then\n"
    "            [[ ! ${_mcvisi_words[\"$verb $word\"]+known} ]] || option=$word\n"
    "        else\n"
    "            ((++place))\n"
    "        fi\n"
    "    done\n"
    "    [[ $current != [=:] ]] || current=''\n"
    "    if ((COMP_CWORD == 1)); then\n"
    "        words=${_mcvisi_words[\"verbs\"]}\n"
    "    elif [[ $option ]]; then\n"
    "        words=${_mcvisi_words[\"$verb $option\"]}\n"
    "    elif [[ $current == -* ]]; then\n"
    "        words=${_mcvisi_words[\"$verb options\"]-}\n"
    "    else\n"
    "        words=${_mcvisi_words[\"$verb $place\"]-}\n"
    "    fi\n"
    "    if [[ \" $words \" == *' % '* ]]; then\n"
    "        compopt -o filenames 2>/dev/null\n"
    "        mapfile -t COMPREPLY < <(compgen -f -- \"$current\")\n"
    "    fi\n"
    "    while read -r word; do\n"
    "        COMPREPLY+=(\"$word\")\n"
    "    done < <(compgen -W \"${words//%/}\" -- \"$current\")\n"
    "}\n"
    "complete -F _mcvisi mcvisi\n";

/* What help calls a file: a name with an ending, or one of these. */
static bool is_file(const char *word, size_t length) {
    static const char *const names[] = {"A",     "B",    "FILE", "FOLDER", "IMAGE",
                                        "OTHER", "PART", "RIG",  "SCENE"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strlen(names[i]) == length && strncmp(word, names[i], length) == 0) return true;
    return memchr(word, '.', length) != NULL;
}

/*
 * The words that an argument of help offers: of "word|word|F.csv" the two words and % for the file.
 * Capitals stand for something else, but where all are words (kind choice).
 */
static void put_argument(FILE *script, const char *argument, size_t length, bool choice) {
    bool files = false;
    for (const char *at = argument, *end = argument + length; at < end;) {
        const size_t size =
            strcspn(at, "|") < (size_t)(end - at) ? strcspn(at, "|") : (size_t)(end - at);
        if (choice || islower((unsigned char)*at))
            fprintf(script, " %.*s", (int)size, at);
        else
            files = files || is_file(at, size);
        at += size + 1;
    }
    if (files) fputs(" %", script);
}

static void put_verbs(FILE *script) {
    for (unsigned i = 0; i < MCV_VERB_COUNT; ++i) fprintf(script, " %s", verbs[i].name);
}

/* What a verb takes beside options: the words of its place-th argument. */
static void put_places(FILE *script, const verb *v) {
    const char *argument = v->argument + (v->argument[0] == '[');
    for (int place = 1; *argument; ++place) {
        const size_t length = strcspn(argument, " ]");
        fprintf(script, "    [\"%s %d\"]=\"", v->name, place);
        if (strncmp(argument, "VERB", length) == 0)
            put_verbs(script);
        else
            put_argument(script, argument, length, false);
        fputs("\"\n", script);
        argument += length + (argument[length] != '\0');
    }
}

static void put_values(FILE *script, const verb *v, const option *o, const char *dashes,
                       const char *name) {
    fprintf(script, "    [\"%s %s%s\"]=\"", v->name, dashes, name);
    put_argument(script, o->argument, strlen(o->argument), strcmp(o->kind, "choice") == 0);
    fputs("\"\n", script);
}

static void put_verb(FILE *script, unsigned index) {
    const verb *v = verbs + index;
    put_places(script, v);
    fprintf(script, "    [\"%s options\"]=\"--help", v->name);
    for (size_t i = 0; i < OPTION_COUNT; ++i)
        if (options[i].verbs >> index & 1) fprintf(script, " --%s", options[i].name);
    fputs("\"\n", script);
    for (size_t i = 0; i < OPTION_COUNT; ++i) {
        const option *o = options + i;
        if (!(o->verbs >> index & 1) || !o->argument) continue;
        put_values(script, v, o, "--", o->name);
        if (o->letter) put_values(script, v, o, "-", (const char[]){o->letter, '\0'});
    }
}

int main(int argc, char **argv) {
    FILE *script = argc == 2 ? fopen(argv[1], "w") : NULL;
    if (argc != 2) {
        fputs("usage: completion FILE\n", stderr);
        return MCV_USAGE;
    }
    if (script) {
        fputs("# shellcheck shell=bash\n"
              "# Completion of mcvisi's verbs, options, values and files. Generated from "
              "host/options/options.h.\n"
              "# The words at each place; % stands for files.\n"
              "declare -gA _mcvisi_words=(\n    [\"verbs\"]=\"--help --version",
              script);
        put_verbs(script);
        fputs("\"\n", script);
        for (unsigned i = 0; i < MCV_VERB_COUNT; ++i) put_verb(script, i);
        fprintf(script, ")\n\n%s", function);
    }
    const bool written = script && !ferror(script);
    if (script && fclose(script) == 0 && written) return MCV_OK;
    fprintf(stderr, "completion: %s: %s\n", argv[1], strerror(errno));
    return MCV_FAILED;
}
