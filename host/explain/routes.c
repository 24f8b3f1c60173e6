/* SPDX-License-Identifier: Apache-2.0 */
#include "explain/routes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check/find.h"
#include "core/basics.h"

static const char *const way_words[] = {
#define MCV_X(WAY, word) word,
    MCV_WAYS(MCV_X)
#undef MCV_X
};

static uint32_t kept_surfaces(const mcv_contribution *c) {
    return c->surface_count < MCV_PATH_SURFACES ? c->surface_count : MCV_PATH_SURFACES;
}

/* Whether the path is scattered by the same surface as before. */
static bool scatters_again(const mcv_contribution *c, uint32_t i) {
    if (i == 0 || i >= MCV_PATH_SURFACES) return false;
    return c->surfaces[i].way == MCV_WAY_SCATTERS && c->surfaces[i - 1].way == MCV_WAY_SCATTERS &&
           c->surfaces[i].instance == c->surfaces[i - 1].instance;
}

/* The next surface of the route from i on. */
static uint32_t next_surface(const mcv_contribution *c, uint32_t i) {
    while (i < kept_surfaces(c) && scatters_again(c, i)) ++i;
    return i;
}

/* Surfaces beyond those that are kept are not told apart. */
static bool same_route(const mcv_contribution *a, const mcv_contribution *b) {
    const uint32_t a_count = kept_surfaces(a), b_count = kept_surfaces(b);
    uint32_t i = 0, j = 0;
    while (i < a_count && j < b_count && a->surfaces[i].instance == b->surfaces[j].instance &&
           a->surfaces[i].way == b->surfaces[j].way) {
        i = next_surface(a, i + 1);
        j = next_surface(b, j + 1);
    }
    return a->emitter == b->emitter && i == a_count && j == b_count;
}

static uint64_t hash_of(const mcv_contribution *c) {
    uint64_t hash = mcv_hash_bytes(MCV_HASH_BEGIN, &c->emitter, sizeof c->emitter);
    for (uint32_t i = 0; i < kept_surfaces(c); i = next_surface(c, i + 1)) {
        hash = mcv_hash_bytes(hash, &c->surfaces[i].instance, sizeof c->surfaces[i].instance);
        hash = mcv_hash_bytes(hash, &c->surfaces[i].way, sizeof c->surfaces[i].way);
    }
    return hash;
}

static double brightness(const mcv_contribution *c) {
    return (c->value[0] + c->value[1] + c->value[2]) / 3;
}

/* Room for one more route, up to MCV_MOST_ROUTES. */
static bool make_room(mcv_routes *r) {
    if (!r->slots) r->slots = calloc(2 * MCV_MOST_ROUTES, sizeof *r->slots);
    if (r->count == r->capacity) {
        const size_t capacity = r->capacity > 0 ? 2 * r->capacity : 64;
        mcv_route *items = realloc(r->items, capacity * sizeof *items);
        if (!items) return false;
        r->items = items;
        r->capacity = capacity;
    }
    return r->slots;
}

/* Adds light to a pixel's sum. Where all places are taken, the faintest pixel leaves its own, and
 * its sum stays as a doubt: pixels that bring more than one of MCV_ROUTE_PIXELS parts are found
 * (space saving: Metwally, Agrawal, El Abbadi, Efficient computation of frequent and top-k elements
 * in data streams, ICDT 2005). */
static void add_pixel(mcv_route *route, const mcv_contribution *c) {
    mcv_route_pixel *to = route->pixels;
    if (!c->has_pixel) return;
    for (int i = 0; i < MCV_ROUTE_PIXELS; ++i) {
        mcv_route_pixel *at = route->pixels + i;
        if (at->sum > 0 && at->pixel[0] == c->pixel[0] && at->pixel[1] == c->pixel[1]) {
            at->sum += brightness(c);
            return;
        }
        if (at->sum < to->sum) to = at;
    }
    to->doubtful = to->sum;
    to->sum += brightness(c);
    memcpy(to->pixel, c->pixel, sizeof to->pixel);
}

const mcv_route_pixel *mcv_route_brightest(const mcv_route *route, double *share) {
    const mcv_route_pixel *best = route->pixels;
    double all = 0;
    for (int i = 1; i < MCV_ROUTE_PIXELS; ++i)
        if (route->pixels[i].sum > best->sum) best = route->pixels + i;
    for (int r = 0; r < MCV_ROUTE_REPLICATES; ++r) all += route->sums[r];
    *share = (best->sum - best->doubtful) / all;
    return best->sum > 0 ? best : NULL;
}

