/* SPDX-License-Identifier: Apache-2.0 */
/* Parses a command line, and combines --device and --precision. */
#include "options/option_table.h"

#include "render/render.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_option(const char *text) { return text[0] == '-' && text[1] != '\0'; }

static bool may_stand_alone(const mcv_option *o) {
    return o->kind == MCV_KIND_choice && mcv_option_has_word(o, "on");
}

/*
 * Parses the option at argv[*i] with its value: --name=value, --name value, -o value, -ovalue.
 * getopt_long is not used, because it accepts any prefix of a name: the meaning of --s would change
 * with each new option.
 */
static mcv_result parse_option(char **argv, int argc, int *i, mcv_command *command,
                               mcv_error *error) {
    const char *text = argv[*i];
    const mcv_option *o;
    const char *value = NULL;
    if (text[1] == '-') {
        const char *name = text + 2;
        const size_t length = strcspn(name, "=");
        if (!(o = mcv_option_find(command->verb, name, length))) {
            char known[64];
            snprintf(known, sizeof known, "%.*s",
                     (int)(length < sizeof known ? length : sizeof known), name);
            return mcv_option_fail_unknown(command->verb, known, error);
        }
        if (name[length] == '=') value = name + length + 1;
    } else {
        if (!(o = mcv_option_find_letter(command->verb, text[1])))
            return mcv_fail(error, MCV_USAGE,
                            "unknown option %s: `mcvisi help %s` lists the options", text,
                            mcv_verbs[command->verb].name);
        if (text[2]) value = text + 2;
    }
    if (o->kind == MCV_KIND_flag) {
        if (value) return mcv_fail(error, MCV_USAGE, "--%s takes no value", o->name);
    } else if (!value && may_stand_alone(o) &&
               (*i + 1 >= argc || !mcv_option_has_word(o, argv[*i + 1]))) {
        value = "on";
    } else if (!value) {
        if (*i + 1 >= argc || strncmp(argv[*i + 1], "--", 2) == 0)
            return mcv_fail(error, MCV_USAGE, "--%s needs a value: %s", o->name, o->argument);
        value = argv[++*i];
    }
    return mcv_option_set(o, value, command, error);
}

mcv_result mcv_command_parse(int argc, char **argv, mcv_command *command, mcv_error *error) {
    *command = (mcv_command){.argc = argc, .argv = argv};
    if (argc < 2)
        return mcv_fail(
            error, MCV_USAGE,
            "a verb is missing, as in `mcvisi render SCENE`: `mcvisi help` lists the verbs");
    MCV_TRY(mcv_verb_find(argv[1], &command->verb, error));
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        mcv_list *list = (mcv_list *)((char *)command + mcv_options[i].offset);
        if (mcv_options[i].kind != MCV_KIND_list) continue;
        list->items = malloc((size_t)argc * sizeof *list->items);
        if (!list->items) return mcv_fail(error, MCV_FAILED, "no memory for the command line");
    }
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i)
        if (mcv_options[i].preset)
            MCV_TRY(mcv_option_set(mcv_options + i, mcv_options[i].preset, command, error));

    const mcv_verb *v = mcv_verbs + command->verb;
    const bool takes_many = strstr(v->argument, "…");
    command->arguments.items = malloc((size_t)argc * sizeof *command->arguments.items);
    if (!command->arguments.items)
        return mcv_fail(error, MCV_FAILED, "no memory for the command line");
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
        } else if (!command->argument || takes_many) {
            if (!command->argument) command->argument = argv[i];
            command->arguments.items[command->arguments.count++] = argv[i];
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
    free(command->arguments.items);
    command->arguments = (mcv_list){NULL, 0};
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        mcv_list *list = (mcv_list *)((char *)command + mcv_options[i].offset);
        if (mcv_options[i].kind != MCV_KIND_list) continue;
        free(list->items);
        *list = (mcv_list){NULL, 0};
    }
}

/* --- precision --- */

/* By --device, or by the variable in its place (cl/cl.h). */
static bool is_reference(const mcv_command *command) {
    const char *device = command->device ? command->device : getenv("MCVISI_OPENCL_DEVICE");
    return device && strcmp(device, "reference") == 0;
}

bool mcv_wants_reference(const mcv_command *command) {
    return is_reference(command) || command->precision == MCV_PRECISION_DOUBLE;
}

mcv_result mcv_precision_read(const mcv_command *command, uint32_t *precision, mcv_error *error) {
    *precision = mcv_wants_reference(command) ? MCV_PRECISION_DOUBLE : (uint32_t)command->precision;
    if (command->precision == MCV_PRECISION_MIXED && is_reference(command))
        return mcv_fail(
            error, MCV_USAGE,
            "--precision mixed is for OpenCL devices: the reference renderer computes in double "
            "only");
    if (command->precision == MCV_PRECISION_DOUBLE && command->device && !is_reference(command))
        return mcv_fail(
            error, MCV_USAGE,
            "--precision double runs the reference renderer, on the host: leave out --device %s",
            command->device);
    if (command->precision == MCV_PRECISION_DOUBLE && command->schedule)
        return mcv_fail(
            error, MCV_USAGE,
            "--precision double runs the reference renderer, which has no --schedule: leave it "
            "out");
    return MCV_OK;
}
