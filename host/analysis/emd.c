/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/emd.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/*
 * A spanning tree of the flow network: sources, sinks and an artificial root, which takes from
 * sources and gives to sinks at a cost that the best plan does not pay. Every arc leaves a source
 * (or the root) for a sink (or the root), so the arc between a node and its parent runs upwards for
 * a source and downwards for a sink.
 */
typedef struct node {
    int32_t parent, first_child, next, previous; /* siblings form a list; -1: none */
    int32_t depth;
    int32_t
        bin; /* -1: the left-over of the larger histogram, which moves for nothing; and the root */
    int64_t flow;     /* on the arc to the parent */
    double potential; /* π_head = π_tail + c along the tree's arcs */
} node;

struct mcv_emd {
    uint32_t bins;
    double max_cost;
    double *costs;      /* [bin][bin] */
    double *difference; /* Q - P of each bin */
    double *arcs;       /* [source][sink], the costs of this pair */
    double *sinks;      /* potentials of the sinks, side by side for pricing */
    node *nodes;        /* sources, then sinks, then the root */
    double *potential;  /* of each bin: the certificate where the caller wants none */
    int32_t source_count, sink_count;
};

mcv_result mcv_emd_new(mcv_emd **emd, uint32_t columns, uint32_t rows, mcv_error *error) {
    *emd = NULL;
    if (columns == 0 || rows == 0 || (uint64_t)columns * rows > MCV_EMD_MAX_BINS)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "Earth Mover's Distance of %u x %u bins: must be 1 to %d bins", columns,
                        rows, MCV_EMD_MAX_BINS);
    const size_t bins = (size_t)columns * rows;
    const size_t nodes =
        bins + 2; /* each bin is a source, a sink or neither; the left-over, the root */
    const size_t arcs = (bins + 1) * (bins + 1) / 4; /* sources times sinks of bins + 1 nodes */
    mcv_emd *e = calloc(1, sizeof *e);
    if (e) {
        e->bins = (uint32_t)bins;
        e->costs = malloc(bins * bins * sizeof *e->costs);
        e->difference = malloc(bins * sizeof *e->difference);
        e->potential = malloc(bins * sizeof *e->potential);
        e->arcs = malloc((arcs + 1) * sizeof *e->arcs);
        e->sinks = malloc(nodes * sizeof *e->sinks);
        e->nodes = malloc(nodes * sizeof *e->nodes);
    }
    if (!e || !e->costs || !e->difference || !e->potential || !e->arcs || !e->sinks || !e->nodes) {
        mcv_emd_free(e);
        return mcv_fail(error, MCV_FAILED,
                        "no memory for the Earth Mover's Distance of %u x %u bins", columns, rows);
    }
    for (size_t a = 0; a < bins; ++a) {
        for (size_t b = 0; b < bins; ++b) {
            const int64_t across = (int64_t)(a % columns) - (int64_t)(b % columns);
            const int64_t down = (int64_t)(a / columns) - (int64_t)(b / columns);
            e->costs[a * bins + b] = hypot((double)across / columns, (double)down / rows);
        }
    }
    e->max_cost = e->costs[bins - 1];
    *emd = e;
    return MCV_OK;
}

void mcv_emd_free(mcv_emd *emd) {
    if (!emd) return;
    free(emd->costs);
    free(emd->difference);
    free(emd->potential);
    free(emd->arcs);
    free(emd->sinks);
    free(emd->nodes);
    free(emd);
}

double mcv_emd_max_cost(const mcv_emd *emd) { return emd->max_cost; }

/* --- the tree --- */

static void attach(node *nodes, int32_t child, int32_t parent) {
    node *c = nodes + child, *p = nodes + parent;
    c->parent = parent;
    c->previous = -1;
    c->next = p->first_child;
    if (c->next >= 0) nodes[c->next].previous = child;
    p->first_child = child;
}

static void detach(node *nodes, int32_t child) {
    const node *c = nodes + child;
    if (c->previous >= 0)
        nodes[c->previous].next = c->next;
    else
        nodes[c->parent].first_child = c->next;
    if (c->next >= 0) nodes[c->next].previous = c->previous;
}

static bool is_source(const mcv_emd *e, int32_t v) { return v < e->source_count; }

static double arc_cost(const mcv_emd *e, int32_t source, int32_t sink) {
    return e->arcs[(size_t)source * (size_t)e->sink_count + (size_t)(sink - e->source_count)];
}

/* From the parent, not by adding the change: so rounding does not pile up over the pivots. */
static void update_node(mcv_emd *e, int32_t v) {
    const int32_t root = e->source_count + e->sink_count, parent = e->nodes[v].parent;
    node *n = e->nodes + v;
    n->depth = e->nodes[parent].depth + 1;
    if (is_source(e, v)) {
        n->potential =
            e->nodes[parent].potential - (parent == root ? e->max_cost : arc_cost(e, v, parent));
    } else {
        n->potential =
            e->nodes[parent].potential + (parent == root ? e->max_cost : arc_cost(e, parent, v));
        e->sinks[v - e->source_count] = n->potential;
    }
}

