/* SPDX-License-Identifier: Apache-2.0 */
/* What test_readout.c asks of all sensors, rendered with the other two of them. */
#define FIRST_RENDERED MCV_SENSOR_TELECENTRIC
#define END_RENDERED MCV_SENSOR_COUNT
#include "test_readout.c"
