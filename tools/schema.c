/* SPDX-License-Identifier: Apache-2.0 */
/* Maintainer's tool: schema DIRECTORY writes the JSON schemas of the extensions
 * (include/mcvisi/schema). */
#include "scene/schema.h"

int main(int argc, char **argv) {
    if (argc != 2) {
        fputs("usage: schema DIRECTORY\n", stderr);
        return MCV_USAGE;
    }
    for (int i = 0; mcv_schema_names[i]; ++i) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s.schema.json", argv[1], mcv_schema_names[i]);
        FILE *stream = fopen(path, "w");
        if (!stream) {
            perror(path);
            return MCV_FAILED;
        }
        mcv_error error;
        const mcv_result result = mcv_schema_write(stream, mcv_schema_names[i], &error);
        if (fclose(stream) != 0 || result != MCV_OK) {
            fprintf(stderr, "%s cannot be written\n", path);
            return MCV_FAILED;
        }
    }
    return MCV_OK;
}
