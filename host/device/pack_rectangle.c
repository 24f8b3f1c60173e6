/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "device/pack.h"
#include "scene/geometry.h"

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void subtract(const double a[3], const double b[3], double way[3]) {
    for (int k = 0; k < 3; ++k) way[k] = a[k] - b[k];
}

/* The corner that is opposite to the longest side of a triangle. */
static int square_corner(double corners[3][3]) {
    double longest = 0;
    int square = 0;
    for (int c = 0; c < 3; ++c) {
        double side[3];
        subtract(corners[(c + 2) % 3], corners[(c + 1) % 3], side);
        if (dot(side, side) > longest) longest = dot(side, side), square = c;
    }
    return square;
}

/* The rectangle of which a triangle is half: the vectors along its sides, the shorter one first,
 * made perpendicular. */
static void complete(double corners[3][3], double origin[3], double sides[2][3]) {
    const int square = square_corner(corners);
    memcpy(origin, corners[square], 3 * sizeof(double));
    subtract(corners[(square + 1) % 3], origin, sides[0]);
    subtract(corners[(square + 2) % 3], origin, sides[1]);
    const bool swapped = dot(sides[0], sides[0]) > dot(sides[1], sides[1]);
    for (int k = 0; swapped && k < 3; ++k) {
        const double kept = sides[0][k];
        sides[0][k] = sides[1][k];
        sides[1][k] = kept;
    }
    const double slant = dot(sides[0], sides[1]) / dot(sides[0], sides[0]);
    for (int k = 0; k < 3; ++k) sides[1][k] -= slant * sides[0][k];
}

/* Which corner of the rectangle a point is, within the distance `most`; false: none. */
static bool find_corner(const double origin[3], double sides[2][3], const double point[3],
                        double most, double place[2]) {
    double rest[3];
    subtract(point, origin, rest);
    for (int i = 0; i < 2; ++i) {
        place[i] = round(dot(rest, sides[i]) / dot(sides[i], sides[i]));
        if (!(place[i] == 0 || place[i] == 1)) return false;
        for (int k = 0; k < 3; ++k) rest[k] -= place[i] * sides[i][k];
    }
    return sqrt(dot(rest, rest)) <= most;
}

/* The u and v of a place on a triangle with those corners. */
static void invert(double corners[3][2], float map[6]) {
    double side[2][2];
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k) side[i][k] = corners[i + 1][k] - corners[0][k];
    const double area = side[0][0] * side[1][1] - side[1][0] * side[0][1];
    const double rows[2][2] = {{side[1][1] / area, -side[1][0] / area},
                               {-side[0][1] / area, side[0][0] / area}};
    for (int i = 0; i < 2; ++i) {
        map[3 * i] = (float)-(rows[i][0] * corners[0][0] + rows[i][1] * corners[0][1]);
        map[3 * i + 1] = (float)rows[i][0];
        map[3 * i + 2] = (float)rows[i][1];
    }
}

bool mcv_pack_rectangle(const mcv_scene *scene, const mcv_packed *packed,
                        mcv_device_emitter *emitter) {
    double corners[2][3][3], origin[3], sides[2][3];
    mcv_rectangle rectangle = {.padding = 0};
    if (emitter->triangle_count != 2 ||
        (emitter->facing[0] == 0 && emitter->facing[1] == 0 && emitter->facing[2] == 0))
        return false;
    for (uint32_t t = 0; t < 2; ++t) {
        mcv_scene_corners(scene, emitter->instance, t, corners[t]);
        for (int c = 0; c < 3; ++c) subtract(corners[t][c], packed->centre, corners[t][c]);
    }
    complete(corners[0], origin, sides);
    /* The tolerance is the resolution of float coordinates. */
    const double most =
        0x1p-20 * ((double)emitter->radius + sqrt(dot(packed->centre, packed->centre)));
    for (int t = 0; t < 2; ++t) {
        double places[3][2];
        unsigned found = 0;
        for (int c = 0; c < 3; ++c) {
            if (!find_corner(origin, sides, corners[t][c], most, places[c])) return false;
            found |= 1u << (unsigned)(places[c][0] + 2 * places[c][1]);
        }
        if (found != (t == 0 ? 7u : 14u)) return false;
        invert(places, rectangle.to_triangle[t]);
    }
    const double width = sqrt(dot(sides[0], sides[0])), height = sqrt(dot(sides[1], sides[1]));
    for (int k = 0; k < 3; ++k) {
        rectangle.corner[k] = (float)origin[k];
        rectangle.x[k] = (float)(sides[0][k] / width);
        rectangle.y[k] = (float)(sides[1][k] / height);
    }
    rectangle.width = (float)width;
    rectangle.height = (float)height;
    emitter->rectangle = rectangle;
    return true;
}
