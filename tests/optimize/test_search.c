/* SPDX-License-Identifier: Apache-2.0 */
/* The search for the smallest value, with functions whose minima are known. */
#include "test.h"

#include <math.h>
#include <nlopt.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/noise.h"
#include "optimize/search.h"

/* --- functions --- */

/* Branin: 0.397887 at three places of [-5, 10] x [0, 15]. */
static double branin(const double *x) {
    const double t = x[1] - 5.1 / (4 * M_PI * M_PI) * x[0] * x[0] + 5 / M_PI * x[0] - 6;
    return t * t + 10 * (1 - 1 / (8 * M_PI)) * cos(x[0]) + 10;
}
static const double branin_least = 0.39788735772973816;
static const mcv_levels branin_box[] = {{.from = -5, .to = 10}, {.from = 0, .to = 15}};

/* Hartmann's in six dimensions: -3.32237 in the unit cube. */
static double hartmann(const double *x) {
    static const double alpha[4] = {1, 1.2, 3, 3.2},
                        a[4][6] = {{10, 3, 17, 3.5, 1.7, 8},
                                   {0.05, 10, 17, 0.1, 8, 14},
                                   {3, 3.5, 1.7, 10, 17, 8},
                                   {17, 8, 0.05, 10, 0.1, 14}},
                        p[4][6] = {{0.1312, 0.1696, 0.5569, 0.0124, 0.8283, 0.5886},
                                   {0.2329, 0.4135, 0.8307, 0.3736, 0.1004, 0.9991},
                                   {0.2348, 0.1451, 0.3522, 0.2883, 0.3047, 0.6650},
                                   {0.4047, 0.8828, 0.8732, 0.5743, 0.1091, 0.0381}};
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        double exponent = 0;
        for (int k = 0; k < 6; ++k) exponent += a[i][k] * (x[k] - p[i][k]) * (x[k] - p[i][k]);
        sum -= alpha[i] * exp(-exponent);
    }
    return sum;
}
static const double hartmann_least = -3.3223680114155147;
static const mcv_levels cube[] = {{.to = 1}, {.to = 1}, {.to = 1}, {.to = 1}, {.to = 1}, {.to = 1}};

/* --- a search --- */

typedef struct noisy {
    double (*of)(const double *);
    double noise;
    uint32_t run;
    size_t calls, stop_after; /* 0: never */
    bool fails;               /* where the first parameter is above 5 */
} noisy;

/* The noise of a seed is the same at all points: differences with one seed are free of it. */
static mcv_result evaluate(void *user, mcv_evaluation *e, mcv_error *error) {
    noisy *n = user;
    mcv_noise noise = mcv_noise_begin(n->run, 31, e->seed);
    if (n->stop_after && n->calls >= n->stop_after)
        return mcv_fail(error, MCV_INTERRUPTED, "stopped");
    ++n->calls;
    e->results[0] = n->of(e->values) + n->noise * mcv_noise_normal(&noise);
    e->errors[0] = n->noise;
    if (n->fails && e->values[0] > 5) e->results[0] = e->errors[0] = NAN;
    return MCV_OK;
}

static mcv_search search_of(noisy *n, const mcv_levels *levels, size_t dimensions, size_t budget) {
    return (mcv_search){.dimensions = dimensions,
                        .objectives = 1,
                        .levels = levels,
                        .budget = budget,
                        .seed = n->run,
                        .evaluate = evaluate,
                        .user = n};
}

static void search_well(const mcv_search *search, mcv_search_result *result) {
    mcv_error error = {""};
    if (mcv_search_run(search, result, &error) != MCV_OK) fail_msg("%s", error.text);
    if (result->count > search->budget)
        fail_msg("%zu evaluations of at most %zu", result->count, search->budget);
}

/* --- the process --- */

/* Without noise it passes through its values, far from all it has the whole deviation; with noise
 * of one value it takes a weighted mean. */