/* Depths and potentials of the whole branch below and with `top`. */
static void update_branch(mcv_emd *e, int32_t top) {
    const node *nodes = e->nodes;
    int32_t v = top;
    for (;;) {
        update_node(e, v);
        if (nodes[v].first_child >= 0) {
            v = nodes[v].first_child;
            continue;
        }
        while (v != top && nodes[v].next < 0) v = nodes[v].parent;
        if (v == top) return;
        v = nodes[v].next;
    }
}

/* --- the network simplex method --- */

/*
 * Brings the arc from source to sink into the tree. The arc that leaves is the last one in the
 * cycle's direction, counted from its topmost node, among those that stop the flow (W. H.
 * Cunningham, A network simplex method, Mathematical Programming 11, 1976): then arcs without flow
 * always point to the root, and no sequence of pivots can come back to a tree it has left.
 */
static void pivot(mcv_emd *e, int32_t source, int32_t sink) {
    node *nodes = e->nodes;
    int32_t leaving = -1, a = source, b = sink;
    int64_t amount = INT64_MAX;
    while (a != b) { /* up to where the ways to the root meet */
        if (nodes[a].depth >= nodes[b].depth)
            a = nodes[a].parent;
        else
            b = nodes[b].parent;
    }
    /* The flow falls on the arcs that run against the cycle: of sources on the source's side, of
     * sinks on the sink's. */
    const int32_t join = a;
    for (a = source; a != join; a = nodes[a].parent) {
        if (is_source(e, a) && nodes[a].flow < amount) {
            amount = nodes[a].flow;
            leaving = a;
        }
    }
    bool at_source = true;
    for (b = sink; b != join; b = nodes[b].parent) {
        if (!is_source(e, b) && nodes[b].flow <= amount) {
            amount = nodes[b].flow;
            leaving = b;
            at_source = false;
        }
    }
    if (amount > 0) {
        for (a = source; a != join; a = nodes[a].parent)
            nodes[a].flow += is_source(e, a) ? -amount : amount;
        for (b = sink; b != join; b = nodes[b].parent)
            nodes[b].flow += is_source(e, b) ? amount : -amount;
    }
    /* The branch that the leaving arc held now hangs on the entering one: the arcs on its way turn
     * round. */
    const int32_t top = at_source ? source : sink;
    int32_t v = top, parent = at_source ? sink : source;
    for (int64_t flow = amount;;) {
        const int32_t old_parent = nodes[v].parent;
        const int64_t old_flow = nodes[v].flow;
        detach(nodes, v);
        attach(nodes, v, parent);
        nodes[v].flow = flow;
        if (v == leaving) break;
        flow = old_flow;
        parent = v;
        v = old_parent;
    }
    update_branch(e, top);
}

/*
 * Arcs enter while their reduced cost c + π_source - π_sink is below -tolerance, the most negative
 * one of a source's arcs at a time. A potential is a sum over a path of the tree: at depth d it
 * errs by at most ε/4 d (d + 1) max(c), and the depths of two nodes add up to at most `count` + 1.
 * A cost beyond that bound is truly negative, so every pivot is one of exact arithmetic.
 */
static void optimise(mcv_emd *e) {
    const int32_t sources = e->source_count, sinks = e->sink_count;
    const double count = sources + sinks + 2;
    const double tolerance = 0.25 * DBL_EPSILON * count * count * e->max_cost;
    for (int32_t row = 0, idle = 0; idle < sources; row = row + 1 < sources ? row + 1 : 0) {
        const double *arcs = e->arcs + (size_t)row * (size_t)sinks;
        double least = arcs[0] - e->sinks[0];
        int32_t best = 0;
        for (int32_t i = 1; i < sinks; ++i) {
            const double cost = arcs[i] - e->sinks[i];
            if (cost < least) {
                least = cost;
                best = i;
            }
        }
        if (least + e->nodes[row].potential < -tolerance) {
            pivot(e, row, sources + best);
            idle = 0;
        } else {
            ++idle;
        }
    }
}

/* --- from histograms to a network and back --- */

static void add_node(mcv_emd *e, int32_t index, int32_t bin, int64_t amount) {
    e->nodes[index] = (node){.first_child = -1, .bin = bin, .flow = amount};
}

/*
 * Sources and sinks of what is left of both histograms, `supply` and `demand` in all, and a tree of
 * artificial arcs. Amounts are scaled by a power of two so that the larger sum has 52 bits. False
 * where nothing has to be moved.
 */
