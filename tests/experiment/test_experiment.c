/* SPDX-License-Identifier: Apache-2.0 */
/* Experiments from the library, without command line and device: the renders are films whose
 * values, and so all rows, are known in closed form. */
#include "program.h"

#include <fcntl.h>
#include <math.h>

#include "experiment/experiment.h"
#include "scene/sensors.h"

enum { WIDTH = 4, HEIGHT = 2, PIXELS = WIDTH * HEIGHT };

/* Its node mirrors, of which the scene warns. */
static const char scene_text[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"extensionsUsed\":[\"MCVISI_sensors\"],\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{"
    "\"name\":\"cam\",\"type\":\"pinhole\",\"imageDistance\":1,\"resolution\":[4,2],"
    "\"pixelSize\":0.001}]}},\"nodes\":[{\"name\":\"stand\",\"translation\":[0,0,0],\"scale\":[-1,"
    "1,1],\"extensions\":"
    "{\"MCVISI_sensors\":{\"sensor\":0}}}]}";

static size_t renders;

/*
 * The image distance d in every pixel: replicates of d - 1/N and d + 1/N after N samples. Their
 * mean is d, its standard error √(((1/N)² + (1/N)²) / (2 · 1)) = 1/N, and that of the mean of P
 * pixels 1/(N √P). All are exact in float for the numbers below.
 */
static mcv_result render_distance(const mcv_scene *scene, uint32_t sensor,
                                  const mcv_render_options *options, mcv_film *film,
                                  mcv_render_stats *stats, mcv_error *error) {
    const double d = *(const double *)mcv_params_find(mcv_sensor_table(scene->sensors[sensor].type),
                                                      "imageDistance", &scene->sensors[sensor].as);
    ++renders;
    memset(stats, 0, sizeof *stats);
    if (d == 8) return mcv_fail(error, MCV_FAILED, "no, \"not\" this\none");
    MCV_TRY(mcv_film_new(film, WIDTH, HEIGHT, 1, 2, error));
    for (film->samples = 1; film->samples <= options->last; film->samples *= 2) {
        for (size_t i = 0; i < (size_t)2 * PIXELS; ++i)
            film->sums[i] = (double)film->samples * d + (i < PIXELS ? -1 : 1);
        if (film->samples == options->last ||
            (options->enough && options->enough(options->user, film)) ||
            !options->progress(options->user, 0, 0, 0))
            break;
    }
    return MCV_OK;
}

/* What the calls were told. */
typedef struct told {
    size_t warnings, rows, stop_after; /* stop_after: 0: never */
} told;

static void take_warning(void *user, const char *sentence) {
    assert_non_null(strstr(sentence, "mirrors"));
    ++((told *)user)->warnings;
}

static void take_row(void *user, const mcv_sweep *sweep, const double *row, const char *message) {
    told *t = user;
    ++t->rows;
    assert_memory_equal(row,
                        sweep->table.rows + (sweep->table.row_count - 1) * sweep->table.columns,
                        sweep->table.columns * sizeof *row);
    const char *kept = sweep->table.messages[sweep->table.row_count - 1];
    assert_string_equal(message ? message : "", kept ? kept : "");
}

static mcv_result is_stopped(void *user) {
    const told *t = user;
    return t->stop_after && t->rows >= t->stop_after ? MCV_INTERRUPTED : MCV_OK;
}

#define TEXTS(...) \
    ((mcv_texts){(const char *const[]){__VA_ARGS__}, \
                 sizeof((const char *const[]){__VA_ARGS__}) / sizeof(char *)})

static mcv_experiment make_experiment(told *t) {
    *t = (told){0};
    renders = 0;
    return (mcv_experiment){
        .rig = "s.gltf",
        .render = {.replicates = 2, .last = 4},
        .render_with = render_distance,
        .table = "t.csv",
        .calls = {.warning = take_warning, .row = take_row, .interrupted = is_stopped, .user = t}};
}

/* One metric, the mean. */
static mcv_experiment mean_along(told *t, mcv_texts vary) {
    static const char *const metrics[] = {"mean"};
    mcv_experiment e = make_experiment(t);
    e.variation.vary = vary;
    e.measuring.metrics = (mcv_texts){metrics, 1};
    return e;
}

static mcv_result run_steps(const mcv_experiment *experiment, mcv_sweep *sweep, mcv_error *error) {
    MCV_TRY(mcv_experiment_plan(experiment, sweep, error));
    MCV_TRY(mcv_experiment_open_table(sweep, error));
    return mcv_experiment_run(sweep, error);
}

/* The library prints nothing, neither to standard output nor to standard error. */
static mcv_result run(const mcv_experiment *experiment, mcv_sweep *sweep, mcv_error *error) {
    struct stat status;
    int kept[2];
    error->text[0] = '\0';
    fflush(NULL);
    const int file = open("printed.txt", O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    for (int i = 0; i < 2; ++i) {
        kept[i] = dup(i + 1);
        dup2(file, i + 1);
    }
    const mcv_result result = run_steps(experiment, sweep, error);
    fflush(NULL);
    for (int i = 0; i < 2; ++i) {
        dup2(kept[i], i + 1);
        close(kept[i]);
    }
    close(file);
    assert_int_equal(stat("printed.txt", &status), 0);
    assert_int_equal(status.st_size, 0);
    return result;
}

static void run_well(const mcv_experiment *experiment, mcv_sweep *sweep) {
    mcv_error error;
    const mcv_result result = run(experiment, sweep, &error);
    if (result != MCV_OK) fail_msg("%d: %s", (int)result, error.text);
}

static void run_fails(const mcv_experiment *experiment, mcv_result code, const char *words) {
    mcv_sweep sweep;
    mcv_error error;
    const mcv_result result = run(experiment, &sweep, &error);
    mcv_experiment_free(&sweep);
    if (result != code || !strstr(error.text, words))
        fail_msg("%d, not %d with \"%s\": %s", (int)result, (int)code, words, error.text);
}

static int fresh(void **state) {
    (void)state;
    if (system("rm -rf ./*") != 0) return -1;
    FILE *file = fopen("s.gltf", "w");
    return !file || fputs(scene_text, file) < 0 || fclose(file) != 0 ? -1 : 0;
}

/* Doubles of one row: parameters, value and uncertainty of each metric, samples. Of the mean of 8
 * pixels and its square root of a sum of squares, to some roundings of double. */
static void check_row(const mcv_sweep *sweep, size_t row, const double *wanted, size_t count) {
    const double *got = sweep->table.rows + row * sweep->table.columns;
    for (size_t i = 0; i < count; ++i)
        if (!(fabs(got[i] - wanted[i]) <= 1e-14 * fabs(wanted[i])))
            fail_msg("row %zu, column %zu: %.17g, not %.17g", row, i, got[i], wanted[i]);
}

static void test_rows(void **state) {
    const double u = 0.25 / sqrt(PIXELS); /* N = 4 samples */
    told t;
    mcv_sweep sweep;
    mcv_experiment e = make_experiment(&t);
    (void)state;
    e.variation = (mcv_variation){.vary = TEXTS("sensors/cam/imageDistance=1,2,4"),
                                  .tie = TEXTS("nodes/stand/translation/z=imageDistance*1mm"),
                                  .where = TEXTS("imageDistance!=2")};
    e.measuring.metrics = TEXTS("mean", "x:=3*mean+1");
    e.images = "kept";
    e.settings = json_pack("{s:s}", "metric", "mean");
    run_well(&e, &sweep);
    assert_int_equal(sweep.table.row_count, 2);
    assert_int_equal(sweep.plan.wanted, 2);
    assert_int_equal(t.rows, 2);
    assert_int_equal(t.warnings, 1); /* of the scene, not of each set */
    assert_int_equal(renders, 2);
    assert_string_equal(sweep.plan.parameters[0].name, "imageDistance");
    check_row(&sweep, 0, (const double[]){1, 1e-3, 1, u, 4, 3 * u, 8}, 7);
    check_row(&sweep, 1, (const double[]){4, 4e-3, 4, u, 13, 3 * u, 8}, 7);
    assert_true(sweep.table.rows[mcv_row_fixed(&sweep.table, MCV_ROW_SET)] == 0 &&
                sweep.table.rows[sweep.table.columns + mcv_row_fixed(&sweep.table, MCV_ROW_SET)] ==
                    2);
    const double *extremes[2];
    mcv_table_extremes(&sweep.table, 1, extremes);
    assert_true(extremes[0] == sweep.table.rows &&
                extremes[1] == sweep.table.rows + sweep.table.columns);
    mcv_experiment_free(&sweep);
    json_decref(e.settings);
    assert_int_equal(system("head -1 t.csv | grep -qx 'set,imageDistance,z,mean,mean_u,x,x_u,"
                            "samples,render_error,seconds,message' && test $(wc -l <t.csv) -eq 3 "
                            "&& grep -q '\"metric\": \"mean\"' t.json && grep -q '<svg' t.html && "
                            "test -s kept/set-00000.exr && test ! -e kept/set-00001.exr"),
                     0);
}

/* A set that fails is a row, and its sentence is one line of the file and comes back from it. */
static void test_failing_set(void **state) {
    told t;
    mcv_sweep sweep;
    mcv_experiment e = mean_along(&t, TEXTS("sensors/cam/imageDistance=8,1,-1"));
    (void)state;
    for (int again = 0; again < 2; ++again) {
        e.resume = again;
        run_well(&e, &sweep);
        assert_int_equal(sweep.table.row_count, 3);
        assert_int_equal(mcv_table_failed(&sweep.table), 2);
        assert_true(isnan(sweep.table.rows[1]) && sweep.table.rows[sweep.table.columns + 1] == 1);
        assert_string_equal(sweep.table.messages[0], "no, \"not\" this one");
        assert_null(sweep.table.messages[1]);
        assert_non_null(strstr(sweep.table.messages[2], "imageDistance"));
        mcv_experiment_free(&sweep);
    }
    assert_int_equal(system("grep -q '\"no, \"\"not\"\" this one\"$' t.csv"), 0);
    assert_int_equal(renders, 2); /* the third scene is none; nothing is done again */
    assert_int_equal(t.rows, 3);
}

static void test_interrupted(void **state) {
    told t;
    mcv_sweep sweep;
    mcv_experiment e = mean_along(&t, TEXTS("sensors/cam/imageDistance=1..4:4"));
    (void)state;
    e.settings = json_pack("{s:i}", "spp", 8);
    t.stop_after = 2;
    run_fails(&e, MCV_INTERRUPTED, "2 rows are in t.csv");
    assert_int_equal(renders, 3); /* the third one has begun, and left no row */
    assert_int_equal(t.rows, 2);
    assert_int_equal(system("grep -q '<svg' t.html && printf 2,3,0.7 >>t.csv"), 0);
    t.stop_after = 0;
    run_fails(&e, MCV_BAD_INPUT, "t.csv exists already");
    e.resume = true;
    json_object_set_new(e.settings, "spp", json_integer(9));
    run_fails(&e, MCV_BAD_INPUT, "--spp differs from that of t.csv");
    json_object_set_new(e.settings, "spp", json_integer(8));
    renders = 0;
    run_well(&e, &sweep);
    assert_int_equal(renders, 2);
    for (size_t i = 0; i < 4; ++i) {
        const double d = (double)i + 1;
        /* The file has ten digits of the uncertainty. */
        const double *row = sweep.table.rows + i * sweep.table.columns;
        assert_true(row[0] == d && row[1] == d &&
                    fabs(row[2] * 4 * sqrt(PIXELS) - 1) <= (i < 2 ? 5e-10 : 1e-14));
    }
    mcv_experiment_free(&sweep);
    /* What a crash had left of a row is gone: five lines of eight fields. */
    assert_int_equal(system("test $(wc -l <t.csv) -eq 5 && awk -F, 'NF != 8 {exit 1}' t.csv"), 0);
    assert_int_equal(system("printf ' ' >>s.gltf"), 0);
    run_fails(&e, MCV_BAD_INPUT, "has changed since t.csv was begun");
    json_decref(e.settings);
}

/* 1/(N √8) is at most 0.01 from N = 64 samples of each of 2 replicates on. */
static void test_until(void **state) {
    told t;
    mcv_sweep sweep;
    mcv_experiment e = make_experiment(&t);
    (void)state;
    e.variation.vary = TEXTS("sensors/cam/imageDistance=1");
    e.measuring.metrics = TEXTS("m:=mean");
    e.measuring.until = TEXTS("m=0.01");
    e.render.last = 1024;
    run_well(&e, &sweep);
    check_row(&sweep, 0, (const double[]){1, 1, 1 / (64 * sqrt(PIXELS)), 128}, 4);
    mcv_experiment_free(&sweep);
}

static void page_has(const char *words) {
    if (!strstr(read_whole("t.html"), words)) fail_msg("the page lacks %s", words);
}

/* Values in the units that were typed, with the uncertainty 1/(4 √8) = 0.088; the best set, what is
 * as good, and names that are no HTML. */
static void test_page(void **state) {
    told t;
    mcv_sweep sweep;
    mcv_experiment e = mean_along(&t, TEXTS("sensors/cam/imageDistance=100cm,125cm,400cm"));
    (void)state;
    setenv("SOURCE_DATE_EPOCH", "1000000000", 1);
    e.title = "</script><img src=x onerror=alert(1)>";
    e.note = "Which & \"why\"?";
    e.measuring.best = "mean=smallest";
    e.settings = json_pack("{s:s, s:i, s:i, s:s}", "metric", "mean", "spp", 8, "seed", 5, "set",
                           "sensors/cam/name=it's");
    run_well(&e, &sweep);
    mcv_experiment_free(&sweep);
    page_has("imageDistance [cm]");
    page_has("<td>100<td>1.000(88)");
    page_has("<td>125<td>1.250(88)");
    page_has("<td>400<td>4.000(88)");
    page_has("mean [W/(m^2 sr)]");
    page_has("The best set is <a href=\"#s0\">0</a>: imageDistance 100 cm");
    page_has("1.000(88) W/(m^2 sr), the smallest of 3 sets");
    /* 0.25 is 2.0 of √2 0.088; 3 is far more. */
    page_has("difference is set <a href=\"#s1\">1</a>.");
    page_has("<tr id=\"s0\" class=\"best\">");
    page_has("2001-09-09 · mcvisi " MCV_VERSION " · 3 of 3 sets");
    page_has("&lt;/script&gt;&lt;img src=x onerror=alert(1)&gt;");
    page_has("Which &amp; &quot;why&quot;?");
    page_has(
        "mcvisi render s.gltf --seed 5 --set 'sensors/cam/name=it'\\''s' --set "
        "sensors/cam/imageDistance=1.25 --adaptive off --light-paths on --spp 8 -o set-00001.exr");
    page_has("The rig, as in set 0");
    page_has("mirrors"); /* the warning of the scene */
    assert_int_equal(system("cp t.html before.html"), 0);
    /* The same table gives the same page; what only the page tells may change. */
    e.resume = true;
    run_well(&e, &sweep);
    mcv_experiment_free(&sweep);
    assert_int_equal(system("cmp t.html before.html"), 0);
    e.measuring.best = "mean=largest";
    json_object_set_new(e.settings, "best", json_string(e.measuring.best));
    run_well(&e, &sweep);
    mcv_experiment_free(&sweep);
    page_has("No other set is as good");
    page_has("The best set is <a href=\"#s2\">2</a>: imageDistance 400 cm");
    json_decref(e.settings);
    unsetenv("SOURCE_DATE_EPOCH");
}

/* No set has the metric, or there is one set: no picture, no best one, and no crash. */
static void test_page_of_failures(void **state) {
    told t;
    mcv_sweep sweep;
    mcv_experiment e = mean_along(&t, TEXTS("sensors/cam/imageDistance=8,-1"));
    (void)state;
    e.measuring.best = "mean=largest";
    run_well(&e, &sweep);
    mcv_experiment_free(&sweep);
    page_has("2 failed");
    page_has("no, &quot;not&quot; this one");
    assert_null(strstr(read_whole("t.html"), "The best set"));
    assert_null(strstr(read_whole("t.html"), "nan"));
}

/* Two parameters: a heat map of 3 x 2 cells, each a link to its set. */
static void test_heat_map(void **state) {
    told t;
    mcv_sweep sweep;
    mcv_experiment e = mean_along(
        &t, TEXTS("sensors/cam/imageDistance=1,2,4", "nodes/stand/translation/z=1mm,2mm"));
    (void)state;
    run_well(&e, &sweep);
    mcv_experiment_free(&sweep);
    assert_int_equal(system("test $(grep -o 's[0-9].><rect' t.html | wc -l) -eq 6 && "
                            "test $(grep -c '<svg class=\"plot\"' t.html) -eq 3"),
                     0);
    e.force = true;
    e.variation.vary =
        TEXTS("sensors/cam/imageDistance=1..4", "nodes/stand/translation/z=1mm..2mm");
    e.variation.design = MCV_DESIGN_LHS;
    e.variation.points = 6;
    run_well(&e, &sweep); /* no grid: six points */
    mcv_experiment_free(&sweep);
    assert_int_equal(system("test $(grep -o 's[0-9].><rect' t.html | wc -l) -eq 0 && "
                            "test $(grep -o 'r=\"6\"' t.html | wc -l) -eq 6"),
                     0);
}

static void test_errors_are_values(void **state) {
    told t;
    mcv_experiment e = make_experiment(&t);
    (void)state;
    run_fails(&e, MCV_USAGE, "--vary is missing");
    e.variation.vary = TEXTS("sensors/cam/imageDistance=1,2");
    run_fails(&e, MCV_USAGE, "--metric is missing");
    e.measuring.metrics = TEXTS("dent.mean");
    run_fails(&e, MCV_USAGE, "no --region with the name \"dent\"");
    e.measuring.metrics = TEXTS("mean");
    e.measuring.best = "mean";
    run_fails(&e, MCV_USAGE, "--best mean: must be NAME=largest or NAME=smallest");
    e.measuring.best = "mean=most";
    run_fails(&e, MCV_USAGE, "--best mean=most: must be");
    e.measuring.best = "men=largest";
    run_fails(&e, MCV_USAGE, "--best men=largest: there is no --metric with this name");
    e.measuring.best = NULL;
    e.measuring.places.regions = TEXTS("dent=0,0,2,2");
    e.table = "t.txt";
    run_fails(&e, MCV_USAGE, "must end in .csv");
    e.table = "nowhere/t.csv";
    run_fails(&e, MCV_BAD_INPUT, "nowhere");
    e.table = "t.csv";
    e.rig = "none.gltf";
    run_fails(&e, MCV_BAD_INPUT, "none.gltf");
    e.rig = "s.gltf";
    e.file = "t.json";
    assert_int_equal(system("echo {} >t.json"), 0);
    run_fails(&e, MCV_USAGE, "t.json is the experiment");
    e.file = NULL;
    e.variation.vary = TEXTS("sensors/camm/imageDistance=1");
    run_fails(&e, MCV_BAD_INPUT, "did you mean");
    assert_int_equal(renders, 0);
    assert_int_equal(system("test ! -e t.csv && test ! -e t.html"), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_rows, fresh),
        cmocka_unit_test_setup(test_failing_set, fresh),
        cmocka_unit_test_setup(test_interrupted, fresh),
        cmocka_unit_test_setup(test_until, fresh),
        cmocka_unit_test_setup(test_page, fresh),
        cmocka_unit_test_setup(test_page_of_failures, fresh),
        cmocka_unit_test_setup(test_heat_map, fresh),
        cmocka_unit_test_setup(test_errors_are_values, fresh),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
