/* SPDX-License-Identifier: Apache-2.0 */
/* The page of a detection: the answer, what the camera sees, the set-up, and what was assumed. */
#include "verbs/detect.h"

#include "check/setup_page.h"
#include "io/html.h"
#include "io/thumbnail.h"

#include <math.h>
#include <stdlib.h>

/* What a detectability is called here, as in docs/detecting.md. */
static const double hard = 1, certain = 5;

static void put_answer(FILE *out, const mcv_detection *d) {
    fputs("<p class=\"answer\"><strong>", out);
    if (d->high == 0)
        fputs("The pictures do not differ. ", out);
    else if (d->low == 0)
        fputs("Whether the defect can be seen is not known: the render's noise may be all that "
              "there is. ",
              out);
    else if (d->high < hard)
        fputs("The defect can hardly be told from the camera's noise. ", out);
    else if (d->low >= certain)
        fputs("The defect stands out of the camera's noise. ", out);
    else
        fputs("The defect can be told from the camera's noise in a share of all cases. ", out);
    fprintf(out, "Its detectability d' is %.3g, between %.3g and %.3g with 95 %% confidence.",
            d->detectability, d->low, d->high);
    fputs("</strong></p>\n", out);
}

/* Shares [%] by the value and both ends. */
static void put_shares(FILE *out, const mcv_detection *d, const char *name, double factor,
                       double quantile) {
    const double ends[3] = {d->detectability, d->low, d->high};
    fprintf(out, "<tr><th>%s", name);
    for (int i = 0; i < 3; ++i)
        fprintf(out, "<td>%.4g %%", 100 * mcv_normal_below(factor * ends[i] - quantile));
    fputs("\n", out);
}

static void put_figures(FILE *out, const mcv_detected *detected) {
    const mcv_detection *d = &detected->detection;
    fprintf(out,
            "<h2>How sure</h2>\n<table class=\"told\">\n<tr><th><th>best estimate<th>lower "
            "end<th>upper end, 95 %% between both\n<tr><th>detectability d'<td>%.4g<td>%.4g"
            "<td>%.4g\n",
            d->detectability, d->low, d->high);
    put_shares(out, d, "found where 1 % of good parts is called bad", 1, 2.3263478740408408);
    put_shares(out, d, "found where 1 in 10 000 is called bad", 1, 3.7190164854556804);
    put_shares(out, d, "the right one of two pictures is preferred", M_SQRT1_2, 0);
    fprintf(out,
            "</table>\n<p>These are shares of the best filter, which knows size, shape and place "
            "of the defect.</p>\n<table class=\"told\">\n"
            "<tr><th>contrast<td>%.4g &plusmn; %.2g\n"
            "<tr><th>root mean squared contrast<td>%.4g &plusmn; %.2g\n"
            "<tr><th>mean without the defect<td>%.4g electrons\n"
            "<tr><th>noise of such a pixel<td>%.4g electrons\n"
            "<tr><th>pixels that show the defect<td>%llu of %llu\n</table>\n",
            d->contrast.value, d->contrast.uncertainty, d->rms_contrast.value,
            d->rms_contrast.uncertainty, d->mean,
            sqrt(mcv_detect_variance(&detected->camera, d->mean)), (unsigned long long)d->visible,
            (unsigned long long)d->values);
}

