/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sellmeier coefficients of glasses and plastics, in the order of the options of `glass` after
 * "none" (mcvisi/params.h): n² = 1 + Σ B_i λ²/(λ² - C_i), λ and √C_i in µm, in air at 20 to 22 °C.
 *
 * Schott's glasses: their data sheets (Optical Glass, Collection Datasheets). Fused silica: I. H.
 * Malitson, J. Opt. Soc. Am. 55, 1205 (1965). Water: M. Daimon and A. Masumura, Appl. Opt. 46, 3811
 * (2007), 20 °C, relative to vacuum. PMMA and polycarbonate: n_d and V_d of N. Sultanova, S.
 * Kasarova and I. Nikolov, Acta Phys. Pol. A 116, 585 (2009); they agree with the table there
 * within 0.002 from 437 to 1052 nm.
 */
#include "scene/scene.h"
#include "scene/spectra.h"

/* The squared index of air relative to vacuum. */
#define AIR (1.000272 * 1.000272)

static const struct {
    double b[5], c[5];
} glasses[] = {
    {{1.03961212, 0.231792344, 1.01046945}, {0.00600069867, 0.0200179144, 103.560653}}, /* N-BK7 */
    {{1.08511833, 0.199562005, 0.930511663}, {0.00661099503, 0.024110866, 111.982777}}, /* N-K5 */
    {{1.28834642, 0.132817724, 0.945395373},
     {0.00779980626, 0.0315631177, 105.965875}},                                        /* N-BAK4 */
    {{1.28189012, 0.257738258, 0.96818604}, {0.0072719164, 0.0242823527, 110.377773}},  /* N-SK2 */
    {{1.34317774, 0.241144399, 0.994317969}, {0.00704687339, 0.0229005, 92.7508526}},   /* N-SK16 */
    {{1.4306027, 0.153150554, 1.01390904}, {0.00823982975, 0.0333736841, 106.870822}},  /* N-SSK2 */
    {{1.33183167, 0.546623206, 1.19084015}, {0.00620023871, 0.0216465439, 82.5827736}}, /* N-LAK8 */
    {{1.14229781, 0.535138441, 1.04088385},
     {0.00585778594, 0.0198546147, 100.834017}},                                       /* N-LAK22 */
    {{2.00029547, 0.298926886, 1.80691843}, {0.0121426017, 0.0538736236, 156.530829}}, /* N-LASF9 */
    {{1.5851495, 0.143559385, 1.08521269}, {0.00926681282, 0.0424489805, 105.613573}}, /* N-BAF10 */
    {{1.34533359, 0.209073176, 0.937357162}, {0.00997743871, 0.0470450767, 111.886764}}, /* F2 */
    {{1.39757037, 0.159201403, 1.2686543}, {0.00995906143, 0.0546931752, 119.248346}},   /* N-F2 */
    {{1.3104463, 0.19603426, 0.96612977}, {0.00958633048, 0.0457627627, 115.011883}},    /* F5 */
    {{1.46141885, 0.247713019, 0.949995832}, {0.0111826126, 0.0508594669, 112.041888}},  /* SF5 */
    {{1.52481889, 0.187085527, 1.42729015}, {0.011254756, 0.0588995392, 129.141675}},    /* N-SF5 */
    {{1.72448482, 0.390104889, 1.04572858}, {0.0134871947, 0.0569318095, 118.557185}},   /* SF6 */
    {{1.77931763, 0.338149866, 2.08734474}, {0.0133714182, 0.0617533621, 174.01759}},    /* N-SF6 */
    {{1.62153902, 0.256287842, 1.64447552}, {0.0122241457, 0.0595736775, 147.468793}}, /* N-SF10 */
    {{1.73759695, 0.313747346, 1.89878101}, {0.013188707, 0.0623068142, 155.23629}},   /* N-SF11 */
    {{1.87543831, 0.37375749, 2.30001797}, {0.0141749518, 0.0640509927, 177.389795}},  /* N-SF57 */
    {{0.971247817, 0.216901417, 0.904651666},
     {0.00472301995, 0.0153575612, 168.68133}}, /* N-FK51A */
    {{0.6961663, 0.4079426, 0.8974794},
     {0.00467914826, 0.0135120631, 97.9340025}}, /* fusedSilica */
    /* water: the fifth term turns n² into n² / n_air² */
    {{0.5684027565 / AIR, 0.1726177391 / AIR, 0.02086189578 / AIR, 0.1130748688 / AIR, 1 / AIR - 1},
     {0.005101829712, 0.01821153936, 0.02620722293, 10.69792721}},
    /* PMMA */
    {{-0.0260113, 1.2129107}, {0, 0.01}},
    /* polycarbonate */
    {{-0.4176267, 1.8387337}, {0, 0.0163}},
};

/* Outside this range some of them are opaque, and the formula does not apply. */
static const double shortest = 0.35, longest = 2.0;

double mcv_cauchy_index(double n_d, double abbe_number, double wavelength) {
    const double d = 587.5618e-9, f = 486.1327e-9, c = 656.2725e-9;
    const double b = (n_d - 1) / (abbe_number * (1 / (f * f) - 1 / (c * c)));
    return fmax(n_d + b * (1 / (wavelength * wavelength) - 1 / (d * d)), 1);
}

double mcv_glass_index(int glass, double wavelength) {
    const double micrometres = fmin(fmax(1e6 * wavelength, shortest), longest),
                 square = micrometres * micrometres;
    double squared = 1;
    if (glass < 1) return 1.5;
    for (int i = 0; i < 5; ++i)
        squared += glasses[glass - 1].b[i] * square / (square - glasses[glass - 1].c[i]);
    return sqrt(squared);
}
