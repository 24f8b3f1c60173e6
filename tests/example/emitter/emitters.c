/* What the example adds to mcv_emitter_unit_power (host/scene/emitters.c): the power of an
 * intensity of 1. */
case MCV_EMITTER_LED:
return 2 * M_PI / (emitter->as.led.exponent + 1.0);
