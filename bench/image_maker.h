/* SPDX-License-Identifier: Apache-2.0 */
/* For bench_render: images of one scene, by ours or by Mitsuba 3, and how far they are from the
 * truth. */
#ifndef MCVISI_BENCH_IMAGE_MAKER_H
#define MCVISI_BENCH_IMAGE_MAKER_H

#include <stdio.h>
#include <sys/types.h>

#include "render/render.h"

#define PYTHON MCV_SOURCE_DIR "/build/peers/bin/python"

/* Mitsuba in one of its variants: bench/render_peer.py at work. */
typedef struct peer {
    FILE *to, *from;
    pid_t process;
} peer;
mcv_result peer_open(const char *variant, const char *mesh_path, const char *folder, unsigned seed,
                     peer *p, mcv_error *error);
void peer_close(peer *p); /* or what is left of it; none: {0} */

typedef struct image_maker {
    peer *peer; /* NULL: ours */
    const char *scene_name, *integrator, *sampler;
    mcv_renderer *renderer;
    const mcv_scene *scene;
    bool is_random; /* numbers in place of Sobol' points */
    bool is_single; /* a sample is one path: no branches, no light paths */
    bool is_adaptive;
    uint32_t surfaces;     /* that a path may meet; 0: 32 */
    uint32_t truth_factor; /* times the samples has the truth; 0: 64 */
    uint32_t replicates;   /* of ours */
    const mcv_film *truth; /* of its own renderer */
    double truth_variance; /* of a value, on average */
    uint32_t pixels, channels, samples, seed;
    double squares; /* mean squared errors, summed over `images` */
    int images;
} image_maker;

/* One image, made here. */
mcv_result make_film(const image_maker *m, mcv_film *film, mcv_error *error);

/* A bench_side: an image of the next seed, and its error. */
mcv_result make_image(void *user, mcv_error *error);
double rmse_of(const image_maker *m);

/* In 16 replicates. */
mcv_result make_truth(image_maker maker, mcv_film *film, mcv_error *error);

/* Of a value of a film, on average. */
double variance_of(const mcv_film *film);

#endif
