/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1200 */
/* Every call of a device fails once, and every second one for good; with and without light paths.
 */
#define STEP 1
#define FIRST_LIGHT 0
#include "test_devices.c"
