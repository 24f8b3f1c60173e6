/* SPDX-License-Identifier: Apache-2.0 */
#include "harness.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static double seconds_of(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* By the clocks of a process; 0: of this one. */
static bench_seconds now_of(pid_t process) {
    clockid_t clock = CLOCK_PROCESS_CPUTIME_ID;
    const bool is_gone = process != 0 && clock_getcpuclockid(process, &clock) != 0;
    return (bench_seconds){{seconds_of(CLOCK_MONOTONIC), is_gone ? NAN : seconds_of(clock)}};
}

static bench_seconds since(bench_seconds start, bench_seconds now) {
    return (bench_seconds){
        {now.by[BENCH_WALL] - start.by[BENCH_WALL], now.by[BENCH_CPU] - start.by[BENCH_CPU]}};
}

bench_seconds bench_now(void) { return now_of(0); }
bench_seconds bench_since(bench_seconds start) { return since(start, bench_now()); }

mcv_result bench_time(const bench *b, bench_side *sides, size_t count, mcv_error *error) {
    for (size_t i = 0; i < count; ++i) MCV_TRY(sides[i].run(sides[i].user, error));
    for (int r = 0; r < b->repetitions; ++r) {
        for (size_t i = 0; i < count; ++i) {
            /* There and back, so that nobody always follows the same neighbour. */
            bench_side *side = sides + (r % 2 ? count - 1 - i : i);
            const bench_seconds start = now_of(side->process);
            MCV_TRY(side->run(side->user, error));
            side->seconds[r] = since(start, now_of(side->process));
        }
    }
    return MCV_OK;
}

/* --- figures
 * ----------------------------------------------------------------------------------------------------
 */

