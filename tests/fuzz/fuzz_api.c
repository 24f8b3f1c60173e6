/* SPDX-License-Identifier: Apache-2.0 */
/* The JSON that the public interface takes, by the first byte: options of its calls, attributes,
 * documents of rigs. Renders end at their first callback. What may run programs or write elsewhere
 * is left out. */
#include "fuzz.h"

#include "mcvisi/mcvisi.h"

typedef struct world {
    mcv_session *session;
    mcv_rig *rig;
    mcv_picture *picture;
    mcv_transport *transport;
} world;

/* What a call makes. */
typedef struct made {
    mcv_session *session;
    mcv_rig *rig;
    mcv_picture *picture;
    mcv_transport *transport;
    char *report, *text;
} made;

static bool stop(void *user, const mcv_progress *progress) {
    (void)user;
    (void)progress;
    return false;
}

static bool stop_told(void *user, const char *report) {
    (void)user;
    (void)report;
    return false;
}

static const double sizes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
static const double signals[] = {1, 3, 2, 5, 4, 7, 5, 9, 8, 11, 10, 13};

typedef mcv_result session_call(const world *w, const char *text, made *m, mcv_error *error);

#define CALL(name, call) \
    static mcv_result name(const world *w, const char *text, made *m, mcv_error *error) { \
        (void)w; \
        (void)m; \
        return call; \
    }

CALL(open_session, mcv_session_open(text, &m->session, error))
CALL(render,
     mcv_session_render(w->session, w->rig, text, stop, NULL, &m->picture, &m->report, error))
CALL(render_files, mcv_session_render_files(w->session, w->rig, text, stop, stop_told, NULL, error))
CALL(sweep, mcv_session_sweep(w->session, w->rig, text, stop_told, NULL, &m->report, error))
CALL(uncertainty,
     mcv_session_uncertainty(w->session, w->rig, text, stop_told, NULL, &m->report, error))
CALL(optimize, mcv_session_optimize(w->session, w->rig, text, stop_told, NULL, &m->report, error))
CALL(pod, mcv_session_pod(w->session, w->rig, text, stop_told, NULL, &m->report, error))
CALL(pod_values,
     mcv_pod_values(sizes, signals, sizeof sizes / sizeof sizes[0], false, text, &m->report, error))
CALL(check, mcv_session_check(w->session, w->rig, text, &m->report, error))
CALL(explain, mcv_session_explain(w->session, w->rig, text, &m->report, error))
CALL(trace, mcv_session_trace(w->session, w->rig, (const double[]){0, 0, 0, 0, 0, -1}, 1, text,
                              &m->text, &m->report, error))
CALL(transport,
     mcv_session_transport(w->session, w->rig, text, stop, NULL, &m->transport, &m->report, error))
CALL(deflectometry, mcv_session_deflectometry(w->session, w->rig, text, stop, NULL, &m->picture,
                                              &m->report, error))
CALL(scan, mcv_session_scan(w->session, w->rig, text, stop, NULL, &m->picture, &m->report, error))
CALL(relight, mcv_transport_relight(w->transport, NULL, 0, text, &m->picture, &m->report, error))
CALL(deflection,
     mcv_transport_deflection(w->transport, NULL, text, &m->picture, NULL, &m->report, error))
CALL(inverse, mcv_transport_inverse(w->transport, text, &m->picture, &m->report, error))
CALL(measure, mcv_picture_measure(w->picture, NULL, w->rig, text, &m->report, error))
CALL(camera, mcv_picture_camera(w->picture, text, &m->picture, &m->report, error))
CALL(compare,
     mcv_picture_compare(w->picture, w->picture, text, NULL, &m->picture, &m->report, error))
CALL(detect, mcv_picture_detect(w->picture, w->picture, text, &m->picture, &m->report, error))
CALL(views, mcv_picture_views(w->picture, text, &m->picture, &m->report, error))
CALL(gradient, mcv_picture_emd_gradient(w->picture, text, &m->picture, &m->report, error))
CALL(write_picture, mcv_picture_write(w->picture, "out.exr", text, error))
CALL(make_picture, mcv_picture_make(1, 1, 1, &(const float){1}, NULL, text, &m->picture, error))
CALL(triangulate,
     mcv_images_triangulate(&(const char *){"picture.exr"}, 1, text, &m->report, error))
CALL(parse, mcv_rig_parse(text, strlen(text), NULL, &m->rig, error))
CALL(new_rig, mcv_rig_new("telecentric", "part.stl", text, &m->rig, &m->report, error))
CALL(camera_model, mcv_rig_camera_model(w->rig, text, &m->text, error))

