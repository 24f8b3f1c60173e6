/* SPDX-License-Identifier: Apache-2.0 */
/* Experiments of the public interface: what all verbs share that render many sets of a rig. */
#ifndef MCVISI_HOST_API_EXPERIMENTS_H
#define MCVISI_HOST_API_EXPERIMENTS_H

#include "api/handles.h"
#include "experiment/experiment.h"

/* The work on an experiment that is set up by the command, with its calls. *report is the text of
 * the end, as JSON or for people; report may be NULL. */
typedef mcv_result mcv_experiment_work(const mcv_experiment *experiment, const mcv_command *command,
                                       char **report, mcv_error *error);

/* Reads the options of a verb, sets the experiment up and has the work done. Arguments are those
 * of mcv_session_sweep. */
mcv_result mcv_session_experiment(mcv_session *session, const mcv_rig *rig, unsigned verb,
                                  const char *options, mcv_experiment_work *work,
                                  mcv_told_call *told, void *user, char **report, mcv_error *error);

/* MCV_FAILED where all sets have failed. */
mcv_result mcv_experiment_finished(const mcv_sweep *sweep, mcv_error *error);

#endif
