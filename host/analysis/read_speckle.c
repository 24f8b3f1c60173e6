/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/read_speckle.h"

#include "analysis/speckle.h"
#include "io/picture_header.h"
#include "scene/camera_model.h"
#include "scene/params.h"

#include <math.h>
#include <string.h>

/* A picture of the laser's light, and how its sub-pixels lie in the image. */
typedef struct subpixels {
    const char *path;
    const mcv_exr *exr;
    uint32_t q;
} subpixels;

/* Is it light of lasers alone, of the same kind as the image? */
static mcv_result check_light(const subpixels *laser, const char *path, const mcv_exr *exr,
                              mcv_error *error) {
    const mcv_attribute *own = mcv_exr_attribute(laser->exr, "mcvisi:quantity"),
                        *other = mcv_exr_attribute(exr, "mcvisi:quantity");
    mcv_error detail = {""};
    if (!mcv_exr_numbers(laser->exr, MCV_LASER_WAVELENGTH, 1))
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: is not lit by lasers of one wavelength alone, and light of lamps makes "
            "no speckle: render it by `mcvisi render --lasers Q`",
            laser->path);
    if (!own || !own->text || !other || !other->text || strcmp(own->text, other->text) != 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: its mcvisi:quantity is not that of %s: render both with the same "
                        "radiometry",
                        laser->path, path);
    const mcv_result result = mcv_camera_check_light(&laser->exr->parts[0].image, &detail);
    return result == MCV_OK ? MCV_OK : mcv_fail(error, result, "%s: %s", laser->path, detail.text);
}

/* Has it q x q pixels for each of the image, enough for the grains? */
static mcv_result check_grid(subpixels *laser, const char *path, const mcv_exr *exr,
                             const mcv_speckle *speckle, const double size[2], mcv_error *error) {
    const mcv_image *own = &laser->exr->parts[0].image, *image = &exr->parts[0].image;
    laser->q = own->width / image->width;
    if (laser->q == 0 || own->width != laser->q * image->width ||
        own->height != laser->q * image->height || own->channels != image->channels)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has %u x %u pixels and %u channels: must have a whole multiple of the "
                        "%u x %u pixels of %s, and its %u channels",
                        laser->path, own->width, own->height, own->channels, image->width,
                        image->height, path, image->channels);
    const uint32_t needed =
        mcv_speckle_subpixels(fmax(size[0], size[1]), speckle->wavelength, speckle->f_number);
    if (laser->q >= needed) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: has %u x %u sub-pixels for each pixel, but grains of %.3g m need %u x %u: "
                    "render it with --lasers %u",
                    laser->path, laser->q, laser->q, speckle->wavelength * speckle->f_number,
                    needed, needed, needed);
}

/* A whole number of the header, 0 where there is none of a sensible size. */
static uint32_t whole_number(const mcv_exr *exr, const char *name) {
    const double *number = mcv_exr_numbers(exr, name, 1);
    return number && *number >= 0 && *number <= 1000 ? (uint32_t)*number : 0;
}

mcv_result mcv_exr_aperture(const char *path, const mcv_exr *exr, mcv_aperture_shape *aperture,
                            mcv_mask *mask, mcv_error *error) {
    const mcv_attribute *word = mcv_exr_attribute(exr, MCV_PICTURE_APERTURE);
    const double *ratio = mcv_exr_numbers(exr, "mcvisi:apertureRatio", 1),
                 *rotation = mcv_exr_numbers(exr, "mcvisi:apertureRotation", 1);
    const char *const *words = mcv_param_options("aperture");
    *aperture = (mcv_aperture_shape){.shape = MCV_APERTURE_DISC,
                                     .ratio = ratio ? *ratio : NAN,
                                     .rotation = rotation ? *rotation : NAN,
                                     .blades = whole_number(exr, "mcvisi:apertureBlades"),
                                     .order = whole_number(exr, "mcvisi:apertureOrder")};
    if (!word) return MCV_OK;
    const mcv_attribute *cells = mcv_exr_attribute(exr, MCV_PICTURE_MASK);
    if (cells && cells->text && mcv_header_read_mask(cells->text, mask)) aperture->mask = mask;
    for (int i = MCV_APERTURE_DISC; i <= MCV_APERTURE_MASK; ++i) {
        aperture->shape = i;
        if (word->text && strcmp(word->text, words[i]) == 0 && mcv_aperture_is_valid(aperture))
            return MCV_OK;
    }
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: %s in its header is \"%s\": must be a shape of sensors with its numbers "
                    "beside it, as `mcvisi render` writes it",
                    path, MCV_PICTURE_APERTURE, word->text ? word->text : "");
}

/*
 * The places of the surface that the pixels see; false where the picture has none. A cell is λN/6
 * of the plane in focus: a sub-pixel of λN/4 has some two of them.
 */
