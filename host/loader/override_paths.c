/* SPDX-License-Identifier: Apache-2.0 */
/* The paths that --set takes and that a document has. */
#include "loader/overrides.h"

#include <stdio.h>
#include <string.h>

enum { LONGEST = 1024, DEEPEST = 8 };

typedef struct listing {
    json_t *list;
    const char *collection;
    char element[LONGEST]; /* by name, or by index where the name is no path to it */
} listing;

static void add(listing *l, const char *path) {
    json_array_append_new(l->list, json_sprintf("%s/%s/%s", l->collection, l->element,
                                                mcv_overrides_shorten(l->collection, path)));
}

/* Paths end at what is no object. */
static void list_below(listing *l, const json_t *object, const char *path, int depth) {
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)object, key, value) {
        char longer[LONGEST];
        if (depth == 0 && strcmp(key, "name") == 0) continue;
        if (snprintf(longer, sizeof longer, "%s%s%s", path, path[0] ? "/" : "", key) >= LONGEST)
            continue;
        if (json_is_object(value) && depth < DEEPEST)
            list_below(l, value, longer, depth + 1);
        else if (!json_is_object(value))
            add(l, longer);
    }
}

static bool is_unique(const json_t *array, const char *name) {
    size_t count = 0, i;
    const json_t *element;
    json_array_foreach((json_t *)array, i, element) {
        count += strcmp(mcv_json_name(element), name) == 0;
    }
    return count == 1;
}

static void list_collection(json_t *list, const json_t *array, const char *collection) {
    size_t i;
    const json_t *element;
    listing l = {.list = list, .collection = collection};
    json_array_foreach((json_t *)array, i, element) {
        const char *name = mcv_json_name(element);
        if (name[0] && strlen(name) < LONGEST && is_unique(array, name))
            snprintf(l.element, sizeof l.element, "%s", name);
        else
            snprintf(l.element, sizeof l.element, "%zu", i);
        list_below(&l, element, "", 0);
    }
}

json_t *mcv_overrides_paths(const json_t *root) {
    static const struct {
        const char *collection, *extension;
    } collections[] = {{"sensors", "MCVISI_sensors"},
                       {"emitters", "MCVISI_emitters"},
                       {"assets", "MCVISI_assets"},
                       {"materials", NULL},
                       {"nodes", NULL},
                       {"cameras", NULL},
                       {"lights", "KHR_lights_punctual"},
                       {"surfaces", "MCVISI_surfaces"},
                       {"defects", "MCVISI_defects"}};
    json_t *list = json_array();
    for (size_t i = 0; list && i < sizeof collections / sizeof collections[0]; ++i) {
        const json_t *in =
            collections[i].extension ? mcv_json_extension(root, collections[i].extension) : root;
        list_collection(list, json_object_get(in, collections[i].collection),
                        collections[i].collection);
    }
    return list;
}
