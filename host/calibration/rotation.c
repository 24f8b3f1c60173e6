/* SPDX-License-Identifier: Apache-2.0 */
/* Rotations as quaternions, vectors and angles. */
#include "calibration/calibration.h"

#include <math.h>

/* The largest of the four components comes first, so that no small one divides. */
void mcv_rotation_to_quaternion(const double r[9], double q[4]) {
    const double squares[4] = {1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8],
                               1 - r[0] + r[4] - r[8], 1 - r[0] - r[4] + r[8]};
    int largest = 0;
    for (int i = 1; i < 4; ++i)
        if (squares[i] > squares[largest]) largest = i;
    const double twice = sqrt(squares[largest]), scale = 0.5 / twice;
    const double xy = r[3] + r[1], xz = r[6] + r[2], yz = r[7] + r[5];
    const double x = r[7] - r[5], y = r[2] - r[6], z = r[3] - r[1];
    const double rows[4][4] = {{0, x, y, z}, {x, 0, xy, xz}, {y, xy, 0, yz}, {z, xz, yz, 0}};
    for (int i = 0; i < 4; ++i) q[i] = i == largest ? twice / 2 : rows[largest][i] * scale;
    if (q[0] < 0)
        for (int i = 0; i < 4; ++i) q[i] = -q[i];
}

void mcv_rotation_of_quaternion(const double q[4], double r[9]) {
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double w = q[0] / length, x = q[1] / length, y = q[2] / length, z = q[3] / length;
    r[0] = 1 - 2 * (y * y + z * z);
    r[1] = 2 * (x * y - w * z);
    r[2] = 2 * (x * z + w * y);
    r[3] = 2 * (x * y + w * z);
    r[4] = 1 - 2 * (x * x + z * z);
    r[5] = 2 * (y * z - w * x);
    r[6] = 2 * (x * z - w * y);
    r[7] = 2 * (y * z + w * x);
    r[8] = 1 - 2 * (x * x + y * y);
}

void mcv_rotation_to_vector(const double r[9], double v[3]) {
    double q[4];
    mcv_rotation_to_quaternion(r, q);
    const double sine = sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double factor = sine > 0 ? 2 * atan2(sine, q[0]) / sine : 2;
    for (int i = 0; i < 3; ++i) v[i] = factor * q[i + 1];
}

void mcv_rotation_of_vector(const double v[3], double r[9]) {
    const double angle = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const double factor = angle > 0 ? sin(angle / 2) / angle : 0.5;
    const double q[4] = {cos(angle / 2), factor * v[0], factor * v[1], factor * v[2]};
    mcv_rotation_of_quaternion(q, r);
}

/* The third angle follows from what R_x leaves: so the result is right also where R_x and R_z turn
 * about the same axis. */
void mcv_rotation_to_gba(const double r[9], double degrees[3]) {
    const double a = atan2(-r[5], r[8]), sine = sin(a), cosine = cos(a);
    const double b = atan2(r[2], cosine * r[8] - sine * r[5]);
    const double c = atan2(cosine * r[3] + sine * r[6], cosine * r[4] + sine * r[7]);
    degrees[0] = a * (180 / M_PI);
    degrees[1] = b * (180 / M_PI);
    degrees[2] = c * (180 / M_PI);
}

void mcv_rotation_of_gba(const double degrees[3], double r[9]) {
    double s[3], c[3];
    for (int i = 0; i < 3; ++i) {
        s[i] = sin(degrees[i] * (M_PI / 180));
        c[i] = cos(degrees[i] * (M_PI / 180));
    }
    r[0] = c[1] * c[2];
    r[1] = -c[1] * s[2];
    r[2] = s[1];
    r[3] = c[0] * s[2] + s[0] * s[1] * c[2];
    r[4] = c[0] * c[2] - s[0] * s[1] * s[2];
    r[5] = -s[0] * c[1];
    r[6] = s[0] * s[2] - c[0] * s[1] * c[2];
    r[7] = s[0] * c[2] + c[0] * s[1] * s[2];
    r[8] = c[0] * c[1];
}
