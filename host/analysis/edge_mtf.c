/* SPDX-License-Identifier: Apache-2.0 */
/* The modulation transfer function of an edge from its edge spread function. */
#include "analysis/edge_line.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* 1 up to three quarters of the reach, from there falling to 0: a hard end would ring. */
static double window_at(double place, double reach) {
    const double share = fabs(place) / reach;
    return share <= 0.75 ? 1 : share >= 1 ? 0 : 0.5 + 0.5 * cos(M_PI * (share - 0.75) / 0.25);
}

static double sinc(double x) { return x == 0 ? 1 : sin(M_PI * x) / (M_PI * x); }

/* F(ν) = Σ window (E_{k+1} - E_k) e^{-2πi ν x}, linear in the E_k, and what becomes of the bins'
 * variances. */
static mcv_quantity modulation_at(const mcv_edge_mtf *m, double frequency, double reach,
                                  double scatter) {
    double re = 0, im = 0, total = 0;
    const size_t n = m->count;
    for (size_t i = 0; i + 1 < n; ++i) {
        const double x = 0.5 * (m->place[i] + m->place[i + 1]),
                     d = window_at(x, reach) * (m->esf[i + 1].value - m->esf[i].value);
        re += d * cos(2 * M_PI * frequency * x);
        im -= d * sin(2 * M_PI * frequency * x);
        total += d;
    }
    const double length = hypot(re, im);
    double across = 0, variance = 0, before[3] = {0};
    for (size_t i = 0; i < n; ++i) {
        double here[3] = {0};
        if (i + 1 < n) {
            const double x = 0.5 * (m->place[i] + m->place[i + 1]), w = window_at(x, reach);
            here[0] = w * cos(2 * M_PI * frequency * x);
            here[1] = -w * sin(2 * M_PI * frequency * x);
            here[2] = w;
        }
        const double c[3] = {before[0] - here[0], before[1] - here[1], before[2] - here[2]},
                     v = m->esf[i].uncertainty * m->esf[i].uncertainty;
        const double slope =
            (re * c[0] + im * c[1]) / (length * total) - length * c[2] / (total * total);
        variance += v * slope * slope;
        across += v * pow((re * c[1] - im * c[0]) / length, 2);
        memcpy(before, here, sizeof before);
    }
    /*
     * Noise at right angles to F lengthens it; what that leaves uncertain is second order, and all
     * there is where F is no more than noise: the factor 2 lets the interval of a length without
     * signal (Rayleigh) hold 0 in 95 % of cases. Bins average over places that scatter, differences
     * over the step between bins.
     */
    const double corrected = fmax(0, length - across / (2 * length)) / fabs(total);
    const double loss =
        (1 - 0.5 * pow(2 * M_PI * frequency, 2) * scatter) * sinc(frequency / MCV_ESF_PER_PIXEL);
    variance += 2 * pow(across / (length * total), 2);
    return (mcv_quantity){corrected / loss, sqrt(variance) / loss};
}

static void find_mtf50(mcv_edge_mtf *m, double reach, double scatter) {
    m->mtf50 = (mcv_quantity){NAN, NAN};
    for (int k = 1; k < MCV_MTF_COUNT; ++k) {
        if (m->modulation[k].value > 0.5) continue;
        double low = m->frequency[k - 1], high = m->frequency[k];
        for (int i = 0; i < 40; ++i) {
            const double middle = 0.5 * (low + high);
            if (modulation_at(m, middle, reach, scatter).value > 0.5)
                low = middle;
            else
                high = middle;
        }
        /* Over half of the way, or the noise would make the slope. */
        const double slope = (modulation_at(m, 0.75 * low, reach, scatter).value -
                              modulation_at(m, 1.25 * low, reach, scatter).value) /
                             (0.5 * low);
        m->mtf50 =
            (mcv_quantity){low, modulation_at(m, low, reach, scatter).uncertainty / fabs(slope)};
        return;
    }
}

static mcv_result spread(const mcv_edge *edge, const mcv_edge_bins *b, const mcv_edge_line *l,
                         mcv_edge_mtf *m, mcv_error *error) {
    double scatter = 0;
    const double step = l->right.value - l->left.value;
    m->count = 2 * b->half;
    m->place = calloc(m->count, sizeof *m->place);
    m->esf = calloc(m->count, sizeof *m->esf);
    m->lsf = calloc(m->count, sizeof *m->lsf);
    if (!m->place || !m->esf || !m->lsf)
        return mcv_edge_fail(edge, error, "no memory for its spread function");
    for (size_t i = 0; i < m->count; ++i) {
        const double n = b->count[i];
        if (n == 0)
            return mcv_edge_fail(
                edge, error,
                "at its tilt some phases of the pixel grid are not sampled: tilt it by 2° to 10°");
        m->place[i] = b->place[i] / n;
        m->esf[i] = (mcv_quantity){(b->sum[i] / n - l->left.value) / step,
                                   sqrt(b->variance[i]) / (n * fabs(step))};
        scatter += (b->place2[i] / n - m->place[i] * m->place[i]) / (double)m->count;
    }
    for (size_t i = 0; i + 1 < m->count; ++i)
        m->lsf[i] = (m->esf[i + 1].value - m->esf[i].value) / (m->place[i + 1] - m->place[i]);
    const double reach = (double)b->half / MCV_ESF_PER_PIXEL;
    for (int k = 0; k < MCV_MTF_COUNT; ++k) {
        m->frequency[k] = (double)k / (MCV_MTF_COUNT - 1);
        m->modulation[k] = modulation_at(m, m->frequency[k], reach, scatter);
    }
    find_mtf50(m, reach, scatter);
    const double widening = mcv_widening(edge->freedom);
    for (size_t i = 0; i < m->count; ++i) m->esf[i].uncertainty *= widening;
    for (int k = 0; k < MCV_MTF_COUNT; ++k) m->modulation[k].uncertainty *= widening;
    m->mtf50.uncertainty *= widening;
    m->nyquist = m->modulation[MCV_MTF_COUNT / 2];
    return MCV_OK;
}

mcv_result mcv_edge_spread(const mcv_readings *readings, const mcv_edge *edge, mcv_edge_mtf *mtf,
                           mcv_error *error) {
    const mcv_edge_patch p = mcv_patch_of(readings, edge);
    const double turn = edge->across_rows ? edge->normal[0] : edge->normal[1];
    const uint32_t corner = edge->across_rows ? edge->box.x : edge->box.y;
    mcv_edge_line l = {.at = edge->position.value - corner,
                       .slope = tan(edge->tilt.value),
                       .middle = 0.5 * (double)p.rows};
    l.left = turn > 0 ? edge->dark : edge->bright;
    l.right = turn > 0 ? edge->bright : edge->dark;
    mcv_edge_bins b;
    *mtf = (mcv_edge_mtf){0};
    if (fabs(l.slope) * (double)p.rows < 1)
        return mcv_edge_fail(
            edge, error,
            "it runs along the pixel grid, so its sharpness cannot be measured: tilt it by 2° to "
            "10°");
    if (!mcv_edge_fill_bins(&p, &l, &b))
        return mcv_edge_fail(edge, error,
                             "the rectangle shows too little beside it for its spread function");
    const mcv_result result = spread(edge, &b, &l, mtf, error);
    mcv_edge_bins_free(&b);
    if (result != MCV_OK) mcv_edge_mtf_free(mtf);
    return result;
}

void mcv_edge_mtf_free(mcv_edge_mtf *mtf) {
    free(mtf->place);
    free(mtf->esf);
    free(mtf->lsf);
    mtf->place = mtf->lsf = NULL;
    mtf->esf = NULL;
}
