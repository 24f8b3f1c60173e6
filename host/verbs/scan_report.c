/* SPDX-License-Identifier: Apache-2.0 */
/* What a scan tells: the profiles, the head's figures in the words of data sheets, the budget. */
#include "verbs/scan.h"

#include <math.h>

/* --- the head --- */

/* Where the light is that a place of the whole film of a camera sees, in the laser's coordinates.
 */
static bool see_by(const mcv_scan *s, const mcv_camera_model *model, double along, double across,
                   double at[3]) {
    const double place[2] = {s->axis ? along : across, s->axis ? across : along};
    const double *m = s->laser.m;
    double world[3];
    if (!mcv_triangulate(model, &s->laser, place, world)) return false;
    for (int k = 0; k < 3; ++k) {
        at[k] = 0;
        for (int i = 0; i < 3; ++i) at[k] += m[3 * i + k] * (world[i] - m[9 + i]);
    }
    return true;
}

static bool see(const mcv_scan *s, double along, double across, double at[3]) {
    return see_by(s, &s->model, along, across, at);
}

/* The height of the middle of the film between two places across the line; NaN where a ray does not
 * meet the light. */
static double height_between(const mcv_scan *s, double from, double to) {
    const double middle = s->model.size[!s->axis] / 2.0;
    double a[3], b[3];
    if (!see(s, middle, from, a) || !see(s, middle, to, b)) return NAN;
    return fabs(b[2] - a[2]);
}

static double measuring_range(const mcv_scan *s) {
    return height_between(s, 0, s->model.size[s->axis]);
}

static double height_of_pixel(const mcv_scan *s) {
    const double middle = s->model.size[s->axis] / 2.0;
    return height_between(s, middle - 0.5, middle + 0.5);
}

/* --- differences of runs --- */

/* The height of a point in a run, NaN where one of the runs that are told of does not see it well.
 */
static double height_at(const mcv_scan *s, int run, size_t i) {
    const mcv_profile_point *p = s->profiles[run].points + i;
    return p->line.state == MCV_LINE_SEEN ? p->at[2] : NAN;
}

/* The root of the mean square of what the heights of two runs differ by, and its largest. */
static double difference(const mcv_scan *s, int run, int other, double *largest) {
    const size_t count = (size_t)s->profiles[0].added * s->profiles[0].length;
    double sum = 0, squares = 0;
    if (largest) *largest = 0;
    if (!mcv_scan_needs(s, run) || !mcv_scan_needs(s, other)) return 0;
    for (size_t i = 0; i < count; ++i) {
        double off = height_at(s, run, i) - height_at(s, other, i), all = 0;
        for (int k = 0; k < MCV_SCAN_RUNS; ++k)
            if (mcv_scan_needs(s, k)) all += height_at(s, k, i);
        if (isnan(off) || isnan(all)) continue;
        ++sum;
        squares += off * off;
        if (largest) *largest = fmax(*largest, fabs(off));
    }
    return sqrt(squares / sum);
}

/* --- the camera's pose --- */

/* The camera, shifted along one of its axes by `step`, or from the fourth on turned about it. */
static mcv_camera_model misplaced(const mcv_camera_model *model, int way, double step) {
    mcv_camera_model moved = *model;
    const int axis = way % 3, p = (axis + 1) % 3, q = (axis + 2) % 3;
    if (way < 3) {
        moved.translation[axis] += step;
        return moved;
    }
    for (int k = 0; k < 4; ++k) {
        double *a = k < 3 ? moved.rotation + 3 * p + k : moved.translation + p,
               *b = k < 3 ? moved.rotation + 3 * q + k : moved.translation + q;
        const double x = *a, y = *b;
        *a = cos(step) * x - sin(step) * y;
        *b = sin(step) * x + cos(step) * y;
    }
    return moved;
}

/* The root of the mean square of what the uncertain pose changes of the first profile's heights: by
 * first order, for each of the six ways. */
static double by_pose(const mcv_scan *s) {
    const mcv_profiles *p = s->profiles + MCV_SCAN_CLEAN;
    double squares = 0, count = 0;
    for (uint32_t i = 0; i < p->length; ++i) {
        if (p->points[i].line.state != MCV_LINE_SEEN) continue;
        ++count;
        for (int way = 0; way < 6; ++way) {
            const double step = s->pose[way / 3];
            const mcv_camera_model before = misplaced(&s->model, way, -step),
                                   behind = misplaced(&s->model, way, step);
            double a[3], b[3];
            if (see_by(s, &before, i + 0.5, p->points[i].line.place, a) &&
                see_by(s, &behind, i + 0.5, p->points[i].line.place, b))
                squares += pow((b[2] - a[2]) / 2, 2);
        }
    }
    return sqrt(squares / count);
}

