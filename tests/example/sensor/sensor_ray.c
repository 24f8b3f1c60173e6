/* What the example adds to host/reference/sensor_ray.c: the model once more, from its formulas. */
static ref_sensor_ray crossed_slits(const mcv_sensor *sensor, uint32_t column, uint32_t row,
                                    double x, double y) {
    const mcv_crossed_slits_params *p = &sensor->as.crossed_slits;
    const double b = p->imageDistance, h = p->slitDistance;
    const point s = image_point(p->resolution, p->principalPoint, p->pixelSize,
                                on_film(p->regionOfInterest, p->binning, 0, column + x),
                                on_film(p->regionOfInterest, p->binning, 1, row + y));
    /* Where the line from s through the level slit meets the plane of the upright one. */
    return in_world(sensor, (point){0, s.y - s.y * b / (b + h)},
                    (ref_vec){-s.x / b, -s.y / (b + h), 1});
}
