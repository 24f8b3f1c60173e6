/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/lightfield.h"

#include "analysis/noise.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <unistd.h>

mcv_result mcv_light_field_check(const char *path, const mcv_image *image,
                                 const uint32_t angular[2], mcv_error *error) {
    if (angular[0] == 0 || angular[1] == 0 || image->width % angular[0] ||
        image->height % angular[1])
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: its %u x %u pixels must be a whole number of macro pixels of %u x %u",
                        path, image->width, image->height, angular[0], angular[1]);
    const size_t pixels = (size_t)image->width * image->height;
    bool light = false;
    for (size_t i = 0; i < pixels * image->channels; ++i) {
        const double value = image->pixels[i];
        if (!isfinite(value))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: pixel (%zu, %zu) is %s: every pixel must be a finite number", path,
                            i % pixels % image->width, i % pixels / image->width,
                            isnan(value) ? "NaN" : "infinite");
        light = light || value > 0;
    }
    if (!light)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: the whole image is dark: there must be a pixel above 0", path);
    return MCV_OK;
}

mcv_result mcv_light_field_views(const mcv_image *image, const uint32_t angular[2],
                                 mcv_image *views, mcv_error *error) {
    MCV_TRY(mcv_image_new(views, image->width, image->height, image->channels, error));
    const uint32_t columns = image->width / angular[0], rows = image->height / angular[1];
    for (uint32_t c = 0; c < image->channels; ++c) {
        const size_t plane = (size_t)c * image->width * image->height;
        for (uint32_t y = 0; y < image->height; ++y) {
            for (uint32_t x = 0; x < image->width; ++x) {
                const size_t to_row = (size_t)(y % angular[1]) * rows + y / angular[1];
                const size_t to_column = (size_t)(x % angular[0]) * columns + x / angular[0];
                views->pixels[plane + to_row * image->width + to_column] =
                    image->pixels[plane + (size_t)y * image->width + x];
            }
        }
    }
    return MCV_OK;
}

/* Pixel (column, row), summed over the channels. */
static double sum_channels(const mcv_image *image, uint32_t column, uint32_t row) {
    const size_t plane = (size_t)image->width * image->height;
    double sum = 0;
    for (uint32_t c = 0; c < image->channels; ++c)
        sum += image->pixels[c * plane + (size_t)row * image->width + column];
    return sum;
}

mcv_result mcv_light_field_plain(const mcv_image *image, const uint32_t angular[2],
                                 mcv_image *plain, mcv_error *error) {
    MCV_TRY(mcv_image_new(plain, image->width / angular[0], image->height / angular[1], 1, error));
    for (uint32_t n = 0; n < plain->height; ++n) {
        for (uint32_t m = 0; m < plain->width; ++m) {
            double sum = 0;
            for (uint32_t k = 0; k < angular[1]; ++k)
                for (uint32_t j = 0; j < angular[0]; ++j)
                    sum += sum_channels(image, m * angular[0] + j, n * angular[1] + k);
            plain->pixels[(size_t)n * plain->width + m] = (float)sum;
        }
    }
    return MCV_OK;
}

/* --- gradient --- */

typedef struct gradient_job {
    const mcv_image *image;
    const mcv_image *errors; /* of the noise floor; NULL: the gradient itself */
    const uint32_t *angular;
    mcv_emd_form form;
    double unit; /* of mass */
    mcv_image *gradient;
    atomic_uint next_row;
} gradient_job;

/* A thread's memory. */
typedef struct worker {
    gradient_job *job;
    mcv_emd *emd;
    double *p, *q;
} worker;

/* The histogram of macro pixel (m, n) in units of mass; its mass. */
static double gather(const gradient_job *job, uint32_t m, uint32_t n, double *histogram) {
    const uint32_t *angular = job->angular;
    double mass = 0;
    for (uint32_t k = 0; k < angular[1]; ++k) {
        for (uint32_t j = 0; j < angular[0]; ++j) {
            const double value =
                fmax(0, sum_channels(job->image, m * angular[0] + j, n * angular[1] + k)) /
                job->unit;
            histogram[(size_t)k * angular[0] + j] = value;
            mass += value;
        }
    }
    return mass;
}

static double distance(const worker *w, uint32_t m0, uint32_t n0, uint32_t m1, uint32_t n1) {
    gather(w->job, m0, n0, w->p);
    gather(w->job, m1, n1, w->q);
    return mcv_emd_distance(w->emd, w->p, w->q, w->job->form, NULL);
}

/* --- noise floor --- */

enum { DRAWS = 4 };

/* The square root of the sum of the channels' squared errors, in units of mass. */
static double error_of(const gradient_job *job, uint32_t column, uint32_t row) {
    const size_t plane = (size_t)job->errors->width * job->errors->height;
    double sum = 0;
    for (uint32_t c = 0; c < job->errors->channels; ++c) {
        const double e = job->errors->pixels[c * plane + (size_t)row * job->errors->width + column];
        sum += isfinite(e) ? e * e : 0;
    }
    return sqrt(sum) / job->unit;
}

/* Adds the noise of macro pixel (m, n) to a histogram; negative values count as 0. */
static void disturb(const gradient_job *job, uint32_t m, uint32_t n, mcv_noise *noise,
                    double *histogram) {
    const uint32_t *angular = job->angular;
    for (uint32_t bin = 0; bin < angular[0] * angular[1]; ++bin) {
        const uint32_t j = bin % angular[0], k = bin / angular[0];
        histogram[bin] =
            fmax(0, histogram[bin] + error_of(job, m * angular[0] + j, n * angular[1] + k) *
                                         mcv_noise_normal(noise));
    }
}