/* --- what is told --- */

static void report_budget(const mcv_scan *s, mcv_report *report) {
    const double render = difference(s, MCV_SCAN_AGAIN, MCV_SCAN_CLEAN, NULL) / M_SQRT2;
    const struct {
        const char *key;
        double value;
    } causes[] = {
        {"photons_and_read_noise", difference(s, MCV_SCAN_NOISE, MCV_SCAN_CLEAN, NULL)},
        {"speckle", difference(s, MCV_SCAN_SPECKLE, MCV_SCAN_CLEAN, NULL)},
        {"quantisation", difference(s, MCV_SCAN_BITS, MCV_SCAN_CLEAN, NULL)},
        {"multipath", difference(s, MCV_SCAN_CLEAN, MCV_SCAN_DIRECT, NULL)},
        {"bow", difference(s, MCV_SCAN_CLEAN, MCV_SCAN_STRAIGHT, NULL)},
        {"calibration", difference(s, MCV_SCAN_CALIBRATED, MCV_SCAN_CLEAN, NULL)},
        {"distortion", difference(s, MCV_SCAN_UNDISTORTED, MCV_SCAN_CLEAN, NULL)},
        {"render", render},
    };
    double squares = 0;
    mcv_report_open(report, "budget");
    for (size_t i = 0; i < sizeof causes / sizeof causes[0]; ++i) {
        squares += causes[i].value * causes[i].value;
        mcv_report_number(report, causes[i].key, "m", causes[i].value);
    }
    mcv_report_number(report, "sum", "m", sqrt(squares));
    /* What it is held against has a render's error of its own. */
    const double all = difference(s, MCV_SCAN_ALL, MCV_SCAN_IDEAL, NULL);
    mcv_report_number(report, "all_together", "m", sqrt(fmax(all * all - render * render, 0)));
    mcv_report_number(report, "peak_locking", "m", s->locking * height_of_pixel(s));
    if (s->command.pose) mcv_report_number(report, "pose", "m", by_pose(s));
    mcv_report_close(report);
}

static void report_head(const mcv_scan *s, mcv_report *report) {
    const uint32_t points = s->model.size[!s->axis], across = s->model.size[s->axis];
    double left[3], right[3], largest, other;
    mcv_report_open(report, "head");
    mcv_report_number(report, "measuring_range", "m", measuring_range(s));
    if (see(s, 0.5, across / 2.0, left) && see(s, points - 0.5, across / 2.0, right)) {
        const double width = fabs(right[0] - left[0]);
        mcv_report_number(report, "reference_width", "m", width);
        mcv_report_number(report, "resolution_x", "m", width / (points - 1));
    }
    mcv_report_number(report, "points_per_profile", "", points);
    mcv_report_number(report, "height_of_a_pixel", "m", height_of_pixel(s));
    if (s->filter.width > 0) {
        const double size[2] = {s->model.size[0], s->model.size[1]};
        mcv_report_number(report, "filter_passes_in_the_middle", "",
                          mcv_scan_transmittance(s, size[0] / 2, size[1] / 2));
        mcv_report_number(report, "filter_passes_in_a_corner", "", mcv_scan_transmittance(s, 0, 0));
    }
    if (s->motion > 1) mcv_report_number(report, "speckle_patterns_by_motion", "", s->motion);
    if (s->command.exposure_time > 0)
        mcv_report_number(report, "profile_rate_at_most", "1/s", 1 / s->command.exposure_time);
    if (s->budget) {
        mcv_report_number(report, "repeatability", "m",
                          difference(s, MCV_SCAN_NOISE, MCV_SCAN_CLEAN, NULL));
        difference(s, MCV_SCAN_CLEAN, MCV_SCAN_DIRECT, &largest);
        difference(s, MCV_SCAN_CLEAN, MCV_SCAN_STRAIGHT, &other);
        mcv_report_number(report, "linearity", "%",
                          100 * hypot(fmax(largest, other), s->locking * height_of_pixel(s)) /
                              measuring_range(s));
    }
    mcv_report_close(report);
}

void mcv_scan_report(const mcv_scan *s, mcv_report *report) {
    mcv_profiles_report(s->profiles, report);
    report_head(s, report);
    if (s->budget) report_budget(s, report);
}
