/* SPDX-License-Identifier: Apache-2.0 */
/* Every vertex of given rays' paths, as a table. */
#include "verbs/trace.h"

#include "core/basics.h"

#include "reference/reference.h"
#include "scene/geometry.h"

#include <stdio.h>
#include <stdlib.h>

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
        if (v->primitive != MCV_NONE) {
            fprintf(out, "%u,", v->primitive);
            print_name(out, scene->instances[mcv_scene_instance_of(scene, v->primitive)].name);
        } else {
            fputc(',', out);
        }
        fputc('\n', out);
    }
}

static mcv_result write_table(const mcv_scene *scene, const mcv_vertex *vertices, size_t count,
                              char **text, size_t *size, mcv_error *error) {
    *text = NULL;
    FILE *memory = open_memstream(text, size);
    if (memory) print_vertices(memory, scene, vertices, count);
    if (mcv_text_close(memory, text)) return MCV_OK;
    return mcv_fail(error, MCV_FAILED, "%s: no memory for %zu vertices", scene->path, count);
}

mcv_result mcv_trace_table(const mcv_command *command, const mcv_scene *scene,
                           const mcv_trace_ray *rays, size_t ray_count, char **text, size_t *size,
                           mcv_error *error) {
    mcv_render_options options = mcv_render_defaults();
    mcv_vertex *vertices = NULL;
    size_t count = 0;
    options.depth = (uint32_t)command->depth;
    options.threads = (uint32_t)command->threads;
    options.device = command->device;
    MCV_TRY(mcv_precision_read(command, &options.precision, error));
    mcv_result result = (mcv_wants_reference(command) ? mcv_reference_trace : mcv_trace)(
        scene, rays, ray_count, &options, &vertices, &count, error);
    if (result == MCV_OK) result = write_table(scene, vertices, count, text, size, error);
    free(vertices);
    return result;
}
