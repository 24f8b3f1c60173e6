/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi scan: profiles of a laser head, rendered, exposed and evaluated. */
#include "cli/client.h"
#include "cli/verbs.h"

mcv_result mcv_verb_scan(const mcv_command *command, mcv_error *error) {
    return mcv_client_picture(command, mcv_session_scan, error);
}
