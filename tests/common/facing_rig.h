/* SPDX-License-Identifier: Apache-2.0 */
/* A telecentric projector that looks into a telecentric camera. */
#ifndef MCVISI_TESTS_FACING_RIG_H
#define MCVISI_TESTS_FACING_RIG_H

/* Pixels of 0.5 mm in the plane in focus, in which a projector of 6 mm x 5 mm lies with 8 x 6
 * pixels, off the axis. Its radiance is 1, so that a pixel that sees it whole has the brightest
 * value. */
static const char facing_rig[] =
    "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 1]}],"
    " \"extensions\": {\"MCVISI_sensors\": {\"sensors\": [{\"name\": \"camera\","
    " \"type\": \"telecentric\", \"magnification\": 0.1, \"workingDistance\": \"100mm\","
    " \"fNumber\": 16, \"resolution\": [12, 10], \"pixelSize\": \"50um\"}]},"
    " \"MCVISI_emitters\": {\"emitters\": [{\"name\": \"projector\","
    " \"type\": \"telecentricProjector\", \"size\": [\"6mm\", \"5mm\"], \"halfAngle\": \"10deg\","
    " \"radiance\": 1, \"image\": \"picture\"}]}},"
    " \"images\": [{\"name\": \"picture\", \"uri\": \"transport-grey.png\"}],"
    " \"samplers\": [{\"magFilter\": 9728}],"
    " \"nodes\": [{\"name\": \"camera\", \"rotation\": [0, 1, 0, 0],"
    "   \"translation\": [0, 0, -0.1],"
    "   \"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}}},"
    "  {\"name\": \"projector\", \"translation\": [0.0003, -0.0002, 0],"
    "   \"extensions\": {\"MCVISI_emitters\": {\"emitter\": 0}}}]}";

#endif