static void test_the_process(void **state) {
    mcv_surrogate s;
    mcv_error error;
    double mean[3], deviation[3];
    (void)state;
    mcv_surrogate_begin(&s, 1);
    for (int i = 0; i <= 10; ++i) {
        const double x = i / 10.0;
        assert_int_equal(mcv_surrogate_add(&s, &x, sin(6 * x), 0, &error), MCV_OK);
    }
    assert_int_equal(mcv_surrogate_fit(&s, true, &error), MCV_OK);
    const double at[3] = {0.3, 0.35, 0.72};
    assert_int_equal(mcv_surrogate_predict(&s, at, 3, mean, deviation, &error), MCV_OK);
    for (int i = 0; i < 3; ++i)
        if (!(fabs(mean[i] - sin(6 * at[i])) < 0.01) || !(deviation[i] < 0.03))
            fail_msg("at %g: %g ± %g, not %g", at[i], mean[i], deviation[i], sin(6 * at[i]));
    assert_true(fabs(mean[0] - sin(1.8)) < 1e-4 && deviation[0] < 1e-3);
    mcv_surrogate_free(&s);
    /* Two values of one point, of variances v and 4v beside a constant: weights 4 and 1, shrunk
     * towards the constant by little, as the process's own variance is much larger. */
    mcv_surrogate_begin(&s, 1);
    const double x = 0.5, far = 1e3;
    mcv_surrogate_add(&s, &x, 1.0, 1e-4, &error);
    mcv_surrogate_add(&s, &x, 2.0, 4e-4, &error);
    mcv_surrogate_add(&s, &far, -3.0, 1e-4, &error);
    assert_int_equal(mcv_surrogate_fit(&s, false, &error), MCV_OK);
    assert_int_equal(mcv_surrogate_predict(&s, &x, 1, mean, deviation, &error), MCV_OK);
    assert_true(fabs(mean[0] - 1.2) < 1e-3);
    assert_true(fabs(deviation[0] - sqrt(0.8e-4)) < 1e-4);
    mcv_surrogate_free(&s);
}

/*
 * Draws have the means and deviations that predict says: of 4000, to four standard deviations. A
 * point near another goes with it: of the process alone their difference has the variance
 * 2 s² (1 - (1 + r + r²/3) exp(-r)) < s² r²/3 at r = √5 d/l, and values only lessen it.
 */
static void test_draws(void **state) {
    enum { DRAWS = 4000, POINTS = 3 };
    const double apart = 1e-3;
    mcv_surrogate s;
    mcv_error error;
    double at[POINTS] = {0.2, 0.8, 0.2 + apart}, mean[POINTS], deviation[POINTS],
           sums[POINTS] = {0}, squares[POINTS] = {0}, differences = 0;
    double *draws = malloc(sizeof *draws * POINTS * DRAWS);
    mcv_noise noise = mcv_noise_begin(3, 4, 5);
    (void)state;
    assert_non_null(draws);
    mcv_surrogate_begin(&s, 1);
    for (int i = 0; i < 4; ++i) {
        const double x = i / 3.0;
        mcv_surrogate_add(&s, &x, x * x, 0.01, &error);
    }
    assert_int_equal(mcv_surrogate_fit(&s, false, &error), MCV_OK);
    assert_int_equal(mcv_surrogate_predict(&s, at, POINTS, mean, deviation, &error), MCV_OK);
    for (int i = 0; i < POINTS * DRAWS; ++i) draws[i] = mcv_noise_normal(&noise);
    assert_int_equal(mcv_surrogate_draw(&s, at, POINTS, DRAWS, draws, &error), MCV_OK);
    for (int i = 0; i < DRAWS; ++i) {
        double off[POINTS];
        for (int k = 0; k < POINTS; ++k) {
            off[k] = draws[POINTS * i + k] - mean[k];
            sums[k] += off[k] / DRAWS;
            squares[k] += off[k] * off[k] / DRAWS;
        }
        differences += (off[2] - off[0]) * (off[2] - off[0]) / DRAWS;
    }
    for (int k = 0; k < POINTS; ++k) {
        assert_true(fabs(sums[k]) < 4 * deviation[k] / sqrt(DRAWS));
        assert_true(fabs(sqrt(squares[k]) / deviation[k] - 1) < 4 / sqrt(2.0 * DRAWS));
    }
    const double most = s.scale * sqrt(s.variance * 5 / 3) * apart * s.inverse[0];
    if (!(sqrt(differences) < most * (1 + 4 / sqrt(2.0 * DRAWS))))
        fail_msg("neighbours are apart by %g, at most %g", sqrt(differences), most);
    assert_true(most < deviation[0] / 10);
    free(draws);
    mcv_surrogate_free(&s);
}

