/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi merge: films of parts of a render become its image, tables of parts of a sweep one table.
 */
#include "cli/client.h"
#include "cli/verbs.h"
#include "core/basics.h"

#include <stdlib.h>

mcv_result mcv_verb_merge(const mcv_command *command, mcv_error *error) {
    char *options = NULL, *report = NULL;
    const mcv_list *files = &command->arguments;
    static const char *const of_images[] = {"png", "parts", NULL};
    const bool tables = mcv_ends_in(command->argument, ".csv");
    if (!command->merged)
        return mcv_fail(error, MCV_USAGE, "merge needs a name for the %s: give -o %s",
                        tables ? "table" : "image", tables ? "TABLE.csv" : "IMAGE.exr");
    mcv_result result = mcv_client_options(command, tables ? of_images : NULL, &options, error);
    if (result == MCV_OK)
        result = tables
                     ? mcv_tables_merge(files->items, files->count, options, &report, error)
                     : mcv_films_merge(files->items, files->count, options, NULL, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    free(options);
    return result;
}
