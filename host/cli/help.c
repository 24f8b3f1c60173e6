/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi help: verbs and options as text and as JSON schemas. */
#include "cli/client.h"
#include "cli/verbs.h"
#include "options/option_table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
        print_wrapped(mcv_verbs[i].doc,
                      printf("  mcvisi %s %s", mcv_verbs[i].name, mcv_verbs[i].argument));
    print_wrapped("the version", printf("  mcvisi --version"));
    puts("\nExit codes:");
#define MCV_X(name, code, meaning) printf("  %3d  %s\n", code, meaning);
    MCV_RESULTS(MCV_X)
#undef MCV_X
}

void mcv_help_print_verb(unsigned verb_index) {
    const mcv_verb *v = mcv_verbs + verb_index;
    printf("mcvisi %s%s%s [OPTIONS]: %s\n\n", v->name, v->argument[0] ? " " : "", v->argument,
           v->doc);
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        const mcv_option *o = mcv_options + i;
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

mcv_result mcv_help_print_schema(unsigned verb_index, mcv_error *error) {
    char *schema;
    MCV_TRY(mcv_options_schema(mcv_verbs[verb_index].name, &schema, error));
    return mcv_client_print(schema, true, error);
}
