/* SPDX-License-Identifier: Apache-2.0 */
/* The bandpass filter before the lens of a head. */
#include "verbs/scan.h"

#include <math.h>
#include <stdlib.h>

double mcv_filter_transmittance(const mcv_bandpass *filter, double wavelength, double sine) {
    const double inside = sine / filter->index;
    const double centre = filter->centre * sqrt(fmax(1 - inside * inside, 0)),
                 off = 2 * (wavelength - centre) / filter->width, square = off * off;
    return 1 / (1 + square * square);
}

mcv_result mcv_filter_read(const mcv_command *c, const mcv_scan *s, mcv_bandpass *filter,
                           mcv_error *error) {
    const double wavelength = s->camera.wavelength[0];
    *filter = (mcv_bandpass){c->filter[0], c->filter_width[0], c->filter_index};
    if (filter->centre == 0 && filter->width == 0) return MCV_OK;
    if (!(filter->centre > 0) || !(filter->width > 0))
        return mcv_fail(error, MCV_USAGE,
                        "--filter and --filter-width make a filter together: give both, as in "
                        "--filter 660nm --filter-width 20nm");
    if (filter->index < 1)
        return mcv_fail(error, MCV_USAGE, "--filter-index %g: must be at least 1", filter->index);
    if (mcv_filter_transmittance(filter, wavelength, 0) >= 0.5) return MCV_OK;
    return mcv_fail(error, MCV_USAGE,
                    "--filter: the laser's %g nm lie outside of the filter's band, %g … %g nm",
                    1e9 * wavelength, 1e9 * (filter->centre - filter->width / 2),
                    1e9 * (filter->centre + filter->width / 2));
}

double mcv_scan_transmittance(const mcv_scan *s, double column, double row) {
    const double place[2] = {column, row}, *axis = s->model.rotation + 6;
    double near[3], far[3], along = 0, squares = 0;
    if (s->model.telecentric)
        return mcv_filter_transmittance(&s->filter, s->camera.wavelength[0], 0);
    mcv_camera_model_unproject(&s->model, place, 1, near);
    mcv_camera_model_unproject(&s->model, place, 2, far);
    for (int i = 0; i < 3; ++i) {
        along += axis[i] * (far[i] - near[i]);
        squares += (far[i] - near[i]) * (far[i] - near[i]);
    }
    return mcv_filter_transmittance(&s->filter, s->camera.wavelength[0],
                                    sqrt(fmax(1 - along * along / squares, 0)));
}

/* The light of each pixel of a part, which has q x q sub-pixels. */
static void filter_part(const mcv_image *image, const double *passed, uint32_t q) {
    const size_t width = image->width, plane = width * image->height;
    for (size_t i = 0; i < plane * image->channels; ++i)
        image->pixels[i] *=
            (float)passed[i % plane / width / q * (width / q) + i % plane % width / q];
}

mcv_result mcv_scan_filter(const mcv_scan *s, uint32_t first, mcv_exr *light, mcv_exr *laser,
                           mcv_error *error) {
    const mcv_image *image = &light->parts[0].image;
    if (!(s->filter.width > 0)) return MCV_OK;
    double *passed = malloc((size_t)image->width * image->height * sizeof *passed);
    if (!passed) return mcv_fail(error, MCV_FAILED, "%s: no memory for a scan", s->name);
    for (uint32_t row = 0; row < image->height; ++row)
        for (uint32_t column = 0; column < image->width; ++column)
            passed[(size_t)row * image->width + column] = mcv_scan_transmittance(
                s, column + 0.5 + (s->axis ? 0 : first), row + 0.5 + (s->axis ? first : 0));
    for (uint32_t k = 0; k < light->part_count; ++k) filter_part(&light->parts[k].image, passed, 1);
    for (uint32_t k = 0; k < laser->part_count; ++k)
        filter_part(&laser->parts[k].image, passed, s->subpixels);
    free(passed);
    return MCV_OK;
}