/* What is known of the first of three words tells the same of both others; of three numbers it
 * tells more of the nearer one. */
static void test_words_have_no_order(void **state) {
    static const double known[3][2] = {{0, 0.2}, {0, 0.5}, {0, 0.9}},
                        others[3][2] = {{0.5, 0.5}, {1, 0.5}, {0.5, 0.2}};
    mcv_error error;
    (void)state;
    for (int named = 0; named < 2; ++named) {
        mcv_surrogate s;
        double mean[3], deviation[3];
        mcv_surrogate_begin(&s, 2);
        s.named[0] = named;
        for (int i = 0; i < 3; ++i)
            assert_int_equal(mcv_surrogate_add(&s, known[i], i == 1 ? -3 : 1, 1e-4, &error),
                             MCV_OK);
        assert_int_equal(mcv_surrogate_fit(&s, false, &error), MCV_OK);
        assert_int_equal(mcv_surrogate_predict(&s, others[0], 3, mean, deviation, &error), MCV_OK);
        if (named) {
            assert_true(mean[0] == mean[1] && deviation[0] == deviation[1]);
            assert_true(mean[0] < mean[2]); /* as of the first one */
        } else {
            assert_true(mean[0] < mean[1] && deviation[0] < deviation[1]);
        }
        mcv_surrogate_free(&s);
    }
}

/* --- minima --- */

static void test_branin(void **state) {
    (void)state;
    for (uint32_t run = 0; run < 5; ++run) {
        noisy n = {.of = branin, .run = run};
        mcv_search search = search_of(&n, branin_box, 2, 80);
        mcv_search_result r;
        search.better[0] = 0.01;
        search_well(&search, &r);
        print_message("branin %u: %.6f of %zu; %s\n", run, branin(r.winner.point.values), r.count,
                      r.ended);
        assert_true(branin(r.winner.point.values) < branin_least + 0.01);
        assert_true(r.near[0][0] <= r.winner.point.values[0] &&
                    r.near[0][1] >= r.winner.point.values[0]);
        mcv_search_free(&r);
    }
}

typedef struct tally {
    size_t held, all;
    double regret;
    size_t evaluations;
} tally;

/* The printed interval is one of the winner's own value, of evaluations that have chosen nothing;
 * the smallest value of the search is too good. */
static tally run_noisy(double (*of)(const double *), double least, const mcv_levels *levels,
                       size_t dimensions, double noise, size_t budget, uint32_t runs) {
    tally t = {0};
    double curse = 0;
    for (uint32_t run = 0; run < runs; ++run) {
        noisy n = {.of = of, .noise = noise, .run = 100 + run};
        mcv_search search = search_of(&n, levels, dimensions, budget);
        mcv_search_result r;
        search.better[0] = noise / 2;
        search_well(&search, &r);
        const double truth = of(r.winner.point.values);
        t.held += r.low <= truth && truth <= r.high;
        t.regret += (truth - least) / runs;
        t.evaluations += r.count;
        curse += (r.points[0].in_search - truth) / runs;
        ++t.all;
        mcv_search_free(&r);
    }
    print_message("%zu of %zu intervals hold the truth; regret %.4f, %.1f evaluations, in search "
                  "%.4f too good\n",
                  t.held, t.all, t.regret, (double)t.evaluations / runs, -curse);
    assert_true(curse < 0);
    return t;
}

#ifndef RUNS
#define RUNS 40
#endif

static void test_noisy_branin(void **state) {
    (void)state;
    const tally t = run_noisy(branin, branin_least, branin_box, 2, 1.0, 60, RUNS);
    const double share = (double)t.held / (double)t.all;
    /* Three standard deviations of a share of 95 %. */
    assert_true(fabs(share - 0.95) <= 3 * sqrt(0.95 * 0.05 / RUNS));
    assert_true(t.regret < 0.5);
}