static bool find_surface(const char *path, const mcv_exr *exr, const mcv_exr *laser,
                         const mcv_speckle *speckle, mcv_surface_noise *surface) {
    const mcv_attribute *text = mcv_exr_attribute(exr, MCV_CAMERA_MODEL_KEY);
    mcv_camera_model model;
    mcv_error ignored;
    bool is_one = false;
    *surface = (mcv_surface_noise){0};
    for (uint32_t i = 1; i < laser->part_count; ++i) {
        const mcv_image *image = &laser->parts[i].image;
        if (strcmp(laser->parts[i].name, MCV_SURFACE_PART) == 0 && image->channels == 4 &&
            image->width == exr->parts[0].image.width + 1 &&
            image->height == exr->parts[0].image.height + 1)
            surface->places = image;
    }
    if (!surface->places || !text || !text->text ||
        mcv_camera_model_read(text->text, path, &model, &is_one, &ignored) != MCV_OK || !is_one)
        return false;
    surface->edge =
        speckle->wavelength * speckle->f_number / 6 *
        fmax(model.object_pixel[0] / model.pixel[0], model.object_pixel[1] / model.pixel[1]);
    mcv_camera_model_free(&model);
    return surface->edge > 0;
}

/* What the headers and settings say of the speckle. */
static mcv_result describe(const mcv_camera_settings *settings, const char *path,
                           const mcv_exr *exr, const mcv_exr *laser, mcv_speckle *speckle,
                           mcv_mask *mask, double size[2], mcv_error *error) {
    const double *f_number = mcv_exr_numbers(exr, "mcvisi:fNumber", 1),
                 *linewidth = mcv_exr_numbers(laser, MCV_LASER_LINEWIDTH, 1);
    if (!f_number || !mcv_camera_pixel_size(exr, size) ||
        mcv_exr_attribute(exr, "mcvisi:angularResolution"))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has no f-number and pixel size of one stop in its header, which "
                        "make the grains of speckle: use a thinLens or telecentric sensor",
                        path);
    MCV_TRY(mcv_exr_aperture(path, exr, &speckle->aperture, mask, error));
    speckle->disc_blurred = strcmp(settings->lens_mtf, "diffraction") == 0;
    speckle->f_number = *f_number;
    speckle->wavelength = *mcv_exr_numbers(laser, MCV_LASER_WAVELENGTH, 1);
    speckle->polarization = settings->speckle_polarization;
    speckle->patterns =
        settings->speckle_patterns * mcv_speckle_spectral_patterns(linewidth ? *linewidth : 0,
                                                                   speckle->wavelength,
                                                                   settings->speckle_roughness);
    speckle->seed = settings->speckle_seed;
    speckle->exposure = settings->speckle_exposure;
    return MCV_OK;
}

static mcv_result add_to_channels(const subpixels *laser, const mcv_speckle *speckle,
                                  mcv_image *light, mcv_error *error) {
    const mcv_image *own = &laser->exr->parts[0].image;
    const size_t plane = (size_t)light->width * light->height,
                 fine = (size_t)own->width * own->height;
    for (uint32_t channel = 0; channel < light->channels; ++channel) {
        const float *from = own->pixels + channel * fine;
        float *to = light->pixels + channel * plane;
        double sum = 0;
        for (size_t i = 0; i < fine; ++i) sum += (double)from[i];
        if (!(sum > 0)) continue;
        MCV_TRY(mcv_speckle_add(speckle, from, laser->q, light->width, light->height, to, error));
        /* The render's own error may take dark places below 0. */
        for (size_t i = 0; i < plane; ++i) to[i] = fmaxf(to[i], 0);
    }
    return MCV_OK;
}

mcv_result mcv_camera_add_speckle(const mcv_camera_settings *settings, const char *path,
                                  mcv_exr *exr, double *contrast, mcv_error *error) {
    mcv_exr file = {0};
    const mcv_exr *picture = settings->speckle_light ? settings->speckle_light : &file;
    mcv_speckle speckle = {0};
    mcv_surface_noise surface;
    mcv_mask mask;
    double size[2];
    *contrast = 0;
    if (!settings->speckle) return MCV_OK;
    if (picture == &file) MCV_TRY(mcv_exr_read(settings->speckle, &file, error));
    subpixels laser = {.path = settings->speckle, .exr = picture};
    mcv_result result = check_light(&laser, path, exr, error);
    if (result == MCV_OK)
        result = describe(settings, path, exr, picture, &speckle, &mask, size, error);
    if (result == MCV_OK) result = check_grid(&laser, path, exr, &speckle, size, error);
    if (result == MCV_OK && find_surface(path, exr, picture, &speckle, &surface))
        speckle.surface = &surface;
    for (int i = 0; result == MCV_OK && i < 2; ++i) speckle.pitch[i] = size[i] / laser.q;
    if (result == MCV_OK) result = add_to_channels(&laser, &speckle, &exr->parts[0].image, error);
    mcv_exr_free(&file);
    *contrast =
        sqrt((1 + speckle.polarization * speckle.polarization) / 2 / fmax(speckle.patterns, 1));
    return result;
}
