/* SPDX-License-Identifier: Apache-2.0 */
#include "device/multiple_goals.h"

#include <math.h>

#include "device/microsurface.h"

static const double pi = 3.14159265358979323846;

double mcv_goal_entry(double half, double sum) {
    return (MCV_GOAL_TURNS - 1) * (double)mcv_interface_turn((float)half,
                                                             (float)sqrt(fmax(1 - half * half, 0)),
                                                             (float)sum + MCV_MULTIPLE_LEAST);
}

/* The |cos φ/2| of an entry, by bisection. */
static double half_of(uint32_t entry, double sum) {
    double low = 0, high = 1;
    for (int round = 0; round < 24 && entry < MCV_GOAL_TURNS - 1; ++round) {
        const double half = 0.5 * (low + high);
        *(mcv_goal_entry(half, sum) < entry ? &low : &high) = half;
    }
    return high;
}

void mcv_goals_fill(double alpha, uint32_t nodes, mcv_goals *goals) {
    enum { TURNS = MCV_GOAL_TURNS };
    goals->nodes = nodes;
    for (uint32_t k = 0; k < nodes; ++k) {
        const double cosine = mcv_multiple_cosine(k, nodes);
        goals->node[k] =
            (mcv_goal_node){cosine, sqrt(1 - cosine * cosine), mcv_smith(alpha, cosine)};
    }
    for (uint32_t k = 0; k < nodes * nodes * TURNS; ++k) {
        const uint32_t row = k / (nodes * TURNS), column = k / TURNS % nodes, turn = k % TURNS;
        const double half = half_of(turn, goals->node[row].cosine + goals->node[column].cosine),
                     c = 2 * half * half - 1;
        goals->x[row][column][turn] = (float)(goals->node[column].sine * c);
        goals->y[row][column][turn] = (float)(goals->node[column].sine * sqrt(fmax(1 - c * c, 0)));
    }
}

/* Into each of the functions below that differ by their instructions alone. */
#define INLINED static inline __attribute__((always_inline))

/* By Fresnel's equations, as one quotient. */
INLINED float reflectance(float eta, float scale, float offset, float c) {
    const float squared = 1 - eta * eta * (1 - c * c), c2 = sqrtf(squared > 0 ? squared : 0);
    const float s = eta * c + c2, p = c + eta * c2, s_less = eta * c - c2, p_less = c - eta * c2;
    const float sum = s_less * s_less * (p * p) + p_less * p_less * (s * s);
    const float r = scale * 0.5F * sum / (s * s * (p * p)) + offset;
    return squared > 0 ? (r > 0 ? r : 0) : 1;
}

float mcv_facet_reflects(const mcv_facet_interface *at, int side, float c) {
    return reflectance((float)(at->n[side] / at->n[!side]), (float)at->scale[side],
                       (float)at->offset[side], c);
}

/* The number of turns is known to the compiler, which makes vectors of them. */
INLINED void send(const mcv_facet_interface *at, const mcv_goals *goals, int start, uint32_t row,
                  const mcv_facet_light *light, mcv_goal_sums sums) {
    const int own = start ^ light->side;
    const float x = (float)light->back[0], y = (float)light->back[1], z = (float)light->back[2];
    const float n1 = (float)at->n[own], n2 = (float)at->n[!own], eta = n1 / n2;
    const float scale = (float)at->scale[own], offset = (float)at->offset[own];
    const float inverse = (float)(1 / (at->alpha * at->alpha)), peak = (float)(inverse / pi);
    for (uint32_t column = 0; column < goals->nodes; ++column)
        for (int passes = 0; passes < 2; ++passes) {
            const float *gx = goals->x[row][column], *gy = goals->y[row][column];
            const float here = light->here[passes][column], there = light->there[passes][column];
            const float a = passes ? n1 : 1, b = passes ? n2 : 1,
                        k = peak * (passes ? 0.5F : 0.125F / (n1 * n1));
            const float cosine = (float)goals->node[column].cosine, g_z = passes ? -cosine : cosine,
                        h_z = a * z + b * g_z, sign = h_z < 0 ? -1.0F : 1.0F;
            float sent[MCV_GOAL_TURNS];
            for (uint32_t turn = 0; turn < MCV_GOAL_TURNS; ++turn) {
                const float h_x = a * x + b * gx[turn], h_y = a * y + b * gy[turn];
                const float across = h_x * h_x + h_y * h_y, squared = across + h_z * h_z;
                /* Cosines of both directions to the microfacet, times the length of h. */
                const float c = sign * (x * h_x + y * h_y + z * h_z),
                            behind = -sign * (gx[turn] * h_x + gy[turn] * h_y + g_z * h_z);
                const float of_length = c / sqrtf(squared);
                const float share = reflectance(eta, scale, offset, of_length < 1 ? of_length : 1);
                const float t = across * inverse + h_z * h_z;
                const float lobe = k * (passes ? c * behind : squared * squared);
                const int meets = (c > 0) & (passes ? behind > 0 : h_z > 0);
                sent[turn] =
                    meets ? here * (passes ? 1 - share : share) * lobe / (t * t + lobe * there) : 0;
            }
            for (uint32_t turn = 0; turn < MCV_GOAL_TURNS; ++turn)
                sums[light->side ^ passes][column][turn] += (double)sent[turn];
        }
}

#if defined(__x86_64__)
/* Eight turns at once take two thirds of the time of four. No FMA: the bits are the same. */
__attribute__((target("avx2"))) static void
send_by_eight(const mcv_facet_interface *at, const mcv_goals *goals, int start, uint32_t row,
              const mcv_facet_light *light, mcv_goal_sums sums) {
    send(at, goals, start, row, light, sums);
}
#endif

void mcv_facet_send(const mcv_facet_interface *at, const mcv_goals *goals, int start, uint32_t row,
                    const mcv_facet_light *light, mcv_goal_sums sums) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) {
        send_by_eight(at, goals, start, row, light, sums);
        return;
    }
#endif
    send(at, goals, start, row, light, sums);
}