/* --- against BOBYQA alone --- */

typedef struct multistart {
    noisy *n;
    nlopt_opt search;
    size_t calls, most;
    double least, regret, wanted; /* least: what was seen */
} multistart;

// NOLINTNEXTLINE(readability-non-const-parameter): as NLopt has it
static double evaluate_one(unsigned count, const double *x, double *slopes, void *user) {
    multistart *m = user;
    mcv_noise noise = mcv_noise_begin(m->n->run, 32, ++m->calls);
    const double truth = m->n->of(x), seen = truth + m->n->noise * mcv_noise_normal(&noise);
    (void)count;
    (void)slopes;
    if (seen < m->least) {
        m->least = seen;
        m->regret = truth - hartmann_least;
    }
    if (m->calls >= m->most || m->regret <= m->wanted) nlopt_force_stop(m->search);
    return seen;
}

/* Evaluations until the best value that was seen is truly as good as wanted. */
static size_t count_multistart(uint32_t run, double noise, double wanted, size_t most) {
    noisy n = {.of = hartmann, .noise = noise, .run = run};
    multistart m = {.n = &n, .most = most, .least = INFINITY, .regret = INFINITY, .wanted = wanted};
    mcv_noise starts = mcv_noise_begin(run, 33, 0);
    while (m.calls < most && m.regret > wanted) {
        double x[6], least;
        for (int i = 0; i < 6; ++i) x[i] = mcv_noise_uniform(&starts);
        m.search = nlopt_create(NLOPT_LN_BOBYQA, 6);
        assert_non_null(m.search);
        nlopt_set_lower_bounds1(m.search, 0);
        nlopt_set_upper_bounds1(m.search, 1);
        nlopt_set_min_objective(m.search, evaluate_one, &m);
        nlopt_set_initial_step1(m.search, 0.2);
        nlopt_set_xtol_abs1(m.search, 1e-3);
        nlopt_set_ftol_abs(m.search, fmax(1e-4, 2 * M_SQRT2 * noise));
        nlopt_optimize(m.search, x, &least);
        nlopt_destroy(m.search);
    }
    return m.calls;
}

/* A third of BOBYQA's evaluations, to the same error on average. */
static void test_noisy_hartmann(void **state) {
    enum { STARTS = 20, MOST = 3000 };
    const double noise = 0.1;
    size_t calls = 0;
    (void)state;
    const tally t = run_noisy(hartmann, hartmann_least, cube, 6, noise, 120, RUNS / 5);
    for (uint32_t i = 0; i < STARTS; ++i) calls += count_multistart(i, noise, t.regret, MOST);
    print_message("BOBYQA with many starts: %.0f evaluations, at most %d each\n",
                  (double)calls / STARTS, MOST);
    assert_true(t.regret < 0.15);
    assert_true((double)t.evaluations / (double)t.all <= (double)calls / STARTS / 3);
    if (RUNS >= 200)
        assert_true(fabs((double)t.held / (double)t.all - 0.95) <=
                    3 * sqrt(0.95 * 0.05 / (RUNS / 5.0)));
}

/* --- constraints, lists, failures --- */

/* Below the line x + y = 8 Branin's only minimum of three is that at (3.14, 2.28). */
static bool below_line(void *user, const double *x) {
    (void)user;
    return x[0] + x[1] < 8 && x[0] > 0;
}

static void test_constraints(void **state) {
    noisy n = {.of = branin, .run = 3};
    mcv_search search = search_of(&n, branin_box, 2, 60);
    mcv_search_result r;
    (void)state;
    search.allowed = below_line;
    search.better[0] = 0.01;
    search_well(&search, &r);
    for (size_t i = 0; i < r.count; ++i) assert_true(below_line(NULL, r.all[i].values));
    assert_true(fabs(r.winner.point.values[0] - M_PI) < 0.1);
    assert_true(branin(r.winner.point.values) < branin_least + 0.02);
    mcv_search_free(&r);
}

static bool nowhere(void *user, const double *x) {
    (void)user;
    (void)x;
    return false;
}

