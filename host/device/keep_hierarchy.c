/* SPDX-License-Identifier: Apache-2.0 */
#include "device/keep_hierarchy.h"

#include <stdlib.h>

/* A structure that has become more costly by this factor is built anew. */
static const double worth_building = 1.2;

static void take(mcv_device_scene *kept, mcv_device_scene *d) {
    d->nodes = kept->nodes;
    d->leaves = kept->leaves;
    d->node_count = kept->node_count;
    d->leaf_count = kept->leaf_count;
    d->kept_structure = true;
    kept->nodes = kept->leaves = NULL;
}

/* The structure of the previous scene in the host's memory. */
static mcv_result read_back(mcv_cl *cl, mcv_device_scene *kept, mcv_bvh *bvh, mcv_error *error) {
    *bvh = (mcv_bvh){.node_count = kept->node_count, .leaf_count = kept->leaf_count};
    const size_t nodes = bvh->node_count * sizeof *bvh->nodes,
                 leaves = bvh->leaf_count * sizeof *bvh->leaves;
    bvh->nodes = aligned_alloc(128, (nodes + 127) / 128 * 128);
    bvh->leaves = aligned_alloc(128, (leaves + 127) / 128 * 128);
    mcv_result result =
        bvh->nodes && bvh->leaves
            ? MCV_OK
            : mcv_fail(error, MCV_FAILED, "no memory to keep the acceleration structure");
    if (result == MCV_OK) result = mcv_cl_read(cl, kept->nodes, 0, nodes, bvh->nodes, error);
    if (result == MCV_OK && leaves)
        result = mcv_cl_read(cl, kept->leaves, 0, leaves, bvh->leaves, error);
    if (result != MCV_OK) mcv_bvh_free(bvh);
    if (result == MCV_OK && kept->structure_cost == 0) kept->structure_cost = mcv_bvh_cost(bvh);
    return result;
}

static bool is_good(const mcv_bvh *bvh, const mcv_device_scene *kept) {
    return bvh->nodes && mcv_bvh_cost(bvh) <= worth_building * kept->structure_cost;
}

/* Refits the structure to the moved triangles. */
static mcv_result move(mcv_cl *cl, mcv_device_scene *kept, mcv_device_scene *d, mcv_error *error) {
    mcv_bvh bvh;
    MCV_TRY(read_back(cl, kept, &bvh, error));
    mcv_result result = mcv_bvh_refit(&bvh, d->packed.positions, d->packed.indices, error);
    if (result == MCV_OK && is_good(&bvh, kept)) {
        result =
            mcv_cl_write(cl, kept->nodes, 0, bvh.node_count * sizeof *bvh.nodes, bvh.nodes, error);
        if (result == MCV_OK)
            result = mcv_cl_write(cl, kept->leaves, 0, bvh.leaf_count * sizeof *bvh.leaves,
                                  bvh.leaves, error);
        if (result == MCV_OK) take(kept, d);
    }
    mcv_bvh_free(&bvh);
    return result;
}

/*
 * Builds what is new. All scenes of a sweep are made from the structure of one of them: made from
 * the scene before, each would hang below the last, and rays would pass what many have left behind.
 */
static mcv_result change(mcv_cl *cl, mcv_device_scene *kept, uint32_t threads, mcv_device_scene *d,
                         mcv_bvh *changed, mcv_error *error) {
    if (!d->base.bvh.nodes) {
        mcv_bvh bvh;
        MCV_TRY(read_back(cl, kept, &bvh, error));
        MCV_TRY(mcv_bvh_base_make(&bvh, kept->packed.triangle_count, &d->base, error));
    }
    MCV_TRY(mcv_bvh_update(&d->base, d->packed.positions, d->packed.indices,
                           d->packed.triangle_count, threads, changed, error));
    if (is_good(changed, kept)) return MCV_OK;
    mcv_bvh_free(changed);
    mcv_bvh_base_free(&d->base);
    return MCV_OK;
}

mcv_result mcv_keep_hierarchy(mcv_cl *cl, mcv_device_scene *kept, uint32_t threads,
                              mcv_device_scene *device, mcv_bvh *changed, mcv_error *error) {
    const mcv_packed *p = &device->packed;
    device->contents[MCV_BUFFER_positions] =
        mcv_digest_of(p->positions, 12 * (size_t)p->vertex_count);
    device->indices_digest = mcv_digest_of(p->indices, 12 * (size_t)p->triangle_count);
    if (!kept || !kept->nodes || p->moves || kept->packed.moves) return MCV_OK;
    device->base = kept->base;
    kept->base = (mcv_bvh_base){0};
    if (mcv_digest_same(&kept->indices_digest, &device->indices_digest)) {
        if (mcv_digest_same(kept->contents + MCV_BUFFER_positions,
                            device->contents + MCV_BUFFER_positions))
            take(kept, device);
        else
            MCV_TRY(move(cl, kept, device, error));
    }
    if (!device->kept_structure) MCV_TRY(change(cl, kept, threads, device, changed, error));
    if (device->kept_structure || changed->nodes) device->structure_cost = kept->structure_cost;
    return MCV_OK;
}
