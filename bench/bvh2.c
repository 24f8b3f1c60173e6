/* SPDX-License-Identifier: Apache-2.0 */
#include "bvh2.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accel/split.h"

enum { HALVED_FROM = 64, SPARE_TENTHS = 3 /* as host/accel/bvh.c */ };

typedef struct maker {
    mcv_splitter splitter;
    bvh2 *made;
} maker;

static void make_leaf(const maker *m, const mcv_record *content, bvh2_node *node) {
    node->first = m->made->triangle_count;
    node->count = mcv_record_count(content);
    for (uint32_t i = content->begin; i < content->end; ++i) {
        bvh2_triangle *triangle = m->made->triangles + m->made->triangle_count++;
        triangle->number = m->splitter.references[i].triangle;
        const uint32_t *corners = m->splitter.indices + 3 * (size_t)triangle->number;
        for (int k = 0; k < 3; ++k) {
            triangle->corner[k] = m->splitter.positions[3 * (size_t)corners[0] + k];
            for (int e = 0; e < 2; ++e)
                triangle->edges[e][k] =
                    m->splitter.positions[3 * (size_t)corners[e + 1] + k] - triangle->corner[k];
        }
    }
}

static void make_node(const maker *m, const mcv_record *content, uint32_t level, uint32_t here) {
    bvh2_node *node = m->made->nodes + here;
    for (int k = 0; k < 3; ++k) {
        node->lower[k] = content->bounds.lower[k];
        node->upper[k] = content->bounds.upper[k];
    }
    if (mcv_record_count(content) <= BVH2_LEAF) {
        make_leaf(m, content, node);
        return;
    }
    mcv_record sides[2];
    mcv_record_split(&m->splitter, content, level >= HALVED_FROM, sides, sides + 1);
    node->count = 0;
    node->first = m->made->node_count;
    m->made->node_count += 2;
    const uint32_t first = node->first;
    for (uint32_t i = 0; i < 2; ++i) make_node(m, sides + i, level + 1, first + i);
}

mcv_result bvh2_build(const float *positions, const uint32_t *indices, uint32_t triangle_count,
                      bvh2 *made, mcv_error *error) {
    const uint32_t capacity = triangle_count + triangle_count / 10 * SPARE_TENTHS;
    maker m = {.splitter = {.positions = positions, .indices = indices, .threads = 1},
               .made = made};
    mcv_record all = mcv_record_empty(0, triangle_count, capacity);
    *made = (bvh2){.nodes = malloc(2 * (size_t)capacity * sizeof *made->nodes),
                   .triangles = malloc((size_t)capacity * sizeof *made->triangles),
                   .node_count = 1};
    m.splitter.references = malloc((size_t)capacity * sizeof *m.splitter.references);
    if (!made->nodes || !made->triangles || !m.splitter.references) {
        free(m.splitter.references);
        bvh2_free(made);
        return mcv_fail(error, MCV_FAILED, "no memory for a binary hierarchy");
    }
    for (uint32_t i = 0; i < triangle_count; ++i) {
        mcv_reference *r = m.splitter.references + i;
        *r = (mcv_reference){
            {INFINITY, INFINITY, INFINITY}, i, {-INFINITY, -INFINITY, -INFINITY}, 0};
        for (int corner = 0; corner < 3; ++corner) {
            for (int k = 0; k < 3; ++k) {
                const float p = positions[3 * (size_t)indices[3 * (size_t)i + corner] + k];
                r->lower[k] = fminf(r->lower[k], p);
                r->upper[k] = fmaxf(r->upper[k], p);
            }
        }
        mcv_record_add(&all, r);
    }
    m.splitter.root_area = mcv_box_area(&all.bounds);
    make_node(&m, &all, 0, 0);
    free(m.splitter.references);
    return MCV_OK;
}

void bvh2_free(bvh2 *b) {
    free(b->nodes);
    free(b->triangles);
    *b = (bvh2){0};
}

mcv_result bvh2_program(const mcv_cl *cl, cl_program *program, mcv_error *error) {
    /* A program of one line: the compiler finds the rest. */
    const char *source = "#include \"bvh2.cl\"\n";
    cl_int code;
    *program = clCreateProgramWithSource(cl->context, 1, &source, NULL, &code);
    MCV_TRY(mcv_cl_check(cl, code, "making a program", error));
    code = clBuildProgram(*program, 1, &cl->device,
                          "-cl-std=CL1.2 -I " MCV_SOURCE_DIR "/bench -I " MCV_SOURCE_DIR "/include",
                          NULL, NULL);
    if (code == CL_SUCCESS) return MCV_OK;
    char log[2048] = "";
    clGetProgramBuildInfo(*program, cl->device, CL_PROGRAM_BUILD_LOG, sizeof log - 1, log, NULL);
    return mcv_fail(error, MCV_DEVICE, "bench/bvh2.cl does not compile with %s:\n%s", cl->name,
                    log);
}
