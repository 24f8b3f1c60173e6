/* SPDX-License-Identifier: Apache-2.0 */
/* Frames of nodes that poses refer to. Each is found once, so that a chain of poses takes a time in
 * proportion to its length. */
#include "loader/loader.h"

#include "loader/validate.h"
#include "scene/transform.h"

#include <stdlib.h>

typedef struct named_node {
    const char *name;
    uint32_t index;
} named_node;

typedef struct known_frame {
    enum { UNKNOWN, BEING_FOUND, KNOWN } state;
    int steps; /* targets and parents that it follows from */
    mcv_transform transform;
} known_frame;

struct mcv_frames {
    size_t count;
    uint32_t *parents; /* or MCV_NONE */
    named_node *names; /* by name, then by index */
    known_frame *known;
    int depth; /* that the last frame was found at, with all that it follows from */
};

void mcv_load_free_frames(mcv_loader *loader) {
    if (!loader->frames) return;
    free(loader->frames->parents);
    free(loader->frames->names);
    free(loader->frames->known);
    free(loader->frames);
}

static int by_name(const void *a, const void *b) {
    const named_node *x = a, *y = b;
    const int order = strcmp(x->name, y->name);
    return order ? order : (x->index > y->index) - (x->index < y->index);
}

/* Makes the tables of parents and names for the first target that is a node. */
static mcv_result need_frames(mcv_loader *loader, mcv_error *error) {
    const json_t *nodes = json_object_get(loader->root, "nodes");
    const size_t count = json_array_size(nodes);
    if (loader->frames) return MCV_OK;
    struct mcv_frames *frames = calloc(1, sizeof *frames);
    if (!frames) return mcv_fail_memory(&loader->file, error);
    loader->frames = frames;
    frames->count = count;
    frames->parents = malloc((count + 1) * sizeof *frames->parents);
    frames->names = malloc((count + 1) * sizeof *frames->names);
    frames->known = calloc(count + 1, sizeof *frames->known);
    if (!frames->parents || !frames->names || !frames->known) {
        mcv_load_free_frames(loader);
        loader->frames = NULL;
        return mcv_fail_memory(&loader->file, error);
    }
    for (size_t i = 0; i < count; ++i) frames->parents[i] = MCV_NONE;
    for (size_t i = 0; i < count; ++i) {
        const json_t *node = json_array_get(nodes, i),
                     *children = json_object_get(node, "children");
        frames->names[i] = (named_node){mcv_json_name(node), (uint32_t)i};
        for (size_t k = 0; k < json_array_size(children); ++k)
            frames->parents[(size_t)json_number_value(json_array_get(children, k))] = (uint32_t)i;
    }
    qsort(frames->names, count, sizeof *frames->names, by_name);
    return MCV_OK;
}

mcv_result mcv_load_find_node(mcv_loader *loader, const char *name, uint32_t *index,
                              const mcv_json_path *place, mcv_error *error) {
    MCV_TRY(need_frames(loader, error));
    const named_node *names = loader->frames->names;
    size_t first = 0, end = loader->frames->count;
    while (first < end) {
        const size_t middle = first + (end - first) / 2;
        if (strcmp(names[middle].name, name) < 0)
            first = middle + 1;
        else
            end = middle;
    }
    const size_t left = loader->frames->count - first;
    if (left == 0 || strcmp(names[first].name, name) != 0)
        return mcv_fail_at(place, error, "there is no node \"%s\"", name);
    if (left > 1 && strcmp(names[first + 1].name, name) == 0)
        return mcv_fail_at(place, error, "the name \"%s\" is ambiguous: use the index %u or %u",
                           name, names[first].index, names[first + 1].index);
    *index = names[first].index;
    return MCV_OK;
}

/* Finds the frame of a node that is not known, or that lies too deep. */
static mcv_result find_frame(mcv_loader *loader, uint32_t index, int depth, const json_t *node,
                             mcv_transform *transform, const mcv_json_path *here,
                             mcv_error *error) {
    bool posed;
    MCV_TRY(mcv_load_pose(loader, node, depth, &posed, transform, here, error));
    if (!posed) MCV_TRY(mcv_load_local(node, transform, here, error));
    const uint32_t parent = loader->frames->parents[index];
    if (posed || parent == MCV_NONE) return MCV_OK;
    mcv_transform outer;
    MCV_TRY(mcv_load_transform(loader, parent, depth + 1, &outer, error));
    *transform = mcv_transform_compose(&outer, transform);
    return MCV_OK;
}

mcv_result mcv_load_transform(mcv_loader *loader, uint32_t index, int depth,
                              mcv_transform *transform, mcv_error *error) {
    const json_t *node = json_array_get(json_object_get(loader->root, "nodes"), index);
    const mcv_json_path place = mcv_json_path_key(&loader->file, "nodes"),
                        here = mcv_json_path_element(&place, mcv_json_name(node), index);
    MCV_TRY(need_frames(loader, error));
    struct mcv_frames *frames = loader->frames;
    known_frame *known = frames->known + index;
    if (known->state == BEING_FOUND)
        return mcv_fail_at(&here, error,
                           "its place follows from itself: a target of a pose leads back to it");
    if (depth > MCV_NODE_DEPTH)
        return mcv_fail_at(&here, error,
                           "its place follows from more than %d targets and parents: break the "
                           "circle of poses, or shorten the chain",
                           MCV_NODE_DEPTH);
    /* One that lies too deep is followed again, to the node that the sentence names. */
    if (known->state == KNOWN && depth + known->steps <= MCV_NODE_DEPTH) {
        *transform = known->transform;
        frames->depth = depth + known->steps;
        return MCV_OK;
    }
    frames->depth = depth;
    known->state = BEING_FOUND;
    const mcv_result result = find_frame(loader, index, depth, node, transform, &here, error);
    if (result != MCV_OK) {
        known->state = UNKNOWN;
        return result;
    }
    *known = (known_frame){KNOWN, frames->depth - depth, *transform};
    return MCV_OK;
}
