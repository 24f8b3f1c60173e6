/* What the example adds to mcv_emitter_projected_solid_angle (host/scene/emitters.c): the exitance
 * of a radiance of 1. */
if (emitter->type == MCV_EMITTER_LED_PANEL) {
    const double n = -M_LN2 / log(cos(emitter->as.led_panel.halfPowerAngle));
    return 2 * M_PI / (n + 1);
}
