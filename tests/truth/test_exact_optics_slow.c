/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1200 */
/* Renders of test_exact_optics.c, by the stream schedule, too; cameras in glass, plates in a
 * furnace. */
#define SLOW 1
#include "test_exact_optics.c"
