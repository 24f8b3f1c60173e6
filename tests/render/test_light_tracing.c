/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: timeout 600 */
/*
 * Light paths: light of emitters through smooth surfaces onto diffuse ones, and beams into lenses.
 * Against closed forms, against the same light without the smooth surface, and against camera paths
 * that find it by chance.
 */
#include "estimates.h"

#include "exact_builder.h"
#include "reference/reference.h"
#include "render/render.h"
#include "scene/sensors.h"

/* Which of the tests run: no file of them shall take long. test_light_tracing_slow.c: all, with all
 * cases. */
enum {
    GROUP_SLABS,
    GROUP_LENSES,
    GROUP_PROJECTOR,
    GROUP_BEAMS,
    GROUP_GLOSS,
    GROUP_METAL,
    GROUP_ALL
};
#ifndef GROUP
#define GROUP GROUP_SLABS
#endif
#define SLOW ((int)GROUP == (int)GROUP_ALL)

static const double ior = 1.5;

/* Both faces of a slab at normal incidence: R = ((n - 1)/(n + 1))², and the series of reflections
 * inside. */
static double slab_transmittance(void) {
    const double r = pow((ior - 1) / (ior + 1), 2);
    return (1 - r) / (1 + r);
}

static mcv_render_options options_of(uint64_t samples, uint32_t seed) {
    mcv_render_options options = mcv_render_defaults();
    options.replicates = REPLICATES;
    options.last = samples;
    options.seed = seed;
    return options;
}

static mcv_film render(const mcv_scene *scene, const mcv_render_options *options, bool expected) {
    mcv_render_stats stats;
    mcv_film film;
    BUILD(render_again(scene, 0, options, &film, &stats, &builder_error));
    if ((strstr(stats.features, "light-tracing") != NULL) != expected)
        fail_msg("features: %s", stats.features);
    if (stats.saturated > 0 || stats.nonfinite > 0 || stats.unmatched > 0)
        fail_msg("%d saturated, %d not finite, %d unmatched", (int)stats.saturated,
                 (int)stats.nonfinite, (int)stats.unmatched);
    return film;
}

/* `bias`: what the closed form leaves out. */
static void expect_mean(const char *what, const mcv_film *film, double expected, double bias) {
    expect_estimate(what, image_estimate(film), expected, 0.02, bias);
}

static void add_light(mcv_scene *scene, mcv_emitter emitter) {
    emitter.name = (char *)"light";
    emitter.texture = MCV_NONE;
    BUILD(mcv_scene_add_emitter(scene, &emitter, &builder_error));
}

static mcv_emitter emitter_of(uint32_t type, uint32_t instance) {
    mcv_emitter emitter = {.type = type, .instance = instance};
    mcv_params_set_defaults(mcv_emitter_table(type), &emitter.as);
    return emitter;
}

/* A beam of the given irradiance. */
static void add_beam(mcv_scene *scene, double size, double irradiance, mcv_transform to_world) {
    mcv_emitter beam = emitter_of(MCV_EMITTER_COLLIMATED_BEAM,
                                  add_rectangle(scene, size, size, add_absorber(scene), to_world));
    for (int k = 0; k < 2; ++k) beam.as.collimated_beam.size[k] = size;
    for (int k = 0; k < 3; ++k) beam.as.collimated_beam.irradiance[k] = irradiance;
    add_light(scene, beam);
}

static void add_point(mcv_scene *scene, double intensity, mcv_transform to_world) {
    mcv_emitter point = emitter_of(MCV_EMITTER_POINT, MCV_NONE);
    point.to_world = to_world;
    for (int k = 0; k < 3; ++k) point.as.point.intensity[k] = intensity;
    add_light(scene, point);
}

/*
 * Sensors that look from (0.2, 0, 0.2) down to the origin, a field of some 8 mm, their depth in
 * focus 10 % off so that places and directions do not stand for each other. A quarter of the field
 * is read out of the fourth one, its pixels binned by two.
 */
enum { PINHOLE, THIN, TELECENTRIC, PART, LIGHT_FIELD, ROUND_FIELD, KINDS };
static const char *const kinds[] = {"pinhole",     "thin lens",
                                    "telecentric", "part of a thin lens's",
                                    "light field", "round light field"};

