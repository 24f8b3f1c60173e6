/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi trace: all vertices of the paths of given rays, as a table. */
#include "cli/command.h"
#include "cli/rays.h"
#include "cli/report.h"
#include "core/output_file.h"
#include "reference/reference.h"
#include "loader/load.h"
#include "scene/geometry.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const events[] = {
#define MCV_X(NAME, word) word,
    MCV_EVENTS(MCV_X)
#undef MCV_X
};

/* Prints a name as one field of the table: in quotes, with inner quotes doubled. */
static void print_name(FILE *out, const char *name) {
    fputc('"', out);
    for (; *name; ++name) fprintf(out, *name == '"' ? "\"\"" : "%c", *name);
    fputc('"', out);
}

static void print_vertices(FILE *out, const mcv_scene *scene, const mcv_vertex *vertices,
                           size_t count) {
    fputs("ray,vertex,event,x [m],y [m],z [m],nx,ny,nz,dx,dy,dz,distance "
          "[m],ior,transmittance,radiance/n^2 [W/(m^2 sr)],triangle,node\n",
          out);
    for (const mcv_vertex *v = vertices; v < vertices + count; ++v) {
        fprintf(out, "%u,%u,%s", v->ray, v->index, events[v->event]);
        for (int k = 0; k < 3; ++k) fprintf(out, ",%.17g", v->position[k]);
        for (int k = 0; k < 3; ++k) fprintf(out, ",%.17g", v->normal[k]);
        for (int k = 0; k < 3; ++k) fprintf(out, ",%.17g", v->direction[k]);
        fprintf(out, ",%.17g,%.17g,%.17g,%.17g,", v->distance, v->ior, v->transmittance,
                v->radiance);
        if (v->triangle != MCV_NONE) {
            fprintf(out, "%u,", v->triangle);
            print_name(out, scene->instances[mcv_scene_instance_of(scene, v->triangle)].name);
        } else {
            fputc(',', out);
        }
        fputc('\n', out);
    }
}

static mcv_result write_vertices(const char *path, const mcv_scene *scene,
                                 const mcv_vertex *vertices, size_t count, mcv_error *error) {
    char *text = NULL;
    size_t size = 0;
    mcv_output output;
    if (!path) {
        print_vertices(stdout, scene, vertices, count);
        return MCV_OK;
    }
    FILE *memory = open_memstream(&text, &size);
    if (memory) print_vertices(memory, scene, vertices, count);
    if (!memory || fclose(memory) != 0) {
        free(text);
        return mcv_fail(error, MCV_FAILED, "%s: no memory for %zu vertices", path, count);
    }
    mcv_result result = mcv_output_open(&output, path, error);
    if (result == MCV_OK) {
        result = mcv_output_write(&output, text, size, error);
        if (result == MCV_OK)
            result = mcv_output_commit(&output, error);
        else
            mcv_output_discard(&output);
    }
    free(text);
    return result;
}

mcv_result mcv_verb_trace(const mcv_command *command, mcv_error *error) {
    mcv_scene *scene;
    mcv_trace_ray *rays;
    size_t ray_count;
    mcv_vertex *vertices = NULL;
    size_t vertex_count = 0;
    mcv_render_options options = mcv_render_defaults();
    if (!command->rays)
        return mcv_fail(error, MCV_USAGE, "--rays is missing: give a table of rays x,y,z,dx,dy,dz");
    options.depth = (uint32_t)command->depth;
    options.threads = (uint32_t)command->threads;
    options.device = command->device;
    MCV_TRY(mcv_precision_read(command, &options.precision, error));
    if (command->paths) MCV_TRY(mcv_output_check(command->paths, error));
    MCV_TRY(mcv_rays_read(command->rays, &rays, &ray_count, error));
    mcv_result result = mcv_scene_load(
        command->argument, (mcv_overrides){command->set.items, command->set.count}, &scene, error);
    if (result == MCV_OK) {
        const bool reference = mcv_wants_reference(command);
        for (uint32_t i = 0; i < scene->warning_count; ++i) mcv_tell("warning", scene->warnings[i]);
        result = (reference ? mcv_reference_trace : mcv_trace)(scene, rays, ray_count, &options,
                                                               &vertices, &vertex_count, error);
        if (result == MCV_OK)
            result = write_vertices(command->paths, scene, vertices, vertex_count, error);
        free(vertices);
        mcv_scene_free(scene);
    }
    free(rays);
    return result;
}
