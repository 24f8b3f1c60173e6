/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi lightfield` makes. */
#ifndef MCVISI_HOST_VERBS_LIGHTFIELD_H
#define MCVISI_HOST_VERBS_LIGHTFIELD_H

#include "analysis/lightfield_file.h"
#include "options/command.h"
#include "verbs/report.h"

/* Parts of a gradient of an image that states its errors. */
#define MCV_GRADIENT_FLOOR "noise floor"
#define MCV_GRADIENT_RATIO "gradient over floor"

/* The words of --form. */
extern const char *const mcv_emd_forms[2];

/* Where to: by the options "output" and "png". One may be NULL, or both: no file. */
typedef struct mcv_processed_files {
    const char *exr, *png;
} mcv_processed_files;

/* MCV_USAGE for names that do not say what to write, or that are the image itself. */
mcv_result mcv_processed_plan(const mcv_command *command, mcv_processed_files *out,
                              mcv_error *error);

/* lightfield_files.c: writes them. */
mcv_result mcv_views_write(const mcv_light_field_file *file, const mcv_processed_files *out,
                           const mcv_exr *views, mcv_error *error);
mcv_result mcv_gradient_write(const mcv_command *command, const mcv_processed_files *out,
                              const mcv_exr *gradient, mcv_error *error);

/* Tells of them. `gradient`: its picture and the seconds that it took; NULL for views. */
void mcv_processed_report(const mcv_command *command, const mcv_light_field_file *file,
                          const mcv_processed_files *out, const mcv_exr *gradient, double seconds,
                          mcv_report *r);

/* Views and gradient with the attributes of what they were made from that still hold. */
mcv_result mcv_views_make(const mcv_light_field_file *file, mcv_exr *views, mcv_error *error);
mcv_result mcv_gradient_make(const mcv_command *command, const mcv_light_field_file *file,
                             mcv_exr *gradient, mcv_error *error);

#endif
