/* SPDX-License-Identifier: Apache-2.0 */
#include "core/kernel_folder.h"

#include <stdio.h>
#include <stdlib.h>

bool mcv_kernel_folder(char path[MCV_KERNEL_FOLDER]) {
    const char *folder = getenv("POCL_CACHE_DIR"), *base = getenv("XDG_CACHE_HOME"),
               *home = getenv("HOME");
    int length;
    if (folder)
        length = snprintf(path, MCV_KERNEL_FOLDER, "%s", folder);
    else if (base && base[0])
        length = snprintf(path, MCV_KERNEL_FOLDER, "%s/pocl/kcache", base);
    else if (home && home[0])
        length = snprintf(path, MCV_KERNEL_FOLDER, "%s/.cache/pocl/kcache", home);
    else
        length = snprintf(path, MCV_KERNEL_FOLDER, "/tmp/pocl/kcache");
    return length > 0 && length < MCV_KERNEL_FOLDER;
}
