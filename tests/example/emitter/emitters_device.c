/* What the example adds to mcv_point_light_prepare (host/scene/emitters_device.c). */
if (emitter->type == MCV_EMITTER_LED) {
    device->edge = 0.5F; /* sin²(90°/2) */
    device->as.led.exponent = emitter->as.led.exponent;
}
