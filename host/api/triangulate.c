/* SPDX-License-Identifier: Apache-2.0 */
/* Laser lines of the public interface: profiles of images. */
#include "api/handles.h"
#include "core/basics.h"
#include "verbs/calibrate.h"

static mcv_result add_all(mcv_profiles *profiles, mcv_texts images, mcv_error *error) {
    for (size_t i = 0; i < images.count; ++i) {
        mcv_picture *picture = NULL;
        MCV_TRY(mcv_picture_read(images.items[i], &picture, error));
        const mcv_result result = mcv_profiles_add(profiles, picture, error);
        mcv_picture_free(picture);
        MCV_TRY(result);
    }
    MCV_TRY(mcv_light_plane_write(profiles, error));
    return mcv_profiles_write(profiles, error);
}

static mcv_result triangulate_with(const mcv_command *command, mcv_texts images, char **report,
                                   mcv_error *error) {
    mcv_profiles profiles;
    mcv_report r;
    mcv_result result = mcv_profiles_begin(command, images, &profiles, error);
    if (result == MCV_OK) result = add_all(&profiles, images, error);
    if (result == MCV_OK && report) {
        result = mcv_report_keep(&r, command->json, error);
        if (result == MCV_OK) {
            mcv_profiles_report(&profiles, &r);
            result = mcv_report_take(&r, report, error);
        } else {
            mcv_report_free(&r);
        }
    }
    mcv_profiles_free(&profiles);
    return result;
}

static mcv_result triangulate(mcv_texts images, const char *options, char **report,
                              mcv_error *error) {
    mcv_options_given given;
    const char *const arguments[2] = {images.items[0]};
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_TRIANGULATE, arguments, NULL, &given, error));
    const mcv_result result = triangulate_with(&given.command, images, report, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_images_triangulate(const char *const *images, size_t count, const char *options,
                                  char **report, mcv_error *error) {
    mcv_result result;
    if (report) *report = NULL;
    MCV_NEED(images);
    for (size_t i = 0; i < count; ++i) MCV_NEED(images[i]);
    if (count == 0) return mcv_fail(error, MCV_USAGE, "there are no images of a laser line");
    MCV_INSIDE(result, triangulate((mcv_texts){images, count}, options, report, error));
    return result;
}