static void test_impossible_constraints(void **state) {
    noisy n = {.of = branin};
    mcv_search search = search_of(&n, branin_box, 2, 60);
    mcv_search_result r;
    mcv_error error = {""};
    (void)state;
    search.allowed = nowhere;
    assert_int_equal(mcv_search_run(&search, &r, &error), MCV_BAD_INPUT);
    assert_non_null(strstr(error.text, "constraints allow none"));
    assert_int_equal(n.calls, 0);
    mcv_search_free(&r);
}

/* One parameter has five values; the best of all 5 is known by trying. */
static void test_lists(void **state) {
    static double list[] = {9, -2.5, 2.8, 0, 5};
    const mcv_levels levels[] = {{.list = list, .count = 5}, {.from = 0, .to = 15}};
    noisy n = {.of = branin, .run = 8};
    mcv_search search = search_of(&n, levels, 2, 60);
    mcv_search_result r;
    double least = INFINITY;
    (void)state;
    search.better[0] = 0.01;
    search_well(&search, &r);
    for (size_t i = 0; i < r.count; ++i) {
        bool member = false;
        for (size_t k = 0; k < 5; ++k) member = member || r.all[i].values[0] == list[k];
        assert_true(member);
    }
    for (size_t k = 0; k < 5; ++k)
        for (double y = 0; y <= 15; y += 0.001) {
            const double x[2] = {list[k], y};
            least = fmin(least, branin(x));
        }
    if (!(branin(r.winner.point.values) < least + 0.02))
        fail_msg("%g at %g, %g, not %g", branin(r.winner.point.values), r.winner.point.values[0],
                 r.winner.point.values[1], least);
    mcv_search_free(&r);
}

/* The screening's points fill the unit interval evenly: half of them lie below the geometric mean
 * of a logarithmic range, but for one of an odd number and one of the ends. */
static double squared_logarithm(const double *x) { return pow(log10(x[0] / 0.1), 2); }

static void test_logarithmic_ranges(void **state) {
    static const mcv_levels levels[] = {{.from = 1e-4, .to = 1, .logarithmic = true}};
    noisy n = {.of = squared_logarithm, .run = 2};
    mcv_search search = search_of(&n, levels, 1, 40);
    mcv_search_result r;
    int screened = 0, below = 0;
    (void)state;
    search.better[0] = 0.01;
    search_well(&search, &r);
    for (size_t i = 0; i < r.count; ++i) {
        if (r.all[i].stage != MCV_STAGE_SCREENING) continue;
        ++screened;
        below += r.all[i].values[0] < 1e-2;
    }
    assert_true(screened >= 8 && abs(2 * below - screened) <= 2);
    if (!(fabs(log10(r.winner.point.values[0] / 0.1)) < 0.15))
        fail_msg("the winner is %g, not 0.1", r.winner.point.values[0]);
    mcv_search_free(&r);
}

/* A third of the box fails, with one of the minima. */
/* Five words, each a parabola of its own. The best, by 0.2, is the second one at 0.8; its
 * neighbours in the list are among the worst. */
static double of_words(const double *x) {
    static const double least[5] = {0.5, 0, 0.7, 0.2, 0.9}, at[5] = {0.1, 0.8, 0.3, 0.6, 0.5};
    const int word = (int)x[0];
    return least[word] + 2 * (x[1] - at[word]) * (x[1] - at[word]);
}

static void test_words(void **state) {
    static double places[5] = {0, 1, 2, 3, 4};
    const mcv_levels levels[] = {{.list = places, .count = 5, .named = true}, {.to = 1}};
    (void)state;
    for (uint32_t run = 0; run < 5; ++run) {
        noisy n = {.of = of_words, .run = run};
        mcv_search search = search_of(&n, levels, 2, 80);
        mcv_search_result r;
        bool seen[5] = {false};
        search.better[0] = 0.02;
        search_well(&search, &r);
        for (size_t i = 0; i < r.count; ++i) {
            const double place = r.all[i].values[0];
            assert_true(place == floor(place) && place >= 0 && place < 5);
            seen[(int)place] = true;
        }
        for (int i = 0; i < 5; ++i) assert_true(seen[i]); /* the screening tries each */
        if (r.winner.point.values[0] != 1 || of_words(r.winner.point.values) > 2 * 0.02)
            fail_msg("run %u: word %g at %g: must be 1 at 0.8", run, r.winner.point.values[0],
                     r.winner.point.values[1]);
        mcv_search_free(&r);
    }
}

