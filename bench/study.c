/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a study of the probability of detection costs beside its renders: bench_study [--quick]
 * [--only TEXT] [OUTPUT.json]. 240 dents of other sizes in other places of a metal plate, 256 x 256
 * pixels, 64 samples (--quick: 16, a harder case, because renders are shorter). Its peer renders
 * one of them as often, with as many seeds, in one session: nothing is loaded, built or measured
 * then. Seconds are those of the processor, in all threads, kernels compiled. The plate is a mesh
 * of few triangles, and one of 500 000.
 */
#include "harness.h"

#include "mcvisi/mcvisi.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static const char rig_options[] =
    "{\"unit\": \"mm\", \"material\": \"aluminium\", \"light\": \"coaxial\", \"resolution\": "
    "\"256x256\", \"field-of-view\": "
    "\"16mm\"}";

/* A square of 20 mm, as binary STL in mm, by n x n squares of two triangles. */
static mcv_result write_plate(const char *path, uint32_t n, mcv_error *error) {
    static const uint32_t corners[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
    const char head[80] = "a plate, mm";
    const uint32_t count = 2 * n * n;
    FILE *file = fopen(path, "wb");
    if (!file) return mcv_fail(error, MCV_FAILED, "%s: cannot be written", path);
    bool written = fwrite(head, sizeof head, 1, file) == 1 && fwrite(&count, 4, 1, file) == 1;
    for (uint32_t i = 0; written && i < count; ++i) {
        float numbers[12] = {0};
        for (int k = 0; k < 3; ++k)
            for (int axis = 0; axis < 2; ++axis) {
                const uint32_t cell = axis ? i / 2 / n : i / 2 % n;
                numbers[3 + 3 * k + axis] =
                    -10 + 20 * (float)(cell + corners[i % 2][k][axis]) / (float)n;
            }
        written = fwrite(numbers, sizeof numbers, 1, file) == 1 && fwrite("\0", 2, 1, file) == 1;
    }
    return fclose(file) == 0 && written ? MCV_OK
                                        : mcv_fail(error, MCV_FAILED, "%s: is not whole", path);
}

typedef struct study {
    mcv_session *session;
    mcv_rig *rig;
    char stem[1100];
    int samples;
} study;

enum { SETS = 240 };

static mcv_result render_alone(const study *s, int seed, mcv_error *error) {
    char options[128];
    mcv_picture *picture = NULL;
    snprintf(options, sizeof options, "{\"spp\": %d, \"adaptive\": \"off\", \"seed\": %d}",
             s->samples, seed);
    const mcv_result result =
        mcv_session_render(s->session, s->rig, options, NULL, NULL, &picture, NULL, error);
    mcv_picture_free(picture);
    return result;
}

static mcv_result run_study(const study *s, mcv_error *error) {
    char options[4096], *report = NULL;
    snprintf(options, sizeof options,
             "{\"vary\": [\"defects/dent/size=0.2mm..1mm\", \"nodes/part/shiftX=-2mm..2mm\"], "
             "\"design\": \"lhs\", \"points\": %d, \"region\": \"dent=@part:0mm,0mm,0mm,1mm,1mm\", "
             "\"background\": \"@part:-5mm,0mm,0mm,3mm,6mm\", \"metric\": "
             "\"signal:=abs(dent.weber_contrast)\", \"expose-to\": 0.5, \"spp\": %d, \"output\": "
             "\"%s.csv\", \"force\": true, "
             "\"pod\": {\"size\": \"size\", \"signal\": \"signal\", \"threshold\": \"0.02\", "
             "\"output\": "
             "\"%s.html\"}}",
             SETS, s->samples, s->stem, s->stem);
    const mcv_result result =
        mcv_session_pod(s->session, s->rig, options, NULL, NULL, &report, error);
    mcv_text_free(report);
    return result;
}

static mcv_result open_study(study *s, uint32_t squares, mcv_error *error) {
    char part[1200];
    snprintf(part, sizeof part, "%s.stl", s->stem);
    MCV_TRY(write_plate(part, squares, error));
    MCV_TRY(mcv_session_open(NULL, &s->session, error));
    MCV_TRY(mcv_rig_new("telecentric", part, rig_options, &s->rig, NULL, error));
    return mcv_rig_add_defect(s->rig, "dent",
                              "{\"node\": \"part\", \"at\": \"0,0,0\", \"size\": \"0.5mm\", "
                              "\"name\": \"dent\"}",
                              NULL, error);
}

static mcv_result measure(bench *b, const study *s, const char *name, mcv_error *error) {
    MCV_TRY(render_alone(s, 0, error)); /* compiles */
    bench_seconds begun = bench_now();
    for (int i = 0; i < SETS; ++i) MCV_TRY(render_alone(s, i, error));
    const double renders = bench_since(begun).by[BENCH_CPU];
    begun = bench_now();
    MCV_TRY(run_study(s, error));
    const double whole = bench_since(begun).by[BENCH_CPU];
    bench_number(b, whole, renders, "s", "%s, %d sets and their renders alone", name, SETS);
    bench_summary(b, name, whole / renders);
    return MCV_OK;
}

static mcv_result run(bench *b, mcv_error *error) {
    static const struct {
        const char *name;
        uint32_t squares;
    } plates[] = {{"few_triangles", 1}, {"500_000_triangles", 500}};
    bench_title("Studies of the probability of detection (ours) and their renders alone (peer)");
    for (size_t i = 0; i < sizeof plates / sizeof *plates; ++i) {
        if (b->only && !strstr(plates[i].name, b->only)) continue;
        study s = {.samples = b->quick ? 16 : 64};
        /* In a folder of their own: report.py reads all beside the output. */
        snprintf(s.stem, sizeof s.stem, "%s-files", b->stem);
        if (mkdir(s.stem, 0777) != 0 && errno != EEXIST)
            return mcv_fail(error, MCV_FAILED, "%s: cannot be made", s.stem);
        snprintf(s.stem, sizeof s.stem, "%s-files/%s", b->stem, plates[i].name);
        mcv_result result = open_study(&s, plates[i].squares, error);
        if (result == MCV_OK) result = measure(b, &s, plates[i].name, error);
        mcv_rig_free(s.rig);
        mcv_session_close(s.session);
        MCV_TRY(result);
    }
    return MCV_OK;
}

int main(int argc, char **argv) { return bench_main(argc, argv, "study", run); }
