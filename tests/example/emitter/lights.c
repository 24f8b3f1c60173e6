/* What the example adds to share_at (host/reference/lights.c): the model once more, from its
 * formula. */
case MCV_EMITTER_LED:
return pow(fmax(cos(angle), 0), emitter->as.led.exponent);