static void test_failures(void **state) {
    noisy n = {.of = branin, .run = 5, .fails = true};
    mcv_search search = search_of(&n, branin_box, 2, 70);
    mcv_search_result r;
    (void)state;
    search.better[0] = 0.01;
    search_well(&search, &r);
    assert_true(r.failed > 0 && r.failed < r.count / 2);
    assert_true(branin(r.winner.point.values) < branin_least + 0.02);
    mcv_search_free(&r);
}

/* What has been done is there; the same search comes by the same points. */
static void test_interrupted(void **state) {
    noisy n = {.of = branin, .noise = 0.5, .run = 6, .stop_after = 20};
    mcv_search search = search_of(&n, branin_box, 2, 60);
    mcv_search_result first, second;
    mcv_error error = {""};
    (void)state;
    assert_int_equal(mcv_search_run(&search, &first, &error), MCV_INTERRUPTED);
    assert_int_equal(first.count, 20);
    n.stop_after = 0;
    search_well(&search, &second);
    for (size_t i = 0; i < 20; ++i)
        assert_memory_equal(first.all[i].values, second.all[i].values, 2 * sizeof(double));
    mcv_search_free(&first);
    mcv_search_free(&second);
}

/* --- two objectives --- */

/* Schaffer's: x² and (x - 2)², whose front is 0 <= x <= 2, √f + √g = 2. */
static mcv_result evaluate_two(void *user, mcv_evaluation *e, mcv_error *error) {
    const double x = e->values[0];
    mcv_noise noise = mcv_noise_begin(9, 34, e->seed);
    (void)user;
    (void)error;
    e->results[0] = x * x + 0.02 * mcv_noise_normal(&noise);
    e->results[1] = (x - 2) * (x - 2) + 0.02 * mcv_noise_normal(&noise);
    e->errors[0] = e->errors[1] = 0.02;
    return MCV_OK;
}

static void test_front(void **state) {
    static const mcv_levels levels[] = {{.from = -10, .to = 10}};
    const mcv_search search = {
        .dimensions = 1, .objectives = 2, .levels = levels, .budget = 70, .evaluate = evaluate_two};
    mcv_search_result r;
    double least = INFINITY, largest = -INFINITY;
    (void)state;
    search_well(&search, &r);
    assert_true(r.point_count >= 4);
    for (size_t i = 0; i < r.point_count; ++i) {
        const mcv_confirmed *c = r.points + i;
        const double x = c->point.values[0];
        least = fmin(least, x);
        largest = fmax(largest, x);
        /* Beyond the front by what 0.02 of noise hides: √0.02 = 0.14. */
        if (!(x > -0.2 && x < 2.2)) fail_msg("%g is not on the front", x);
        assert_true(fabs(c->point.results[0] - x * x) < 5 * 0.02 / sqrt((double)c->count));
    }
    assert_true(least < 0.3 && largest > 1.7);
    mcv_search_free(&r);
}

/* --- requirements --- */

/* The corner (1, 1) lies outside of the circle: the nearest point of the disc x² + y² <= 1 is
 * (√½, √½), with 2 (1 - √½)² = 0.1716. Values and margins are noisy. */
static mcv_result evaluate_in_disc(void *user, mcv_evaluation *e, mcv_error *error) {
    noisy *n = user;
    mcv_noise noise = mcv_noise_begin(n->run, 33, e->seed);
    const double x = e->values[0], y = e->values[1];
    (void)error;
    ++n->calls;
    e->results[0] = (x - 1) * (x - 1) + (y - 1) * (y - 1) + n->noise * mcv_noise_normal(&noise);
    e->margins[0] = x * x + y * y - 1 + n->noise * mcv_noise_normal(&noise);
    e->errors[0] = e->margin_errors[0] = n->noise;
    return MCV_OK;
}

/* The mean of the winner's 16 or so fresh margins has an error of a quarter of the noise: at the
 * limit it may be missed by four of these, 0.01, as far as the objective gains: its slope there is
 * 0.41 of the margin's. */
