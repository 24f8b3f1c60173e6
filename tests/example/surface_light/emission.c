/* What the example adds to share_at (host/reference/emission.c): the model once more, from its
 * formula, 1/2 = cos^n θ_h. */
case MCV_EMITTER_LED_PANEL:
return pow(cos(angle), log(0.5) / log(cos(emitter->as.led_panel.halfPowerAngle)) - 1);
