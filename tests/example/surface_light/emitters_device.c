/* What the example adds to mcv_surface_light_prepare (host/scene/emitters_device.c), in double up
 * to the last rounding. At 60° rounding may make n less than 1. */
if (emitter->type == MCV_EMITTER_LED_PANEL) {
    const double n = -M_LN2 / log(cos(emitter->as.led_panel.halfPowerAngle));
    device->as.led_panel.exponent = (float)fmax(n - 1, 0);
}
