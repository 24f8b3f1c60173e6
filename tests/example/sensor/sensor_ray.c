/* What the example adds to host/reference/sensor_ray.c: the model once more, from its formulas. */
static ref_sensor_ray line_scan(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                                double y) {
    const mcv_line_scan_params *p = &sensor->as.line_scan;
    const double pitch[2] = {p->pixelSize[0],
                             p->linePitch}; /* from row to row the place moves by linePitch */
    const point s = image_point(p->resolution, p->principalPoint, pitch,
                                on_film(p->regionOfInterest, p->binning, 0, column + x),
                                on_film(p->regionOfInterest, p->binning, 1, row + y));
    return in_world(sensor, (point){0, -s.y}, (ref_vec){-s.x / p->imageDistance, 0, 1});
}