/* The distance of two draws about the mean of both histograms. */
static double noise_distance(const worker *w, mcv_noise *noise, uint32_t m0, uint32_t n0,
                             uint32_t m1, uint32_t n1) {
    const gradient_job *job = w->job;
    gather(job, m0, n0, w->p);
    gather(job, m1, n1, w->q);
    for (uint32_t bin = 0; bin < job->angular[0] * job->angular[1]; ++bin)
        w->p[bin] = w->q[bin] = 0.5 * (w->p[bin] + w->q[bin]);
    disturb(job, m0, n0, noise, w->p);
    disturb(job, m1, n1, noise, w->q);
    return mcv_emd_distance(w->emd, w->p, w->q, job->form, NULL);
}

static double floor_at(const worker *w, uint32_t m, uint32_t n) {
    double sum = 0;
    for (uint32_t draw = 0; draw < DRAWS; ++draw) {
        mcv_noise noise = mcv_noise_begin(draw, 0, (uint64_t)n * w->job->gradient->width + m);
        const double x = noise_distance(w, &noise, m - 1, n, m + 1, n),
                     y = noise_distance(w, &noise, m, n - 1, m, n + 1);
        sum += 0.5 * hypot(x, y);
    }
    return sum / DRAWS;
}

/* --- threads --- */

static double gradient_at(const worker *w, uint32_t m, uint32_t n) {
    if (w->job->errors) return floor_at(w, m, n);
    return 0.5 * hypot(distance(w, m - 1, n, m + 1, n), distance(w, m, n - 1, m, n + 1));
}

static void *run_worker(void *user) {
    const worker *w = user;
    mcv_image *g = w->job->gradient;
    for (uint32_t n; (n = atomic_fetch_add(&w->job->next_row, 1)) < g->height;) {
        for (uint32_t m = 0; m < g->width; ++m) {
            const bool border = m == 0 || n == 0 || m + 1 == g->width || n + 1 == g->height;
            g->pixels[(size_t)n * g->width + m] = border ? NAN : (float)gradient_at(w, m, n);
        }
    }
    return NULL;
}

static int compare_numbers(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The median mass of the macro pixels that are not empty; 0: all are. */
static mcv_result find_unit(gradient_job *job, double *histogram, mcv_error *error) {
    const mcv_image *g = job->gradient;
    double *masses = malloc((size_t)g->width * g->height * sizeof *masses);
    size_t count = 0;
    if (!masses)
        return mcv_fail(error, MCV_FAILED, "no memory for the masses of %u x %u macro pixels",
                        g->width, g->height);
    job->unit = 1;
    for (uint32_t n = 0; n < g->height; ++n) {
        for (uint32_t m = 0; m < g->width; ++m) {
            masses[count] = gather(job, m, n, histogram);
            count += masses[count] > 0;
        }
    }
    qsort(masses, count, sizeof *masses, compare_numbers);
    if (count > 0) job->unit = 0.5 * (masses[(count - 1) / 2] + masses[count / 2]);
    free(masses);
    return MCV_OK;
}

static mcv_result new_worker(worker *w, gradient_job *job, mcv_error *error) {
    const size_t bins = (size_t)job->angular[0] * job->angular[1];
    w->job = job;
    MCV_TRY(mcv_emd_new(&w->emd, job->angular[0], job->angular[1], error));
    w->p = malloc(2 * bins * sizeof *w->p);
    if (!w->p) return mcv_fail(error, MCV_FAILED, "no memory for histograms of %zu bins", bins);
    w->q = w->p + bins;
    return MCV_OK;
}

enum { MAX_THREADS = 1024 };

static mcv_result run_workers(gradient_job *job, worker *workers, uint32_t count,
                              mcv_error *error) {
    pthread_t threads[MAX_THREADS];
    uint32_t started = 1;
    for (uint32_t i = 0; i < count; ++i) MCV_TRY(new_worker(workers + i, job, error));
    MCV_TRY(find_unit(job, workers->p, error));
    /* Without a thread its rows go to the others. */
    while (started < count &&
           pthread_create(threads + started, NULL, run_worker, workers + started) == 0)
        ++started;
    run_worker(workers);
    for (uint32_t i = 1; i < started; ++i) pthread_join(threads[i], NULL);
    return MCV_OK;
}

/* The gradient, or with errors its noise floor. */
static mcv_result run_job(gradient_job *job, uint32_t threads, mcv_error *error) {
    const mcv_image *image = job->image;
    MCV_TRY(mcv_image_new(job->gradient, image->width / job->angular[0],
                          image->height / job->angular[1], 1, error));
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (threads == 0) threads = cores > 0 ? (uint32_t)cores : 1;
    if (threads > MAX_THREADS) threads = MAX_THREADS;
    worker workers[MAX_THREADS] = {{0}};
    const mcv_result result = run_workers(job, workers, threads, error);
    for (uint32_t i = 0; i < threads; ++i) {
        mcv_emd_free(workers[i].emd);
        free(workers[i].p);
    }
    if (result != MCV_OK) mcv_image_free(job->gradient);
    return result;
}

mcv_result mcv_light_field_gradient(const mcv_image *image, const uint32_t angular[2],
                                    mcv_emd_form form, uint32_t threads, mcv_image *gradient,
                                    mcv_error *error) {
    gradient_job job = {.image = image, .angular = angular, .form = form, .gradient = gradient};
    return run_job(&job, threads, error);
}

mcv_result mcv_light_field_floor(const mcv_image *image, const mcv_image *errors,
                                 const uint32_t angular[2], mcv_emd_form form, uint32_t threads,
                                 mcv_image *noise_floor, mcv_error *error) {
    gradient_job job = {.image = image,
                        .errors = errors,
                        .angular = angular,
                        .form = form,
                        .gradient = noise_floor};
    return run_job(&job, threads, error);
}