/* The contribution's route; NULL without memory. */
static mcv_route *find_route(mcv_routes *r, const mcv_contribution *c) {
    const uint64_t hash = hash_of(c);
    const size_t mask = 2 * MCV_MOST_ROUTES - 1;
    if (!make_room(r)) return NULL;
    size_t slot = (size_t)(hash ^ hash >> 32) & mask;
    for (; r->slots[slot] > 0; slot = (slot + 1) & mask) {
        mcv_route *route = r->items + r->slots[slot] - 1;
        if (route->hash != hash || !same_route(&route->strongest, c)) continue;
        if (brightness(c) > brightness(&route->strongest)) route->strongest = *c;
        return route;
    }
    if (r->count == MCV_MOST_ROUTES) return &r->others;
    r->items[r->count] = (mcv_route){.strongest = *c, .hash = hash};
    r->slots[slot] = (uint32_t)++r->count;
    return r->items + r->count - 1;
}

void mcv_routes_add(void *user, const mcv_contribution *contribution) {
    mcv_routes *r = user;
    mcv_route *route = find_route(r, contribution);
    r->failed = r->failed || !route;
    if (!route) return;
    route->sums[contribution->replicate] += brightness(contribution);
    add_pixel(route, contribution);
}

static int by_value(const void *a, const void *b) {
    const mcv_route *x = a, *y = b;
    if (x->value != y->value) return x->value < y->value ? 1 : -1;
    return (x->hash > y->hash) - (x->hash < y->hash);
}

/* The standard error of the mean of sums[r] - share * whole[r], per sample. */
static double error_of(const double *sums, double share, const double *whole, double mean,
                       double samples) {
    double squares = 0;
    for (int r = 0; r < MCV_ROUTE_REPLICATES; ++r) {
        const double residual = (sums[r] - share * whole[r]) / samples - mean;
        squares += residual * residual;
    }
    return sqrt(squares / (MCV_ROUTE_REPLICATES - 1) / MCV_ROUTE_REPLICATES);
}

mcv_result mcv_routes_finish(mcv_routes *routes, uint64_t samples, mcv_error *error) {
    double whole[MCV_ROUTE_REPLICATES] = {0};
    if (routes->failed) return mcv_fail(error, MCV_FAILED, "no memory for the routes of a pixel");
    for (int r = 0; r < MCV_ROUTE_REPLICATES; ++r) {
        whole[r] = routes->others.sums[r];
        routes->others_value += routes->others.sums[r] / ((double)samples * MCV_ROUTE_REPLICATES);
    }
    routes->value = routes->others_value;
    for (size_t i = 0; i < routes->count; ++i) {
        mcv_route *route = routes->items + i;
        for (int r = 0; r < MCV_ROUTE_REPLICATES; ++r) {
            whole[r] += route->sums[r];
            route->value += route->sums[r] / ((double)samples * MCV_ROUTE_REPLICATES);
        }
        routes->value += route->value;
    }
    if (!(routes->value > 0)) return MCV_OK;
    routes->value_error = error_of(whole, 0, whole, routes->value, (double)samples);
    for (size_t i = 0; i < routes->count; ++i) {
        mcv_route *route = routes->items + i;
        route->share = route->value / routes->value;
        /* Of a ratio of means, to first order. */
        route->share_error =
            error_of(route->sums, route->share, whole, 0, (double)samples) / routes->value;
    }
    if (routes->count > 0) qsort(routes->items, routes->count, sizeof *routes->items, by_value);
    return MCV_OK;
}

char *mcv_route_words(const mcv_scene *scene, uint32_t sensor, const mcv_route *route) {
    char *text = NULL, label[MCV_LABEL];
    size_t size = 0;
    const mcv_contribution *c = &route->strongest;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    fprintf(out, "%s", scene->sensors[sensor].name[0] ? scene->sensors[sensor].name : "camera");
    for (uint32_t i = 0; i < kept_surfaces(c);) {
        const uint32_t instance = c->surfaces[i].instance, way = c->surfaces[i].way;
        const bool again = next_surface(c, i + 1) > i + 1;
        uint32_t times = 0;
        for (; i < kept_surfaces(c) && c->surfaces[i].instance == instance &&
               c->surfaces[i].way == way;
             ++i)
            ++times;
        fprintf(out, " <- %s %s", mcv_instance_label(scene, instance, label), way_words[way]);
        if (again)
            fputs(" once or more", out);
        else if (times > 1)
            fprintf(out, " %u times", times);
    }
    if (c->surface_count > MCV_PATH_SURFACES) fprintf(out, " <- …");
    const char *name = scene->emitters[c->emitter].name;
    fprintf(out, " <- emitter \"%s\"", name ? name : "");
    (void)mcv_text_close(out, &text);
    return text;
}

void mcv_routes_free(mcv_routes *routes) {
    free(routes->items);
    free(routes->slots);
    *routes = (mcv_routes){0};
}