static mcv_sensor sensor_of(int kind, bool irradiance) {
    static const uint32_t types[] = {MCV_SENSOR_PINHOLE,     MCV_SENSOR_THIN_LENS,
                                     MCV_SENSOR_TELECENTRIC, MCV_SENSOR_THIN_LENS,
                                     MCV_SENSOR_LIGHT_FIELD, MCV_SENSOR_LIGHT_FIELD};
    const double field = 0.008, distance = sqrt(0.08), f = 0.05, focus = 1.1 * distance,
                 b = f * focus / (focus - f);
    const double image = field * b / distance;
    const uint32_t radiometry = irradiance ? MCV_RADIOMETRY_IRRADIANCE : MCV_RADIOMETRY_RADIANCE;
    mcv_sensor sensor = sensor_defaults(types[kind]);
    if (kind == PINHOLE) {
        mcv_pinhole_params *p = &sensor.as.pinhole;
        p->imageDistance = b;
        for (int k = 0; k < 2; ++k) p->resolution[k] = 16, p->pixelSize[k] = image / 16;
    } else if (kind == TELECENTRIC) {
        mcv_telecentric_params *p = &sensor.as.telecentric;
        p->magnification = 0.5;
        p->workingDistance = focus;
        p->numericalAperture = 0.02;
        p->radiometry = radiometry;
        for (int k = 0; k < 2; ++k) p->resolution[k] = 16, p->pixelSize[k] = field / 2 / 16;
    } else if (kind < LIGHT_FIELD) {
        mcv_thin_lens_params *p = &sensor.as.thin_lens;
        p->focalLength = f;
        p->imageDistance = b;
        p->lensDiameter = 0.02;
        p->radiometry = radiometry;
        for (int k = 0; k < 2; ++k) p->resolution[k] = 16, p->pixelSize[k] = image / 16;
        if (kind == PART) {
            memcpy(p->regionOfInterest, (const uint32_t[]){4, 2, 12, 8},
                   sizeof p->regionOfInterest);
            p->binning[0] = p->binning[1] = 2;
        }
    } else {
        mcv_light_field_params *p = &sensor.as.light_field;
        p->focalLength = f;
        p->imageDistance = b;
        p->lensDiameter = 0.02;
        p->aperture = kind == ROUND_FIELD ? MCV_APERTURE_CIRCLE : MCV_APERTURE_SQUARE;
        p->radiometry = radiometry;
        for (int k = 0; k < 2; ++k)
            p->spatialResolution[k] = 5, p->angularResolution[k] = 3, p->pixelSize[k] = image / 15;
    }
    return sensor;
}

static void add_camera(mcv_scene *scene, int kind, bool irradiance) {
    const double s = sqrt(0.5);
    const mcv_sensor sensor = sensor_of(kind, irradiance);
    add_sensor(scene, sensor.type, &sensor,
               looking((const double[]){0.2, 0, 0.2}, (const double[]){-s, 0, -s},
                       (const double[]){0, 1, 0}));
}

/*
 * A beam of 24 mm onto paper, through a slab 0.3 m above or bare with the irradiance that the slab
 * lets through. What paper and slab send to and fro is left out there: the slab's reflectance of
 * 0.077 times the paper's 0.5 A/(π (0.6 m)²): 2e-5.
 */
static mcv_scene *slab_scene(bool slab) {
    mcv_scene *scene = mcv_scene_new("slab");
    add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    if (slab)
        add_box(scene, (const double[]){0.02, 0.02, 0.003}, add_glass(scene, ior, 0, 0),
                looking_down_z(0, 0, 0.3));
    add_beam(scene, 0.024, slab ? 3 : 3 * slab_transmittance(), looking_down_z(0, 0, 0.4));
    return scene;
}

static void test_slab_before_every_sensor(void **state) {
    (void)state;
    for (int kind = 0; kind < KINDS; ++kind) {
        if (!SLOW && kind != THIN)
            continue; /* what light paths need of the others is compared in test_elements.c */
        for (int irradiance = 0; irradiance < 2; ++irradiance) {
            if (kind == PINHOLE && irradiance) continue;
            char what[96];
            snprintf(what, sizeof what, "%s, %s", kinds[kind],
                     irradiance ? "irradiance" : "radiance");
            mcv_scene *bare = slab_scene(false), *through = slab_scene(true);
            add_camera(bare, kind, irradiance);
            add_camera(through, kind, irradiance);
            const mcv_render_options one = options_of(16, 1), other = options_of(64, 2);
            /* A beam that shines away from a sensor needs no light paths, behind a slab it does. */
            mcv_film x = render(bare, &one, false), y = render(through, &other, true);
            expect_same_picture(what, &x, &y);
            if (!irradiance && kind != ROUND_FIELD)
                expect_mean(what, &y, 0.5 / M_PI * 3 * slab_transmittance(), 1e-4);
            mcv_film_free(&x);
            mcv_film_free(&y);
            mcv_scene_free(bare);
            mcv_scene_free(through);
        }
    }
}

/*
 * The same beam through the slab, seen by a lens whose axis stands on the paper and whose film lies
 * far aside, at 45°: paper is as bright from everywhere. Blurred to 7 mm, its field of 6 mm lies
 * within the beam.
 */