/* A rig of its own, because it is changed. */
static mcv_result change(const world *w, const char *text, made *m, mcv_error *error) {
    if (mcv_rig_copy(w->rig, &m->rig, error) != MCV_OK) abort();
    return mcv_rig_set(m->rig, "sensors/camera/resolution", text, error);
}

static mcv_result add_defect(const world *w, const char *text, made *m, mcv_error *error) {
    if (mcv_rig_copy(w->rig, &m->rig, error) != MCV_OK) abort();
    return mcv_rig_add_defect(m->rig, "dent", text, &m->report, error);
}

/* How many images there are; they are not made. */
static mcv_result sequence(const world *w, const char *text, made *m, mcv_error *error) {
    size_t count;
    return mcv_transport_sequence(w->transport, text, NULL, 0, &count, &m->report, error);
}

static session_call *const calls[] = {
    open_session, render,       render_files, sweep,      uncertainty,   optimize,     pod,
    pod_values,   check,        explain,      trace,      transport,     measure,      camera,
    compare,      detect,       views,        gradient,   write_picture, make_picture, parse,
    new_rig,      camera_model, change,       add_defect, deflectometry, relight,      deflection,
    inverse,      sequence,     triangulate,  scan,
};

static void must(mcv_result result, const mcv_error *error) {
    if (result == MCV_OK) return;
    fprintf(stderr, "%s\n", error->text);
    abort();
}

/* A shipped scene with a change that makes it 24 x 16 pixels, as a file of the folder: what a call
 * writes lies beside it. */
static mcv_rig *rig_of(const char *scene, const char *path, const char *value) {
    mcv_rig *shipped = NULL, *rig = NULL;
    char *text = NULL;
    mcv_error e = {""};
    must(mcv_rig_open(scene, &shipped, &e), &e);
    must(mcv_rig_get(shipped, "", &text, &e), &e);
    must(mcv_rig_parse(text, strlen(text), NULL, &rig, &e), &e);
    must(mcv_rig_set(rig, path, value, &e), &e);
    must(mcv_rig_save(rig, "rig.gltf", &e), &e);
    mcv_text_free(text);
    mcv_rig_free(shipped);
    return rig;
}

static const char part[] =
    "solid part\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 1\n"
    "endloop\nendfacet\nendsolid part\n";

/* The reference renderer, but for the matrix, which it does not make. */
static world open_world(void) {
    static const char options[] = "{\"spp\": 4, \"parts\": \"replicates\"}";
    world w = {0};
    mcv_session *device = NULL;
    mcv_error e = {""};
    mcv_rig *stripes = rig_of(MCV_SOURCE_DIR "/scenes/gray-code.gltf",
                              "sensors/camera/regionOfInterest", "[100, 80, 48, 32]");
    must(mcv_session_open(NULL, &device, &e), &e);
    must(mcv_session_transport(device, stripes, "{\"spp\": 4}", NULL, NULL, &w.transport, NULL, &e),
         &e);
    mcv_session_close(device);
    mcv_rig_free(stripes);
    fuzz_file("part.stl", (const uint8_t *)part, sizeof part - 1);
    w.rig = rig_of(MCV_SOURCE_DIR "/scenes/telecentric-edge.gltf", "sensors/camera/resolution",
                   "[24, 16]");
    must(mcv_session_open("{\"device\": \"reference\", \"threads\": 1}", &w.session, &e), &e);
    must(mcv_session_render(w.session, w.rig, options, NULL, NULL, &w.picture, NULL, &e), &e);
    must(mcv_picture_write(w.picture, "picture.exr", NULL, &e), &e);
    return w;
}

/* Programs, files elsewhere, and films of any size. */
static bool is_left_out(const char *text) {
    static const char *const words[] = {"allow", "\"/", "../", "=/", "\\u", "resolution"};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; ++i)
        if (strstr(text, words[i])) return true;
    return false;
}

static world prepared;

/* Building kernels may take longer than an input is given, so it is no part of the first one. */
int LLVMFuzzerInitialize(int *argc, char ***argv) {
    (void)argc, (void)argv;
    prepared = open_world();
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    mcv_error error = {""};
    made m = {0};
    if (size < 1) return 0;
    char *text = calloc(1, size);
    if (!text) return 0;
    memcpy(text, data + 1, size - 1);
    if (!is_left_out(text))
        fuzz_sentence(
            calls[data[0] % (sizeof calls / sizeof calls[0])](&prepared, text, &m, &error), &error);
    mcv_text_free(m.text);
    mcv_text_free(m.report);
    mcv_transport_free(m.transport);
    mcv_picture_free(m.picture);
    mcv_rig_free(m.rig);
    mcv_session_close(m.session);
    free(text);
    return 0;
}