static mcv_result put_pictures(FILE *out, const mcv_detect_view *view, mcv_error *error) {
    const mcv_image *with = &view->with->parts[0].image, *without = &view->without->parts[0].image,
                    *sigmas = &view->detected->sigmas, *truth = &view->detected->truth;
    mcv_image difference, shown;
    MCV_TRY(mcv_image_new(&difference, with->width, with->height, with->channels, error));
    for (size_t i = 0; i < (size_t)with->width * with->height * with->channels; ++i)
        difference.pixels[i] = fabsf(with->pixels[i] - without->pixels[i]);
    const mcv_result result = mcv_image_new(&shown, sigmas->width, sigmas->height, 1, error);
    if (result == MCV_OK) {
        for (size_t i = 0; i < (size_t)shown.width * shown.height; ++i)
            shown.pixels[i] = (double)sigmas->pixels[i] >= view->command->visible ? 1.0F : 0;
        fprintf(out,
                "<h2>What the camera sees</h2>\n<p>Light without the camera's noise. Each picture "
                "has a white of its own; the difference is stretched. White in the last ones: "
                "pixels that differ by %.3g deviations of the noise%s.</p>\n<table "
                "class=\"told\">\n<tr><th>with<th>without<th>difference<th>shows it%s\n<tr><td>",
                view->command->visible, truth->pixels ? ", and those that look at the defect" : "",
                truth->pixels ? "<th>looks at it" : "");
        mcv_thumbnail_put(out, with, "with the defect");
        fputs("<td>", out);
        mcv_thumbnail_put(out, without, "without it");
        fputs("<td>", out);
        mcv_thumbnail_put(out, &difference, "their difference");
        fputs("<td>", out);
        mcv_thumbnail_put(out, &shown, "the pixels that show the defect");
        if (truth->pixels) fputs("<td>", out);
        if (truth->pixels) mcv_thumbnail_put(out, truth, "the pixels that look at the defect");
        fputs("\n</table>\n", out);
        mcv_image_free(&shown);
    }
    mcv_image_free(&difference);
    return result;
}

static void put_assumed(FILE *out, const mcv_detect_view *view) {
    const mcv_detected *d = view->detected;
    fputs("<h2>What was simulated, and what not</h2>\n<ul>\n<li>One defect in one place, on one "
          "part in one pose. How places, shapes and poses vary is not in these figures.\n"
          "<li>The interval holds the noise of the renders. How well the model describes the real "
          "part, its light and its camera is not in it.\n"
          "<li>Light goes along rays: it is not diffracted by the defect.\n"
          "<li>The camera has shot noise, read noise, dark current and the fixed pattern that "
          "were given; the fixed pattern counts as noise.\n<li>Blur of the lens: ",
          out);
    mcv_html_text(out, d->lens[0] ? d->lens : "none");
    fprintf(out, ".\n%s%s</ul>\n",
            !d->same_seed ? "<li>The pictures have different seeds: their noise does not cancel.\n"
            : !d->same_sampling
                ? "<li>One picture alone has adaptive sampling: their noise does not cancel.\n"
                : "",
            d->same_seed && mcv_detect_lights_differ(d)
                ? "<li>The pictures differ in their light paths: their noise does not cancel.\n"
                : "");
}

static void put_files(FILE *out, const mcv_detect_view *view) {
    fputs("<footer><p>With the defect: ", out);
    mcv_html_text(out, view->with_path);
    fputs("; without it: ", out);
    mcv_html_text(out, view->without_path);
    fprintf(out, "; %.6g electrons per unit of light.</p></footer>\n</body></html>\n",
            view->detected->camera.electrons_per_unit[0]);
}

struct written {
    const mcv_detect_view *view;
    mcv_result result;
    mcv_error *error;
};

static bool put_page(FILE *out, void *user) {
    struct written *w = user;
    const mcv_detected *d = w->view->detected;
    mcv_html_begin(out, "Can the defect be seen?", true, "; img-src data:");
    fputs("<p class=\"file\">", out);
    mcv_html_date(out);
    fputs(" · mcvisi " MCV_VERSION "</p>\n", out);
    put_answer(out, &d->detection);
    w->result = put_pictures(out, w->view, w->error);
    if (d->setup) fprintf(out, "<h2>The set-up</h2>\n%s", d->setup);
    put_figures(out, d);
    put_assumed(out, w->view);
    put_files(out, w->view);
    return w->result == MCV_OK;
}

mcv_result mcv_detect_write_page(const char *path, const mcv_detect_view *view, mcv_error *error) {
    struct written w = {.view = view, .error = error};
    return mcv_html_write(path, put_page, &w, error);
}

char *mcv_detect_draw(const mcv_scene *scene, uint32_t sensor) {
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    if (!out) return NULL;
    const bool memory = mcv_setup_put_view(out, scene, sensor, false, NULL, NULL);
    if (fclose(out) == 0 && memory) return text;
    free(text);
    return NULL;
}