static void test_oblique_view(void **state) {
    (void)state;
    mcv_scene *scene = slab_scene(true);
    mcv_sensor sensor = sensor_of(THIN, false);
    mcv_thin_lens_params *p = &sensor.as.thin_lens;
    p->principalPoint[0] = p->resolution[0] / 2.0 + p->imageDistance / p->pixelSize[0];
    p->principalPoint[1] = p->resolution[1] / 2.0;
    add_sensor(scene, sensor.type, &sensor, looking_down_z(0.2, 0, 0.2));
    const mcv_render_options options = options_of(64, 1);
    mcv_film film = render(scene, &options, true);
    expect_mean("oblique view", &film, 0.5 / M_PI * 3 * slab_transmittance(), 1e-4);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

/*
 * Two point lights in one place, as good as one, 0.4 m above the paper behind a slab of thickness
 * t: seen through it, they are t (1 - 1/n) nearer. Within 5 mm of the axis the irradiance I T/d²
 * falls by 3/2 (0.007/0.4)² = 5e-4; the slab's transmittance less. What its sides turn back lands
 * beyond. The slab is two halves that do not quite touch, so that the cones around them overlap:
 * what the one face between them turns back is what the other would have let pass.
 */
static void test_point_lights_behind_slab(void **state) {
    (void)state;
    mcv_scene *scene = mcv_scene_new("point");
    add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    const uint32_t glass = add_glass(scene, ior, 0, 0);
    for (int i = 0; i < 2; ++i) {
        add_box(scene, (const double[]){0.00299999, 0.006, 0.002}, glass,
                looking_down_z(i ? 0.003 : -0.003, 0, 0.3));
        add_point(scene, i ? 1.5 : 0.5, looking_down_z(0, 0, 0.4));
    }
    add_camera(scene, TELECENTRIC, false);
    const mcv_render_options options = options_of(256, 1);
    mcv_film film = render(scene, &options, true);
    const double distance = 0.4 - 0.004 * (1 - 1 / ior);
    expect_mean("point light", &film, 0.5 / M_PI * 2 / (distance * distance) * slab_transmittance(),
                6e-4);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

/* A beam along -x, turned down onto the paper by a mirror of reflectance 0.8 at 45°: L = ρ/π E 0.8.
 */
static void test_mirror(void **state) {
    (void)state;
    const double s = sqrt(0.5);
    mcv_scene *scene = mcv_scene_new("mirror");
    const uint32_t mirror = add_material(scene, MCV_MATERIAL_MIRROR,
                                         &(mcv_material){.as.mirror.reflectance = {0.8, 0.8, 0.8}});
    add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    add_rectangle(scene, 0.05, 0.05, mirror,
                  looking((const double[]){0, 0, 0.3}, (const double[]){s, 0, -s},
                          (const double[]){0, 1, 0}));
    add_beam(scene, 0.024, 3,
             looking((const double[]){0.1, 0, 0.3}, (const double[]){-1, 0, 0},
                     (const double[]){0, 1, 0}));
    add_camera(scene, THIN, false);
    const mcv_render_options options = options_of(64, 1);
    mcv_film film = render(scene, &options, true);
    /* The mirror sees the paper, 1 % of the hemisphere, and itself not. */
    expect_mean("mirror", &film, 0.5 / M_PI * 3 * 0.8, 1e-4);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

/*
 * Coaxial light: a camera looks down on the paper through a splitter at 45°, which turns the beam
 * down onto it: L = ρ/π E r t, through a thin window before the camera, too. Camera paths through
 * both leave it to light paths.
 */
static mcv_scene *coaxial_scene(bool beam, double *expected) {
    const double s = sqrt(0.5);
    mcv_scene *scene = mcv_scene_new("coaxial");
    const uint32_t splitter =
        add_material(scene, MCV_MATERIAL_BEAM_SPLITTER,
                     &(mcv_material){.as.beam_splitter = {.reflectance = {0.3, 0.3, 0.3},
                                                          .transmittance = {0.6, 0.6, 0.6}}});
    const uint32_t window =
        add_material(scene, MCV_MATERIAL_SHEET,
                     &(mcv_material){.as.sheet = {.ior = ior, .transmittance = {1, 1, 1}}});
    mcv_sensor sensor = sensor_of(TELECENTRIC, false);
    for (int k = 0; k < 2; ++k) {
        sensor.as.telecentric.resolution[k] = 4;
        sensor.as.telecentric.pixelSize[k] *= 6;
    }
    add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    add_rectangle(scene, 0.05, 0.07, splitter,
                  looking((const double[]){0, 0, 0.3}, (const double[]){s, 0, -s},
                          (const double[]){0, 1, 0}));
    add_rectangle(scene, 0.05, 0.05, window, looking_up_z(0, 0, 0.35));
    const mcv_transform from = looking((const double[]){0.1, 0, 0.3}, (const double[]){-1, 0, 0},
                                       (const double[]){0, 1, 0});
    if (beam)
        add_beam(scene, 0.03, 3, from);
    else
        add_emitter(scene, MCV_EMITTER_PARALLEL,
                    add_rectangle(scene, 0.06, 0.06, add_absorber(scene), from), 100,
                    12 * M_PI / 180);
    add_sensor(scene, MCV_SENSOR_TELECENTRIC, &sensor, looking_down_z(0, 0, 0.4));
    *expected = 0.5 / M_PI * 3 * 0.3 * 0.6 * slab_transmittance();
    return scene;
}

/* A directional light through slabs, seen by a light field camera: L = ρ/π E T within their shadow.
 */
static void sun_through_slabs(int slabs) {
    mcv_scene *scene = mcv_scene_new("sun");
    mcv_emitter sun = emitter_of(MCV_EMITTER_DIRECTIONAL, MCV_NONE);
    sun.to_world = looking_down_z(0, 0, 0);
    for (int k = 0; k < 3; ++k) sun.as.directional.irradiance[k] = 3;
    add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    /* One, or four quarters of it that do not quite touch, so that the disks around them overlap.
     */
    const uint32_t glass = add_glass(scene, ior, 0, 0);
    if (slabs == 1)
        add_box(scene, (const double[]){0.015, 0.015, 0.003}, glass, looking_down_z(0, 0, 0.3));
    for (int i = 0; i < slabs && slabs > 1; ++i)
        add_box(scene, (const double[]){0.00749999, 0.00749999, 0.003}, glass,
                looking_down_z(i % 2 ? 0.0075 : -0.0075, i / 2 ? 0.0075 : -0.0075, 0.3));
    add_light(scene, sun);
    add_camera(scene, LIGHT_FIELD, false);
    const mcv_render_options options = options_of(64, 1);
    mcv_film film = render(scene, &options, true);
    /* The paper beyond the slab's shadow lights the slab's lower face: 0.08 times 0.5 · 0.01/(π
     * 0.6²) of it comes back. */
    expect_mean("sun", &film, 0.5 / M_PI * 3 * slab_transmittance(), 1e-3);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

static void test_sun_through_slab(void **state) {
    (void)state;
    sun_through_slabs(1);
}

static void test_sun_through_four_slabs(void **state) {
    (void)state;
    sun_through_slabs(4);
}

/*
 * A point light in the focus of an exact lens, r/(n - 1) before its hyperbolic side (conic -n²),
 * which makes its light parallel: a spot as large as the lens, in its shadow, whose light is that
 * of the cone on the lens, less what both faces reflect. At θ to the axis the light is turned to
 * the axis: sin(θ + t) = n sin t. What is reflected twice inside, 0.04², and from the paper by the
 * lens 50 mm above, 0.08 · 0.5 · (2/50)², may come, too.
 */
static void test_lens_gathers(void **state) {
    (void)state;
    const double r = 0.01, focus = r / (ior - 1), radius = 0.002, h = 0.05;
    const double sag = radius * radius / r / (1 + sqrt(1 + (ior * ior - 1) * pow(radius / r, 2)));
    const double theta = atan(radius / (focus + sag));
    double flux = 0;
    const int steps = 1000;
    for (int i = 0; i < steps; ++i) {
        const double c = 1 - (i + 0.5) / steps * (1 - cos(theta)),
                     out = atan(sqrt(1 - c * c) / (ior - c)), in = acos(c) + out;
        const double s = pow((cos(in) - ior * cos(out)) / (cos(in) + ior * cos(out)), 2);
        const double p = pow((ior * cos(in) - cos(out)) / (ior * cos(in) + cos(out)), 2);
        flux += 2 * M_PI * (1 - cos(theta)) / steps * (1 - (s + p) / 2);
    }
    flux *= 1 - pow((ior - 1) / (ior + 1), 2);
    mcv_scene *scene = mcv_scene_new("lens");
    mcv_solid lens = element(radius, (mcv_cap){.z = -0.002},
                             (mcv_cap){.curvature = -1 / r, .conic = -ior * ior});
    lens.to_world.m[11] = h;
    add_solid(scene, &lens, add_glass(scene, ior, 0, 0), add_absorber(scene));
    add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    add_point(scene, 2, looking_down_z(0, 0, h + focus));
    mcv_sensor sensor = sensor_of(TELECENTRIC, false);
    const double s = sqrt(0.5), field = 0.006;
    for (int k = 0; k < 2; ++k) sensor.as.telecentric.pixelSize[k] = field / 2 / 16;
    add_sensor(scene, sensor.type, &sensor,
               looking((const double[]){0.2, 0, 0.2}, (const double[]){-s, 0, -s},
                       (const double[]){0, 1, 0}));
    const mcv_render_options options = options_of(16, 1);
    mcv_film film = render(scene, &options, true);
    /* Seen at 45°, the film's square is longer on the paper. */
    expect_mean("lens", &film, 0.5 / M_PI * 2 * flux / (field * field / s), 2e-3);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

/*
 * A thin-lens projector with a white picture, behind a slab of thickness t, which brings it t (1 -
 * 1/n) nearer: on the axis the disk of its lens gives π L R²/(R² + d²) T. Within 6 mm of the axis
 * that falls by 2 (0.006/0.4)² = 5e-4 at most.
 */
static void test_projector_through_slab(void **state) {
    (void)state;
    static uint8_t white[4 * 4 * 4];
    mcv_scene *scene = mcv_scene_new("projector");
    memset(white, 255, sizeof white);
    mcv_texture picture = {
        .width = 4, .height = 4, .wrap_s = 33071, .wrap_t = 33071, .nearest = true, .rgba = white};
    BUILD(mcv_scene_add_texture(scene, &picture, &builder_error));
    add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    const double thickness = 0.006;
    add_box(scene, (const double[]){0.02, 0.02, thickness / 2}, add_glass(scene, ior, 0, 0),
            looking_down_z(0, 0, 0.3));
    float positions[] = {-0.005f, -0.005f, 0, 0.005f,  -0.005f, 0,
                         0.005f,  0.005f,  0, -0.005f, 0.005f,  0};
    float texcoords[] = {0, 1, 1, 1, 1, 0, 0, 0};
    uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    const mcv_mesh square = {.vertex_count = 4,
                             .triangle_count = 2,
                             .positions = positions,
                             .texcoords = texcoords,
                             .indices = indices};
    const uint32_t window =
        add_instance(scene, &square, add_absorber(scene), looking_down_z(0, 0, 0.4));
    mcv_emitter projector = emitter_of(MCV_EMITTER_PROJECTOR, window);
    mcv_projector_params *p = &projector.as.projector;
    p->image = 0;
    p->focalLength = 0.02;
    p->focusDistance = 0.4;
    p->lensDiameter = 0.01;
    for (int k = 0; k < 2; ++k) p->pixelSize[k] = 0.03 / 4 * 0.02 / 0.38;
    for (int k = 0; k < 3; ++k) p->radiance[k] = 100;
    add_light(scene, projector);
    add_camera(scene, TELECENTRIC, false);
    const mcv_render_options options = options_of(64, 1);
    mcv_film film = render(scene, &options, true);
    const double d = 0.4 - thickness * (1 - 1 / ior), r = 0.005;
    expect_mean("projector", &film, 0.5 * 100 * r * r / (r * r + d * d) * slab_transmittance(),
                6e-4);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

static void test_coaxial(void **state) {
    (void)state;
    double expected;
    mcv_scene *beam = coaxial_scene(true, &expected), *panel = coaxial_scene(false, &expected);
    mcv_render_options by_light = options_of(1024, 1), by_chance = options_of(4096, 2);
    mcv_film film = render(beam, &by_light, true);
    /* The paper, its picture in the splitter and the splitter send light to and fro, some 0.3 of
     * 0.5 A/(π (0.6 m)²): 1e-4. */
    expect_mean("coaxial beam", &film, expected, 2e-4);
    mcv_film_free(&film);
    if (SLOW) {
        mcv_film x = render(panel, &by_light, true);
        by_chance.no_light_paths = true;
        mcv_film y = render(panel, &by_chance, false);
        expect_same_picture("coaxial panel", &x, &y);
        mcv_film_free(&x);
        mcv_film_free(&y);
    }
    mcv_scene_free(beam);
    mcv_scene_free(panel);
}

/*
 * Both ways together are not noisier than camera paths alone at as many samples. The film of
 * coaxial_scene sees 144 mm², the panel has an étendue of π 156 mm²; with 4 x 4 pixels 64 light
 * paths start per 16 samples, so that they bring 79 % of the light. Where the film sees a
 * hundredth, there are none. The error of 16 pixels by 16 replicates is known to 1/√(2·15·16) = 5
 * %; 1.2 allows for 3 times that of both.
 */
static void test_no_noisier_than_chance(void **state) {
    (void)state;
    for (int small = 0; small < 2; ++small) {
        double expected, errors[2];
        mcv_scene *scene = coaxial_scene(false, &expected);
        for (int k = 0; k < 2 && small; ++k) scene->sensors[0].as.telecentric.pixelSize[k] /= 10;
        for (int chance = 0; chance < 2; ++chance) {
            mcv_render_options options = options_of(1024, 1);
            options.no_light_paths = chance;
            mcv_film film = render(scene, &options, !chance && !small);
            errors[chance] = mcv_film_relative_error(&film);
            mcv_film_free(&film);
        }
        print_message("%s field: error %.3g %%, by chance %.3g %%\n", small ? "small" : "large",
                      100 * errors[0], 100 * errors[1]);
        if (!(errors[0] <= 1.2 * errors[1]))
            fail_msg("error %g with light paths, %g by chance", errors[0], errors[1]);
        mcv_scene_free(scene);
    }
}

/* A cone of 5° through a glass ball onto paper between walls of which one is a mirror; the camera
 * sees paper, ball and mirror. */
static mcv_scene *ball_scene(int kind) {
    mcv_scene *scene = mcv_scene_new("ball");
    const double s = sqrt(0.5);
    const uint32_t mirror = add_material(scene, MCV_MATERIAL_MIRROR,
                                         &(mcv_material){.as.mirror.reflectance = {0.8, 0.8, 0.8}});
    const uint32_t paper = add_diffuse(scene, 0.7);
    add_rectangle(scene, 0.06, 0.06, paper, looking_up_z(0, 0, 0));
    add_rectangle(scene, 0.06, 0.03, paper,
                  looking((const double[]){-0.02, 0, 0.015}, (const double[]){1, 0, 0},
                          (const double[]){0, 0, 1}));
    add_rectangle(scene, 0.06, 0.03, mirror,
                  looking((const double[]){0, 0.02, 0.015}, (const double[]){0, -1, 0},
                          (const double[]){0, 0, 1}));
    add_sphere(scene, 0.005, 24, add_glass(scene, ior, 20, 0), looking_down_z(0, 0, 0.009));
    const uint32_t panel =
        add_rectangle(scene, 0.016, 0.016, add_absorber(scene), looking_down_z(0, 0, 0.05));
    add_emitter(scene, MCV_EMITTER_PARALLEL, panel, 100, 5 * M_PI / 180);
    /* Few pixels: light that is found by chance comes in bursts, and tests of ranks want many of
     * them. */
    mcv_sensor sensor = sensor_of(kind, true);
    const bool telecentric = kind == TELECENTRIC;
    for (int k = 0; k < 2; ++k) {
        (telecentric ? sensor.as.telecentric.resolution : sensor.as.thin_lens.resolution)[k] = 4;
        (telecentric ? sensor.as.telecentric.pixelSize : sensor.as.thin_lens.pixelSize)[k] *=
            3 * 16 / 4;
    }
    add_sensor(scene, sensor.type, &sensor,
               looking((const double[]){0.2, 0, 0.2}, (const double[]){-s, 0, -s},
                       (const double[]){0, 1, 0}));
    return scene;
}

static void test_ball_against_chance(void **state) {
    (void)state;
    const int tested[] = {THIN, TELECENTRIC};
    for (int i = 0; i < 2; ++i) {
        mcv_scene *scene = ball_scene(tested[i]);
        mcv_render_options by_light = options_of(512, 1), by_chance = options_of(4096, 2);
        by_chance.no_light_paths = true;
        mcv_film x = render(scene, &by_light, true), y = render(scene, &by_chance, false);
        expect_same_picture(kinds[tested[i]], &x, &y);
        mcv_film_free(&x);
        mcv_film_free(&y);
        mcv_scene_free(scene);
    }
}

/*
 * A small lamp that shines all around, and exact balls of glass, of which one lies in another's
 * shadow. Camera paths find the lamp behind them by chance, as those of the reference renderer do.
 */
static void test_lamp_against_reference(void **state) {
    (void)state;
    const double s = sqrt(0.5), balls[3][4] = {{0, 0, 0.009, 0.005},
                                               {0.002, 0.001, 0.02, 0.003},
                                               {-0.012, 0, 0.005, 0.002}};
    mcv_scene *scene = mcv_scene_new("lamp");
    add_rectangle(scene, 0.06, 0.06, add_diffuse(scene, 0.7), looking_up_z(0, 0, 0));
    const uint32_t glass = add_glass(scene, ior, 20, 0);
    for (int i = 0; i < 3; ++i) {
        mcv_solid ball = sphere(balls[i][3]);
        ball.to_world = looking_down_z(balls[i][0], balls[i][1], balls[i][2]);
        add_solid(scene, &ball, glass, glass);
    }
    const uint32_t panel =
        add_rectangle(scene, 0.004, 0.004, add_absorber(scene), looking_down_z(0.01, 0, 0.04));
    add_emitter(scene, MCV_EMITTER_AREA, panel, 100, 0);
    mcv_sensor sensor = sensor_of(TELECENTRIC, true);
    for (int k = 0; k < 2; ++k) {
        sensor.as.telecentric.resolution[k] = 4;
        sensor.as.telecentric.pixelSize[k] *= 3 * 16 / 4;
    }
    add_sensor(scene, sensor.type, &sensor,
               looking((const double[]){0.2, 0, 0.2}, (const double[]){-s, 0, -s},
                       (const double[]){0, 1, 0}));
    mcv_render_options by_light = options_of(512, 1), by_chance = options_of(32768, 2);
    const mcv_render_options reference = options_of(512, 3);
    by_chance.no_light_paths = true;
    mcv_film x = render(scene, &by_light, true), y = render(scene, &by_chance, false), z;
    mcv_render_stats stats;
    BUILD(mcv_reference_render(scene, 0, &reference, &z, &stats, &builder_error));
    expect_same_picture("lamp", &x, &y);
    /* Found in a few bursts, the light tells nothing about pixels; together they tell the mean. */
    const mcv_estimate ours = image_estimate(&x), truth = image_estimate(&z);
    const double error = sqrt(ours.variance + truth.variance);
    print_message("lamp: mean %.6g, reference %.6g, error of both %.2g\n", ours.mean, truth.mean,
                  error);
    if (!(error <= 0.03 * truth.mean) || !(fabs(ours.mean - truth.mean) <= 6.1 * error))
        fail_msg("mean %.6g, reference %.6g, error of both %.2g", ours.mean, truth.mean, error);
    mcv_film_free(&x);
    mcv_film_free(&y);
    mcv_film_free(&z);
    mcv_scene_free(scene);
}

/*
 * A lamp, a wide cone or a point light over a ball of ground glass (of facets in the quick tests:
 * without exact surfaces programs are smaller), a satin and a brushed plate, on paper between
 * walls: what they throw onto the paper comes by light paths. In the quick tests the ball and the
 * plates are in programs of their own. Camera paths find it by chance or, from the last rough
 * surface, by next-event estimation.
 */
enum { LAMP, CONE, POINT, LIGHTS };
#define WITH_BALL ((int)GROUP != (int)GROUP_METAL)
#define WITH_PLATES (SLOW || !WITH_BALL)
static const char *const lights[] = {"lamp", "cone", "point light"};

static void add_facetted_ball(mcv_scene *scene, double radius, uint32_t material,
                              mcv_transform to_world) {
    mcv_scene *parts = mcv_scene_new("parts");
    add_sphere(parts, radius, 16, add_absorber(parts), mcv_transform_identity());
    mcv_mesh mesh = parts->meshes[0];
    mesh.normals = NULL;
    add_instance(scene, &mesh, material, to_world);
    mcv_scene_free(parts);
}

static mcv_scene *rough_scene(int light) {
    mcv_scene *scene = mcv_scene_new("rough");
    const double s = sqrt(0.5);
    mcv_material ground = {.texture = MCV_NONE, .surface_texture = MCV_NONE}, satin = ground,
                 brushed = ground;
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_DIELECTRIC), &ground.as);
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_CONDUCTOR), &satin.as);
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_METALLIC_ROUGHNESS), &brushed.as);
    ground.as.dielectric.roughness = 0.35;
    satin.as.conductor.roughness = 0.4;
    brushed.as.metallic_roughness.metallic = 1;
    brushed.as.metallic_roughness.roughness = 0.45;
    const uint32_t glass = WITH_BALL ? add_material(scene, MCV_MATERIAL_DIELECTRIC, &ground) : 0,
                   paper = add_diffuse(scene, 0.7);
    add_rectangle(scene, 0.06, 0.06, paper, looking_up_z(0, 0, 0));
    add_rectangle(scene, 0.06, 0.03, paper,
                  looking((const double[]){-0.02, 0, 0.015}, (const double[]){1, 0, 0},
                          (const double[]){0, 0, 1}));
    mcv_solid ball = sphere(0.005);
    ball.to_world = looking_down_z(0, 0, 0.009);
    if (SLOW)
        add_solid(scene, &ball, glass, glass);
    else if (WITH_BALL)
        add_facetted_ball(scene, 0.005, glass, ball.to_world);
    if (WITH_PLATES) {
        const double root = sqrt(0.1);
        add_rectangle(scene, 0.012, 0.012, add_material(scene, MCV_MATERIAL_CONDUCTOR, &satin),
                      looking((const double[]){0.012, 0.004, 0.01}, (const double[]){-s, 0, s},
                              (const double[]){0, 1, 0}));
        add_rectangle(scene, 0.012, 0.012,
                      add_material(scene, MCV_MATERIAL_METALLIC_ROUGHNESS, &brushed),
                      looking((const double[]){-0.004, -0.012, 0.008},
                              (const double[]){0, 3 * root, root}, (const double[]){1, 0, 0}));
    }
    if (light == POINT) {
        add_point(scene, 0.01, looking_down_z(0.004, 0, 0.04));
    } else {
        const uint32_t panel =
            add_rectangle(scene, 0.008, 0.008, add_absorber(scene), looking_down_z(0.004, 0, 0.04));
        add_emitter(scene, light == LAMP ? MCV_EMITTER_AREA : MCV_EMITTER_PARALLEL, panel, 100,
                    light == LAMP ? 0 : 15 * M_PI / 180);
    }
    mcv_sensor sensor = sensor_of(TELECENTRIC, true);
    for (int k = 0; k < 2; ++k) {
        sensor.as.telecentric.resolution[k] = 8;
        /* Of the quick tests one sees the ball's shadow alone. */
        sensor.as.telecentric.pixelSize[k] *= WITH_PLATES ? 4 * 16 / 8 : 2;
    }
    add_sensor(scene, sensor.type, &sensor,
               looking((const double[]){0.2, 0, 0.2}, (const double[]){-s, 0, -s},
                       (const double[]){0, 1, 0}));
    return scene;
}

