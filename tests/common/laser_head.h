/* SPDX-License-Identifier: Apache-2.0 */
/* A triangulation head over a plate. */
#ifndef MCVISI_TESTS_LASER_HEAD_H
#define MCVISI_TESTS_LASER_HEAD_H

/* A laser line on a plate, 0.2 m below it, and a camera 30° aside whose film is tilted so that the
 * plane of the light is in focus. A pixel stands for 5 µm/(sin 30°/9) = 90 µm of height. The
 * plate's top is 5 mm over its node. */
static const char laser_head[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"camera\",\"type\":\"thinLens\","
    "\"focalLength\":\"25mm\",\"focusDistance\":\"250mm\",\"fNumber\":8,\"resolution\":[48,48],"
    "\"pixelSize\":\"5um\",\"tilt\":\"10.893deg\",\"tiltDirection\":\"180deg\","
    "\"radiometry\":\"irradiance\"}]},"
    "\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"laser\",\"type\":\"laser\",\"wavelength\":"
    "\"660nm\",\"power\":0.02,\"lineThickness\":\"200um\",\"widthMeasure\":\"1/e2\","
    "\"workingDistance\":\"200mm\",\"fanAngle\":\"20deg\"}]},"
    "\"MCVISI_surfaces\":{\"surfaces\":[{\"name\":\"plate\",\"type\":\"box\",\"width\":\"100mm\","
    "\"height\":\"10mm\",\"depth\":\"100mm\",\"material\":\"grey\"}]}},"
    "\"materials\":[{\"name\":\"grey\",\"extensions\":{\"MCVISI_materials\":"
    "{\"type\":\"diffuse\",\"reflectance\":0.5}}}],"
    "\"nodes\":[{\"name\":\"camera\",\"extensions\":{\"MCVISI_pose\":{\"target\":[0,0,0],"
    "\"distance\":\"250mm\",\"elevation\":\"60deg\"},\"MCVISI_sensors\":{\"sensor\":0}}},"
    "{\"name\":\"laser\",\"extensions\":{\"MCVISI_pose\":{\"target\":[0,0,0],\"distance\":"
    "\"200mm\",\"elevation\":\"90deg\"},\"MCVISI_emitters\":{\"emitter\":0}}},"
    "{\"name\":\"plate\",\"translation\":[0,-0.005,0],\"extensions\":{\"MCVISI_surfaces\":"
    "{\"surface\":0}}}]}";

#endif