static bool build(mcv_emd *e, double supply, double demand) {
    int exponent;
    if (!(supply > 0 && demand > 0)) return false;
    frexp(fmax(supply, demand), &exponent);
    int64_t left_over = 0;
    e->source_count = e->sink_count = 0;
    for (int pass = 0; pass < 2; ++pass) { /* sources first */
        for (uint32_t bin = 0; bin < e->bins; ++bin) {
            const int64_t amount =
                llrint(ldexp(pass ? e->difference[bin] : -e->difference[bin], 52 - exponent));
            if (amount <= 0) continue;
            add_node(e, e->source_count + e->sink_count, (int32_t)bin, amount);
            ++*(pass ? &e->sink_count : &e->source_count);
            left_over += pass ? -amount : amount;
        }
        if (pass == 0 && e->source_count == 0) return false;
    }
    if (e->sink_count == 0) return false;
    if (left_over < 0) { /* the last source: the sinks have to move up */
        for (int32_t i = e->source_count + e->sink_count; i > e->source_count; --i)
            e->nodes[i] = e->nodes[i - 1];
        add_node(e, e->source_count++, -1, -left_over);
    } else if (left_over > 0) {
        add_node(e, e->source_count + e->sink_count++, -1, left_over);
    }
    const int32_t root = e->source_count + e->sink_count;
    add_node(e, root, -1, 0);
    double *arc = e->arcs;
    for (int32_t i = 0; i < e->source_count; ++i) {
        for (int32_t j = e->source_count; j < root; ++j) {
            const int32_t a = e->nodes[i].bin, b = e->nodes[j].bin;
            *arc++ = a < 0 || b < 0 ? 0 : e->costs[(uint32_t)a * e->bins + (uint32_t)b];
        }
    }
    for (int32_t i = 0; i < root; ++i) {
        attach(e->nodes, i, root);
        update_node(e, i);
    }
    return true;
}

/* The cost of the plan in the tree, in units of the histograms. */
static double plan_cost(const mcv_emd *e, double supply, double demand) {
    const int32_t root = e->source_count + e->sink_count;
    int exponent;
    double sum = 0;
    for (int32_t v = 0; v < root; ++v) {
        const node *n = e->nodes + v;
        if (n->flow == 0) continue;
        assert(n->parent != root);
        sum += (double)n->flow *
               (is_source(e, v) ? arc_cost(e, v, n->parent) : arc_cost(e, n->parent, v));
    }
    frexp(fmax(supply, demand), &exponent);
    return ldexp(sum, exponent - 52);
}

/*
 * Kantorovich's potential from that of the sources: f(x) = min over sources of π + c, by the
 * triangle inequality steep by at most c. A left-over source gives for nothing, so f stays below
 * its π.
 */
static void find_potential(const mcv_emd *e, double *potential) {
    for (uint32_t x = 0; x < e->bins; ++x) potential[x] = INFINITY;
    for (int32_t i = 0; i < e->source_count; ++i) {
        const node *n = e->nodes + i;
        const double *costs = n->bin < 0 ? NULL : e->costs + (uint32_t)n->bin * e->bins;
        for (uint32_t x = 0; x < e->bins; ++x) {
            const double f = n->potential + (costs ? costs[x] : 0);
            if (f < potential[x]) potential[x] = f;
        }
    }
}

#ifndef NDEBUG
/* What the potential proves: a lower bound on the cost of moving P to Q. */
static double dual_cost(const mcv_emd *e, const double *potential, double supply, double demand) {
    double sum = 0, low = INFINITY, high = -INFINITY;
    for (uint32_t x = 0; x < e->bins; ++x) {
        low = fmin(low, potential[x]);
        high = fmax(high, potential[x]);
    }
    const double extreme =
        demand > supply ? high
                        : low; /* subtracted from f, not from the sum: fewer digits are lost */
    for (uint32_t x = 0; x < e->bins; ++x) sum += (potential[x] - extreme) * e->difference[x];
    return sum;
}
#endif

double mcv_emd_distance(mcv_emd *e, const double *p, const double *q, mcv_emd_form form,
                        double *potential) {
    double sum_p = 0, sum_q = 0, supply = 0, demand = 0, cost = 0;
    for (uint32_t i = 0; i < e->bins; ++i) {
        sum_p += p[i];
        sum_q += q[i];
    }
    if (potential) memset(potential, 0, e->bins * sizeof *potential);
    const bool normalized = form == MCV_EMD_NORMALIZED;
    if (normalized && (sum_p == 0 || sum_q == 0)) return sum_p == sum_q ? 0 : e->max_cost;
    for (uint32_t i = 0; i < e->bins; ++i) {
        const double d = normalized ? q[i] / sum_q - p[i] / sum_p : q[i] - p[i];
        e->difference[i] = d;
        *(d < 0 ? &supply : &demand) += fabs(d);
    }
    const double penalty = normalized ? 0 : 0.5 * e->max_cost * fabs(demand - supply);
    if (build(e, supply, demand)) {
        optimise(e);
        cost = plan_cost(e, supply, demand);
#ifndef NDEBUG
        if (!potential) potential = e->potential;
#endif
        if (potential) find_potential(e, potential);
        /* Beyond 1e-9 of the distance the histograms' own rounding shows: where they are equal but
         * for it. */
        assert(cost - dual_cost(e, potential, supply, demand) <=
               1e-9 * (cost + penalty) +
                   DBL_EPSILON * e->bins * e->max_cost * (normalized ? 2 : sum_p + sum_q));
    }
    return cost + penalty;
}
