/* SPDX-License-Identifier: Apache-2.0 */
/* Options as a JSON schema. */
#include "options/option_table.h"

#include <stdio.h>
#include <string.h>

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
    case MCV_KIND_bytes:
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
        if (mcv_option_has_word(o, "on")) json_array_append_new(words, json_true());
        if (mcv_option_has_word(o, "off")) json_array_append_new(words, json_false());
        return json_pack("{s:o}", "enum", words);
    }
    case MCV_KIND_text:
        break;
    }
    return json_pack("{s:s}", "type", "string");
}

json_t *mcv_verb_schema(unsigned verb_index) {
    const bool experiment = (MCV_IN_EXPERIMENTS >> verb_index & 1) != 0;
    char title[64];
    json_t *properties = json_object();
    if (experiment) {
        json_object_set_new(properties, "rig",
                            json_pack("{s:s, s:s}", "type", "string", "description",
                                      "the scene, relative to this file's folder"));
        json_object_set_new(
            properties, "fingerprint",
            json_pack("{s:s, s:s}", "type", "string", "description",
                      "fingerprint of the scene's files, which is written beside its table"));
    }
    if (verb_index == MCV_VERB_SWEEP)
        json_object_set_new(properties, "pod",
                            json_pack("{s:s, s:s}", "type", "object", "description",
                                      "what `mcvisi pod` tells of the table: its options"));
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        if (!(mcv_options[i].verbs >> verb_index & 1)) continue;
        json_t *schema = option_schema(mcv_options + i);
        json_object_set_new(schema, "description", json_string(mcv_options[i].doc));
        json_object_set_new(properties, mcv_options[i].name, schema);
    }
    snprintf(title, sizeof title, "%s%s", experiment ? "experiment of mcvisi " : "",
             mcv_verbs[verb_index].name);
    json_t *document = json_pack("{s:s, s:s, s:s, s:o, s:b}", "$schema",
                                 "http://json-schema.org/draft-04/schema", "title", title, "type",
                                 "object", "properties", properties, "additionalProperties", 0);
    if (document && experiment) json_object_set_new(document, "required", json_pack("[s]", "rig"));
    return document;
}
