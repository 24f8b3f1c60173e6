/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi help: verbs and options as text and as JSON schemas. */
#include "cli/option_table.h"

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

/* The schema of one value; flags are true or absent. */
static json_t *option_schema(const mcv_option *o) {
    switch (o->kind) {
    case MCV_KIND_flag:
        return json_pack("{s:s}", "type", "boolean");
    case MCV_KIND_number:
        return json_pack("{s:s, s:f, s:b, s:f}", "type", "number", "minimum", o->min,
                         "exclusiveMinimum", 1, "maximum", o->max);
    case MCV_KIND_count:
        return json_pack("{s:s, s:f, s:f}", "type", "integer", "minimum", o->min, "maximum",
                         o->max);
    case MCV_KIND_size:
        return json_pack("{s:s, s:s}", "type", "string", "pattern", "^[0-9]+x[0-9]+$");
    case MCV_KIND_range:
        return json_pack("{s:s, s:s}", "type", "string", "pattern", "^[0-9]+:[0-9]+$");
    case MCV_KIND_time:
    case MCV_KIND_channels:
    case MCV_KIND_lengths:
        return json_pack("{s:[s,s]}", "type", "number", "string");
    case MCV_KIND_list:
        return json_pack("{s:[{s:s}, {s:s, s:{s:s}}]}", "anyOf", "type", "string", "type", "array",
                         "items", "type", "string");
    case MCV_KIND_choice: {
        json_t *words = json_array();
        for (const char *word = o->argument; *word;
             word += word[strcspn(word, "|")] ? strcspn(word, "|") + 1 : strcspn(word, "|"))
            json_array_append_new(words, json_stringn(word, strcspn(word, "|")));
        return json_pack("{s:o}", "enum", words);
    }
    case MCV_KIND_text:
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
                                      "the scene, relative to this file's folder"));
        json_object_set_new(properties, "note",
                            json_pack("{s:s, s:s}", "type", "string", "description", "a comment"));
        json_object_set_new(
            properties, "fingerprint",
            json_pack("{s:s, s:s}", "type", "string", "description",
                      "fingerprint of the scene's files, which a sweep writes beside its table"));
    }
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        if (!(mcv_options[i].verbs >> verb_index & 1)) continue;
        json_t *schema = option_schema(mcv_options + i);
        json_object_set_new(schema, "description", json_string(mcv_options[i].doc));
        json_object_set_new(properties, mcv_options[i].name, schema);
    }
    json_t *document =
        json_pack("{s:s, s:s, s:s, s:o, s:b}", "$schema", "http://json-schema.org/draft-04/schema",
                  "title", experiment ? "experiment of mcvisi sweep" : mcv_verbs[verb_index].name,
                  "type", "object", "properties", properties, "additionalProperties", 0);
    if (experiment) json_object_set_new(document, "required", json_pack("[s]", "rig"));
    char *text = document ? json_dumps(document, JSON_INDENT(2)) : NULL;
    json_decref(document);
    if (!text) return mcv_fail(error, MCV_FAILED, "no memory for the schema");
    puts(text);
    free(text);
    return MCV_OK;
}
