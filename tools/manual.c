/* SPDX-License-Identifier: Apache-2.0 */
/* Build tool: manual FOLDER writes the manual pages mcvisi.1 and mcvisi-VERB.1 from the list of
 * options (host/options/options.h). */
#include "options/command.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

typedef struct verb {
    const char *name, *argument, *doc;
} verb;

static const verb verbs[] = {
#define MCV_X(verb, VERB, name, argument, doc) {name, argument, doc},
    MCV_VERBS(MCV_X)
#undef MCV_X
};

typedef struct option {
    const char *name, *argument, *preset, *doc;
    unsigned verbs;
    char letter; /* or 0 */
} option;

static const option options[] = {
#define MCV_X(kind, field, name, letter, argument, verbs, preset, min, max, doc) \
    {name, argument, preset, doc, verbs, letter},
    MCV_OPTIONS(MCV_X)
#undef MCV_X
};
enum { OPTION_COUNT = sizeof options / sizeof options[0] };

/* The character that begins at *text, which is valid UTF-8 of the sources, and the place after it.
 */
static unsigned next_character(const char **text) {
    const unsigned char *bytes = (const unsigned char *)*text;
    const int more = bytes[0] < 0x80 ? 0 : bytes[0] < 0xe0 ? 1 : bytes[0] < 0xf0 ? 2 : 3;
    unsigned character = more ? bytes[0] & (0x3fu >> more) : bytes[0];
    for (int i = 1; i <= more; ++i) character = character << 6 | (bytes[i] & 0x3fu);
    *text += 1 + more;
    return character;
}

/* In roff, - is a hyphen, which cannot be pasted into a shell; a line must not begin with a dot or
 * an apostrophe. */
static void put_text(FILE *page, const char *text) {
    fputs("\\&", page);
    while (*text) {
        const unsigned character = next_character(&text);
        if (character == '-')
            fputs("\\-", page);
        else if (character == '\\')
            fputs("\\e", page);
        else if (character == '\'')
            fputs("\\(aq", page);
        else if (character == '`')
            fputs("\\(ga", page);
        else if (character == '^')
            fputs("\\(ha", page);
        else if (character == '~')
            fputs("\\(ti", page);
        else if (character < 0x80)
            fputc((int)character, page);
        else
            fprintf(page, "\\[u%04X]", character);
    }
}

/* text in a font of man(7): B or I. */
static void put_font(FILE *page, char font, const char *text) {
    fprintf(page, "\\f%c", font);
    put_text(page, text);
    fputs("\\fR", page);
}

static void put_line(FILE *page, const char *text) {
    put_text(page, text);
    fputc('\n', page);
}

static void put_head(FILE *page, const char *title, const char *doc) {
    fputs(".\\\" Generated from host/options/options.h.\n", page);
    fprintf(page, ".TH \"%s\" 1 \"\" \"mcvisi %s\" \"MC ViSi\"\n.nh\n.SH NAME\n", title,
            MCV_VERSION);
    put_text(page, title);
    fputs(" \\- ", page);
    put_line(page, doc);
}

static void put_synopsis(FILE *page, const verb *v, bool takes_options) {
    put_font(page, 'B', "mcvisi");
    fputc(' ', page);
    put_font(page, 'B', v->name);
    if (v->argument[0]) {
        fputc(' ', page);
        put_font(page, 'I', v->argument);
    }
    if (takes_options) {
        fputs(" [", page);
        put_font(page, 'I', "OPTIONS");
        fputc(']', page);
    }
    fputc('\n', page);
}

static void put_exit_codes(FILE *page) {
    fputs(".SH EXIT STATUS\n", page);
#define MCV_X(name, code, meaning) \
    fprintf(page, ".TP\n%d\n", code); \
    put_line(page, meaning);
    MCV_RESULTS(MCV_X)
#undef MCV_X
}

static void put_option(FILE *page, const option *o) {
    const char letter[] = {'-', o->letter, '\0'};
    char name[64];
    snprintf(name, sizeof name, "--%s", o->name);
    fputs(".TP\n", page);
    if (o->letter) {
        put_font(page, 'B', letter);
        fputs(", ", page);
    }
    put_font(page, 'B', name);
    if (o->argument) {
        fputc(' ', page);
        put_font(page, 'I', o->argument);
    }
    fputc('\n', page);
    put_text(page, o->doc);
    if (o->preset) {
        fputs(" (", page);
        put_text(page, o->preset);
        fputc(')', page);
    }
    fputc('\n', page);
}

static void put_verb_page(FILE *page, unsigned index) {
    const verb *v = verbs + index;
    char title[64];
    bool any = false;
    for (size_t i = 0; i < OPTION_COUNT; ++i) any = any || options[i].verbs >> index & 1;
    snprintf(title, sizeof title, "mcvisi-%s", v->name);
    put_head(page, title, v->doc);
    fputs(".SH SYNOPSIS\n", page);
    put_synopsis(page, v, any);
    if (any)
        fputs(".SH OPTIONS\nThe value follows as the next word or after =. A default stands in "
              "parentheses.\n",
              page);
    for (size_t i = 0; i < OPTION_COUNT; ++i)
        if (options[i].verbs >> index & 1) put_option(page, options + i);
    put_exit_codes(page);
    fputs(".SH SEE ALSO\n.BR mcvisi (1)\n", page);
}

static void put_main_page(FILE *page) {
    put_head(page, "mcvisi", "simulate machine-vision systems by rendering");
    fputs(".SH SYNOPSIS\n", page);
    for (unsigned i = 0; i < MCV_VERB_COUNT; ++i) {
        if (i) fputs(".br\n", page);
        put_synopsis(page, verbs + i, true);
    }
    fputs(".br\n\\fBmcvisi\\fR \\fB\\-\\-version\\fR\n.SH DESCRIPTION\n"
          "mcvisi renders machine-vision scenes (glTF with MCVISI_ extensions) by OpenCL.\n"
          "It measures in the images, with the standard uncertainty of each figure.\n"
          "Each verb has a page of its own:\n",
          page);
    for (unsigned i = 0; i < MCV_VERB_COUNT; ++i) {
        fprintf(page, ".TP\n.BR mcvisi\\-%s (1)\n", verbs[i].name);
        put_line(page, verbs[i].doc);
    }
    put_exit_codes(page);
    fputs(".SH ENVIRONMENT\n.TP\n.B POCL_CACHE_DIR\nwhere PoCL, an OpenCL driver for processors, "
          "keeps compiled kernels.\n",
          page);
}

/* index MCV_VERB_COUNT: mcvisi.1 */
static bool write_page(const char *folder, unsigned index) {
    char path[4096];
    const bool of_verb = index < MCV_VERB_COUNT;
    const int length = snprintf(path, sizeof path, "%s/mcvisi%s%s.1", folder, of_verb ? "-" : "",
                                of_verb ? verbs[index].name : "");
    FILE *page = length < (int)sizeof path ? fopen(path, "w") : NULL;
    if (page && of_verb) put_verb_page(page, index);
    if (page && !of_verb) put_main_page(page);
    const bool written = page && !ferror(page);
    if (page && fclose(page) == 0 && written) return true;
    fprintf(stderr, "manual: %s: %s\n", path, strerror(errno));
    return false;
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fputs("usage: manual FOLDER\n", stderr);
        return MCV_USAGE;
    }
    for (unsigned i = 0; i <= MCV_VERB_COUNT; ++i)
        if (!write_page(argv[1], i)) return MCV_FAILED;
    return MCV_OK;
}
