/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi trace: all vertices of the paths of given rays, as a table. */
#include "cli/tell.h"
#include "cli/verbs.h"
#include "core/output_file.h"
#include "loader/load.h"
#include "cli/rays.h"
#include "verbs/trace.h"

#include <stdio.h>
#include <stdlib.h>

static mcv_result trace(const mcv_command *command, const mcv_scene *scene,
                        const mcv_trace_ray *rays, size_t count, mcv_error *error) {
    char *text;
    size_t size;
    MCV_TRY(mcv_trace_table(command, scene, rays, count, &text, &size, error));
    mcv_result result = MCV_OK;
    if (command->paths)
        result = mcv_output_whole(command->paths, text, size, error);
    else
        fwrite(text, 1, size, stdout);
    free(text);
    return result;
}

mcv_result mcv_verb_trace(const mcv_command *command, mcv_error *error) {
    mcv_scene *scene;
    mcv_trace_ray *rays;
    size_t ray_count;
    uint32_t precision;
    if (!command->rays)
        return mcv_fail(error, MCV_USAGE, "--rays is missing: give a table of rays x,y,z,dx,dy,dz");
    MCV_TRY(mcv_precision_read(command, &precision, error));
    if (command->paths) MCV_TRY(mcv_output_check(command->paths, error));
    MCV_TRY(mcv_rays_read(command->rays, &rays, &ray_count, error));
    mcv_result result = mcv_scene_load(
        command->argument, (mcv_overrides){command->set.items, command->set.count}, &scene, error);
    if (result == MCV_OK) {
        for (uint32_t i = 0; i < scene->warning_count; ++i) mcv_tell("warning", scene->warnings[i]);
        result = trace(command, scene, rays, ray_count, error);
        mcv_scene_free(scene);
    }
    free(rays);
    return result;
}
