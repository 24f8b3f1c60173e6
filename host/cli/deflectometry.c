/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi deflectometry: slopes and heights of a mirroring part from fringes. */
#include "cli/client.h"
#include "cli/verbs.h"

mcv_result mcv_verb_deflectometry(const mcv_command *command, mcv_error *error) {
    return mcv_client_picture(command, mcv_session_deflectometry, error);
}