static void meets_requirements(void **state) {
    const double least = 2 * (1 - M_SQRT1_2) * (1 - M_SQRT1_2);
    (void)state;
    for (uint32_t run = 1; run <= 4; ++run) {
        noisy n = {.noise = 0.01, .run = run};
        mcv_search search = search_of(&n, cube, 2, 80);
        mcv_search_result result;
        search.evaluate = evaluate_in_disc;
        search.requirements = 1;
        search.better[0] = 0.02;
        search_well(&search, &result);
        const double *v = result.winner.point.values, margin = v[0] * v[0] + v[1] * v[1] - 1,
                     value = (v[0] - 1) * (v[0] - 1) + (v[1] - 1) * (v[1] - 1);
        print_message("%u: %g at %g, %g: margin %g, %zu calls\n", run, value, v[0], v[1], margin,
                      n.calls);
        assert_true(result.winner.point.margins[0] <= 0.01);
        if (!(margin < 0.01)) fail_msg("run %u: the requirement is missed by %g", run, margin);
        if (!(value < least + 0.03)) fail_msg("run %u: %g, must be %g", run, value, least);
        mcv_search_free(&result);
    }
}

/* No point of the square has x + y > 3. */
static mcv_result evaluate_out_of_reach(void *user, mcv_evaluation *e, mcv_error *error) {
    (void)user;
    (void)error;
    e->results[0] = e->values[0];
    e->margins[0] = 3 - e->values[0] - e->values[1];
    e->errors[0] = e->margin_errors[0] = 0.001;
    return MCV_OK;
}

static void says_where_requirements_cannot_be_met(void **state) {
    noisy n = {.run = 1};
    mcv_search search = search_of(&n, cube, 2, 30);
    mcv_search_result result;
    mcv_error error = {""};
    (void)state;
    search.evaluate = evaluate_out_of_reach;
    search.requirements = 1;
    assert_int_equal(mcv_search_run(&search, &result, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "seems to meet the requirements"));
    mcv_search_free(&result);
}

static double bowl(const double *x) { return (x[0] - 0.3) * (x[0] - 0.3); }

/* Free of noise below the middle: it shows up after the screening, or not at all. */
static mcv_result evaluate_partly_noisy(void *user, mcv_evaluation *e, mcv_error *error) {
    MCV_TRY(evaluate(user, e, error));
    if (e->values[0] < 0.5) e->results[0] = bowl(e->values), e->errors[0] = 0;
    return MCV_OK;
}

/* Whatever the budget is, from the smallest one that the program takes, it holds all stages. */
static void keeps_to_small_budgets(void **state) {
    (void)state;
    for (size_t budget = 20; budget <= 26; ++budget)
        for (size_t dimensions = 1; dimensions <= 6; dimensions += 2)
            for (int partly = 0; partly < 2; ++partly) {
                noisy n = {.of = bowl, .noise = 0.05, .run = (uint32_t)budget};
                mcv_search search = search_of(&n, cube, dimensions, budget);
                mcv_search_result result;
                if (partly) search.evaluate = evaluate_partly_noisy;
                search_well(&search, &result);
                assert_true(result.winner.count >= 2);
                mcv_search_free(&result);
            }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_the_process),
                                       cmocka_unit_test(test_draws),
                                       cmocka_unit_test(test_words_have_no_order),
                                       cmocka_unit_test(test_words),
                                       cmocka_unit_test(test_branin),
                                       cmocka_unit_test(test_noisy_branin),
                                       cmocka_unit_test(test_noisy_hartmann),
                                       cmocka_unit_test(test_constraints),
                                       cmocka_unit_test(test_impossible_constraints),
                                       cmocka_unit_test(test_lists),
                                       cmocka_unit_test(test_logarithmic_ranges),
                                       cmocka_unit_test(test_failures),
                                       cmocka_unit_test(test_interrupted),
                                       cmocka_unit_test(test_front),
                                       cmocka_unit_test(meets_requirements),
                                       cmocka_unit_test(keeps_to_small_budgets),
                                       cmocka_unit_test(says_where_requirements_cannot_be_met)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
