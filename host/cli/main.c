/* SPDX-License-Identifier: Apache-2.0 */
#include "mcvisi/mcvisi.h"

#include <stdio.h>

int main(void) {
    printf("mcvisi %s\n", mcv_version());
    return MCV_OK;
}
