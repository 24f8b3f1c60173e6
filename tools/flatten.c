/* SPDX-License-Identifier: Apache-2.0 */
/* Build-time tool: flatten OUTPUT.c ROOT PROGRAM… writes the programs as strings of the library
 * (host/cl/programs.h). */
#include "cl/flatten.h"

#include <stdio.h>
#include <stdlib.h>

static void write_string(FILE *out, const char *text) {
    fputs("    \"", out);
    for (const char *c = text; *c; ++c) {
        if (*c == '\n')
            fputs(c[1] ? "\\n\"\n    \"" : "\\n", out);
        else if (*c == '"' || *c == '\\')
            fprintf(out, "\\%c", *c);
        else
            fputc(*c, out);
    }
    fputs("\"", out);
}

int main(int argc, char **argv) {
    if (argc < 3) {
        fputs("usage: flatten OUTPUT.c ROOT PROGRAM...\n", stderr);
        return MCV_USAGE;
    }
    FILE *out = fopen(argv[1], "w");
    if (!out) {
        perror(argv[1]);
        return MCV_FAILED;
    }
    fputs("#include \"cl/programs.h\"\nconst mcv_program mcv_programs[] = {\n", out);
    for (int i = 3; i < argc; ++i) {
        mcv_error error = {""};
        char *text;
        const mcv_result result = mcv_flatten(argv[2], argv[i], &text, &error);
        if (result != MCV_OK) {
            fprintf(stderr, "flatten: %s\n", error.text);
            fclose(out);
            remove(argv[1]);
            return result;
        }
        fprintf(out, "{\"%s\",\n", argv[i]);
        write_string(out, text);
        fputs("},\n", out);
        free(text);
    }
    fprintf(out, "};\nconst size_t mcv_program_count = %d;\n", argc - 3);
    return fclose(out) == 0 ? MCV_OK : MCV_FAILED;
}
