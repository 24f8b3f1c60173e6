/* SPDX-License-Identifier: Apache-2.0 */
#include "image_maker.h"

#include <fcntl.h>
#include <math.h>
#include <sys/wait.h>
#include <unistd.h>

#include "convergence.h"

enum { REFERENCE_REPLICATES = 16, REFERENCE_FACTOR = 64, REFERENCE_SEED = 100000, SURFACES = 32 };

/* --- Mitsuba
 * ------------------------------------------------------------------------------------------------------
 */

mcv_result peer_open(const char *variant, const char *mesh_path, const char *folder, unsigned seed,
                     peer *p, mcv_error *error) {
    int to[2], from[2];
    char number[16];
    snprintf(number, sizeof number, "%u", seed);
    if (pipe2(to, O_CLOEXEC) != 0 || pipe2(from, O_CLOEXEC) != 0)
        return mcv_fail(error, MCV_FAILED, "no pipe to Mitsuba");
    p->process = fork();
    if (p->process < 0) return mcv_fail(error, MCV_FAILED, "no process for Mitsuba");
    if (p->process == 0) {
        dup2(to[0], STDIN_FILENO);
        dup2(from[1], STDOUT_FILENO);
        execl(PYTHON, PYTHON, MCV_SOURCE_DIR "/bench/render_peer.py", variant, mesh_path, folder,
              number, (char *)NULL);
        _exit(127);
    }
    close(to[0]);
    close(from[1]);
    p->to = fdopen(to[1], "w");
    p->from = fdopen(from[0], "r");
    return p->to && p->from ? MCV_OK : mcv_fail(error, MCV_FAILED, "no pipe to Mitsuba");
}

void peer_close(peer *p) {
    if (p->to) fclose(p->to);
    if (p->from) fclose(p->from);
    if (p->process > 0) waitpid(p->process, NULL, 0);
    *p = (peer){0};
}

/* --- one image of one renderer
 * ------------------------------------------------------------------------------------- */

static mcv_result peer_image(const image_maker *m, double *values, size_t count, mcv_error *error) {
    fprintf(m->peer->to, "%u %s %s %u %u %s\n", m->pixels, m->integrator, m->sampler, m->samples,
            m->seed, m->scene_name);
    fflush(m->peer->to);
    if (fread(values, sizeof *values, count, m->peer->from) != count)
        return mcv_fail(error, MCV_FAILED, "%s: Mitsuba's %s with %s gave no image", m->scene_name,
                        m->integrator, m->sampler);
    return MCV_OK;
}

static mcv_result peer_film(const image_maker *m, mcv_film *film, mcv_error *error) {
    MCV_TRY(mcv_film_new(film, m->pixels, m->pixels, m->channels, 1, error));
    film->samples = 1;
    const mcv_result result = peer_image(m, film->sums, film_values(film), error);
    if (result != MCV_OK) mcv_film_free(film);
    return result;
}

static mcv_result our_image(const image_maker *m, uint32_t replicates, mcv_film *film,
                            mcv_error *error) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    options.replicates = replicates;
    options.last = m->samples;
    options.seed = m->seed;
    options.depth = m->surfaces ? m->surfaces : SURFACES;
    if (m->is_random) options.sampler = MCV_SAMPLER_RANDOM;
    options.no_light_paths = options.no_split = m->is_single;
    options.light_pilot = !m->is_single && replicates == m->replicates;
    options.adaptive = m->is_adaptive && replicates == m->replicates; /* not the truth */
    return mcv_renderer_render(m->renderer, m->scene, 0, &options, film, &stats, error);
}

mcv_result make_film(const image_maker *m, mcv_film *film, mcv_error *error) {
    return m->peer ? peer_film(m, film, error) : our_image(m, m->replicates, film, error);
}

mcv_result make_image(void *user, mcv_error *error) {
    image_maker *m = user;
    mcv_film film = {0};
    ++m->seed;
    const mcv_result result = make_film(m, &film, error);
    if (result == MCV_OK) {
        const double rmse = errors_against(&film, m->truth).rmse;
        m->squares += rmse * rmse - m->truth_variance;
        ++m->images;
    }
    mcv_film_free(&film);
    return result;
}

double rmse_of(const image_maker *m) { return sqrt(fmax(m->squares / m->images, 0)); }

/* --- truths
 * -------------------------------------------------------------------------------------------------------
 */

mcv_result make_truth(image_maker maker, mcv_film *film, mcv_error *error) {
    const uint32_t factor = maker.truth_factor ? maker.truth_factor : REFERENCE_FACTOR;
    maker.samples = maker.samples * factor / REFERENCE_REPLICATES;
    maker.seed = REFERENCE_SEED;
    if (!maker.peer) return our_image(&maker, REFERENCE_REPLICATES, film, error);
    MCV_TRY(mcv_film_new(film, maker.pixels, maker.pixels, maker.channels, REFERENCE_REPLICATES,
                         error));
    film->samples = 1;
    for (uint32_t r = 0; r < REFERENCE_REPLICATES; ++r, ++maker.seed)
        MCV_TRY(peer_image(&maker, film->sums + r * film_values(film), film_values(film), error));
    return MCV_OK;
}

double variance_of(const mcv_film *film) {
    const double standard_error = mcv_film_relative_error(film) * mcv_film_mean(film);
    return standard_error * standard_error;
}
