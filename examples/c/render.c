/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Renders a scene, and writes the image, its preview and the grey values of a camera:
 *
 *     render SCENE.gltf [DEVICE]
 */
#include <mcvisi/mcvisi.h>

#include <stdio.h>

static bool show(void *user, const mcv_progress *progress) {
    (void)user;
    fprintf(stderr, "\r%3.0f %%", 100 * progress->fraction);
    return true; /* false would stop the render, and keep the picture so far */
}

/* What has to be freed, in one place: a call that fails leaves its output NULL. */
typedef struct work {
    mcv_session *session;
    mcv_rig *rig;
    mcv_picture *image, *grey;
    char *report;
} work;

static mcv_result run(work *w, const char *scene, const char *options, mcv_error *error) {
    mcv_result result = mcv_session_open(options, &w->session, error);
    if (result == MCV_OK) result = mcv_rig_open(scene, &w->rig, error);
    if (result == MCV_OK)
        result = mcv_session_render(w->session, w->rig, "{\"spp\": 16, \"resolution\": [96, 64]}",
                                    show, NULL, &w->image, NULL, error);
    if (result == MCV_OK) result = mcv_picture_write(w->image, "image.exr", NULL, error);
    if (result == MCV_OK) result = mcv_picture_write(w->image, "image.png", NULL, error);
    if (result == MCV_OK)
        result = mcv_picture_camera(w->image, "{\"expose_to\": 0.8}", &w->grey, &w->report, error);
    if (result == MCV_OK) result = mcv_picture_write(w->grey, "grey.tif", NULL, error);
    return result;
}

int main(int argc, char **argv) {
    mcv_error error = {""};
    work w = {0};
    char options[256] = "";
    if (argc < 2) {
        fprintf(stderr, "usage: render SCENE.gltf [DEVICE]\n");
        return MCV_USAGE;
    }
    if (argc > 2) snprintf(options, sizeof options, "{\"device\": \"%s\"}", argv[2]);
    const mcv_result result = run(&w, argv[1], options, &error);
    if (result == MCV_OK)
        printf("%s\n", w.report);
    else
        fprintf(stderr, "%s\n", error.text);
    mcv_text_free(w.report);
    mcv_picture_free(w.grey);
    mcv_picture_free(w.image);
    mcv_rig_free(w.rig);
    mcv_session_close(w.session);
    return result;
}