static int by_value(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The value below which a share of all lies, between the neighbours. */
static double quantile(const double *values, int count, double share) {
    double sorted[BENCH_REPETITIONS];
    memcpy(sorted, values, (size_t)count * sizeof *values);
    qsort(sorted, (size_t)count, sizeof *sorted, by_value);
    const double at = share * (count - 1);
    const int below = (int)at;
    return below + 1 < count ? sorted[below] + (at - below) * (sorted[below + 1] - sorted[below])
                             : sorted[below];
}

double bench_median(const double *values, int count) { return quantile(values, count, 0.5); }

double bench_spread(const double *values, int count) {
    return 0.5 * (quantile(values, count, 0.75) - quantile(values, count, 0.25)) /
           fabs(bench_median(values, count));
}

static void take(const bench *b, const bench_side *side, bench_clock clock, double *values) {
    for (int r = 0; r < b->repetitions; ++r) values[r] = side->seconds[r].by[clock];
}

double bench_side_median(const bench *b, const bench_side *side, bench_clock clock) {
    double values[BENCH_REPETITIONS];
    take(b, side, clock, values);
    return bench_median(values, b->repetitions);
}

void bench_mean_add(bench_mean *mean, double value) {
    mean->log_sum += log(value);
    ++mean->count;
}

double bench_mean_value(const bench_mean *mean) { return exp(mean->log_sum / mean->count); }

/* --- table and JSON
 * --------------------------------------------------------------------------------------------- */

void bench_title(const char *text) {
    printf("\n%s\n%-52s %-10s %10s %10s %7s %7s\n", text, "case", "unit", "ours", "peer", "ratio",
           "spread");
}

static json_t *number_or_null(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static void print_number(double value) {
    if (isfinite(value))
        printf(" %10.4g", value);
    else
        printf(" %10s", "");
}

static void put_row(bench *b, const char *unit, double ours, double peer, double ratio,
                    double spread, const char *format, va_list words) {
    char what[160];
    vsnprintf(what, sizeof what, format, words);
    printf("%-52s %-10s", what, unit);
    print_number(ours);
    print_number(peer);
    if (isfinite(ratio))
        printf(" %7.2f", ratio);
    else
        printf(" %7s", "");
    if (isfinite(spread)) printf(" %5.1f %%", 100 * spread);
    putchar('\n');
    fflush(stdout);
    json_array_append_new(b->rows, json_pack("{s:s, s:s, s:o, s:o, s:o, s:o}", "case", what, "unit",
                                             unit, "ours", number_or_null(ours), "peer",
                                             number_or_null(peer), "ratio", number_or_null(ratio),
                                             "spread", number_or_null(spread)));
}

double bench_row(bench *b, bench_clock clock, const bench_side *ours, const bench_side *peer,
                 double work, const char *unit, const char *format, ...) {
    double mine[BENCH_REPETITIONS] = {0}, theirs[BENCH_REPETITIONS], ratios[BENCH_REPETITIONS];
    double ratio = NAN, other = NAN;
    take(b, ours, clock, mine);
    double spread = bench_spread(mine, b->repetitions);
    if (peer) {
        take(b, peer, clock, theirs);
        for (int r = 0; r < b->repetitions; ++r) ratios[r] = theirs[r] / mine[r];
        ratio = bench_median(ratios, b->repetitions);
        spread = bench_spread(ratios, b->repetitions);
        other = bench_median(theirs, b->repetitions);
    }
    const double own = bench_median(mine, b->repetitions);
    va_list words;
    va_start(words, format);
    put_row(b, unit, work > 0 ? 1e-6 * work / own : own, work > 0 ? 1e-6 * work / other : other,
            ratio, spread, format, words);
    va_end(words);
    return ratio;
}

double bench_number(bench *b, double ours, double peer, const char *unit, const char *format, ...) {
    va_list words;
    va_start(words, format);
    put_row(b, unit, ours, peer, peer / ours, NAN, format, words);
    va_end(words);
    return peer / ours;
}

void bench_more(bench *b, const char *key, double value) {
    json_object_set_new(json_array_get(b->rows, json_array_size(b->rows) - 1), key,
                        number_or_null(value));
}

void bench_summary(bench *b, const char *key, double value) {
    printf("%s: %.3g\n", key, value);
    json_object_set_new(b->summary, key, number_or_null(value));
}

void bench_summary_text(bench *b, const char *key, const char *text) {
    printf("%s: %s\n", key, text);
    json_object_set_new(b->summary, key, json_string(text));
}

/* --- device and main
 * -------------------------------------------------------------------------------------------- */

mcv_result bench_cores(const mcv_cl *all, cl_uint count, mcv_cl *cl, mcv_error *error) {
    const cl_device_partition_property by_count[] = {CL_DEVICE_PARTITION_BY_COUNTS, count,
                                                     CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
    cl_int code;
    *cl = *all;
    cl->context = NULL;
    cl->queue = NULL;
    cl->units = count;
    MCV_TRY(mcv_cl_check(all, clCreateSubDevices(all->device, by_count, 1, &cl->device, NULL),
                         "splitting the device", error));
    cl->context = clCreateContext(NULL, 1, &cl->device, NULL, NULL, &code);
    MCV_TRY(mcv_cl_check(all, code, "making a context", error));
    cl->queue = clCreateCommandQueue(cl->context, cl->device, CL_QUEUE_PROFILING_ENABLE, &code);
    return mcv_cl_check(all, code, "making a command queue", error);
}

/* The first line that a command prints, or "unknown". */
static json_t *line_of(const char *command) {
    char line[128] = "";
    FILE *pipe = popen(command, "r");
    if (pipe) {
        if (!fgets(line, sizeof line, pipe)) line[0] = '\0';
        pclose(pipe);
    }
    line[strcspn(line, "\n")] = '\0';
    return json_string(line[0] ? line : "unknown");
}

static json_t *report_of(const bench *b, const char *name) {
    double load[1] = {NAN};
    char platform[256] = "";
    getloadavg(load, 1);
    clGetPlatformInfo(b->cl.platform, CL_PLATFORM_VERSION, sizeof platform, platform, NULL);
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:o, s:i, s:b, s:i, s:o, s:O, s:O}", "name", name,
                     "device", b->cl.name, "driver", b->cl.version, "platform", platform,
                     "compiler", __VERSION__, "commit",
                     line_of("git -C '" MCV_SOURCE_DIR "' describe --always --dirty 2>/dev/null"),
                     "cores", (int)sysconf(_SC_NPROCESSORS_ONLN), "quick", b->quick, "repetitions",
                     b->repetitions, "load_before", number_or_null(load[0]), "rows", b->rows,
                     "summary", b->summary);
}

static mcv_result run_and_write(bench *b, const char *name,
                                mcv_result (*run)(bench *b, mcv_error *error), mcv_error *error) {
    char path[sizeof b->stem + 8];
    snprintf(path, sizeof path, "%s.json", b->stem);
    MCV_TRY(mcv_cl_open(NULL, &b->cl, error));
    json_t *report = report_of(b, name);
    mcv_result result = run(b, error);
    if (json_dump_file(report, path, JSON_INDENT(1) | JSON_REAL_PRECISION(6)) != 0 &&
        result == MCV_OK)
        result = mcv_fail(error, MCV_FAILED, "%s: cannot be written", path);
    json_decref(report);
    mcv_cl_close(&b->cl);
    return result;
}

int bench_main(int argc, char **argv, const char *name,
               mcv_result (*run)(bench *b, mcv_error *error)) {
    bench b = {.repetitions = BENCH_REPETITIONS};
    mcv_error error = {""};
    const char *output = argv[0];
    for (int i = 1; i < argc; ++i) {
        if (strcmp(argv[i], "--quick") == 0) {
            b.quick = true;
            b.repetitions = BENCH_QUICK_REPETITIONS;
        } else if (strcmp(argv[i], "--only") == 0 && i + 1 < argc) {
            b.only = argv[++i];
        } else if (strcmp(argv[i], "--seed") == 0 && i + 1 < argc) {
            b.seed = (unsigned)strtoul(argv[++i], NULL, 10);
        } else if (argv[i][0] != '-') {
            output = argv[i];
        } else {
            fprintf(stderr,
                    "bench_%s: %s is no option: [--quick] [--only NAME] [--seed N] [FILE.json]\n",
                    name, argv[i]);
            return MCV_USAGE;
        }
    }
    const size_t length = strlen(output);
    const bool ending = length > 5 && strcmp(output + length - 5, ".json") == 0;
    snprintf(b.stem, sizeof b.stem, "%.*s", (int)(ending ? length - 5 : length), output);
    b.rows = json_array();
    b.summary = json_object();
    const mcv_result result = run_and_write(&b, name, run, &error);
    if (result != MCV_OK) fprintf(stderr, "bench_%s: %s\n", name, error.text);
    json_decref(b.rows);
    json_decref(b.summary);
    return result;
}
