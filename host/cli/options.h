/* SPDX-License-Identifier: Apache-2.0 */
/* What the program is asked to do: verbs and options, each listed once. Parsing, help and messages follow from the lists. */
#ifndef MCVISI_HOST_CLI_OPTIONS_H
#define MCVISI_HOST_CLI_OPTIONS_H

#include "scene/scene.h"

/* X(verb, VERB, "its argument", "what it does"); [] around an argument that may be left out. */
#define MCV_VERBS(X) \
    X(render, RENDER, "SCENE", "render every sensor of a scene into OpenEXR and PNG images") \
    X(check, CHECK, "[SCENE]", "print what was understood of a scene: optics, emitters, materials, features and stages, and why") \
    X(trace, TRACE, "SCENE", "print every vertex of the given rays' paths through a scene's smooth surfaces") \
    X(devices, DEVICES, "", "list the OpenCL devices and their numbers") \
    X(help, HELP, "[VERB]", "explain a verb and its options")

enum {
#define MCV_X(verb, VERB, argument, doc) MCV_VERB_##VERB,
    MCV_VERBS(MCV_X)
#undef MCV_X
        MCV_VERB_COUNT
};

/* Sets of verbs that take an option. */
enum {
#define MCV_X(verb, VERB, argument, doc) MCV_IN_##VERB = 1 << MCV_VERB_##VERB,
    MCV_VERBS(MCV_X)
#undef MCV_X
};

/*
 * X(kind, field, "name", letter, "argument", verbs, default, min, max, "doc")
 *
 * kinds: flag; text; list (may be repeated); number, above min and at most max; count, an integer from min to max; size, two
 * counts WxH; range, two counts A:B with A < B; choice, one of the words in the argument, kept as its index. The default is
 * written as on the command line; without one the field is zero.
 */
#define MCV_OPTIONS(X) \
    X(text, exr, "output", 'o', "F.exr", MCV_IN_RENDER, NULL, 0, 0, \
      "the OpenEXR image, with the standard error as its second part; by default the scene's name, and the sensor's where there are " \
      "several") \
    X(text, png, "png", 0, "F.png", MCV_IN_RENDER, NULL, 0, 0, "the preview; by default the name of the OpenEXR image with .png") \
    X(text, sensor, "sensor", 0, "NAME", MCV_IN_RENDER | MCV_IN_CHECK, NULL, 0, 0, "only this sensor, by name or number") \
    X(count, spp, "spp", 0, "N", MCV_IN_RENDER, NULL, 1, 1ull << 37, \
      "stop at N samples per pixel over all replicates; N / replicates is rounded up to a power of two") \
    X(number, error, "error", 0, "E", MCV_IN_RENDER, NULL, 0, 1e9, \
      "stop at this error: root of the mean squared standard error over the image's mean; without --spp, --error, --time and " \
      "--samples it is 0.01 or 60 s") \
    X(number, time, "time", 0, "T", MCV_IN_RENDER, NULL, 0, 1e9, \
      "stop before T seconds have passed, those of building the scene and the kernels included") \
    X(range, samples, "samples", 0, "A:B", MCV_IN_RENDER, NULL, 0, 1ull << 31, \
      "render just samples A to B - 1 of each replicate; B - A is a power of two and A a multiple of it") \
    X(count, replicates, "replicates", 0, "R", MCV_IN_RENDER, "4", 1, 64, \
      "independent scrambles of the sample points, from whose spread the standard error comes") \
    X(choice, sampler, "sampler", 0, "sobol|random", MCV_IN_RENDER, "sobol", 0, 0, "Owen-scrambled Sobol' points, or independent ones") \
    X(count, seed, "seed", 0, "S", MCV_IN_RENDER, "0", 0, UINT32_MAX, "another seed, another noise; the same seed, the same bits") \
    X(count, depth, "depth", 0, "N", MCV_IN_RENDER | MCV_IN_TRACE, "32", 1, 1000000, "surfaces that a path may meet") \
    X(size, resolution, "resolution", 0, "WxH", MCV_IN_RENDER, NULL, 1, 65536, \
      "other pixels on the same field of view; the macro pixels of a light field camera") \
    X(choice, schedule, "schedule", 0, "auto|tile|stream", MCV_IN_RENDER, "auto", 0, 0, \
      "how the stages are launched: a slice of the image at a time (CPUs), or one launch a stage (GPUs); the same bits") \
    X(text, device, "device", 0, "D", MCV_IN_RENDER | MCV_IN_TRACE, NULL, 0, 0, \
      "a number from `mcvisi devices`, PLATFORM:TYPE:NAME, or `reference`: the independent renderer in double precision, slow") \
    X(count, threads, "threads", 0, "N", MCV_IN_RENDER | MCV_IN_TRACE, NULL, 1, 1024, \
      "threads of the host (building the scene, the reference renderer); by default one per core") \
    X(text, rays, "rays", 0, "rays.csv", MCV_IN_TRACE, NULL, 0, 0, "the rays: rows x,y,z,dx,dy,dz in metres, in the world") \
    X(text, paths, "output", 'o', "paths.csv", MCV_IN_TRACE, NULL, 0, 0, "where to write the vertices; by default standard output") \
    X(list, set, "set", 0, "PATH=VALUE", MCV_IN_RENDER | MCV_IN_CHECK | MCV_IN_TRACE, NULL, 0, 0, \
      "change the scene, as in --set sensors/cam/fNumber=8 or --set emitters/back/halfAngle=0.2deg; may be repeated") \
    X(flag, defines, "defines", 0, NULL, MCV_IN_CHECK, NULL, 0, 0, \
      "print the -D options that specialise the scene's OpenCL programs; without a scene, those with all features") \
    X(flag, json, "json", 0, NULL, MCV_IN_RENDER | MCV_IN_CHECK | MCV_IN_DEVICES, NULL, 0, 0, \
      "print JSON in SI units; render prints one object, on one line, per sensor")

#define MCV_OPTION_FIELD_flag(field) bool field;
#define MCV_OPTION_FIELD_text(field) const char *field;
#define MCV_OPTION_FIELD_list(field) \
    struct { \
        const char **items; \
        size_t count; \
    } field;
#define MCV_OPTION_FIELD_number(field) double field;
#define MCV_OPTION_FIELD_count(field) uint64_t field;
#define MCV_OPTION_FIELD_size(field) uint64_t field[2];
#define MCV_OPTION_FIELD_range(field) uint64_t field[2];
#define MCV_OPTION_FIELD_choice(field) uint64_t field;

typedef struct mcv_command {
    unsigned verb;
    const char *argument; /* the scene, or help's verb; NULL where left out */
    bool help;            /* --help after the verb */
#define MCV_X(kind, field, ...) MCV_OPTION_FIELD_##kind(field)
    MCV_OPTIONS(MCV_X)
#undef MCV_X
} mcv_command;

/* Reads argv[1] …; texts point into argv. MCV_USAGE with a sentence that says what would be right. */
mcv_result mcv_command_parse(int argc, char **argv, mcv_command *command, mcv_error *error);
void mcv_command_free(mcv_command *command);

/* The verb's number, or an error that suggests the nearest one. */
mcv_result mcv_verb_find(const char *name, unsigned *verb, mcv_error *error);

/* Prints all verbs, or one and its options. */
void mcv_help_print(void);
void mcv_help_print_verb(unsigned verb);

/* The verbs. Results go to standard output, warnings and progress to standard error. */
#define MCV_X(verb, VERB, argument, doc) mcv_result mcv_verb_##verb(const mcv_command *command, mcv_error *error);
MCV_VERBS(MCV_X)
#undef MCV_X

#endif
