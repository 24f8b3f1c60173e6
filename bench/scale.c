/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How the cost grows with the work: bench_scale [--quick] [OUTPUT.json]. Wall clock, all cores
 * unless said otherwise.
 *
 *   - triangles: the inside of a bumpy diffuse sphere of 1 k to 10 M, where every path meets six
 *     surfaces: rays per second of a launch, seconds to set the scene up, bytes of its hierarchy;
 *   - bounces: the same with 10 k triangles, 1 to 32 surfaces a path: rays per second;
 *   - pixels and samples: report-clean, samples per second of rendering alone; a few pixels or
 *     samples do not fill the cores;
 *   - threads: report-clean on 1 to all cores, samples per second and, as ratio, the speed-up.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drive.h"
#include "harness.h"
#include "mesh.h"
#include "scene/sensors.h"

enum { MOST_POINTS = 16, SPHERE_PIXELS = 64, SPHERE_DEPTH = 6 };

/* --- scenes
 * -----------------------------------------------------------------------------------------------------
 */

/* A camera in the middle of a sphere of 12 squares² diffuse triangles. */
static mcv_result add_sphere(mcv_scene *scene, uint32_t squares, mcv_error *error) {
    static const double identity[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    mcv_transform here;
    mesh m = mesh_sphere(squares, 0.1);
    const mcv_mesh sphere = {.name = (char *)"sphere",
                             .vertex_count = m.vertex_count,
                             .triangle_count = m.triangle_count,
                             .positions = m.positions,
                             .indices = m.indices};
    const mcv_material grey = {.name = (char *)"grey",
                               .type = MCV_MATERIAL_DIFFUSE,
                               .texture = MCV_NONE,
                               .as.diffuse.reflectance = {0.5, 0.5, 0.5}};
    memcpy(here.m, identity, sizeof identity);
    mcv_result result = mcv_scene_add_mesh(scene, &sphere, error);
    mesh_free(&m);
    MCV_TRY(result);
    MCV_TRY(mcv_scene_add_material(scene, &grey, error));
    MCV_TRY(mcv_scene_add_instance(
        scene, &(mcv_instance){.name = (char *)"sphere", .emitter = MCV_NONE, .to_world = here},
        error));
    mcv_sensor sensor = {.name = (char *)"camera", .type = MCV_SENSOR_PINHOLE, .to_world = here};
    mcv_params_set_defaults(mcv_sensor_table(MCV_SENSOR_PINHOLE), &sensor.as);
    mcv_pinhole_params *p = &sensor.as.pinhole;
    p->imageDistance = 0.01;
    for (int k = 0; k < 2; ++k) {
        p->resolution[k] = SPHERE_PIXELS;
        p->pixelSize[k] = 0.015 / SPHERE_PIXELS;
    }
    return mcv_scene_add_sensor(scene, &sensor, error);
}

static mcv_result make_sphere(uint32_t squares, mcv_scene **scene, mcv_error *error) {
    *scene = mcv_scene_new("sphere");
    return *scene ? add_sphere(*scene, squares, error)
                  : mcv_fail(error, MCV_FAILED, "no memory for a scene");
}

/* --- triangles and threads: the same launch again and again
 * ----------------------------------------------------------- */

static double rays_of(const drive *d) { return (double)(d->stats.rays + d->stats.shadow_rays); }

static mcv_result bench_triangles_of(bench *b, uint32_t squares, double *nanoseconds,
                                     mcv_error *error) {
    mcv_scene *scene;
    drive d = {0};
    bench_side side = {.run = drive_run, .user = &d};
    drive_options options = drive_defaults(MCV_SCHEDULE_TILE);
    options.depth = SPHERE_DEPTH;
    mcv_result result = make_sphere(squares, &scene, error);
    const bench_seconds begun = bench_now();
    if (result == MCV_OK) result = drive_open(&b->cl, scene, options, &d, error);
    const double setup = bench_since(begun).by[BENCH_WALL] - d.seconds_program;
    if (result == MCV_OK) result = bench_time(b, &side, 1, error);
    if (result == MCV_OK) {
        const double triangles = scene->triangle_count;
        bench_row(b, BENCH_WALL, &side, NULL, rays_of(&d), "Mrays/s", "triangles %.0f", triangles);
        *nanoseconds = 1e9 * bench_side_median(b, &side, BENCH_WALL) / rays_of(&d);
        bench_more(b, "triangles", triangles);
        bench_more(b, "nanoseconds", *nanoseconds);
        bench_more(b, "setup_seconds", setup);
        bench_more(b, "setup_nanoseconds_per_triangle", 1e9 * setup / triangles);
    }
    drive_close(&d);
    mcv_scene_free(scene);
    return result;
}

static mcv_result bench_triangles(bench *b, mcv_error *error) {
    static const uint32_t squares[] = {9, 29, 91, 289, 913};
    const int count = b->quick ? 3 : 5;
    double nanoseconds[5] = {0};
    for (int i = 0; i < count; ++i)
        MCV_TRY(bench_triangles_of(b, squares[i], nanoseconds + i, error));
    bench_summary(b, "cost_per_decade_of_triangles",
                  pow(nanoseconds[count - 1] / nanoseconds[0], 1.0 / (count - 1)));
    return MCV_OK;
}

static mcv_result bench_threads(bench *b, const mcv_scene *scene, mcv_error *error) {
    mcv_cl cores[MOST_POINTS] = {{0}};
    drive drives[MOST_POINTS] = {{0}};
    bench_side sides[MOST_POINTS] = {{0}};
    cl_uint threads = 1;
    int count = 0;
    mcv_result result = MCV_OK;
    while (result == MCV_OK && count < MOST_POINTS) {
        result = bench_cores(&b->cl, threads, cores + count, error);
        if (result == MCV_OK)
            result = drive_open(cores + count, scene, drive_defaults(MCV_SCHEDULE_TILE),
                                drives + count, error);
        sides[count] = (bench_side){.run = drive_run, .user = drives + count};
        ++count;
        if (threads == b->cl.units) break;
        threads = 2 * threads < b->cl.units ? 2 * threads : b->cl.units;
    }
    if (result == MCV_OK) result = bench_time(b, sides, (size_t)count, error);
    double speedup = 1;
    for (int i = 0; i < count; ++i) {
        if (result == MCV_OK) {
            const double paths = (double)drives[i].stats.paths;
            speedup = bench_row(b, BENCH_WALL, sides + i, sides, paths, "Msamples/s", "threads %u",
                                cores[i].units);
            bench_more(b, "threads", cores[i].units);
        }
        drive_close(drives + i);
        mcv_cl_close(cores + i);
    }
    if (result == MCV_OK) bench_summary(b, "thread_speedup", speedup);
    return result;
}

/* --- renders
 * ----------------------------------------------------------------------------------------------------
 */

/* A render with its options, timed by itself. */
typedef struct point {
    mcv_scene *scene;
    mcv_render_options options;
    mcv_render_stats stats;
    double x; /* what changes */
} point;

static mcv_result run_point(point *p, bench_seconds *seconds, mcv_error *error) {
    mcv_film film;
    memset(&p->stats, 0, sizeof p->stats);
    MCV_TRY(mcv_render(p->scene, 0, &p->options, &film, &p->stats, error));
    mcv_film_free(&film);
    seconds->by[BENCH_WALL] = p->stats.seconds_render;
    return MCV_OK;
}

/* Renders of all points in turns; a row each, of rays or of samples. Returns the first's
 * nanoseconds over the last's. */
static mcv_result bench_points(bench *b, const char *what, bool rays, point *points, int count,
                               double *first_over_last, mcv_error *error) {
    bench_side sides[MOST_POINTS] = {{0}};
    double nanoseconds[MOST_POINTS];
    for (int r = -1; r < b->repetitions; ++r) { /* the first does not count */
        for (int i = 0; i < count; ++i)
            MCV_TRY(run_point(points + i, &sides[i].seconds[r < 0 ? 0 : r], error));
    }
    for (int i = 0; i < count; ++i) {
        const double work = (double)(rays ? points[i].stats.rays + points[i].stats.shadow_rays
                                          : points[i].stats.paths);
        bench_row(b, BENCH_WALL, sides + i, NULL, work, rays ? "Mrays/s" : "Msamples/s", "%s %.0f",
                  what, points[i].x);
        nanoseconds[i] = 1e9 * bench_side_median(b, sides + i, BENCH_WALL) / work;
        bench_more(b, what, points[i].x);
        bench_more(b, "nanoseconds", nanoseconds[i]);
    }
    *first_over_last = nanoseconds[0] / nanoseconds[count - 1];
    return MCV_OK;
}

static mcv_result bench_pixels(bench *b, mcv_error *error) {
    point points[MOST_POINTS] = {{0}};
    const int count = b->quick ? 3 : 6;
    double ratio;
    mcv_result result = MCV_OK;
    for (int i = 0; i < count && result == MCV_OK; ++i) {
        uint32_t film[2] = {0, 0};
        points[i].options = mcv_render_defaults();
        points[i].options.last = 4;
        result = load_shipped("report-clean.glb", 256 << 2 * i, &points[i].scene, error);
        if (result == MCV_OK) mcv_sensor_film_size(points[i].scene->sensors, film, film + 1);
        points[i].x = (double)film[0] * film[1];
    }
    if (result == MCV_OK) result = bench_points(b, "pixels", false, points, count, &ratio, error);
    for (int i = 0; i < count; ++i) mcv_scene_free(points[i].scene);
    if (result == MCV_OK) bench_summary(b, "cost_of_few_pixels", ratio);
    return result;
}

static mcv_result bench_samples(bench *b, mcv_scene *scene, mcv_error *error) {
    point points[MOST_POINTS];
    const int count = b->quick ? 3 : 6;
    double ratio;
    for (int i = 0; i < count; ++i) {
        points[i] = (point){.scene = scene, .options = mcv_render_defaults()};
        points[i].options.last = (uint64_t)1 << 2 * i;
        points[i].x = (double)points[i].options.last * points[i].options.replicates;
    }
    MCV_TRY(bench_points(b, "samples", false, points, count, &ratio, error));
    bench_summary(b, "cost_of_few_samples", ratio);
    return MCV_OK;
}

static mcv_result bench_bounces(bench *b, mcv_error *error) {
    mcv_scene *scene;
    point points[MOST_POINTS];
    double ratio;
    const int count = b->quick ? 3 : 6;
    mcv_result result = make_sphere(29, &scene, error);
    for (int i = 0; i < count; ++i) {
        points[i] = (point){.scene = scene, .options = mcv_render_defaults(), .x = 1 << i};
        points[i].options.last = 4;
        points[i].options.depth = 1u << i;
    }
    if (result == MCV_OK) result = bench_points(b, "bounces", true, points, count, &ratio, error);
    mcv_scene_free(scene);
    if (result == MCV_OK) bench_summary(b, "cost_of_later_rays", 1 / ratio);
    return result;
}

static mcv_result bench_report(bench *b, mcv_error *error) {
    mcv_scene *scene = NULL;
    mcv_result result =
        load_shipped("report-clean.glb", b->quick ? 1 << 10 : 1 << 14, &scene, error);
    if (result == MCV_OK) result = bench_threads(b, scene, error);
    mcv_scene_free(scene);
    MCV_TRY(result);
    result = load_shipped("report-clean.glb", 1 << 10, &scene, error);
    if (result == MCV_OK) result = bench_samples(b, scene, error);
    mcv_scene_free(scene);
    return result;
}

static mcv_result run(bench *b, mcv_error *error) {
    bench_title("Scale: rays and samples per second against triangles, bounces, pixels, samples "
                "and threads");
    MCV_TRY(bench_triangles(b, error));
    MCV_TRY(bench_bounces(b, error));
    MCV_TRY(bench_pixels(b, error));
    return bench_report(b, error);
}

int main(int argc, char **argv) { return bench_main(argc, argv, "scale", run); }