static void test_rough_against_chance(void **state) {
    (void)state;
    for (int light = 0; light < (SLOW ? LIGHTS : 1); ++light) {
        mcv_scene *scene = rough_scene(light);
        mcv_render_options by_light = options_of(SLOW ? 512 : 1024, 1),
                           by_chance = options_of(SLOW ? 4096 : 2048, 2);
        by_chance.no_light_paths = true;
        mcv_film x = render(scene, &by_light, true), y = render(scene, &by_chance, false);
        print_message("%s: errors %.3g %% and, by chance, %.3g %%\n", lights[light],
                      100 * mcv_film_relative_error(&x), 100 * mcv_film_relative_error(&y));
        expect_same_picture(lights[light], &x, &y);
        mcv_film_free(&x);
        mcv_film_free(&y);
        mcv_scene_free(scene);
    }
}

/*
 * A beam of 4 mm into a thin lens focused at infinity, tilted: all of it lands on the pixel at s =
 * -b d, E A_beam/A_pixel in irradiance. Then the same through a slab across the beam. Rounding
 * alone: each path brings the same, to some 30 roundings of float32; the slab's reflections are
 * chosen at random.
 */
static void test_beam_into_lens(void **state) {
    (void)state;
    for (int slab = 0; slab < 1 + SLOW; ++slab) {
        mcv_scene *scene = mcv_scene_new("into lens");
        mcv_sensor sensor = sensor_defaults(MCV_SENSOR_THIN_LENS);
        mcv_thin_lens_params *p = &sensor.as.thin_lens;
        p->focalLength = p->imageDistance = 0.05;
        p->lensDiameter = 0.02;
        p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
        for (int k = 0; k < 2; ++k) p->resolution[k] = 16, p->pixelSize[k] = 1e-4;
        /* The pixel (11, 5) from the top left sees d = (-s_x/b, -s_y/b, 1), s_x = (8 - 11.5) l, s_y
         * = (5.5 - 8) l; light comes from there.
         */
        const double d[3] = {3.5 * 1e-4 / 0.05, 2.5 * 1e-4 / 0.05, 1},
                     length = sqrt(d[0] * d[0] + d[1] * d[1] + 1);
        const double from[3] = {0.1 * d[0], 0.1 * d[1],
                                -0.1}; /* the camera looks along -z of the world */
        const double forward[3] = {-d[0] / length, -d[1] / length, 1 / length};
        const double up[3] = {0, forward[2] / hypot(forward[1], forward[2]),
                              -forward[1] / hypot(forward[1], forward[2])};
        add_sensor(scene, MCV_SENSOR_THIN_LENS, &sensor, looking_down_z(0, 0, 0));
        const double half[3] = {forward[0] * 0.05, forward[1] * 0.05, -0.05};
        if (slab)
            add_box(scene, (const double[]){0.005, 0.005, 0.001}, add_glass(scene, ior, 0, 0),
                    looking((const double[]){half[0] + from[0], half[1] + from[1], half[2]},
                            forward, up));
        add_beam(scene, 0.004, 3, looking(from, forward, up));
        const mcv_render_options options = options_of(16, 1);
        mcv_film film = render(scene, &options, true);
        const double expected =
            3 * 0.004 * 0.004 / (1e-4 * 1e-4) * (slab ? slab_transmittance() : 1);
        for (uint32_t i = 0; i < 16 * 16; ++i) {
            double sum = 0;
            for (uint32_t r = 0; r < REPLICATES; ++r)
                sum += film.sums[r * 256 + i] / 16 / REPLICATES;
            if (i == 5 * 16 + 11 ? !(fabs(sum - expected) <= (slab ? 0.01 : 2e-6) * expected)
                                 : sum != 0)
                fail_msg("slab %d: pixel (%u, %u) is %.9g, expected %.9g", slab, i % 16, i / 16,
                         sum, i == 5 * 16 + 11 ? expected : 0);
        }
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

static void expect_same_bits(const char *what, const mcv_film *x, const mcv_film *y) {
    const size_t count = (size_t)x->width * x->height * x->channels * x->replicates;
    assert_int_equal(x->samples, y->samples);
    for (size_t i = 0; i < count; ++i)
        if (x->sums[i] != y->sums[i])
            fail_msg("%s: value %zu is %.17g, not %.17g", what, i, y->sums[i], x->sums[i]);
}

static void expect_same_bits_of(mcv_scene *scene) {
    mcv_render_options options = options_of(8, 1);
    options.schedule = MCV_SCHEDULE_TILE;
    mcv_film whole = render(scene, &options, true);
    if (SLOW) {
        options.slice = 64;
        mcv_film slices = render(scene, &options, true);
        expect_same_bits("other slices", &whole, &slices);
        mcv_film_free(&slices);
    }
    options.schedule = MCV_SCHEDULE_STREAM;
    mcv_film stream = render(scene, &options, true);
    expect_same_bits("stream", &whole, &stream);
    options.last = 4;
    mcv_film first = render(scene, &options, true);
    options.first = 4, options.last = 8;
    mcv_film second = render(scene, &options, true);
    BUILD(mcv_film_merge(&first, &second, &builder_error));
    expect_same_bits("merged", &whole, &first);
    mcv_film *const films[] = {&whole, &stream, &first, &second};
    for (int i = 0; i < 4; ++i) mcv_film_free(films[i]);
    mcv_scene_free(scene);
}

static void test_same_bits(void **state) {
    (void)state;
    expect_same_bits_of(ball_scene(THIN));
    if (SLOW) expect_same_bits_of(rough_scene(LAMP));
}

int main(void) {
    const struct CMUnitTest slabs[] = {
        cmocka_unit_test(test_slab_before_every_sensor), cmocka_unit_test(test_oblique_view),
        cmocka_unit_test(test_point_lights_behind_slab), cmocka_unit_test(test_coaxial)};
    const struct CMUnitTest lenses[] = {cmocka_unit_test(test_sun_through_four_slabs),
                                        cmocka_unit_test(test_lens_gathers)};
    const struct CMUnitTest projector[] = {cmocka_unit_test(test_projector_through_slab)};
    const struct CMUnitTest beams[] = {cmocka_unit_test(test_beam_into_lens),
                                       cmocka_unit_test(test_same_bits)};
    const struct CMUnitTest gloss[] = {cmocka_unit_test(test_rough_against_chance)};
    const struct CMUnitTest all[] = {
        cmocka_unit_test(test_slab_before_every_sensor),
        cmocka_unit_test(test_mirror),
        cmocka_unit_test(test_coaxial),
        cmocka_unit_test(test_no_noisier_than_chance),
        cmocka_unit_test(test_sun_through_slab),
        cmocka_unit_test(test_beam_into_lens),
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_ball_against_chance),
        cmocka_unit_test(test_lamp_against_reference),
        cmocka_unit_test(test_rough_against_chance),
    };
    switch (GROUP) {
    case GROUP_SLABS:
        return cmocka_run_group_tests(slabs, NULL, NULL);
    case GROUP_LENSES:
        return cmocka_run_group_tests(lenses, NULL, NULL);
    case GROUP_PROJECTOR:
        return cmocka_run_group_tests(projector, NULL, NULL);
    case GROUP_BEAMS:
        return cmocka_run_group_tests(beams, NULL, NULL);
    case GROUP_GLOSS:
    case GROUP_METAL:
        return cmocka_run_group_tests(gloss, NULL, NULL);
    default:
        return cmocka_run_group_tests(all, NULL, NULL);
    }
}
